"""Lines of joints as straight segments, and which of them are near what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.edges import LongArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Segments:
    """Straight segments of the lines of joints, line after line, each from its start to its end.

    Attributes
    ----------
    ends : (n, 2, 2) float64 [m]
        Both ends of each.
    line : (n,) int64
        Number of its line.
    joint : (n,) int64
        Number of its joint.
    """

    ends: FloatArray
    line: LongArray
    joint: LongArray

    @classmethod
    def of(cls, lines: Mapping[str, Sequence[FloatArray]]) -> Segments:
        """Return the segments of the lines of each joint; those without length are left out."""
        parts = [(k, np.asarray(line, dtype=np.float64)) for k, some in enumerate(lines.values()) for line in some]
        ends = [np.stack([line[:-1], line[1:]], axis=1) for _, line in parts]
        count = [len(part) for part in ends]
        flat = np.concatenate([np.empty((0, 2, 2)), *ends])
        long = np.any(flat[:, 0] != flat[:, 1], axis=1)
        return cls(
            ends=flat[long],
            line=np.repeat(np.arange(len(parts)), count)[long],
            joint=np.repeat(np.array([k for k, _ in parts], dtype=np.int64), count)[long],
        )

    def around(self, low: FloatArray, high: FloatArray) -> Segments:
        """Return the segments that may reach a box, by its corners [m]; far ends are drawn nearer along the segments.

        Lines within one size of the box stay as they are.
        """
        size = float((high - low).max())
        low, high = low - size, high + size
        start, vector = self.ends[:, 0], self.ends[:, 1] - self.ends[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - start) / vector, (high - start) / vector
        outside = (start < low) | (start > high)
        first = np.where(vector == 0, np.where(outside, np.inf, -np.inf), np.minimum(a, b)).max(axis=1)
        last = np.where(vector == 0, np.inf, np.maximum(a, b)).min(axis=1)
        first, last = np.maximum(first, 0.0)[:, None], np.minimum(last, 1.0)[:, None]
        reach = (first < last)[:, 0]
        ends = np.stack(
            [
                start + np.where(reach[:, None], first, 0) * vector,
                np.where(last < 1, start + last * vector, self.ends[:, 1]),
            ],
            axis=1,
        )
        return Segments(ends=ends[reach], line=self.line[reach], joint=self.joint[reach])

    @property
    def shapes(self) -> Any:
        """The segments as Shapely's lines."""
        import shapely

        return shapely.linestrings(self.ends)

    def length_of(self, joint: int) -> float:
        """Return the length of all segments of a joint, by its number [m]."""
        vectors = (self.ends[:, 1] - self.ends[:, 0])[self.joint == joint]
        return float(np.hypot(*vectors.T).sum())

    def tips(self) -> tuple[FloatArray, FloatArray]:
        """Return the two ends of every line, (k, 2) [m], and the unit vectors in which they point out of it."""
        new = np.flatnonzero(np.append(True, self.line[1:] != self.line[:-1]))
        last = np.append(new[1:], len(self.line)) - 1
        points = np.concatenate([self.ends[new, 0], self.ends[last, 1]])
        vectors = points - np.concatenate([self.ends[new, 1], self.ends[last, 0]])
        return points, vectors / np.hypot(*vectors.T)[:, None]

    def moved(self, place: FloatArray) -> Segments:
        """Return the segments with their ends at other places, (2 n, 2) [m], without those that lose their length."""
        ends = place.reshape(-1, 2, 2)
        long = np.any(ends[:, 0] != ends[:, 1], axis=1)
        return Segments(ends=ends[long], line=self.line[long], joint=self.joint[long])

    def divided(self, segment: LongArray, points: FloatArray) -> Segments:
        """Return the segments with further ends in them: each of the points on one of them."""
        count = len(self.ends)
        owner = np.concatenate([np.repeat(np.arange(count), 2), segment])
        place = np.concatenate([self.ends.reshape(-1, 2), points])
        vector = self.ends[owner, 1] - self.ends[owner, 0]
        along = np.einsum("nj,nj->n", place - self.ends[owner, 0], vector)
        along[: 2 * count : 2], along[1 : 2 * count : 2] = -np.inf, np.inf
        order = np.lexsort([along, owner])
        owner, place = owner[order], place[order]
        inside = (owner[1:] == owner[:-1]) & np.any(place[1:] != place[:-1], axis=1)
        ends = np.stack([place[:-1], place[1:]], axis=1)[inside]
        return replace(self, ends=ends, line=self.line[owner[:-1][inside]], joint=self.joint[owner[:-1][inside]])


def foot_points(points: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the nearest point of one segment each, by their ends (n, 2, 2), to points (n, 2) [m]."""
    start, vector = ends[:, 0], ends[:, 1] - ends[:, 0]
    squared = np.maximum(np.einsum("nj,nj->n", vector, vector), np.finfo(np.float64).tiny)
    share = np.clip(np.einsum("nj,nj->n", points - start, vector) / squared, 0.0, 1.0)[:, None]
    foot: FloatArray = np.where(share == 1.0, ends[:, 1], start + share * vector)
    return foot


def crossings(first: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where straight lines through pairs of segments (n, 2, 2) cross, (n, 2) [m], and the sines of the angles.

    Not-a-number where they are parallel.
    """
    u, v = first[:, 1] - first[:, 0], other[:, 1] - other[:, 0]
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    gap = other[:, 0] - first[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (gap[:, 0] * v[:, 1] - gap[:, 1] * v[:, 0]) / cross
        sine = np.abs(cross) / (np.hypot(*u.T) * np.hypot(*v.T))
        place: FloatArray = first[:, 0] + share[:, None] * u
    return np.where(np.isfinite(place), place, np.nan), sine
