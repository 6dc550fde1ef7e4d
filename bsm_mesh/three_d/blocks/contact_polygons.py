"""The plane polygons in which blocks touch, and the contact points that stand for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray, Portable, show_only
from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.polygons import next_corner, owner_of_corner
from bsm_mesh.three_d.blocks.polygons import PolygonMoments, bent_corners, polygon_moments, sums

PointRule = Literal["corners", "both"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ContactPolygons(Portable):
    """The polygons in which pairs of blocks touch, one row each.

    Attributes
    ----------
    block_a, block_b : (n,) int32
        The two blocks.
    joint : (n,) int32
        Index of the joint; -1 where the blocks meet without a joint.
    face : (n,) int32
        Face of the blocks that the polygon is.
    corners : (n_corners, 3) float64 [m]
        Corners, counter-clockwise about `normal`, polygon after polygon; none lies in line with its neighbours.
    offsets : (n + 1,) int32
        Polygon f owns ``corners[offsets[f]:offsets[f + 1]]``.
    """

    block_a: IntArray
    block_b: IntArray
    joint: IntArray
    face: IntArray
    corners: FloatArray
    offsets: IntArray

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def count(self) -> int:
        """Number of polygons."""
        return len(self.block_a)

    @cached_property
    def moments(self) -> PolygonMoments:
        """Area, normal, centroid and polar second moment of every polygon."""
        return polygon_moments(self.corners, self.offsets)

    @property
    def normal(self) -> FloatArray:
        """Outward unit normal of block_b, which points into block_a, (n, 3)."""
        return self.moments.normal

    @property
    def area(self) -> FloatArray:
        """Areas, (n,) [m2]."""
        return self.moments.area

    @property
    def centroid(self) -> FloatArray:
        """Centroids, (n, 3) [m]."""
        return self.moments.centroid

    @property
    def polar_moment(self) -> FloatArray:
        """Polar second moments of area about the normal through the centroid, (n,) [m4]."""
        return self.moments.polar

    def of(self, block: int) -> IntArray:
        """Return the polygons of one block."""
        return np.flatnonzero((self.block_a == block) | (self.block_b == block))

    def some(self, chosen: IntArray) -> ContactPolygons:
        """Return some of the polygons, by their numbers."""
        sizes = np.diff(self.offsets)[chosen]
        offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
        within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
        return ContactPolygons(
            block_a=self.block_a[chosen],
            block_b=self.block_b[chosen],
            joint=self.joint[chosen],
            face=self.face[chosen],
            corners=self.corners[np.repeat(self.offsets[chosen], sizes) + within],
            offsets=offsets,
        )

    def points(self, rule: str = "both") -> ContactPoints:
        """Return the contact points of all polygons.

        Parameters
        ----------
        rule : str
            ``corners``: every corner. ``both``: corners and centroid; the corners bear the part of the area that gives
            the polygon its own polar moment (a third of a rectangle, a quarter of a triangle).

        Raises
        ------
        ModelError
            If there is no such rule.
        """
        if rule not in get_args(PointRule):
            raise ModelError(f"contact points: '{rule}' is unknown{nearest(rule, get_args(PointRule))}")
        owner = owner_of_corner(self.offsets)
        area = _corner_areas(self)
        if rule == "corners":
            return ContactPoints(polygon=owner, point=self.corners, area=area)
        arm = self.corners - self.centroid[owner]
        share = self.polar_moment / sums(owner, area * np.square(arm).sum(axis=1), self.count)
        return ContactPoints(
            polygon=np.concatenate([owner, np.arange(self.count, dtype=np.int32)]),
            point=np.concatenate([self.corners, self.centroid]),
            area=np.concatenate([area * share[owner], self.area * (1 - share)]),
        )


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactPoints(Portable):
    """Points at which contact forces act, one row each.

    The areas of a polygon's points sum up to its area, and a uniform pressure has no moment about its centroid.

    Attributes
    ----------
    polygon : (k,) int32
        Contact polygon of every point.
    point : (k, 3) float64 [m]
        Where it lies.
    area : (k,) float64 [m2]
        The area that it stands for.
    """

    polygon: IntArray
    point: FloatArray
    area: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.polygon)


def contact_polygons(
    vertices: FloatArray, face_vertices: IntArray, face_offsets: IntArray, face_blocks: IntArray, face_joint: IntArray
) -> ContactPolygons:
    """Return the faces between different blocks as contact polygons, their corners in line left out.

    Parameters
    ----------
    vertices, face_vertices, face_offsets : array
        Faces as in `bsm_mesh.three_d.blocks.polyhedra.Polyhedra`.
    face_blocks : (n_faces, 2) int32
        The blocks on both sides of every face, the first one that from which its normal points away; -1 for none.
    face_joint : (n_faces,) int32
        Joint of every face.
    """
    first, second = face_blocks.T
    face = np.flatnonzero((first >= 0) & (second >= 0) & (first != second)).astype(np.int32)
    sizes = np.diff(face_offsets)[face]
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    corners = vertices[face_vertices[np.repeat(face_offsets[face], sizes) + within]]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    bent = bent_corners(corners, offsets)
    sizes = np.bincount(owner_of_corner(offsets)[bent], minlength=len(face))
    kept = np.repeat(sizes >= 3, sizes)
    face, sizes = face[sizes >= 3], sizes[sizes >= 3]
    return ContactPolygons(
        block_a=second[face].astype(np.int32),
        block_b=first[face].astype(np.int32),
        joint=face_joint[face].astype(np.int32),
        face=face,
        corners=corners[bent[kept]],
        offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
    )


def _corner_areas(polygons: ContactPolygons) -> FloatArray:
    """Return the area that every corner stands for where corners bear all of it, (n_corners,) [m2].

    Half of the two adjacent triangles. As these have their tip in the centroid, first moments about it vanish.
    """
    following = next_corner(polygons.offsets)
    before = np.empty_like(following)
    before[following] = np.arange(len(following))
    triangle = polygons.moments.triangle_area
    area: FloatArray = (triangle + triangle[before]) / 2
    return area
