"""Water above surfaces that stages excavate: it presses on them as a pond does, which is often not meant."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bsm_mesh.errors import place
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import presence

LEAST_DEPTH = 1e-3  # of the model's height: less water is not worth a note


def of_water_on_excavations(model: Model) -> Iterator[str]:
    """Say which stages excavate surfaces below the water table, and the greatest depth of the water on them."""
    digs = [stage for stage in model.stages if stage.excavate]
    if not digs or (model.water is None and all(stage.water is None for stage in model.stages)):
        return
    blocks, water = model.blocks, model.water
    faces = find_faces(blocks)
    sides = blocks.owner[np.stack([faces.edge_a, faces.edge_b])]
    middle = (faces.start + faces.end) / 2
    least = LEAST_DEPTH * float(np.ptp(blocks.vertices[:, 1]))
    here = presence(model.stages, blocks)
    names, depth, where = [], least, middle[:1]
    for stage, before, now in zip(model.stages, here, here[1:], strict=False):
        water = water if stage.water is None else stage.water
        exposed = before[sides].all(axis=0) & (now[sides].sum(axis=0) == 1)
        if water is None or not exposed.any():
            continue
        below = water.surface().at(middle[exposed, 0]) - middle[exposed, 1]
        deepest = int(below.argmax())
        if below[deepest] > least:
            names.append(f"'{stage.name}'")
        if below[deepest] > depth:
            depth, where = float(below[deepest]), middle[exposed][deepest]
    if names:
        stages = f"stage {names[0]}" if len(names) == 1 else f"stages {', '.join(names)}"
        yield (
            f"{stages}: the water table lies up to {depth:.3g} m above excavated surfaces, deepest at {place(where)}: "
            "the water presses on them like a pond. If the excavation is drained, lower the table in the stage "
            "(water = { table = [[x, y], ...] })"
        )
