"""Geometry of many plane polygons in space, stored flat: normals, areas, centroids and second moments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray, rounding_of
from bsm_mesh.model.polygons import next_corner, owner_of_corner


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PolygonMoments:
    """Areas and moments of polygons in space.

    Attributes
    ----------
    area : (n,) float64 [m2]
        Areas, not negative.
    normal : (n, 3) float64
        Unit normals; the corners run counter-clockwise about them. Zero where there is no area.
    centroid : (n, 3) float64 [m]
        Centre of area; the mean of the corners where there is no area.
    polar : (n,) float64 [m4]
        Polar second moment of area about the normal through the centroid.
    triangle_area : (n_corners,) float64 [m2]
        Area of the triangle of the centroid with every corner and the next.
    """

    area: FloatArray
    normal: FloatArray
    centroid: FloatArray
    polar: FloatArray
    triangle_area: FloatArray


def sums(owner: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Return the sums of values, (k,) or (k, m), over each of `count` owners."""
    columns = np.atleast_2d(values.T)
    found = np.stack([np.bincount(owner, column, count) for column in columns], axis=1).astype(np.float64)
    return found.reshape(count, *values.shape[1:])


def spread(first: IntArray, sizes: IntArray) -> IntArray:
    """Return ``first[i], first[i] + 1, ...``, of every i as many as its size."""
    places: IntArray = np.repeat(first - np.cumsum(sizes) + sizes, sizes) + np.arange(sizes.sum())
    return places


def vector_areas(corners: FloatArray, offsets: IntArray) -> FloatArray:
    """Return the area times the normal of every polygon, (n, 3) [m2]."""
    owner, following = owner_of_corner(offsets), next_corner(offsets)
    arm = corners - corners[offsets[:-1]][owner]
    return sums(owner, np.cross(arm, arm[following]), len(offsets) - 1) / 2


def polygon_moments(corners: FloatArray, offsets: IntArray) -> PolygonMoments:
    """Return normal, area, centroid and polar second moment of every polygon.

    Parameters
    ----------
    corners : (n_corners, 3) float64 [m]
        Corners in order, polygon after polygon.
    offsets : (n + 1,) int32
        Polygon f owns ``corners[offsets[f]:offsets[f + 1]]``.
    """
    count, sizes = len(offsets) - 1, np.diff(offsets)
    owner, following = owner_of_corner(offsets), next_corner(offsets)
    middle = sums(owner, corners, count) / sizes[:, None]
    vector = vector_areas(corners, offsets)
    area = np.linalg.norm(vector, axis=1)
    over_area = np.divide(1.0, area, out=np.zeros_like(area), where=area > 0)
    normal = vector * over_area[:, None]
    first, second = corners - middle[owner], corners[following] - middle[owner]
    triangle = np.einsum("ij,ij->i", np.cross(first, second), normal[owner]) / 2
    shift = sums(owner, triangle[:, None] * (first + second) / 3, count) * over_area[:, None]
    first, second = first - shift[owner], second - shift[owner]
    triangle = np.einsum("ij,ij->i", np.cross(first, second), normal[owner]) / 2
    squares = np.square(first).sum(axis=1) + np.square(second).sum(axis=1) + np.square(first + second).sum(axis=1)
    return PolygonMoments(
        area=area,
        normal=normal,
        centroid=middle + shift,
        polar=sums(owner, triangle * squares / 12, count),
        triangle_area=triangle,
    )


def tangents(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors across every normal, (n, 3) each; normal, first and second are right-handed."""
    axis = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)


def bent_corners(corners: FloatArray, offsets: IntArray, tolerance: float = 1e-9) -> IntArray:
    """Return the corners at which the outline turns; others lie in line with their neighbours.

    Parameters
    ----------
    corners, offsets : array
        As for `polygon_moments`.
    tolerance : float
        Greatest height of a corner over the line of its neighbours that counts as in line, over their distance.
    """
    following = next_corner(offsets)
    before = np.empty_like(following)
    before[following] = np.arange(len(following))
    along, chord = corners - corners[before], corners[following] - corners[before]
    twice, length = np.linalg.norm(np.cross(along, chord), axis=1), np.linalg.norm(chord, axis=1)
    return np.flatnonzero(twice > (tolerance * length + rounding_of(corners)) * length)
