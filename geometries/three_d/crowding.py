"""How many cells joints will cut a box into, estimated before any is cut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement
from math import factorial

import numpy as np

from bsm_mesh.geometries.three_d.joints import Planes
from bsm_mesh.geometries.three_d.rows import BoolArray, FloatArray, IntArray

DRAWS = 20_000  # of planes at random, for every two and every three joints
PARALLEL = 1e-9  # sine of the angle between planes that do not meet
FEWEST = 100  # draws that meet in the box; fewer say too little to count


def expected_cells(joints: Sequence[tuple[Planes, float]], low: FloatArray, high: FloatArray) -> float:
    """Return about how many cells joints cut a box into.

    Planes in general position cut a convex body into one cell and one more for every plane. Every line in which two
    planes meet in the body adds a cell, and so does every point in which three meet (Buck 1943).
    How many meet is estimated from planes drawn at random. Discs are left out: most end inside cells and divide none.

    Parameters
    ----------
    joints : sequence of (Planes, float)
        The planes of every joint, and its persistence.
    low, high : (3,) float64 [m]
        Lower and upper corner of the box.

    Examples
    --------
    >>> level = Planes(normal=np.array([[0, 0, 1.0]]), point=np.full((1, 3), 0.5), radius=np.array([np.inf]))
    >>> expected_cells([(level, 1.0)], np.zeros(3), np.ones(3))
    2.0
    """
    generator = np.random.default_rng(0)
    joints = [(_whole(planes), share) for planes, share in joints]
    joints = _single_ones_together([(planes, share) for planes, share in joints if len(planes.normal)])
    cells = 1.0 + sum(len(planes.normal) * share for planes, share in joints)
    for number, meet in ((2, _lines_meet), (3, _points_meet)):
        for chosen in combinations_with_replacement(range(len(joints)), number):
            drawn = list(_drawn([joints[c][0] for c in chosen], generator))
            there = int(np.count_nonzero(meet(drawn, low, high)))
            if there >= FEWEST:
                ways = float(np.prod([len(joints[c][0].normal) for c in chosen]))
                ways /= np.prod([factorial(chosen.count(c)) for c in set(chosen)])
                cells += there / DRAWS * ways * float(np.prod([joints[c][1] for c in chosen]))
    return cells


def _single_ones_together(joints: Sequence[tuple[Planes, float]]) -> list[tuple[Planes, float]]:
    """Return joints with all single planes of a persistence as one: of many, every three would be drawn for minutes."""
    singles: dict[float, list[Planes]] = {}
    for planes, share in joints:
        if len(planes.normal) == 1:
            singles.setdefault(share, []).append(planes)
    found = [(planes, share) for planes, share in joints if len(planes.normal) > 1]
    for share, several in singles.items():
        normal, point, radius = (
            np.concatenate([getattr(p, n) for p in several]) for n in ("normal", "point", "radius")
        )
        found.append((Planes(normal=normal, point=point, radius=radius), share))
    return found


def _whole(planes: Planes) -> Planes:
    kept = np.isinf(planes.radius)
    return Planes(normal=planes.normal[kept], point=planes.point[kept], radius=planes.radius[kept])


def _drawn(joints: Sequence[Planes], generator: np.random.Generator) -> Iterator[Planes]:
    for planes in joints:
        row: IntArray = generator.integers(len(planes.normal), size=DRAWS)
        yield Planes(normal=planes.normal[row], point=planes.point[row], radius=planes.radius[row])


def _points_meet(drawn: Sequence[Planes], low: FloatArray, high: FloatArray) -> BoolArray:
    """Return whether three planes meet in a point of the box, (n,)."""
    matrix = np.stack([planes.normal for planes in drawn], axis=1)
    offset = np.stack([_offset(planes) for planes in drawn], axis=1)
    cross = np.stack([np.cross(matrix[:, k - 2], matrix[:, k - 1]) for k in range(3)], axis=1)
    volume = np.einsum("ni,ni->n", matrix[:, 0], cross[:, 0])
    apart = np.abs(volume) > PARALLEL
    point = np.einsum("nk,nki->ni", offset, cross) / np.where(apart, volume, 1)[:, None]
    there: BoolArray = apart & ((point >= low) & (point <= high)).all(axis=1)
    return there


def _lines_meet(drawn: Sequence[Planes], low: FloatArray, high: FloatArray) -> BoolArray:
    """Return whether two planes meet in a line through the box, (n,)."""
    first, second = drawn
    along = np.cross(first.normal, second.normal)
    length = np.einsum("ni,ni->n", along, along)
    apart = length > PARALLEL**2
    towards = _offset(first)[:, None] * second.normal - _offset(second)[:, None] * first.normal
    foot = np.cross(towards, along) / np.where(apart, length, 1)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([(low - foot) / along, (high - foot) / along])
    there: BoolArray = apart & (np.fmin(*ends).max(axis=1) < np.fmax(*ends).min(axis=1))
    return there


def _offset(planes: Planes) -> FloatArray:
    offset: FloatArray = np.einsum("ni,ni->n", planes.normal, planes.point)
    return offset
