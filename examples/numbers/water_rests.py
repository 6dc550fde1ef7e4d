"""Numbers on a block that slides with water behind it: where statics and energy let it rest, and where runs do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

import bsm_mesh as bsm
from benchmarks.slices import extruded
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.strength import with_strength
from examples.numbers.pages import Table, markdown
from tests.scenes.known_factors import known

PAGE = "docs/verification_3d.md"
NAMES = ("3 m of water in the crack, no cohesion", "7 m of water in the crack, no cohesion")
BEYOND = 1.05  # of the known factor
BLOCK = 1
PLACES = np.linspace(0.0, 40.0, 4001)  # m along the plane
ALONG_EDGE = (np.arange(1000) + 0.5) / 1000


def excess(model: bsm.Model, down: FloatArray) -> FloatArray:
    """Return pull less friction on a block that slides down a plane, at all `PLACES` [N/m].

    Its weight and the water below a straight table act on it: statics of a rigid block, with the pressure summed along
    its edges. `down` (2,) is the unit vector down the plane.
    """
    blocks, table = model.blocks, np.array(model.water.table[0])
    corners = blocks.vertices[blocks.offsets[BLOCK] : blocks.offsets[BLOCK + 1]]
    sides = np.roll(corners, -1, axis=0) - corners
    points = corners[:, None, :] + ALONG_EDGE[:, None] * sides[:, None, :] + PLACES[:, None, None, None] * down
    level = table[0, 1] + np.diff(table[:, 1]) / np.diff(table[:, 0]) * (points[..., 0] - table[0, 0])
    pressure = model.water.unit_weight * np.maximum(level - points[..., 1], 0.0).mean(axis=2)
    force = pressure @ np.column_stack([-sides[:, 1], sides[:, 0]])
    force[:, 1] -= model.rocks[blocks.rock[BLOCK]].unit_weight * blocks.moments.area[BLOCK]
    across = np.array([down[1], -down[0]])  # down and to the left: into the plane
    across = across if across[1] < 0 else -across
    friction = next(joint.law.friction for joint in model.joints if joint.law.friction > 0)
    pull: FloatArray = force @ down - np.tan(np.radians(friction)) * (force @ across)
    return pull


def rests() -> str:
    """Return the first rest by statics, the last one by energy, and those of runs in the plane and in space."""
    rows = []
    for each in known():
        if not each.name.endswith(NAMES):
            continue
        model = with_strength(each.build(), dict.fromkeys(each.joints or ("*",), 1 / (BEYOND * each.factor)))
        options = replace(model.options or bsm.Options(), threads=1, scheme="continuation")
        ends = [bsm.run(one, options).stages[-1].displacement[BLOCK] for one in (model, extruded(model))]
        plane = ends[0][:2]
        pull = excess(model, plane / np.linalg.norm(plane))
        first = PLACES[np.argmax(pull <= 0)]
        last = PLACES[1:][np.argmax(cumulative_trapezoid(pull, PLACES) < 0)]
        found = float(np.linalg.norm(plane)), float(np.linalg.norm(ends[1][:3]))
        rows.append((each.name, f"{first:.2f}", *(f"{value:.2f}" for value in found), f"{last:.2f}"))
    return markdown(("model", "first rest [m]", "plane [m]", "slice [m]", "last rest [m]"), rows)


TABLES = (Table(name="water_rests", page=PAGE, make=rests, tolerance=0.02, is_slow=True),)
