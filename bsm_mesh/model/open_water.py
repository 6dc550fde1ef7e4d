"""Water above the ground as given: open water is level, so that a water surface that slopes there is a mistake."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import place
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.excavated_water import depths_below, least_depth
from bsm_mesh.model.model import Model
from bsm_mesh.model.water import Water

MIN_SLOPE = 0.01  # of a water surface that is no open water; rivers fall by less
SAMPLES = 401  # abscissas of the ground's surface


def of_sloping_open_water(model: Model, ground_of: Callable[[Any], FloatArray]) -> Iterator[str]:
    """Report where a surface of groundwater slopes above the ground, and its greatest height above it.

    `ground_of` returns points of the ground's surface, (k, 2) or (k, 3) [m], of blocks.
    """
    waters = (("water", model.water), *((f"stage '{stage.name}': water", stage.water) for stage in model.stages))
    given = [(told, water) for told, water in waters if water is not None]
    ground = ground_of(model.blocks) if given else np.zeros((0, 2))
    for told, water in given:
        if not len(ground):
            continue
        depth = np.where(_slopes(water, ground), depths_below(water, ground), -np.inf)
        if depth.max() <= least_depth(model):
            continue
        surface = "plane" if ground.shape[1] == 3 else "table"
        yield (
            f"{told}: the {surface} slopes and lies up to {depth.max():.3g} m above the ground, most at "
            f"{place(ground[int(depth.argmax())].round(3))}: it presses there as open water, which is level. "
            f"Lower the {surface} to the ground, or make it level there"
        )


def ground_line(blocks: Blocks) -> FloatArray:
    """Return points of the highest outer edges from left to right, (k, 2) [m]."""
    edges = blocks.outer_edges
    start, end = blocks.vertices[edges], blocks.vertices[blocks.following[edges]]
    way = end[:, 0] - start[:, 0]
    left, right = np.minimum(start[:, 0], end[:, 0]), np.maximum(start[:, 0], end[:, 0])
    low, high = blocks.extent
    points = []
    for x in (low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES).tolist():
        met = (left < x) & (x < right)
        if met.any():
            height = start[met, 1] + (x - start[met, 0]) / way[met] * (end[met, 1] - start[met, 1])
            points.append((x, float(height.max())))
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def _slopes(water: Water, points: FloatArray) -> BoolArray:
    """Return at which points (k, 2) or (k, 3) the surface of the water slopes, (k,)."""
    if points.shape[1] == 3:
        steep = water.plane is not None and float(np.hypot(*water.plane.up[:2])) > MIN_SLOPE
        return np.full(len(points), steep)
    surface = water.surface()
    steep_pieces: BoolArray = np.abs(surface.slope[np.searchsorted(surface.breaks, points[:, 0])]) > MIN_SLOPE
    return steep_pieces
