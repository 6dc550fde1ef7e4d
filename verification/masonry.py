"""Arches, stacks, columns and joints in series: limits that statics of rigid blocks knows."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.solve.limit_analysis import limit_tilt
from tests.scenes.arch import arch
from tests.scenes.flat_arch import snapped
from tests.scenes.models import GAMMA, LINEAR, model_of
from tests.scenes.shapes import grid, rectangle, turned
from verification.case import Answer, Case, limit_between

THICKNESS = {8: 0.09997, 10: 0.10701, 12: 0.10486, 16: 0.10708, 20: 0.10735, 30: 0.10741, 32: 0.10720, 64: 0.10738}
LEAST_FRICTION = ((20, 0.12, 0.3825), (30, 0.12, 0.3819), (30, 0.20, 0.3090))


def least_thickness(n: int) -> Answer:
    """Compare least thickness over radius of an arch of n stones, by limit analysis, a digit to either side."""

    def falls(ratio: float) -> bool:
        return not bsm.limit_analysis(arch(n, ratio)).admissible

    return THICKNESS[n], limit_between(falls, THICKNESS[n] - 1e-5, THICKNESS[n] + 1e-5)


def continuous_arch() -> Answer:
    """Compare least thickness of the continuous arch, by 200 stones."""

    def falls(ratio: float) -> bool:
        return not bsm.limit_analysis(arch(200, ratio)).admissible

    return 0.1075, limit_between(falls, 0.1073, 0.1075)


def least_friction(n: int, ratio: float, exact: float) -> Answer:
    """Compare least friction at which an arch stands, by limit analysis, a digit of the table to either side."""

    def falls(friction: float) -> bool:
        return not bsm.limit_analysis(arch(n, ratio, math.degrees(math.atan(friction)))).admissible

    return exact, limit_between(falls, exact - 1e-4, exact + 1e-4)


def arch_that_falls(n: int) -> Answer:
    """Compare least thickness of an arch followed to rest or collapse, 1 % to either side."""

    def falls(ratio: float) -> bool:
        return bool(bsm.run(arch(n, ratio)).status == "unstable")

    return THICKNESS[n], limit_between(falls, 0.99 * THICKNESS[n], 1.01 * THICKNESS[n])


def crown_thrust() -> Answer:
    """Compare thrust at the crown of an arch of 20 stones, t / R = 0.15, with the bounds of statics."""
    stage = bsm.run(arch(20, 0.15)).stages[-1]
    at_crown = {9, 10}
    c = stage.contacts
    both = np.array([{int(a), int(b)} == at_crown for a, b in zip(c.block_a, c.block_b, strict=True)])
    thrust = -c.normal_force[both].sum() / GAMMA
    return "0.08243 to 0.10687", "0.08243 to 0.10687" if 0.08243 <= thrust <= 0.10687 else f"{thrust:.5f}"


def overhang(n: int, *, statics: bool) -> Answer:
    """Compare greatest overhang of a stack of n blocks, over 1/2 + 1/4 + ... of a block's length."""

    def stands(part: float) -> bool:
        shift = np.concatenate([[0], np.cumsum([part / (2 * k) for k in range(n, 0, -1)])])[: n + 1]
        polygons = [rectangle(s - 1, 0.5 * k, s, 0.5 * k + 0.5) for k, s in enumerate(shift)]
        model = model_of(polygons, friction=45, kn=1e10)
        return bsm.limit_analysis(model).admissible if statics else bool(bsm.run(model).status == "stable")

    near = 1e-4 if statics else 0.01
    return 1.0, limit_between(stands, 1 - near, 1 + near)


def toppling_column(n: int) -> Answer:
    """Compare tilt at which a column of n blocks of 1 x 2 m topples, by limit analysis."""
    polygons = [rectangle(-9, -1, 9, 0), *(rectangle(0, 2 * k, 1, 2 * k + 2) for k in range(n))]
    return math.degrees(math.atan(1 / (2 * n))), limit_tilt(model_of(polygons, friction=80))


def column_that_topples() -> Answer:
    """Compare the same of three blocks of 1 x 0.5 m, followed, 0.05 degrees to either side."""
    exact = math.degrees(math.atan(1 / 1.5))
    polygons = [rectangle(-20, -1, 20, 0), *(rectangle(0, 0.5 * k, 1, 0.5 * k + 0.5) for k in range(3))]

    def stands(tilt: float) -> bool:
        model = model_of(polygons, friction=60, kn=1e10, gravity_direction=-90.0 - tilt)
        return bsm.run(model, bsm.Options(displacement_limit=0.4)).stages[-1].max_displacement < 1e-3

    return exact, limit_between(stands, exact - 0.05, exact + 0.05)


def shaken_column() -> Answer:
    """Compare part of its weight at which a column of 1 x 4 m topples: breadth over height."""
    polygons = [rectangle(-9, -1, 9, 0), rectangle(0, 0, 1, 4)]

    def stands(part: float) -> bool:
        model = model_of(polygons, friction=60, kn=1e11, gravity_horizontal=part)
        return bool(bsm.run(model, bsm.Options(displacement_limit=0.5)).status == "stable")

    return 0.25, limit_between(stands, 0.2495, 0.2505)


def toppled_slab() -> Answer:
    """Compare a slab of 0.4 x 2 m that leans falls flat: its turn, and the height of its centre at rest."""
    results = bsm.run(model_of([rectangle(-5, -1, 5, 0), turned(rectangle(-0.4, 0, 0, 2), -15.0)], friction=40))
    final = results.stages[-1].displacement[1]
    height = results.blocks.moments.centroid[1, 1] + final[1]
    return np.array([-75.0 / 100, 0.2]), np.array([math.degrees(final[2]) / 100, height])


def joints_in_series() -> Answer:
    """Compare closure of ten joints under ten blocks, and the settlement of the topmost [um]."""
    n, kn = 10, 1e9
    model = model_of(grid([0, 1], np.arange(-1.0, n + 1)), kn=kn)
    stage = bsm.run(model, LINEAR).stages[-1]
    joint = np.arange(1, n + 1)
    below = np.minimum(stage.contacts.block_a, stage.contacts.block_b)  # joint k is above block k - 1
    closure = np.zeros(n)
    closure[below] = -stage.contacts.opening
    exact = np.append((n - joint + 1) * GAMMA / kn, GAMMA * n * (n + 1) / (2 * kn))
    return 1e6 * exact, 1e6 * np.append(closure, -stage.displacement[-1, 1])


def glued_block() -> Answer:
    """Compare load factor of a pull of 1 kN on a block of 25 kN glued by 20 kPa on 1 m."""
    joint = bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=30, cohesion=5e3), tensile_strength=20e3)
    model = model_of([rectangle(-5, -1, 15, 0), rectangle(0, 0, 1, 1)], joint=joint)
    lift = [bsm.PointLoad(block=1, point=(0.5, 0.5), force=(0.0, 1e3))]
    return 45.0, bsm.limit_analysis(model, lift).factor


def flat_arch() -> Answer:
    """Compare load at which a flat arch of two stones snaps through, over the closed form."""

    def stands(part: float) -> bool:
        stage, exact = snapped(0.2, part, 1e10, half=False)
        right = part > 1 or abs(abs(stage.displacement[2, 2]) / exact - 1) < 5e-3
        return bool(stage.status == "stable" and right)

    return 1.0, limit_between(stands, 0.99, 1.01)


CASES = (
    *(Case(name=f"arch-of-{n}", what=f"arch of {n} stones: limit analysis", source="arches",
           quantity="least t / R", compute=partial(least_thickness, n), tolerance=1.1e-4) for n in THICKNESS),
    Case(name="continuous-arch", what="semicircular arch with many radial joints (200)", source="couplet",
         quantity="least t / R", compute=continuous_arch, tolerance=2e-3),
    *(Case(name=f"friction-of-arch-{n}-{ratio:g}", what=f"arch of {n} stones, t / R = {ratio:g}", source="arches",
           quantity="least friction", compute=partial(least_friction, n, ratio, exact), tolerance=4e-4)
      for n, ratio, exact in LEAST_FRICTION),
    Case(name="arch-that-falls", what="arch of 16 stones followed to rest or collapse", source="arches",
         quantity="least t / R", compute=partial(arch_that_falls, 16), tolerance=0.011),
    Case(name="crown-thrust", what="arch of 20 stones at rest: thrust over gamma R^2", source="arches",
         quantity="within the bounds", compute=crown_thrust, tolerance=0.0),
    *(Case(name=f"harmonic-stack-{n}", what=f"stack of {n} blocks: limit analysis", source="harmonic",
           quantity="overhang over 1/2 + 1/4 + ...", compute=partial(overhang, n, statics=True), tolerance=1.1e-4)
      for n in (2, 3, 4)),
    Case(name="stack-that-falls", what="stack of 3 blocks, followed", source="harmonic",
         quantity="overhang over 1/2 + 1/4 + ...", compute=partial(overhang, 3, statics=False), tolerance=0.011),
    *(Case(name=f"column-of-{n}", what=f"column of {n} blocks 1 x 2 m: limit analysis", source="statics",
           quantity="tilt [degrees]", compute=partial(toppling_column, n), tolerance=1e-7) for n in (1, 2, 4)),
    Case(name="column-that-topples", what="column of 3 blocks 1 x 0.5 m, followed", source="statics",
         quantity="tilt [degrees]", compute=column_that_topples, tolerance=1.6e-3),
    Case(name="shaken-column", what="column of 1 x 4 m in an earthquake", source="statics",
         quantity="part of the weight", compute=shaken_column, tolerance=2.1e-3),
    Case(name="toppled-slab", what="a leaning slab falls flat and rests", source="statics",
         quantity="turn [100 degrees], height [m]", compute=toppled_slab, tolerance=1e-4),
    Case(name="joints-in-series", what="ten blocks on ten joints", source="springs",
         quantity="closures, settlement [um]",
         compute=joints_in_series, tolerance=1e-12),
    Case(name="glued-block", what="a block glued by tensile strength is lifted", source="statics",
         quantity="load factor", compute=glued_block, tolerance=1e-8),
    Case(name="flat-arch", what="a flat arch of two stones snaps through", source="euler",
         quantity="load over the greatest one", compute=flat_arch, tolerance=0.011),
)  # fmt: skip
