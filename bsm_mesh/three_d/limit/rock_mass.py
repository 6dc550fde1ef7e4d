"""Limit analysis of rock with free faces: whether the whole of it, or the rest without some blocks, can be at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.limit.analysis import ConeAnalysis, LimitAnalysis3D, weights
from bsm_mesh.three_d.limit.strength import cone_strength

MAX_POINTS = 60_000  # of contact: beyond, a program takes minutes and gigabytes


def analyse_rock(
    blocks: Polyhedra,
    materials: Materials,
    present: BoolArray,
    *,
    free: Sequence[str] = (),
    loads: FloatArray | None = None,
) -> ConeAnalysis:
    """Return whether forces within strength balance the loads on the blocks that are present.

    Blocks that reach outer faces other than `free` boundaries are fixed.

    Parameters
    ----------
    blocks, materials : Polyhedra, Materials
        The rock.
    present : (n,) bool
        The blocks that are there.
    free : sequence of str
        Free boundaries.
    loads : (n, 6) float64, optional [N, N m]
        Forces on all blocks and moments about their centroids; by default the weights.

    Raises
    ------
    ModelError
        If no block can move, a law has no straight lines, or there are too many contact points.
    """
    fixed = ~present
    fixed[blocks.boundary_blocks(*(name for name in blocks.boundaries if name not in free))] = True
    polygons = blocks.contact_polygons
    polygons = polygons.some(np.flatnonzero(present[polygons.block_a] & present[polygons.block_b]))
    analysis = LimitAnalysis3D(blocks.moments, polygons, fixed)
    if analysis.points.count > MAX_POINTS:
        raise ModelError(
            f"limit analysis: {analysis.points.count} contact points, more than {MAX_POINTS}; take a smaller box or a "
            "wider spacing"
        )
    if loads is None:
        loads = weights(blocks.moments, materials.unit_weights(blocks))
    return analysis.analyse(loads, cone_strength(materials, blocks, analysis.polygons, analysis.points))
