"""Models of which tests take single steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.solve.contacts.history import History
from bsm_mesh.solve.continuation.first_step import solve_at_once
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.step.equations import Step

CONTINUATION = bsm.Options(scheme="continuation")
STIFFNESS, WEIGHT = 1e9, 26e3
COURSES, BRICKS = 24, 40  # of the wall


def begun(model: bsm.Model) -> Step:
    """Return the first step from zero stress."""
    engine = Continuation(model, CONTINUATION, lambda *_: None)
    contacts = engine.system.gather(History.none(), engine.system.start, first=True)
    return Step(engine.system, engine.factors, contacts, engine.system.start, engine.min_lam)


def block_on_a_base(tilt: float = 0.0, **given) -> bsm.Model:
    """Return a square metre on a base, tilted [degrees] in that gravity is."""
    law = given.pop("law", bsm.MohrCoulomb(friction=35))
    parts = {
        "blocks": bsm.Blocks.from_polygons(
            [[(0, 0), (4, 0), (4, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="r"
        ),
        "rocks": [bsm.Rock("r", unit_weight=WEIGHT)],
        "joints": [bsm.Joint("J", STIFFNESS, STIFFNESS, law=law, tensile_strength=given.pop("tension", 0.0))],
        "default_joint": "J",
        "supports": [bsm.Fixed(blocks=[0])],
        "gravity_direction": -90.0 + tilt,
    }
    return bsm.Model(**(parts | given))


def wall_at_rest(tolerance: float) -> tuple[Step, np.ndarray]:
    """Return the step of a tilted wall and where it is at rest (n, 3), with factors of its tangent there."""
    polygons = [[(-1, -0.5), (BRICKS + 1, -0.5), (BRICKS + 1, 0), (-1, 0)]]
    for c in range(COURSES):
        joints = np.arange(BRICKS + 1.0) if c % 2 == 0 else np.concatenate([[0], np.arange(BRICKS) + 0.5, [BRICKS]])
        polygons += [[(a, c / 2), (b, c / 2), (b, c / 2 + 0.5), (a, c / 2 + 0.5)] for a, b in pairwise(joints)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=2500 * 9.81)],
        joints=[bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=35.0))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-85.0,
    )
    step = begun(model)
    found = solve_at_once(step, tolerance)
    assert found.converged
    assert step.factorize(step.tangent(found.at, 1e-3), found.position)
    return step, found.position
