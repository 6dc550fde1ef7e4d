"""Chapter 6 of the thesis: pressure of the groundwater on faces and blocks, and water where closed forms know it."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.water_pressure import WaterLoad
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import rectangle
from verification.case import Answer, Case
from verification.thesis_matrices import Array, matrix_b

EXACT = 1e-12
WATER = 9810.0
OUTLINES = (
    np.array([(0, 0), (3, 0.5), (2.5, 2), (0.5, 1.5)]),
    np.array([(0.0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)]),  # concave
)


def _model(outline: Array, water: bsm.Water, unit_weight: float = 0.0) -> bsm.Model:
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([outline], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=unit_weight)],
        supports=[bsm.Fixed(blocks=[0])],
        water=water,
    )


def _faces(outline: Array, level: float) -> tuple[Array, Array, Array]:
    """Return length of every face, and depths of both ends below a level water table."""
    ends = np.roll(outline, -1, axis=0)
    return np.hypot(*(ends - outline).T), level - outline[:, 1], level - ends[:, 1]


def submerged_faces() -> Answer:
    """Compare two forces at the ends of faces wholly under water."""
    exact, found = [], []
    for outline in OUTLINES:
        length, h1, h2 = _faces(outline, 5.0)
        q1, q2 = WATER * h1, WATER * h2
        exact.append(np.column_stack([length * (2 * q1 + q2) / 6, length * (2 * q2 + q1) / 6]))
        water = WaterLoad(_model(outline, bsm.Water(table=[(0, 5.0)])))
        found.append(water.on_faces(outline, np.roll(outline, -1, axis=0)))
    return np.concatenate(exact), np.concatenate(found)


def partly_submerged_faces() -> Answer:
    """Compare faces whose one end is above the table: the wet length l' and the two forces of R = q l' / 2."""
    outline, level = OUTLINES[0], 0.9
    exact = np.zeros((len(outline), 2))
    for k, (length, h1, h2) in enumerate(zip(*_faces(outline, level), strict=True)):
        deep, high = max(h1, h2), min(h1, h2)
        if high >= 0 or deep <= 0:
            continue
        wet = abs(deep) / (abs(deep) + abs(high)) * length  # Eq. 6.5
        resultant = wet * WATER * deep / 2  # Eq. 6.3
        near, far = (1 - wet / (3 * length)) * resultant, wet / (3 * length) * resultant  # Eq. 6.4
        exact[k] = (near, far) if h1 > h2 else (far, near)
    found = WaterLoad(_model(outline, bsm.Water(table=[(0, level)]))).on_faces(outline, np.roll(outline, -1, axis=0))
    partly = exact.any(axis=1)
    return exact[partly], found[partly]


def water_on_blocks() -> Answer:
    """Compare components of the forces at the corners, and their force and moment on the block."""
    exact, found = [], []
    for outline in OUTLINES:
        model = _model(outline, bsm.Water(table=[(0, 5.0)]))
        centroid, total = model.blocks.moments.centroid[0], np.zeros(3)
        ends = np.roll(outline, -1, axis=0)
        for start, end, length, h1, h2 in zip(outline, ends, *_faces(outline, 5.0), strict=True):
            c = np.array([(end - start)[1], -(end - start)[0]]) / length  # outward normal
            q1, q2 = WATER * h1, WATER * h2
            for point, force in ((start, length * (2 * q1 + q2) / 6), (end, length * (2 * q2 + q1) / 6)):
                total += matrix_b(centroid, point).T @ (-c * force)  # Eqs. 6.6, 6.7
        exact.append(total)
        found.append(bsm.run(model, LINEAR).stages[0].water[0])
    return np.array(exact), np.array(found)


def archimedes() -> Answer:
    """Compare reaction under a submerged block: its weight less that of the water it takes the place of."""
    from shapely import Polygon

    exact, found = [], []
    for outline in OUTLINES:
        exact.append((26e3 - WATER) * Polygon(outline).area)
        stage = bsm.run(_model(outline, bsm.Water(table=[(0, 10)]), 26e3), LINEAR).stages[0]
        found.append(stage.reactions[0, 1])
    return np.array(exact), np.array(found)


def bent_table() -> Answer:
    """Compare force and moment on a block under a table that bends between its corners."""
    table = np.array([(0.4, 0.3), (0.6, 1.2), (1.1, 0.4), (5, -1.5), (6, 0.5)])
    t = ((np.arange(200_000) + 0.5) / 200_000)[:, None]
    exact, found = [], []
    for outline in OUTLINES:
        model = _model(outline, bsm.Water(table=[tuple(p) for p in table]))
        centroid, total = model.blocks.moments.centroid[0], np.zeros(3)
        for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            x = start + t * (end - start)
            pressure = WATER * np.maximum(np.interp(x[:, 0], *table.T) - x[:, 1], 0)
            force = pressure[:, None] * np.array([-(end - start)[1], (end - start)[0]]) / len(t)
            arm = x - centroid
            total += [*force.sum(axis=0), (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum()]
        exact.append(total)
        found.append(bsm.run(model, LINEAR).stages[0].water[0])
    return np.array(exact), np.array(found)


def on_rock(
    block: Array, below: Array, water: bsm.Water | None, unit_weight: float, **given: Any
) -> tuple[float, float, Array]:
    """Return effective normal force, shear force, and normal forces by rising x, of a block on fixed rock."""
    joint = bsm.Joint("J", normal_stiffness=1e10, shear_stiffness=1e9)
    results = bsm.run(model_of([below, block], gamma=unit_weight, joint=joint, water=water, **given), LINEAR)
    assert results.check().ok
    contacts = results.stages[-1].contacts
    pressed = -contacts.normal_force
    return float(pressed.sum()), abs(float(contacts.shear_force.sum())), pressed[np.argsort(contacts.point[:, 0])]


def infinite_slope(head: str) -> Answer:
    """Compare factors of safety of a slab with the table parallel to the slope at 0, 2.5 and 5 m above its base."""
    b, z, gamma, length, tan_phi = math.radians(30), 5.0, 26e3, 8.0, math.tan(math.radians(35))
    slope, exact, found = math.tan(b), [], []
    block = np.array([(0, 0), (length, slope * length), (length, slope * length + z), (0, z)])
    below = np.array([(0, -20.0), (length, -20.0), (length, slope * length), (0, 0)])
    for depth in (0.0, 2.5, 5.0):
        table = [(x, slope * x + depth) for x in (-50.0, 50.0)]
        water = bsm.Water(table=table, head=head) if depth else None
        pressed, sheared, _ = on_rock(block, below, water, gamma)
        part = math.cos(b) ** 2 if head == "parallel" else 1.0
        effective = gamma * z * math.cos(b) ** 2 - WATER * depth * part
        exact.append(effective * tan_phi / (gamma * z * math.sin(b) * math.cos(b)))
        found.append(pressed * tan_phi / sheared)
    return np.array(exact), np.array(found)


def gravity_dam(*, uplift: bool) -> Answer:
    """Compare factors of sliding at 45 degrees, without and with 200 kPa, and the forces at heel and toe."""
    H, B, gamma = 50.0, 40.0, 24e3
    water = bsm.Water(table=[(-50, H), (0, H), (B, 0)], joint_pressure={} if uplift else {"J": 0.0})
    pressed, sheared, (heel, toe) = on_rock(np.array([(0, 0), (B, 0), (0, H)]), rectangle(0, -10, B, 0), water, gamma)
    W, thrust, up = gamma * H * B / 2, WATER * H**2 / 2, WATER * H * B / 2 if uplift else 0.0
    at_toe = (W * B / 3 + thrust * H / 3 - up * B / 3) / B  # moments about the heel
    exact = [(W - up) / thrust, (W - up + 200e3 * B) / thrust, (W - up - at_toe) / W, at_toe / W]
    return np.array(exact), np.array([pressed / sheared, (pressed + 200e3 * B) / sheared, heel / W, toe / W])


def column_under_water() -> Answer:
    """Compare total and effective vertical stress of ten blocks under 12 m of water, compression positive."""
    n, head = 10, 12.0
    blocks = bsm.Blocks.from_polygons([rectangle(0, k, 1, k + 1) for k in range(n)], rock="rock")
    model = bsm.Model(
        blocks=blocks.with_boundary("bottom", lambda x, y: y < 1e-9),
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=[bsm.Joint("J", 1e10, 1e9)],
        default_joint="J",
        supports=[bsm.NormalRoller(boundary="bottom"), bsm.Roller(point=(0.5, 0.5), direction=0)],
        water=bsm.Water(table=[(0, head)]),
    )
    stage = bsm.run(model, LINEAR).stages[0]
    y = np.arange(n) + 0.5
    total = 26e3 * (n - y) + WATER * (head - n)
    exact = np.concatenate([total, total - WATER * (head - y)])
    return exact, -np.concatenate([stage.stress[:, 1, 1], stage.stress_effective[:, 1, 1]])


CASES = (
    Case(name="submerged-faces", what="forces at the ends of submerged faces", source="wang", quantity="force [N/m]",
         compute=submerged_faces, tolerance=EXACT, equations=("6.1", "6.2")),
    Case(name="partly-submerged-faces", what="forces at the ends of faces that rise out of the water", source="wang",
         quantity="force [N/m]", compute=partly_submerged_faces, tolerance=EXACT, equations=("6.3", "6.4", "6.5")),
    Case(name="water-on-blocks", what="force and moment of the water on blocks", source="wang",
         quantity="force [N/m], moment [N]", compute=water_on_blocks, tolerance=EXACT, equations=("6.6", "6.7")),
    Case(name="archimedes", what="a convex and a concave block under water", source="archimedes",
         quantity="reaction [N/m]", compute=archimedes, tolerance=EXACT),
    Case(name="bent-table", what="blocks under a table with four bends", source="quadrature",
         quantity="force [N/m], moment [N]", compute=bent_table, tolerance=1e-9),
    Case(name="infinite-slope-vertical", what="slab, water by vertical depth (Eq. 6.1)", source="wang",
         quantity="factor of safety", compute=lambda: infinite_slope("vertical"), tolerance=EXACT),
    Case(name="infinite-slope-parallel", what="slab, seepage parallel to the slope", source="skempton",
         quantity="factor of safety", compute=lambda: infinite_slope("parallel"), tolerance=EXACT),
    Case(name="gravity-dam", what="triangular dam, full reservoir, uplift to the toe", source="statics",
         quantity="factors; heel, toe over weight", compute=partial(gravity_dam, uplift=True), tolerance=EXACT),
    Case(name="drained-dam", what="the same without uplift", source="statics",
         quantity="factors; heel, toe over weight", compute=partial(gravity_dam, uplift=False), tolerance=EXACT),
    Case(name="column-under-water", what="total and effective stress of a column", source="statics",
         quantity="stress [Pa]", compute=column_under_water, tolerance=EXACT),
)  # fmt: skip
