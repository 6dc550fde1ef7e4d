"""Outlines of deformed blocks for the contact search: nodes of zones along them are corners, flat ones too.

The search is that of rigid blocks (`bsm_mesh.contact.search`). An edge is a side of a zone; with second-order zones it
is half of one, from an end to the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ActiveContacts, Candidates, Outlines, Slid, detect_contacts
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.face_chains import FaceChains
from bsm_mesh.solve.zones.mesh import ContinuumMesh

# Faces bend: up to 6 degrees is no corner. A correction may bring blocks far into each other before the search.
ZONE_RULES = RULES._replace(flat=RULES.parallel, new_penetration=RULES.max_penetration)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ZoneFaces:
    """Corners of the outlines of all blocks, (v,) each, block after block; an edge starts at every corner.

    Attributes
    ----------
    model : Model
        The input.
    chains : FaceChains
        Sides of zones along the outlines, and how faces continue.
    node : (v,) int32
        Node of every corner.
    block : (v,) int32
        Its block.
    edge : (v,) int32
        The model's edge that it lies on.
    cluster : (v,) int32
        Corners at one place as given have one number.
    inner : (v,) bool
        Whether blocks on both sides of its edge are one piece of rock.
    offsets : (n + 1,) int32
        Block b owns the corners ``offsets[b]:offsets[b + 1]``.
    halves : int
        Edges of a side of a zone: 1, with second-order zones 2.
    """

    model: Model
    chains: FaceChains
    node: IntArray
    block: IntArray
    edge: IntArray
    cluster: IntArray
    inner: BoolArray
    offsets: IntArray
    halves: int

    @classmethod
    def of(cls, model: Model, whole: ContinuumMesh, opened: ContinuumMesh, order: int) -> ZoneFaces:
        """Return the outlines of a mesh that is opened along its joints; `whole` is the same before."""
        chains, halves = FaceChains.of(whole, opened, order), order
        cluster = np.full((len(chains.block), halves), -1, dtype=np.int32)
        cluster[:, 0] = whole.piece_ends[:, 0]
        cluster[:, 1:] = whole.mesh.p.shape[1] + np.arange(len(cluster))[:, None]
        edge = np.repeat(opened.edge_of_piece, halves)
        block = model.blocks.owner[edge]
        return cls(
            model=model,
            chains=chains,
            node=chains.node[:, [0, 2][:halves]].ravel(),
            block=block,
            edge=edge,
            cluster=cluster.ravel(),
            inner=np.repeat(opened.mesh.f2t[1, opened.piece_facet] >= 0, halves),
            offsets=np.concatenate([[0], np.cumsum(np.bincount(block))]).astype(np.int32),
            halves=halves,
        )

    @property
    def preceding(self) -> IntArray:
        """The corner before of the same block, (v,)."""
        found = np.arange(-1, len(self.node) - 1)
        found[self.offsets[:-1]] = self.offsets[1:] - 1
        return found

    @property
    def following(self) -> IntArray:
        """The next corner of the same block, (v,)."""
        found = np.arange(1, len(self.node) + 1)
        found[self.offsets[1:] - 1] = self.offsets[:-1]
        return found

    @property
    def size(self) -> float:
        """Of a block, the median [m]."""
        return float(np.sqrt(np.median(self.model.blocks.moments.area)))

    def least_overlap(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return the shared length of two blocks' faces below which it counts as none, (k,) [m]."""
        size = np.minimum(np.sqrt(self.model.blocks.moments.area), self.size)
        found: FloatArray = RULES.min_overlap * np.minimum(size[one], size[other])
        return found

    def near(self, where: FloatArray, band: float, active: ActiveContacts, slid: Slid) -> Candidates:
        """Return the corners within a band [m] of edges of other blocks, where nodes are at `where` (k, 2) [m].

        `active`: contacts that carry force; `slid`: where corners have slid from.
        """
        corners = where[self.node]
        along = corners[self.following] - corners
        size = np.sqrt(self.model.blocks.moments.area)
        outlines = Outlines(
            corners=corners,
            directions=along / np.hypot(*along.T)[:, None],
            centroid=np.zeros((len(size), 2)),
            offsets=self.offsets,
            vertex_clusters=self.cluster,
            neighbour_clusters=self.cluster,
            fixed=np.zeros(len(size), dtype=bool),
            block_size=size,
            size=self.size,
        )
        return detect_contacts(outlines, np.zeros((len(size), 3)), active, band, rules=ZONE_RULES, slid=slid)

    def share_nodes(self, corner: IntArray, block: IntArray) -> BoolArray:
        """Return which corners (k,) are at nodes of a block (k,) too: both are one piece of rock there."""
        count = len(self.offsets)
        of_blocks = np.unique(self.node.astype(np.int64) * count + self.block)
        return np.isin(self.node[corner].astype(np.int64) * count + block, of_blocks)
