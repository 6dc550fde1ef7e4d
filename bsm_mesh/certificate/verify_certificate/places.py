"""Contacts lie where two blocks touch; supports push where blocks are held."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import AGREES, Arrays, cross, edges_of, moments, placed, scaled, size_of

TOUCHING = 2e-3  # of a block's size, beyond the opening: runs let contacts act across a thousandth of the mean size
TURNED = 1e-6  # of a normal from its edge's
DEFORMED = 0.05  # of its area and its size: strains of rock are small, and blocks bend no more
LONGER = 2e-2  # by how much a contact may represent more than its edge


def distances(shape: Arrays, block: Any, point: Any, beyond: Any) -> tuple[Any, Any, Any]:
    """Return distances of points (k, 2) from all edges of their blocks (k,), the edges, and the points' rows.

    Edges are longer by `beyond` (k,) [m] at both ends.
    """
    edge, row = edges_of(shape, block)
    start = shape["corner"][edge]
    along = shape["corner"][shape["following"][edge]] - start
    more = beyond[row] / np.hypot(*along.T)
    part = np.clip(((point[row] - start) * along).sum(axis=1) / (along**2).sum(axis=1), -more, 1.0 + more)
    return np.hypot(*(point[row] - start - part[:, None] * along).T), edge, row


def normals(shape: Arrays, edge: Any) -> Any:
    """Return the outward unit normals of edges (k,), (k, 2)."""
    along = shape["corner"][shape["following"][edge]] - shape["corner"][edge]
    return np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]


def place_faults(a: Arrays) -> list[str]:
    """Return which contacts that carry something lie on no corner and edge of their blocks, or along another normal."""
    bears = np.flatnonzero((a["contact_normal_force"] != 0) | (a["contact_shear_force"] != 0))
    if not len(bears):
        return []
    shape = a["shape"]
    point, normal = a["contact_point"][bears], a["contact_normal"][bears]
    reach = TOUCHING * size_of(a) + np.abs(a["contact_opening"][bears])
    beyond = np.zeros(len(bears))
    away, _, row = distances(shape, a["contact_block_a"][bears], point, beyond)
    off_a = np.ones(len(bears), dtype=bool)
    off_a[row[away <= reach[row]]] = False
    if "outline" in a:  # points of zones slide over the end of an edge, with a part of what they represent
        beyond = a["contact_length"][bears]
    away, edge, row = distances(shape, a["contact_block_b"][bears], point, beyond)
    near = away <= reach[row]
    off_b = np.ones(len(bears), dtype=bool)
    off_b[row[near]] = False
    along = near & (np.hypot(*(normals(shape, edge) - normal[row]).T) <= TURNED)
    turned = np.ones(len(bears), dtype=bool)
    turned[row[along]] = False
    given = placed(a, np.zeros_like(a["position"]))
    longest = np.maximum.reduceat(np.hypot(*(given[a["following"]] - given).T), a["offsets"][:-1])
    longest = np.maximum(*(longest[a[f"contact_block_{side}"][bears]] for side in "ab"))  # a corner may have two faces
    short = ~(a["contact_length"][bears] <= (1 + LONGER) * longest)
    same = a["contact_block_a"][bears] == a["contact_block_b"][bears]
    gone = ~(a["present"][a["contact_block_a"][bears]] & a["present"][a["contact_block_b"][bears]])
    tests = (
        (same | gone, "is between no two blocks that are there"),
        (off_a | off_b, "does not lie where its blocks touch"),
        (turned, "has another normal than the edge"),
        (short, "represents more than any edge of its blocks"),
    )
    return [f"contact {bears[int(bad.argmax())]} {text}" for bad, text in tests if bad.any()]


def shape_faults(a: Arrays) -> list[str]:
    """Return which blocks that deformed have another area, or another place, than blocks of their size and movement."""
    if "outline" not in a:
        return []
    found = moments(a["outline"], a["outline_offsets"])
    off = np.abs(found["area"] / a["area"] - 1) * a["present"]
    away = np.hypot(*(found["centroid"] - a["at"]).T) / np.sqrt(a["area"]) * a["present"]
    tests = ((off, "another area than its given one"), (away, "another place than its movement says"))
    return [f"block {int(bad.argmax())}: its outline has {text}" for bad, text in tests if not bad.max() <= DEFORMED]


def support_faults(a: Arrays, reference: float) -> list[str]:
    """Return which blocks the supports push where, or in a direction in which, no support holds them."""
    push = np.abs(scaled(a, a["reactions"]))
    allowed = AGREES * (reference + push.max(initial=0.0))
    pushed = np.flatnonzero((push > allowed).any(axis=1))
    loose = pushed[~np.isin(pushed, a["bar_block"])]
    if len(loose):
        return [f"supports push block {int(loose[0])}, which none holds"]
    order = np.argsort(a["bar_block"], kind="stable")
    held = a["bar_block"][order]
    for block in pushed:
        bars = order[np.searchsorted(held, block) : np.searchsorted(held, block, side="right")]
        arm, along = a["bar_point"][bars] - a["at"][block], a["bar_direction"][bars]
        turn = np.where(a["bar_turns"][bars], 1.0, cross(arm, along) / a["gyration"][block])
        columns = np.column_stack([along, turn]).T
        wanted = a["reactions"][block] / (1.0, 1.0, a["gyration"][block])
        left = wanted - columns @ np.linalg.lstsq(columns, wanted, rcond=None)[0]
        if np.abs(left).max() > allowed:
            return [f"supports push block {int(block)} in a direction in which none holds it"]
    return []
