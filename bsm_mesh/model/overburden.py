"""Notes on an in-situ field that does not fit the blocks: ground above them, weights that it does not balance."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import counted
from bsm_mesh.model.in_situ import places_of
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.locate import pairs_at
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import unit_vector

LEAST = 0.05  # of the model's height, on average along its top: less ground is worth no note
UNBALANCED = 0.1  # of the mean unit weight: rocks of several weights have no field in equilibrium


def of_overburden(model: Model) -> Iterator[str]:
    """Say how many blocks lie above the surface, and how much ground lies over a top that nothing loads or holds."""
    field, blocks = model.in_situ, model.blocks
    if field is None or field.surface is None:
        return
    line = "" if isinstance(field.surface, tuple) else "; surface may be the line of the ground, [[x, y], ...]"
    yield from of_blocks_above(model, line)
    edges = _top(model)
    start, end = blocks.vertices[edges], blocks.vertices[blocks.following[edges]]
    width, (x, y) = start[:, 0] - end[:, 0], ((start + end) / 2).T
    given: list[Any] = [*model.supports, *model.loads]
    names = set(blocks.boundaries) & {getattr(part, "boundary", None) for part in given}
    held = [np.array(getattr(part, "blocks", None) or (), dtype=np.int32) for part in model.supports]
    taken = np.concatenate([edges[:0], *(blocks.boundary_edges(name) for name in names)])
    bare = ~np.isin(edges, taken) & ~np.isin(blocks.owner[edges], np.concatenate([edges[:0], *held]))
    if not bare.any():
        return
    ground = float(np.maximum(field.level(x) - y, 0)[bare] @ width[bare] / width[bare].sum())
    if ground > LEAST * float(np.ptp(blocks.vertices[:, 1])):
        bounds = [name for name, own in blocks.boundaries.items() if np.isin(edges[bare], own).any()]
        yield (
            f"in_situ: the surface lies {ground:.4g} m above the top of the model on average, and nothing loads that "
            "top: the stress has the weight of this ground, the model has not. Give "
            f'[[load]] boundary = "{bounds[0] if bounds else "top"}", in_situ = true '
            "(in Python bsm.InSituTraction), or lower the surface"
        )


def of_blocks_above(model: Model, cure: str = "") -> Iterator[str]:
    """Say how many blocks lie above the in-situ surface."""
    centroid = model.blocks.moments.centroid
    if model.in_situ is not None and model.in_situ.surface is not None:
        above = int((centroid[:, -1] > model.in_situ.level(centroid[:, 0])).sum())
        if above:
            yield f"in_situ: {counted(above, 'block')} above the surface: without stress at the start{cure}"


def of_field_and_weights(model: Model) -> Iterator[str]:
    """Say that a field given by its components is not in equilibrium with the weights."""
    field = model.in_situ
    if field is None or field.method != "direct" or field.stress is None:
        return
    spatial = in_space(model.blocks)
    mean = float(model.weights.sum() / model.blocks.moments.bulk.sum())
    off = mean * (np.array([0.0, 0.0, -1.0]) if spatial else unit_vector(model.gravity_direction))
    for (row, column), (_, *gradient) in zip(places_of(field.stress), field.stress, strict=True):
        off[row] += gradient[column]
        off[column] += gradient[row] * (row != column)
    if np.linalg.norm(off) > UNBALANCED * mean > 0:
        vertical = f"zz = [c, 0, 0, {mean:.4g}]" if spatial else f"yy = [c, 0, {mean:.4g}]"
        yield (
            "in_situ: stress does not balance the weights, and blocks move in the stage initial. "
            f"The mean unit weight is {mean:.4g} N/m^3; below level ground that balances {vertical}"
        )


def _top(model: Model) -> IntArray:
    """Return the outer edges that face up with no other block above them."""
    blocks = model.blocks
    edges = blocks.outer_edges
    start, end = blocks.vertices[edges], blocks.vertices[blocks.following[edges]]
    up = start[:, 0] > end[:, 0]  # corners go counter-clockwise
    edges, start, end = edges[up], start[up], end[up]
    height = float(np.ptp(blocks.vertices[:, 1]))
    rows, _ = pairs_at(blocks, (start + end) / 2 + np.array([0.0, 1e-6 * height]))
    free = ~np.isin(np.arange(len(edges)), rows)
    edges, start, end = edges[free], start[free], end[free]
    x, y = ((start + end) / 2).T
    spans = (end[None, :, 0] < x[:, None]) & (x[:, None] < start[None, :, 0])
    higher = spans & ((start[:, 1] + end[:, 1])[None, :] / 2 > y[:, None] + 1e-9 * height)
    top: IntArray = edges[~higher.any(axis=1)]
    return top
