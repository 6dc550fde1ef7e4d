"""Combinations in the plane: rocks, zones, laws, supports, loads, water, flow, stress, bolts, histories and stages."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.combinations.draw import LAWS, OF_JOINTS, Draw, in_time, options_of
from bsm_mesh.model.loads import Load

FIELDS = (
    bsm.InSitu(surface=3.0, k0=0.5),
    bsm.InSitu(surface=3.0, k0=0.5, method="gravity"),
    bsm.InSitu(stress={"yy": (-72e3, 0, 24e3), "xx": (-36e3, 0, 12e3), "xy": 0}),
)
LOADS: tuple[Load, ...] = (
    bsm.Pressure(boundary="top", pressure=5e4),
    bsm.Traction(boundary="top", traction=(3e3, -1e4)),
    bsm.PointLoad(block=10, point=(1.5, 2.5), force=(2e3, -1e4)),
    bsm.EarthPressure(boundary="left", state="active", unit_weight=19e3, friction=30, surface=3.0),
)
STAGES = ("excavate", "relax", "pressure", "fill", "water", "strength", "gravity", "shaking", "load", "nothing")
SHAKEN: tuple[dict[str, Any], ...] = (
    {},
    {"contact_damping": 0.1},
    {"contact_damping": "housner"},
    {"mass_damping": (0.05, 5.0)},
    {"integrator": "implicit"},
)


@cache
def wall() -> bsm.Blocks:
    """Return three courses of bricks in bond on a base."""
    rows = [(0, 1, 2, 3, 4), (0, 1.5, 2.5, 3.5, 4), (0, 1, 2, 3, 4)]
    bricks = [(a, row, b, row + 1) for row, ends in enumerate(rows) for a, b in pairwise(ends)]
    boxes = [(-1, -1, 5, 0), *bricks]
    outlines = [[(a, low), (b, low), (b, high), (a, high)] for a, low, b, high in boxes]
    blocks = bsm.Blocks.from_polygons(outlines, rock=["base", *["stone"] * len(bricks)])
    return (
        blocks.with_boundary("bottom", lambda x, y: y < -1 + 1e-9)
        .with_boundary("left", lambda x, y: (np.abs(x) < 1e-9) & (y > -1e-9))
        .with_boundary("right", lambda x, y: (np.abs(x - 4) < 1e-9) & (y > -1e-9))
        .with_boundary("top", lambda x, y: y > 3 - 1e-9)
        .with_joint(
            "bed", lambda x, y: (np.abs(y - np.round(y)) < 1e-9) & (y < 2.9) & (y > -0.1) & (x > -0.1) & (x < 4.1)
        )
    )


def combination(seed: int) -> tuple[dict[str, Any], bsm.Options, list[str]]:
    """Return the parts of a model, its options, and the names of its features."""
    draw = Draw(seed)
    parts = {"blocks": wall(), "default_joint": "head", **_rocks(draw)}
    flow = draw.often(0.2, "flow")
    parts |= {**_joints(draw, flow), **_ground(draw, flow)}
    stages = [_stage(draw, number, flow) for number in range(draw.one(0, 1, 2))]
    bolt = {"start": (2.2, 2.9), "end": (2.4, 0.2)}
    parts |= in_time(draw, stages, bolt, {"point": (2, 2.5)}, {"block": 10}, {"line": [(0.5, 0.5), (0.5, 2.5)]})
    if draw.often(0.3, "gauss"):
        parts["contact_points"] = "gauss"
    options = options_of(draw)
    if draw.often(0.1, "linear"):
        options = replace(options, scheme="linear")
    return parts, options, draw.tags


def _rocks(draw: Draw) -> dict[str, Any]:
    zones = draw.one("", "", "small", "large")
    elastic = bool(zones) or draw.often(0.5, "elastic")
    yields = bool(zones) and draw.often(0.3, "yields")
    draw.tags.append(f"{zones} zones" if zones else "rigid")
    given: dict[str, Any] = {"young": draw.one(1e9, 2e10), "poisson": 0.2} if elastic else {}
    if zones:
        law = "mohr_coulomb" if yields else "elastic"
        given["zones"] = bsm.Zones(size=draw.one(0.5, 1.0, None), order=draw.one(1, 2), displacement=zones, law=law)
    if yields or draw.often(0.15, "strength"):
        given |= {"cohesion": draw.one(2e5, 1e6), "friction": 40, "tensile_strength": 1e5}
    base = given if draw.often(0.5) else {}
    return {"rocks": [bsm.Rock("base", unit_weight=25e3, **base), bsm.Rock("stone", unit_weight=24e3, **given)]}


def _joints(draw: Draw, flow: bool) -> dict[str, Any]:
    number = draw.one(*range(len(LAWS)))
    draw.tags.append(f"law {number}")
    given: dict[str, Any] = {"normal_stiffness": draw.one(1e9, 1e10), "shear_stiffness": draw.one(5e8, 5e9)}
    for more in OF_JOINTS:
        given |= more if draw.often(0.12, next(iter(more))) else {}
    given |= {"aperture": 1e-4, "residual_aperture": 1e-5} if flow else {}
    head = bsm.Joint("head", **given, law=bsm.MohrCoulomb(friction=30))
    return {"joints": [bsm.Joint("bed", **given, law=LAWS[number]), head]}


def _ground(draw: Draw, flow: bool) -> dict[str, Any]:
    """Return supports, loads, in-situ stress and water."""
    rollers = draw.one((), (), ("left",), ("left", "right"))
    found: dict[str, Any] = {
        "supports": [bsm.Fixed(boundary="bottom"), *(bsm.NormalRoller(boundary=name) for name in rollers)],
        "loads": [load for load in LOADS if draw.often(0.12, type(load).__name__)],
    }
    if rollers:
        found["loads"] = [load for load in found["loads"] if not isinstance(load, bsm.EarthPressure)]
    if draw.often(0.25, "in situ"):
        found["in_situ"] = draw.one(*FIELDS)
        if not rollers and draw.often(0.5, "tractions"):
            found["loads"] += [bsm.InSituTraction(boundary=name) for name in ("left", "right")]
    if flow:
        coupling = draw.one("one_way", "two_way")
        found["flow"] = bsm.Flow(head={"left": draw.one(2.0, 3.5)}, seepage=["right"], coupling=coupling)
    elif draw.often(0.35, "water"):
        table = [(-2, draw.one(0.5, 1.5, 2.5)), (6, draw.one(0.5, 1.5))] if draw.often(0.8) else []
        own = {"bed": 1e4} if not table or draw.often(0.3, "joint_pressure") else {}
        found["water"] = bsm.Water(table=table, joint_pressure=own)
    return found


def _stage(draw: Draw, number: int, flow: bool) -> dict[str, Any]:
    kind = draw.one(*STAGES)
    draw.tags.append(f"stage: {kind}")
    away = {"excavate": [draw.one(*((12, 11, 9), (8, 7, 10))[number])]}
    low: dict[str, Any] = {"flow": bsm.FlowChange(head={"left": 1.0})}
    low = low if flow else {"water": bsm.Water(table=[(-2, 0.2), (6, 0.2)])}
    wave = bsm.Shaking(waveform="sine", frequency=5.0, cycles=2, amplitude=0.5, **draw.one(*SHAKEN))
    changes: dict[str, dict[str, Any]] = {
        "excavate": away,
        "relax": {**away, "relaxation": [0.5, 1.0]},
        "pressure": {**away, "pressure": 1e4},
        "fill": {"fill": []},
        "water": low,
        "strength": {"strength": {"bed": 0.9}},
        "gravity": {"gravity": (0.05, 0.0)},
        "shaking": {"shaking": wave},
        "load": {"loads": [bsm.Pressure(boundary="top", pressure=2e4)]},
        "nothing": {},
    }
    return {"name": f"stage {number + 1}", **changes[kind]}
