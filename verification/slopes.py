"""Blocks on planes and slopes: limit equilibrium as the books have it."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.safety.bound import limit_of
from bsm_mesh.safety.factor import factor_of_safety
from bsm_mesh.safety.trials import Reduction
from tests.scenes.known_factors import Known, known, tutorial_slope
from tests.scenes.models import LINEAR, model_of
from tests.scenes.plane_failure import PlaneFailure, hoek_and_bray
from tests.scenes.shapes import rectangle, turned
from verification.case import Answer, Between, Case, limit_between
from verification.thesis_water import on_rock

GAMMA, KN, B = 20e3, 10e6, 10.0  # 3DEC's sliding block: density 2000, g 10, Kn = Ks = 10 MPa/m, 10 m wide
PAGE = "safety.md#known-answers"
WIDTH = 0.002  # of brackets of the factor of safety


def tan(degrees: float) -> float:
    """Return the tangent of an angle in degrees."""
    return math.tan(math.radians(degrees))


def _on_plane(height: float, friction: float, plane: float, kn: float = KN) -> bsm.Model:
    polygons = [turned(rectangle(*r), plane) for r in ((-40, -10, 30, 0), (0, 0, B, height))]
    return model_of(polygons, friction=friction, kn=kn, gamma=GAMMA)


def two_springs() -> Answer:
    """Compare normal force at toe and heel over the weight, normal and shear displacement of the block that stands."""
    contacts = bsm.run(_on_plane(10.0, 40.1, 40.0), LINEAR).stages[-1].contacts
    W, a = GAMMA * B * 10.0, math.radians(40)
    N, S = W * math.cos(a), W * math.sin(a)
    exact = [1408.83e3, 123.26e3, 15.3209e-3 * 1e8, 12.8558e-3 * 1e8]
    assert math.isclose(N / 2 + S / 2, exact[0], rel_tol=1e-5)  # the printed text is N / 2 + S h / (2 b)
    pressed = np.sort(-contacts.normal_force)
    moved = -contacts.opening.mean() * 1e8, abs(contacts.slip.mean()) * 1e8  # 1e8: as large as the forces
    return np.array(exact), np.array([pressed[1], pressed[0], *moved])


def how_it_fails(height: float, friction: float, plane: float) -> str:
    """Return what the block does, from a run that ends when it moved half its width."""
    stage = bsm.run(_on_plane(height, friction, plane), bsm.Options(displacement_limit=5.0)).stages[-1]
    if stage.status == "stable":
        return "stands"
    u, v, turn = stage.displacement[1]
    toe = turned(np.array([(0.0, 0.0)]), plane)[0]
    centre = turned(np.array([(B / 2, height / 2)]), plane)[0]
    moved = np.array([u, v]) + turned((toe - centre)[None], math.degrees(turn))[0] - (toe - centre)
    slides = turned(moved[None], -plane)[0, 0] < -0.5
    topples = math.degrees(turn) > 5.0
    return " and ".join(word for word, yes in (("slides", slides), ("topples", topples)) if yes)


def limit_angle() -> Answer:
    """Compare a flat block slides beyond its angle of friction."""

    def stands(plane: float) -> bool:
        return bool(bsm.run(_on_plane(5.0, 35.0, plane, 1e9)).status == "stable")

    return 35.0, limit_between(stands, 34.99, 35.01)


def statics_of(case: PlaneFailure, **given: Any) -> float:
    """Return the factor of safety from the contact forces of the linear scheme, nothing behind the crack."""
    foot = case.crack
    block = np.array([(0.0, 0.0), foot, case.top, case.crest])
    below = np.array([(0.0, 0.0), (0.0, -8.0), (foot[0], -8.0), foot])
    table = [(0.0, 0.0), (foot[0], foot[1] + case.zw)]
    water = bsm.Water(table=table, unit_weight=case.water) if case.zw else None
    pressed, sheared, _ = on_rock(block, below, water, case.gamma, **given)
    return (case.cohesion * math.hypot(*foot) + pressed * tan(case.friction)) / sheared


def book_factors() -> Answer:
    """Compare drained; 3 m of water; drained, no cohesion; 3 m of water, no cohesion."""
    given = ((0.0, 25e3), (3.0, 25e3), (0.0, 0.0), (3.0, 0.0))
    found = [statics_of(hoek_and_bray(zw=zw, cohesion=cohesion)) for zw, cohesion in given]
    return np.array([1.544, 1.247, 1.076, 0.801]), np.array(found)


def full_crack() -> Answer:
    """Compare the crack full of water; the book's crack is 4.35 m deep, the model's 4.348 m."""
    return 1.072, statics_of(hoek_and_bray(zw=4.348))


def bolted_factors() -> Answer:
    """Compare bolts at yield, 400 kN/m, plunging by 55 and 20 degrees, drained, no cohesion."""
    case, found = hoek_and_bray(cohesion=0.0), []
    head, steel = np.array(case.crest) / 2, 4e5 / (math.pi * 0.02**2)
    for plunge, length in ((55.0, 8.0), (20.0, 6.5)):
        end = head + length * np.array([math.cos(math.radians(plunge)), -math.sin(math.radians(plunge))])
        bolt = bsm.Bolt(start=tuple(head), end=tuple(end), kind="end_anchored", diameter=0.04, yield_strength=steel,
                        pretension=4e5)  # fmt: skip
        found.append(statics_of(case, bolts=[bolt]))
    return np.array([1.499, 2.099]), np.array(found)


def earthquake() -> Answer:
    """Compare friction that a plane of 20 degrees needs under 0.15 g down the slope, over the closed form."""
    a = math.radians(20.0)
    exact = (math.sin(a) + 0.15 * math.cos(a)) / (math.cos(a) - 0.15 * math.sin(a))
    polygons = [turned(p, 20.0) for p in (rectangle(-9, -2, 9, 0), rectangle(0, 0, 4, 0.5))]

    def slides(part: float) -> bool:
        friction = math.degrees(math.atan(part * exact))
        return bool(bsm.run(model_of(polygons, friction=friction, gravity_horizontal=-0.15)).status == "unstable")

    return 1.0, limit_between(slides, 0.999, 1.001)


def brittle_cohesion() -> Answer:
    """Compare factor of plane failure, 3 m of water, whose cohesion a contact loses at its first slip."""
    slope = hoek_and_bray(zw=3.0)

    def stands(factor: float) -> bool:
        results = bsm.run(slope.model(factor, residual_cohesion=0.0))
        return bool(results.status == "stable" and results.stages[0].max_displacement < 1e-3)

    return 1.129, limit_between(stands, 1.126, 1.132)


def tutorial_of_udec() -> Answer:
    """Compare what slides when the left block is excavated: friction 20, then 11."""
    told = []
    for friction in (20.0, 11.0):
        before, after = bsm.run(tutorial_slope(friction)).stages
        told.append("at rest" if before.status == "stable" else "moves")
        told.append({(3,): "top", (2, 3): "both"}.get(tuple(after.unstable_blocks.tolist()), "other"))
    return "at rest, top, at rest, both", ", ".join(told)


def bound(case: Known) -> Answer:
    """Compare greatest factor at which forces within strength exist."""
    return case.factor, limit_of(case.build(), Reduction(joints=case.joints), bsm.Options().falls).factor


def bracket(case: Known) -> Answer:
    """Compare last stable and first unstable factor by strength reduction."""
    found = factor_of_safety(case.build(), joints=case.joints, tolerance=WIDTH)
    low, high = found.stable, found.unstable
    return case.factor, Between(math.nan if low is None else low, math.nan if high is None else high)


STATED = (
    Case(name="two-springs", what="block of 10 m on 40 degrees, elastic", source="3dec",
         quantity="toe, heel [N/m]; closure, shear [1e-8 m]", compute=two_springs, tolerance=1e-5),
    *(Case(name=f"3dec-{word}", what=f"block of {height:g} m, friction {friction:g}, on {plane:g} degrees",
           source="3dec", quantity="movement",
           compute=lambda word=word, given=(height, friction, plane): (word, how_it_fails(*given)), tolerance=0.0)
      for word, height, friction, plane in (("stands", 10.0, 40.1, 40.0), ("slides", 5.0, 20.0, 40.0),
                                            ("topples", 25.0, 40.0, 30.0))),
    Case(name="sliding-without-toppling", what="block of 25 m, friction 20, on 40 degrees: as it slides, the force on "
         "its base acts h / 2 tan(phi) = 4.55 m from the middle of 10 m, so that it does not turn; charts of statics "
         "say that it slides and topples", source="statics", quantity="movement",
         compute=lambda: ("slides", how_it_fails(25.0, 20.0, 40.0)), tolerance=0.0),
    Case(name="limit-angle", what="flat block, friction 35, planes of 34.99 and 35.01 degrees", source="statics",
         quantity="angle [degrees]", compute=limit_angle, tolerance=3e-4),
    Case(name="book-factors", what="plane failure with a tension crack", source="hoek-bray",
         quantity="factor of safety", compute=book_factors, tolerance=3.3e-4),
    Case(name="full-crack", what="the same, the crack full of water", source="hoek-bray", quantity="factor of safety",
         compute=full_crack, tolerance=1e-3),
    Case(name="bolted-factors", what="the same with bolts at yield", source="hoek-bray", quantity="factor of safety",
         compute=bolted_factors, tolerance=3.3e-4),
    Case(name="brittle-cohesion", what="the same with cohesion that is lost at the first slip", source="given",
         quantity="factor of safety", compute=brittle_cohesion, tolerance=2.7e-3),
    Case(name="tutorial-of-udec", what="slope of UDEC's tutorial, its left block excavated, friction 20 and 11",
         source="udec", quantity="before; what slides", compute=tutorial_of_udec, tolerance=0.0),
    Case(name="earthquake", what="block on a plane of 20 degrees under 0.15 g", source="statics",
         quantity="friction over the closed form", compute=earthquake, tolerance=1.1e-3),
)  # fmt: skip


def _slug(case: Known) -> str:
    words = "".join(c if c.isalnum() or c == "." else " " for c in case.name.lower()).split()
    return "-".join(words)


BOUNDS = tuple(
    Case(name=f"bound-{_slug(case)}", what=f"{case.name}: limit analysis", source=case.source,
         quantity="factor of strength", compute=partial(bound, case), tolerance=2e-4, page=PAGE)
    for case in known() if case.at_bound
)  # fmt: skip
BRACKETS = tuple(
    Case(name=f"factor-{_slug(case)}", what=f"{case.name}: strength reduction", source=case.source,
         quantity="factor of safety", compute=partial(bracket, case), tolerance=0.003, page=PAGE, is_slow=True)
    for case in known()
)  # fmt: skip
CASES = (*STATED, *BOUNDS, *BRACKETS)
