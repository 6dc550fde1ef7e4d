"""Blocks that have no contact, but free faces near each other: their edges may meet at any moment.

Faces of two blocks at a common edge share no area. A block that falls there meets the other one only when
it has passed the edge a little. Until then such pairs are searched after steps of the width that counts as shared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.edges import pairs_of
from bsm_mesh.three_d.contacts.contact_set import ContactSet


@dataclass(frozen=True, eq=False, slots=True)
class Meetings:
    """Pairs of blocks (k, 2), the lower number first, as given.

    Attributes
    ----------
    pairs : (k, 2) int
        The pairs.
    block_size : (n,) float64 [m]
        Size of every block.
    """

    pairs: IntArray
    block_size: FloatArray

    def left(self, contacts: ContactSet, position: FloatArray, share: float) -> IntArray:
        """Return the pairs (m, 2) without a contact yet, by less than a share of their size moved past each other."""
        (a, b), c = self.pairs.T, contacts.candidates
        turn = np.linalg.norm(position[:, 3:], axis=1) * self.block_size
        moved = np.linalg.norm(position[a, :3] - position[b, :3], axis=1) + turn[a] + turn[b]
        near = moved < share * np.minimum(self.block_size[a], self.block_size[b])
        found: IntArray = self.pairs[near & ~np.isin(pairs_of(a, b), pairs_of(c.block_a, c.block_b))]
        return found

    def searched_from(self, share: float) -> FloatArray:
        """Return the share of their sizes (n,) from which on moved blocks are searched: less for those of pairs."""
        shares = np.full(len(self.block_size), share)
        shares[self.pairs] = RULES.min_overlap
        return shares
