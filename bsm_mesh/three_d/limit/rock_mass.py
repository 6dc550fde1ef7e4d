"""Limit analysis of rock with free faces: whether the whole of it, or the rest without some blocks, can be at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
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
    gravity: Sequence[float] = (0.0, 0.0, -1.0),
    joint_pressure: Mapping[str, float] | None = None,
) -> ConeAnalysis:
    """Return whether forces within strength balance the weights of the blocks that are present.

    Blocks that reach outer faces other than `free` boundaries are fixed.

    Parameters
    ----------
    blocks, materials : Polyhedra, Materials
        The rock.
    present : (n,) bool
        The blocks that are there.
    free, gravity, joint_pressure
        As for `bsm_mesh.three_d.key_blocks.analysis.key_blocks`.

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
    loads = weights(blocks.moments, materials.unit_weights(blocks), gravity)
    loads += _thrusts(blocks, polygons, joint_pressure or {})
    return analysis.analyse(loads, cone_strength(materials, blocks, analysis.polygons, analysis.points))


def _thrusts(blocks: Polyhedra, polygons: ContactPolygons, joint_pressure: Mapping[str, float]) -> FloatArray:
    """Return the forces and moments of water in joints on the blocks, (n, 6) [N, N m]."""
    pressure = np.array([*(joint_pressure.get(name, 0.0) for name in blocks.joint_names), 0.0])[polygons.joint]
    force = (pressure * polygons.area)[:, None] * polygons.normal
    total = np.zeros((blocks.count, 6))
    for block, sign in ((polygons.block_a, 1.0), (polygons.block_b, -1.0)):
        arm = polygons.centroid - blocks.moments.centroid[block]
        np.add.at(total, block, sign * np.concatenate([force, np.cross(arm, force)], axis=1))
    return total
