"""Limit analysis of rock with free faces: whether the whole of it, or the rest without some blocks, can be at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.errors import ModelError
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.renewal import points_apart, touching_points
from bsm_mesh.three_d.contacts.surfaces import Surfaces
from bsm_mesh.three_d.limit.analysis import ConeAnalysis, LimitAnalysis3D, weights
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.strength import cone_strength
from bsm_mesh.three_d.model.parts import some_polyhedra

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

    Blocks that reach outer faces other than `free` boundaries are fixed. The answer has the blocks that are present.

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
    part, _ = some_polyhedra(blocks, present)
    fixed = np.zeros(part.count, dtype=bool)
    fixed[part.boundary_blocks(*(name for name in part.boundaries if name not in free))] = True
    of_faces = LimitPoints.of(part.contact_polygons)
    count = int((~(fixed[of_faces.block_a] & fixed[of_faces.block_b])).sum())
    if count > MAX_POINTS:
        raise ModelError(
            f"limit analysis: {count} contact points, more than {MAX_POINTS}; take a smaller box or a wider spacing"
        )
    analysis = LimitAnalysis3D(part.moments, of_faces.with_more(_touching(part, fixed)), fixed)
    acting = weights(part.moments, materials.unit_weights(part)) if loads is None else loads[present]
    return analysis.analyse(acting, cone_strength(materials, part, analysis.points))


def _touching(blocks: Polyhedra, fixed: BoolArray) -> LimitPoints:
    """Return the points of blocks that share no face and touch, all but `fixed` ones (n,) free to move."""
    moves = ~fixed
    size = float(np.median(blocks.moments.size[moves if moves.any() else fixed]))
    start, near = np.zeros((blocks.count, 6)), RULES.rounding * size
    apart = points_apart(Surfaces(blocks=blocks, rule="both"), start, fixed, near, size)
    return LimitPoints.touching(blocks, touching_points(apart, size), size)
