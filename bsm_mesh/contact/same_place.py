"""Relations between two candidates of a pair of blocks: duals, and opposing corner-corner candidates."""

from __future__ import annotations

import numpy as np

from bsm_mesh.compiled import njit
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules


@njit(forceinline=True)
def are_duals(vertices: RecordArray, one: Record, other: Record, reach: float) -> bool:  # pragma: no cover - compiled
    """Whether two rows are duals: the same contact with corner and edge swapped."""
    if one.block_a != other.block_b:
        return False
    v, e, w, f = one.corner, one.edge, other.corner, other.edge
    w_starts, w_ends = e == w, vertices[e].following == w
    v_starts, v_ends = f == v, vertices[f].following == v
    if not ((w_starts or w_ends) and (v_starts or v_ends)):
        return False
    if one.parallel_edge >= 0 and other.parallel_edge >= 0 and not ((w_starts and v_ends) or (w_ends and v_starts)):
        return False  # the two ends of a short face
    return bool(np.hypot(vertices[v].x - vertices[w].x, vertices[v].y - vertices[w].y) < reach)


@njit(forceinline=True)
def at_one_node(vertices: RecordArray, one: Record, other: Record) -> bool:  # pragma: no cover - compiled
    """Whether of two rows with corner and edge swapped the corner of each is an end of the other's edge."""
    if one.block_a != other.block_b:
        return False
    v, w = one.corner, other.corner
    at_w = w == one.edge or w == vertices[one.edge].following
    return bool(at_w and (v == other.edge or v == vertices[other.edge].following))


@njit(forceinline=True)
def same_vertices(
    vertices: RecordArray, rules: Rules, one: Record, other: Record
) -> bool:  # pragma: no cover - compiled
    """Whether two rows are one corner-corner contact on the same side, with corner and edge swapped."""
    if one.corner_gap == 0.0 or other.corner_gap == 0.0 or one.block_a != other.block_b:
        return False
    w, f = other.corner, other.edge
    at_w = w == (one.edge if one.tangential < 0.5 * one.edge_length else vertices[one.edge].following)
    at_v = f == one.corner or vertices[f].following == one.corner
    return bool(at_w and at_v and not are_opposing(vertices, rules, one, other))


@njit(forceinline=True)
def are_opposing(
    vertices: RecordArray, rules: Rules, one: Record, other: Record
) -> bool:  # pragma: no cover - compiled
    """Whether two rows are opposing candidates: the two edges over which one corner may leave another.

    What corner v cannot reach beside corner w of the other block is a wedge, convex as both are. Its two sides are
    edges at v or w: v on an edge at w, or w on an edge at v. The contact is on the side with the smaller penetration.
    """
    v, e = one.corner, one.edge
    w = e if one.tangential < 0.5 * one.edge_length else vertices[e].following
    f = other.edge
    cosine = vertices[e].dx * vertices[f].dx + vertices[e].dy * vertices[f].dy
    sine = vertices[e].dx * vertices[f].dy - vertices[e].dy * vertices[f].dx
    if other.corner == v:
        if f == e or (f != w and vertices[f].following != w):
            return False
        if (sine if f == w else -sine) <= rules.flat:
            return False  # a notch, or no corner
    elif other.corner == w and (f == v or vertices[f].following == v):
        cosine = -cosine
    else:
        return False
    if one.entering_edge >= 0 or other.entering_edge >= 0:
        return False  # not before the blocks have rotated
    return bool(cosine < 0.0 or abs(sine) > rules.parallel)


@njit(forceinline=True)
def closed_on_both(
    vertices: RecordArray, h: float, rules: Rules, one: Record, other: Record
) -> bool:  # pragma: no cover - compiled
    """Whether a corner that has closed on edge `one` stays closed on it whatever it does on the edge `other`.

    So it is where the block is not convex: the edge lies in front of the other (the floor of a wide notch and its
    wall), or the two meet in a notch. So it is, too, at a flat corner where each touches an edge of its own.
    """
    e, f = one.edge, other.edge
    cosine = vertices[e].dx * vertices[f].dx + vertices[e].dy * vertices[f].dy
    if other.gap - one.gap * cosine > rules.rounding * h:  # the foot on the one edge, seen from the other
        return True
    if vertices[f].following == e:
        e, f = f, e
    if vertices[e].following != f:
        return False
    turn = vertices[e].dx * vertices[f].dy - vertices[e].dy * vertices[f].dx
    if turn < -rules.flat:
        return True
    p, q = one.parallel_edge, other.parallel_edge
    return bool(turn <= rules.flat and p >= 0 and q >= 0 and p != q)


@njit(forceinline=True)
def is_face(h: float, rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Whether the candidate is an end of an edge-edge contact (a face)."""
    return bool(row.parallel_edge >= 0 and row.overlap >= rules.min_overlap * h)


@njit(forceinline=True)
def is_closing(h: float, rules: Rules, row: Record) -> bool:  # pragma: no cover - compiled
    """Whether a candidate is closed, or would be at once."""
    return bool(row.in_range and row.corner_gap == 0.0 and row.gap <= rules.new_penetration * h)
