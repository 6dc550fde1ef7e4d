"""Water above surfaces that stages excavate: it presses on them as a pond does, which is often not meant."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import place
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import presence
from bsm_mesh.model.water import Water

LEAST_DEPTH = 1e-3  # of the model's height: less water is not worth a note


def of_water_on_excavations(model: Model) -> Iterator[str]:
    """Say which stages excavate surfaces below the water, and the greatest depth of the water on them."""
    digs = [stage for stage in model.stages if stage.excavate]
    if not digs or (model.water is None and all(stage.water is None for stage in model.stages)):
        return
    sides, middle = _faces_between_blocks(model)
    here = presence(model.stages, model.blocks)
    names, depth, where, water = [], least_depth(model), middle[:1], model.water
    for stage, before, now in zip(model.stages, here, here[1:], strict=False):
        water = water if stage.water is None else stage.water
        exposed = np.flatnonzero(before[sides].all(axis=1) & (now[sides].sum(axis=1) == 1))
        if water is None or not exposed.size:
            continue
        below = depths_below(water, middle[exposed])
        deepest = int(below.argmax())
        if below[deepest] > least_depth(model):
            names.append(f"'{stage.name}'")
        if below[deepest] > depth:
            depth, where = float(below[deepest]), middle[exposed[deepest]]
    if names:
        stages = f"stage {names[0]}" if len(names) == 1 else f"stages {', '.join(names)}"
        surface, form = ("plane", "{ point = [x, y, z] }") if in_space(model.blocks) else ("table", "[[x, y], ...]")
        yield (
            f"{stages}: the water {surface} lies up to {depth:.3g} m above excavated surfaces, deepest at "
            f"{place(where)}: the water presses on them like a pond. If the excavation is drained, lower the {surface} "
            f"in the stage (water = {{ {surface} = {form} }})"
        )


def depths_below(water: Water, points: FloatArray) -> FloatArray:
    """Return the depths of points (k, 2) or (k, 3) below the surface of the water, (k,) [m]; -inf: there is none."""
    if points.shape[1] == 3:
        none = np.full(len(points), -np.inf)
        return none if water.plane is None else (water.plane.point - points) @ water.plane.up
    return water.surface().at(points[:, 0]) - points[:, 1]


def least_depth(model: Model) -> float:
    """Return the depth of water on a surface that is worth a note [m]."""
    return LEAST_DEPTH * float(np.ptp(model.blocks.vertices[:, -1]))


def _faces_between_blocks(model: Model) -> tuple[IntArray, FloatArray]:
    """Return the two blocks of every face, (k, 2), and the middles of the faces, (k, 2) or (k, 3)."""
    blocks = model.blocks
    if not in_space(blocks):
        faces = find_faces(blocks)
        return blocks.owner[np.column_stack([faces.edge_a, faces.edge_b])], (faces.start + faces.end) / 2
    corners, sizes = blocks.vertices[blocks.face_vertices], np.diff(blocks.face_offsets)
    middle = np.add.reduceat(corners, blocks.face_offsets[:-1]) / sizes[:, None]
    between = (blocks.face_blocks >= 0).all(axis=1) & (blocks.face_blocks[:, 0] != blocks.face_blocks[:, 1])
    return blocks.face_blocks[between], middle[between]
