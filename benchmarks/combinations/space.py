"""Combinations in space: laws, supports, loads, water, in-situ stress, bolts, histories and stages."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.combinations.draw import LAWS, OF_JOINTS, Draw, in_time, options_of
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.loads import Load

SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
"""Corners of the faces of a box; its corners go round the bottom, then the top."""

FIELDS = (
    bsm.InSitu(surface=3.0, k0=0.5),
    bsm.InSitu(surface=3.0, k0=0.5, method="gravity"),
    bsm.InSitu(surface=3.0, k0=0.5, k0_across=0.8, trend=30.0),
)
LOADS: tuple[Load, ...] = (
    bsm.Pressure(boundary="top", pressure=5e4),
    bsm.Traction(boundary="top", traction=(3e3, (0, 1e3, 0, 0), -1e4)),
    bsm.Pressure(boundary="left", pressure=(6e4, 0, 0, -2e4)),
    bsm.PointLoad(block=8, point=(1.5, 0.5, 2.5), force=(2e3, 1e3, -1e4)),
)
STAGES = ("excavate", "relax", "pressure", "fill", "water", "strength", "gravity", "load", "nothing")
WORN = bsm.BartonBandis(jrc=8, jcs=5e7, residual_friction=28, roughness_wears=True)


def _box(low: tuple[float, float, float], high: tuple[float, float, float]) -> tuple[FloatArray, list[tuple[int, ...]]]:
    (x, y, z), (X, Y, Z) = low, high
    around = [(x, y), (X, y), (X, Y), (x, Y)]
    return np.array([(*place, height) for height in (z, Z) for place in around]), SIDES


@cache
def wall() -> bsm.Polyhedra:
    """Return three courses of bricks in bond, 1 m thick, on a base."""
    rows = [(0, 1, 2, 3), (0, 1.5, 2.5, 3), (0, 1, 2, 3)]
    bricks = [_box((a, 0, row), (b, 1, row + 1)) for row, ends in enumerate(rows) for a, b in pairwise(ends)]
    blocks = bsm.Polyhedra.from_solids([_box((-1, -1, -1), (4, 2, 0)), *bricks], rock="stone", joint="bed")
    return (
        blocks.with_boundary("bottom", lambda x, y, z: z < -1 + 1e-9)
        .with_boundary("left", lambda x, y, z: (np.abs(x) < 1e-9) & (z > -1e-9))
        .with_boundary("right", lambda x, y, z: (np.abs(x - 3) < 1e-9) & (z > -1e-9))
        .with_boundary("top", lambda x, y, z: z > 3 - 1e-9)
    )


def combination(seed: int) -> tuple[dict[str, Any], bsm.Options, list[str]]:
    """Return the parts of a model, its options, and the names of its features."""
    draw = Draw(seed)
    parts = {"blocks": wall(), "default_joint": "bed", **_matter(draw), **_ground(draw)}
    stages = [_stage(draw, number) for number in range(draw.one(0, 1, 2))]
    bolt = {"start": (1.6, 0.5, 2.9), "end": (1.8, 0.4, 0.2)}
    line = [(0.5, 0.5, 0.5), (0.5, 0.5, 2.5)]
    parts |= in_time(draw, stages, bolt, {"point": (1.5, 0.5, 2.5)}, {"block": 8}, {"line": line})
    if draw.often(0.3, "corners"):
        parts["contact_points"] = "corners"
    return parts, options_of(draw), draw.tags


def _matter(draw: Draw) -> dict[str, Any]:
    """Return rock and joint."""
    elastic = draw.often(0.3, "elastic")
    rock = bsm.Rock("stone", unit_weight=24e3, **({"young": 2e10, "poisson": 0.2} if elastic else {}))
    number = draw.one(*range(len(LAWS) + 1))
    draw.tags.append(f"law {number}")
    given: dict[str, Any] = {"normal_stiffness": draw.one(1e9, 1e10), "shear_stiffness": draw.one(5e8, 5e9)}
    for more in OF_JOINTS[:3]:  # the last is for the plane
        given |= more if draw.often(0.12, next(iter(more))) else {}
    return {"rocks": [rock], "joints": [bsm.Joint("bed", **given, law=(*LAWS, WORN)[number])]}


def _ground(draw: Draw) -> dict[str, Any]:
    """Return supports, loads, in-situ stress and water."""
    rollers = draw.one((), (), ("left",), ("left", "right"))
    found: dict[str, Any] = {
        "supports": [bsm.Fixed(boundary="bottom"), *(bsm.NormalRoller(boundary=name) for name in rollers)],
        "loads": [load for load in LOADS if draw.often(0.15, type(load).__name__)],
    }
    if draw.often(0.25, "in situ"):
        found["in_situ"] = draw.one(*FIELDS)
        if not rollers and draw.often(0.5, "tractions"):
            found["loads"] += [bsm.InSituTraction(boundary=name) for name in ("left", "right")]
    if draw.often(0.5, "water"):
        plane = None
        if draw.often(0.8):
            place, dip = (0, 0, draw.one(0.5, 1.5, 2.5)), draw.one(0, 5, 15)
            plane = bsm.HeadPlane(point=place, dip=dip, dip_direction=draw.one(0, 90, 200))
        own = {"bed": draw.one(0.0, 1e4)} if plane is None or draw.often(0.4, "joint_pressure") else {}
        found["water"] = bsm.Water(plane=plane, joint_pressure=own)
    return found


def _stage(draw: Draw, number: int) -> dict[str, Any]:
    kind = draw.one(*STAGES)
    draw.tags.append(f"stage: {kind}")
    away = {"excavate": [draw.one(*((9, 8, 7), (5, 4, 6))[number])]}
    changes: dict[str, dict[str, Any]] = {
        "excavate": away,
        "relax": {**away, "relaxation": [0.5, 1.0]},
        "pressure": {**away, "pressure": 1e4},
        "fill": {"fill": []},
        "water": {"water": bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 0.2)))},
        "strength": {"strength": {"bed": 0.9}},
        "gravity": {"gravity": (0.05, 0.0), "gravity_trend": draw.one(0.0, 40.0)},
        "load": {"loads": [bsm.Pressure(boundary="top", pressure=2e4)]},
        "nothing": {},
    }
    return {"name": f"stage {number + 1}", **changes[kind]}
