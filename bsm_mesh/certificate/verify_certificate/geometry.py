"""Polygons, vectors, and forces on blocks."""

from __future__ import annotations

from typing import Any

import numpy as np

Arrays = dict[str, Any]
ROUNDING = 4.0 * np.finfo(float).eps  # of coordinates, in an arm
AGREES = 1e-6  # relative: numbers of the certificate that follow from others


def moments(vertices: Any, offsets: Any) -> Arrays:
    """Return area, centroid, polar radius of gyration of polygons, and the owner of every corner and the next one."""
    count = len(offsets) - 1
    owner = np.repeat(np.arange(count), np.diff(offsets))
    following = np.arange(1, len(vertices) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    anchor = vertices[offsets[:-1]]
    x, y = (vertices - anchor[owner]).T
    u, v = x[following], y[following]
    cross = x * v - u * y

    def summed(values: Any) -> Any:
        return np.bincount(owner, values, minlength=count)

    area = summed(cross) / 2
    centre = np.column_stack([summed((x + u) * cross), summed((y + v) * cross)]) / (6 * area)[:, None]
    polar = summed((x * x + x * u + u * u + y * y + y * v + v * v) * cross) / 12 - area * (centre**2).sum(axis=1)
    gyration = np.sqrt(polar / area)
    return {"area": area, "centroid": anchor + centre, "gyration": gyration, "owner": owner, "following": following}


def placed(a: Arrays, position: Any) -> Any:
    """Return the corners of blocks moved by u, v, theta (n, 3) from where they were given."""
    owner = a["owner"]
    x, y = (a["vertices"] - a["centroid"][owner]).T
    cosine, sine = np.cos(position[owner, 2]), np.sin(position[owner, 2])
    turned = np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
    return a["centroid"][owner] + position[owner, :2] + turned


def shapes(a: Arrays) -> Arrays:
    """Return corners of the blocks as they are, the next corner of each, and where those of every block begin.

    Blocks that deformed have outlines of their own.
    """
    if "outline" not in a:
        return {"corner": placed(a, a["position"]), "following": a["following"], "offsets": a["offsets"]}
    following = np.arange(1, len(a["outline"]) + 1)
    following[a["outline_offsets"][1:] - 1] = a["outline_offsets"][:-1]
    return {"corner": a["outline"], "following": following, "offsets": a["outline_offsets"]}


def edges_of(a: Arrays, block: Any) -> tuple[Any, Any]:
    """Return the edges of blocks (k,), one after the other, and the row of the block that each belongs to."""
    count = np.diff(a["offsets"])[block]
    row = np.repeat(np.arange(len(block)), count)
    return a["offsets"][block][row] + np.arange(len(row)) - (np.cumsum(count) - count)[row], row


def size_of(a: Arrays) -> float:
    """Return the size of a block: the root of the median area."""
    return float(np.sqrt(np.median(a["area"])))


def turned_left(vectors: Any) -> Any:
    """Return vectors (k, 2) turned by +90 degrees."""
    return vectors[:, ::-1] * (-1.0, 1.0)


def cross(one: Any, other: Any) -> Any:
    """Return the cross products of vectors: (k,) of plane ones (k, 2), (k, 3) of others."""
    return np.cross(one, other) if one.shape[1] == 3 else one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def add_forces(total: Any, a: Arrays, block: Any, point: Any, push: Any, moment: Any = 0.0) -> Any:
    """Add forces at points of blocks, and moments, to those about the centroids (n, 3 or 6), and return these."""
    moment = moment + cross(point - a["at"][block], push)
    np.add.at(total, block, np.column_stack([push, moment]))
    return total


def scaled(a: Arrays, rows: Any) -> Any:
    """Return forces and moments (n, 3 or 6) with the moments over the radii of gyration."""
    axes = a["at"].shape[1]
    return np.column_stack([rows[:, :axes], rows[:, axes:] / a["gyration"][:, None]])
