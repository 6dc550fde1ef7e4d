"""The area that blocks share."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import Arrays

OVERLAP = 1.3e-3  # of a block's area, beyond the closure of contacts: what touching within a thousandth allows
MAX_PAIRED = 20_000  # blocks whose overlap is checked here


def overlap(a: Arrays) -> tuple[str, list[str]]:
    """Return by how much blocks share area beyond the closure of their contacts, and whether that is too much.

    What lies under an edge, signed by its direction, sums up to a block; under the lower of two edges, to what two
    blocks share.
    """
    if a["present"].sum() > MAX_PAIRED:
        return "whether blocks overlap is not checked here in so large a model", []
    shape = a["shape"]
    corner = shape["corner"] - a["at"][0]
    one, other = pairs_of_edges(corner, shape["offsets"], a["present"])
    edges = [(*corner[k].T, *corner[shape["following"][k]].T) for k in (one, other)]
    left = np.maximum(*(np.minimum(x, u) for x, _, u, _ in edges))
    width = np.minimum(*(np.maximum(x, u) for x, _, u, _ in edges)) - left
    edges, left, width = [tuple(v[width > 0] for v in edge) for edge in edges], left[width > 0], width[width > 0]
    begin, end = (np.array([y + (v - y) / (u - x) * (at - x) for x, y, u, v in edges]) for at in (left, left + width))
    sign = np.prod([np.sign(x - u) for x, _, u, _ in edges], axis=0)
    shared = float((sign * width * mean_of_lower(begin - begin[1], end - end[1], (begin[1] + end[1]) / 2)).sum())
    closure = float((np.maximum(-a["contact_opening"], 0.0) * a["contact_length"]).sum())
    excess = (shared - closure) / float(np.median(a["area"]))
    told = f"overlap by {max(excess, 0.0):.1e} of a block's area beyond the closure of joints"
    return f"blocks {told}", [] if excess <= OVERLAP else [f"blocks {told}"]


def mean_of_lower(begin: Any, end: Any, mean: Any) -> Any:
    """Return the mean of the lower of two lines; the first begins and ends above the second, whose mean is given."""
    d, e = begin[0], end[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = np.where(d < 0, d * d, -e * e) / (d - e) / 2
    below = np.where(np.maximum(d, e) <= 0, (d + e) / 2, np.where(np.minimum(d, e) >= 0, 0.0, crossing))
    return mean + below


def pairs_of_edges(corner: Any, offsets: Any, present: Any) -> tuple[Any, Any]:
    """Return the edges (k,) of one and of the other block of all pairs of blocks whose boxes meet."""
    low, high = (bound.reduceat(corner, offsets[:-1], axis=0) for bound in (np.minimum, np.maximum))
    meet = present[:, None] & present[None, :]
    for axis in range(2):
        meet &= (low[:, None, axis] <= high[None, :, axis]) & (high[:, None, axis] >= low[None, :, axis])
    first, second = np.nonzero(np.triu(meet, 1))
    sides = np.diff(offsets)
    count = sides[first] * sides[second]
    pair = np.repeat(np.arange(len(first)), count)
    within = np.arange(len(pair)) - (np.cumsum(count) - count)[pair]
    across = sides[second][pair]
    return offsets[first][pair] + within // across, offsets[second][pair] + within % across
