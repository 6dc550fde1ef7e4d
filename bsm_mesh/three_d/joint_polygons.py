"""The contact polygons with what acts and moves on them at the end of a stage: their contact points put together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.movements import lengths, turned, turns
from bsm_mesh.results.joint_faces import HELD, SHORTEST, slips_or_will, status_of_shares
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import ContactStatus, StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.three_d.point_forces import PointForces3D


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointPolygons:
    """Contact polygons between blocks that are there at the end of a stage, one row each.

    Attributes
    ----------
    polygon : (k,) int64
        Row of ``blocks.contact_polygons``.
    block_a, block_b : (k,) int32
        Its blocks.
    joint : (k,) int32
        Number of the joint in ``Results.joint_names``; -1 for unjointed rock.
    length : (k,) float64 [m2]
        Area.
    force : (k, 3) float64 [N]
        On `block_b`, all points together.
    normal : (k, 3) float64
        Outward unit normal of `block_b`, where it is.
    slip, opening : (k,) float64 [m]
        Displacement of a against b along the face and away from it, mean over the area; slip without sign.
    pressure : (k,) float64 [Pa]
        Normal force over area, compression positive.
    utilisation : (k,) float64
        Shear force over shear strength, the greatest of the points.
    slipping, open : (k,) float64
        Share of the area that slips, or is at `AT_STRENGTH`, and that is open.
    """

    polygon: IntArray
    block_a: IntArray
    block_b: IntArray
    joint: IntArray
    length: FloatArray
    force: FloatArray
    normal: FloatArray
    slip: FloatArray
    opening: FloatArray
    pressure: FloatArray
    utilisation: FloatArray
    slipping: FloatArray
    open: FloatArray

    @property
    def status(self) -> IntArray:
        """`ContactStatus` of every polygon, (k,) int8: open as a whole, slipping wherever it is closed, or sticking."""
        return status_of_shares(self.slipping, self.open)


def joint_polygons(results: Results, stage: StageResult) -> JointPolygons:
    """Return the contact polygons of a stage as given; points that have left theirs count as open."""
    blocks, c = results.blocks, stage.contacts
    assert in_space(blocks)
    assert isinstance(c, PointForces3D)
    polygons = blocks.contact_polygons
    row = np.full(len(blocks.face_joint), -1, dtype=np.int64)
    row[polygons.face] = np.arange(polygons.count)
    c = c.on_given_faces(row)
    of, area = row[c.face], polygons.area
    sign = np.where(c.block_b == polygons.block_b[of], 1.0, -1.0)[:, None]

    def share(values: FloatArray) -> FloatArray:
        total: FloatArray = np.bincount(of, values * c.length, minlength=polygons.count) / area
        return total

    recorded = share(np.ones(len(of)))
    none, missing = recorded <= 0, np.where(recorded < 1 - SHORTEST, 1 - recorded, 0.0)
    normal, slip, opening = _movement(results, stage)
    parted = np.hypot(slip, opening) > HELD * np.sqrt(area)
    is_open = c.status == ContactStatus.OPEN
    force, used = np.zeros((polygons.count, 3)), np.zeros(polygons.count)
    np.add.at(force, of, sign * c.force)
    np.maximum.at(used, of, c.utilisation)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean_slip, mean_opening = share(np.abs(c.slip)) / recorded, share(c.opening) / recorded
    there = np.flatnonzero(stage.present[polygons.block_a] & stage.present[polygons.block_b])
    return JointPolygons(
        polygon=there,
        block_a=polygons.block_a[there],
        block_b=polygons.block_b[there],
        joint=_joints(results)[there],
        length=area[there],
        force=force[there],
        normal=normal[there],
        slip=np.where(none, slip, mean_slip)[there],
        opening=np.where(none, opening, mean_opening)[there],
        pressure=(np.bincount(of, -c.normal_force, minlength=polygons.count) / area)[there] + 0.0,
        utilisation=used[there],
        slipping=share(slips_or_will(c).astype(float))[there],
        open=(share(is_open.astype(float)) + np.where(parted, missing, 0.0))[there],
    )


def _movement(results: Results, stage: StageResult) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normals of all polygons, and the displacement of a against b at their centroids, along and away [m]."""
    blocks: Any = results.blocks
    polygons, moved = blocks.contact_polygons, stage.displacement + stage.origin
    one, other = (
        displacement_of(blocks, moved, block, polygons.centroid) for block in (polygons.block_a, polygons.block_b)
    )
    normal = turned(polygons.normal, turns(moved)[polygons.block_b])
    opening = np.einsum("ij,ij->i", one - other, normal)
    return normal, lengths(one - other - opening[:, None] * normal), opening


def _joints(results: Results) -> IntArray:
    """Return the number of every polygon's joint in ``Results.joint_names``."""
    blocks, names = results.blocks, list(results.joint_names)
    assert in_space(blocks)
    default = -1 if results.default_joint is None else names.index(results.default_joint)
    number = np.array([*(names.index(name) for name in blocks.joint_names), default], dtype=np.int32)
    return number[blocks.contact_polygons.joint]
