"""Models of which tests take single steps."""

from __future__ import annotations

import bsm_mesh as bsm
from bsm_mesh.solve.continuation import Continuation
from bsm_mesh.solve.history import History
from bsm_mesh.solve.step import Step

CONTINUATION = bsm.Options(scheme="continuation")
STIFFNESS, WEIGHT = 1e9, 26e3


def begun(model: bsm.Model) -> Step:
    """Return the first step from zero stress."""
    engine = Continuation(model, CONTINUATION, lambda *_: None)
    contacts = engine.moving.gather(History.none(), engine.moving.start, first=True)
    return Step(engine.moving, engine.factors, contacts, engine.moving.start, engine.least_lam)


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
