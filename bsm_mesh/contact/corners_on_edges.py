"""Corners that lie on edges of other blocks as given, between the nodes of the mesh."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.contact.outlines import Outlines
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.contact.search import ActiveContacts, detect_contacts
from bsm_mesh.model.blocks import Blocks


def corners_on_edges(blocks: Blocks, outlines: Outlines) -> tuple[IntArray, IntArray]:
    """Return corners (k,) and the edges (k,) of other blocks on which they lie, not at an end.

    Parameters
    ----------
    blocks : Blocks
        The blocks.
    outlines : Outlines
        Theirs; blocks that supports hold are not searched against each other.
    """
    near = CONTACT_TOLERANCE * outlines.size
    found = detect_contacts(outlines, outlines.placed(np.zeros((blocks.count, 3))), ActiveContacts.none(), near)
    ends = blocks.nodes[np.stack([found.edge, blocks.following[found.edge]])]
    chosen = found.in_range & (found.gap <= near) & (blocks.nodes[found.corner] != ends).all(axis=0)
    return found.corner[chosen], found.edge[chosen]
