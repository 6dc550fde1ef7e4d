"""Where blocks, nodes and outlines are at the end of a stage: as given, or displaced where displacements are large."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.supports import Bars
from bsm_mesh.solve.zones.mesh import ContinuumMesh
from bsm_mesh.solve.zones.supports import SAME_POINT, nodal_unknowns

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_solution import StageEnd
    from bsm_mesh.solve.zones.stages import Continuum


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Placement:
    """Where forces act.

    Attributes
    ----------
    node : (k, 2) float64 [m]
        Nodes of the cells apart (`Apart`).
    centroid : (n, 2) float64 [m]
        Centroids of the blocks.
    shift : (k, 2) float64 [m]
        Displacements of the nodes that count: zero where displacements are small.
    """

    node: FloatArray
    centroid: FloatArray
    shift: FloatArray

    @classmethod
    def of(cls, of: Continuum, end: StageEnd) -> Placement:
        """Return the nodes and centroids at the end of a stage."""
        assert of.apart is not None
        if end.large is None:
            node, centroid = of.apart.as_given
            return cls(node=node, centroid=centroid, shift=np.zeros_like(node))
        node, centroid = of.apart.placed(end.u)
        shift = end.u[of.apart.merged_dof][nodal_unknowns(of.apart.basis)]
        return cls(node=node, centroid=centroid, shift=shift)

    def bars(self, of: Continuum, bars: Bars) -> FloatArray:
        """Return where bars hold their blocks, (b, 2) [m]: at nodes, or else at the same arm from the centroid."""
        assert of.apart is not None
        centroid = of.model.blocks.moments.centroid
        given, far = self.node - self.shift, 10 * of.model.blocks.span
        nodes = cKDTree(np.column_stack([given, far * of.apart.node_block]))
        distance, nearest = nodes.query(np.column_stack([bars.point, far * bars.block]))
        at_node = (distance <= SAME_POINT)[:, None]
        moved: FloatArray = np.where(at_node, self.shift[nearest], (self.centroid - centroid)[bars.block])
        return bars.point + moved


def outline_of(mesh: ContinuumMesh, node: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the corners of all blocks' outlines, and where those of each begin, (n + 1,).

    They are the ends of all sides of zones: with second-order zones sides that bend are chords.

    Parameters
    ----------
    mesh : ContinuumMesh
        The cells apart.
    node : (k, 2) float64 [m]
        Where their nodes are.
    """
    owner = mesh.block[mesh.mesh.f2t[0, mesh.piece_facet]]
    return node[mesh.piece_ends[:, 0]], np.concatenate([[0], np.cumsum(np.bincount(owner))]).astype(np.int32)
