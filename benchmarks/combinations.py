"""Random combinations of features on a small wall: each has an answer that holds, or a message.

``python -m benchmarks.combinations -n N``. Rocks, zones, joint laws, supports, loads, water, flow, in-situ stress,
bolts, histories and stages are drawn at random. Each result is checked, saved, verified, read back and drawn. A
combination fails that ends with another error than `bsm.ModelError`, or whose stable stages do not hold.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
import time
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.model.loads import Load
from examples.numbers.pages import markdown

MAKER = "python -m benchmarks.combinations"
DRAWN = ("displacement", "joints_state", "deformation", "histories", "sigma_1")
LAWS = (
    bsm.MohrCoulomb(friction=35),
    bsm.MohrCoulomb(friction=30, cohesion=5e4, residual_cohesion=0),
    bsm.MohrCoulomb(friction=35, residual_friction=25, softening_slip=1e-3),
    bsm.Patton(friction=30, dilation=5, cohesion=5e4),
    bsm.BartonBandis(jrc=8, jcs=5e7, residual_friction=28),
)
OF_JOINTS: tuple[dict[str, Any], ...] = (
    {"tensile_strength": 2e4},
    {"max_closure": 1e-3},
    {"dilation_angle": 5.0, "dilation_slip": 0.01},
    {"shear_stiffness_exponent": 0.5, "reference_stress": 1e6},
)
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
BOLTS: dict[str, dict[str, Any]] = {
    "grouted": {"bond_strength": 2e5},
    "end-anchored": {"kind": "end_anchored", "anchor_capacity": 2e5},
    "resists shear": {"bond_strength": 2e5, "bearing_stiffness": 1e9},
    "pretensioned": {"pretension": 2e4, "yield_strength": 5e8},
}
STAGES = ("excavate", "relax", "pressure", "fill", "water", "strength", "gravity", "shaking", "load", "nothing")
SHAKEN: tuple[dict[str, Any], ...] = (
    {},
    {"contact_damping": 0.1},
    {"contact_damping": "housner"},
    {"mass_damping": (0.05, 5.0)},
    {"integrator": "implicit"},
)


class Draw:
    """Draws the combination of a seed; `tags` are the features that it has."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self.tags: list[str] = []

    def one(self, *choices: Any) -> Any:
        """Return one of some choices."""
        return choices[self._random.integers(len(choices))]

    def often(self, share: float, tag: str = "") -> bool:
        """Return whether a feature is drawn, with a share of all seeds."""
        drawn = bool(self._random.random() < share)
        self.tags += [tag] if drawn and tag else []
        return drawn


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
    for former, stage in pairwise(stages):
        stage |= {"fill": former.get("excavate", [])} if "fill" in stage else {}
    if draw.often(0.35):
        kind = draw.one(*BOLTS)
        draw.tags.append(f"bolt: {kind}")
        late = {"stage": "stage 1"} if stages and draw.often(0.5, "late bolt") else {}
        parts["bolts"] = [bsm.Bolt(start=(2.2, 2.9), end=(2.4, 0.2), diameter=0.025, name="B", **BOLTS[kind], **late)]
    if draw.often(0.4, "histories"):
        places: list[dict[str, Any]] = [{"point": (2, 2.5)}, {"block": 10}, {"joint": "bed"}]
        places += [{"line": [(0.5, 0.5), (0.5, 2.5)]}, *[{"bolt": "B"}] * ("bolts" in parts)]
        parts["histories"] = [bsm.History(f"h{number}", **place) for number, place in enumerate(places)]
    parts["stages"] = [bsm.Stage(**stage) for stage in stages]
    if draw.often(0.3, "gauss"):
        parts["contact_points"] = "gauss"
    options = bsm.Options(threads=1, max_steps=60)
    if draw.often(0.1, "falls removed"):
        options = replace(options, falls=bsm.Falls(on_fall="remove"))
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


def judged(seed: int) -> dict[str, Any]:
    """Return the answer to a combination: its verdict or ``refused``, and faults."""
    parts, options, tags = combination(seed)
    begun = time.process_time()
    told: dict[str, Any] = {"seed": seed, "tags": tags, "faults": []}
    try:
        results = bsm.run(bsm.Model(**parts), options)
        told |= {"verdict": str(results.status), "reason": results.stages[-1].reason}
        told["faults"] = _faults(results)
    except bsm.ModelError as error:
        told |= {"verdict": "refused", "reason": str(error)}
    except Exception as error:
        told |= {"verdict": "error", "reason": f"{type(error).__name__}: {error}", "faults": ["error"]}
    return {**told, "seconds": round(time.process_time() - begun, 2)}


def _faults(results: bsm.Results) -> list[str]:
    """Return which of check, certificate, reading and drawing do not hold."""
    found = [] if results.status != "stable" or results.check().ok else ["check"]
    with tempfile.TemporaryDirectory() as place, contextlib.redirect_stdout(io.StringIO()):
        folder = results.save(Path(place) / "out")
        found += ["certificate"] * (verify_certificate.main(folder) != 0)
        back = bsm.Results.load(folder)
    found += ["read back"] * (back.status != results.status)
    for picture in DRAWN:
        with contextlib.suppress(bsm.ModelError):  # there is nothing to show
            back.plot(picture)
    return found


def table(records: list[dict[str, Any]]) -> str:
    """Return verdicts and processor times, and the combinations with a fault."""
    verdicts = Counter(record["verdict"] for record in records)
    seconds = {name: sum(r["seconds"] for r in records if r["verdict"] == name) for name in verdicts}
    rows = [(name, str(count), f"{seconds[name]:.0f}") for name, count in sorted(verdicts.items())]
    wrong = [f"seed {r['seed']}: {', '.join(r['faults'])} ({', '.join(r['tags'])})" for r in records if r["faults"]]
    return "\n".join([markdown(("answer", "combinations", "processor time, s"), rows), "", *wrong])


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, 300, judged, table))
