"""Tolerances of the contact rules, each with its reason."""

from __future__ import annotations

from typing import NamedTuple

CONTACT_TOLERANCE = 1e-3  # over the block size: a gap or penetration up to this is contact when two blocks meet


class Rules(NamedTuple):
    """Tolerances of the contact rules: lengths over a block size h, sines and cosines of angles.

    h is the size of the smaller block of a pair, but not more than the median block's. Between a pebble and a wall
    lengths must be small against the pebble, or its own face counts as no overlap; between two very large blocks they
    must stay small against the steps, which follow the median block.
    """

    flat: float = 1e-6  # sine of the turn: a corner that turns right by more is concave and touches nothing
    entrance: float = 0.05  # sine: a corner's edges may enter the other block by 3 degrees, because blocks rotate
    turn: float = 1.5  # times the band over h: sine by which they may enter more, as blocks rotate in a step
    ahead: float = 0.1  # where they cross the other's edge so far ahead, at least
    parallel: float = 0.1  # sine: edges within 6 degrees touch along their length
    max_penetration: float = 0.25  # a corner deeper than this has come from the other side
    min_overlap: float = 5e-3  # a shorter shared length counts as none: over elastic penetration, below a step (0.02 h)
    vertex_tol: float = 5e-3  # a corner this near a diagonal neighbour's corner touches that corner alone
    detach_tol: float = 1e-3  # an active contact ends when its corner is this far off the edge
    new_penetration: float = 1e-3  # a contact without history must not start deeper: it would push the blocks apart
    initial_penetration: float = 1e-2  # but where it came over an edge's end: `min_overlap`, and what was added since
    rounding: float = 1e-6  # positions nearer than this are equal, an intact contact open by less has not separated
    closure_tol: float = 1e-6  # a corner nearer than this to two edges has closed on both
    transfer_distance: float = 0.1  # history is transferred no further: blocks move less than that in a step
    min_cosine: float = 0.9  # cosine between the normals of a contact and of the one that inherits its history
    dual_distance: float = 1.0  # over the band: corners nearer than this are one contact
    corner_share: float = 0.05  # length of a contact of a corner on an edge that is not parallel; area over h2 in space


RULES = Rules()
