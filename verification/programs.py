"""Other solvers on the same model: dense matrices, a linear program by HiGHS, finite elements by scikit-fem."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters.continuum import solve_continuum_stages
from bsm_mesh.model.strength import with_strength
from bsm_mesh.solve.limit_analysis import strength_limit
from tests.scenes.large import jointed_slope
from tests.scenes.models import LINEAR, admissible_at, model_of
from tests.scenes.pushed_block import FRICTION, example_2
from tests.scenes.reference import brute_faces, dense_solution, face_forces
from tests.scenes.shapes import rectangle, running_bond, turned
from verification.case import Answer, Between, Case, Value


def wall_by_lagrange() -> Answer:
    """Compare displacements of a turned wall, a block displaced by 1 mm, and its forces."""
    polygons = [turned(2 * p, 15.0) for p in running_bond(4, 3)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="r")
    centroid, area, stiffness = blocks.moments.centroid, blocks.moments.area, (2e9, 5e8)
    bars = [(b, polygons[b][k] + 1e-7 * (centroid[b] - polygons[b][k]), 105.0, 0.0) for b in range(3) for k in (0, 1)]
    bars += [(0, centroid[0], 15.0, 1e-3)]
    loads = np.column_stack([np.zeros(len(area)), -26e3 * area, np.zeros(len(area))])
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=26e3)],
        joints=[bsm.Joint("J", *stiffness)],
        default_joint="J",
        supports=[bsm.PrescribedDisplacement(point=tuple(p), direction=a, displacement=w) for _, p, a, w in bars],
    )
    exact = dense_solution(polygons, stiffness, loads, bars)
    stage = bsm.run(model, LINEAR).stages[-1]
    found, pairs = face_forces(stage.contacts), [(i, j) for i, j, *_ in brute_faces(polygons)]
    forces = [np.array([of[pair] for pair in pairs]).ravel() / 26e3 for of in (exact.face_forces, found)]
    moved = [1e3 * each.ravel() for each in (exact.displacement, stage.displacement)]
    return np.concatenate([moved[0], forces[0]]), np.concatenate([moved[1], forces[1]])


@cache
def _slopes() -> tuple[bsm.Model, ...]:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(4):
        dips = rng.uniform(45, 85), -rng.uniform(20, 40)
        scene = jointed_slope(int(rng.integers(20, 60)), rng.uniform(20, 45), dips)
        found.append(replace(scene, cohesion=rng.uniform(0, 5e3)).model())
    return tuple(found)


def slopes_by_highs() -> tuple[Value, Value | Between]:
    """Compare whether forces exist at 0.999 and at 1.001 of our factors of strength of four random slopes."""
    from scipy.optimize import linprog

    from bsm_mesh.solve.algebra.loads import external_loads
    from bsm_mesh.solve.limit.program import LimitProgram

    told = []
    for model in _slopes():
        factor = strength_limit(model).factor
        for part in (0.999, 1.001):
            reduced = with_strength(model, {"*": 1 / (part * factor)}).replace(contact_points="ends")
            program, loads = LimitProgram(reduced), external_loads(reduced)
            rows, bound = program.bounds()
            free, scale = np.repeat(program.movable, 3), np.hypot(*loads[:, :2].T).mean()
            answer = linprog(
                np.zeros(program.unknowns), A_ub=rows, b_ub=bound / scale, bounds=(None, None),
                A_eq=program.equilibrium[free], b_eq=-loads.reshape(-1)[free] / scale,
            )  # fmt: skip
            told.append({0: "yes", 2: "no"}.get(answer.status, "?"))
    return "yes, no of each", "yes, no of each" if told == ["yes", "no"] * len(told[::2]) else ", ".join(told)


def rest_by_highs() -> Answer:
    """Compare whether forces within friction hold the block of Example 2 where it reached rest, and where it began."""
    model = example_2(1e9)
    at_rest = admissible_at(bsm.run(model), FRICTION)
    begins = bsm.limit_analysis(model).admissible
    return "at rest, not at the start", f"{'at rest' if at_rest else '-'}, {'-' if begins else 'not at the start'}"


def rigid_limit() -> Answer:
    """Compare a column that leans, on stiff joints: blocks, and rock a thousand times as stiff with interfaces [mm]."""
    polygons = [rectangle(-2, -1, 3, 0), *(rectangle(0, k, 1, k + 1) for k in range(3))]
    rigid = model_of(polygons, friction=35.0, kn=1e9, gravity_direction=-86.0)
    stiff = rigid.replace(rocks=(bsm.Rock("rock", unit_weight=25e3, young=1e13, poisson=0.0),))
    blocks = bsm.run(rigid, bsm.Options(tolerance=1e-9)).stages[-1].displacement[1:, :2]
    (stage,) = solve_continuum_stages(stiff, order=1, joints=True)
    return 1e3 * stage.displacement[1:, :2].ravel(), 1e3 * blocks.ravel()


CASES = (
    Case(name="wall-by-lagrange", what="wall on inclined rollers, one block displaced", source="lagrange",
         quantity="displacement [mm], forces of faces [26 kN]", compute=wall_by_lagrange, tolerance=1e-11),
    Case(name="slopes-by-highs", what="four random slopes: forces within strength at 0.999 and 1.001 of our factor",
         source="highs", quantity="do forces exist", compute=slopes_by_highs, tolerance=0.0),
    Case(name="rest-by-highs", what="Example 2: forces within friction", source="highs", quantity="do forces exist",
         compute=rest_by_highs, tolerance=0.0),
    Case(name="rigid-limit", what="a leaning column by finite elements with interfaces, nearly rigid", source="skfem",
         quantity="displacement [mm]", compute=rigid_limit, tolerance=1e-3),
)  # fmt: skip
