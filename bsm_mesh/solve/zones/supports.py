"""Supports of the model as exact constraints on the finite-element displacements.

A support of a boundary holds every node of its edges, mid-side nodes too. At each node the displacement is given along
some axes, and free along the others. The node's unknowns are turned into these axes and the given ones are left out, so
that no penalty enters. (scikit-fem's own `mpc` does not serve here. It drops the equations of the eliminated unknowns,
where an inclined roller needs their component along the free direction.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.supports import Bars, Fixed, GivenSupport, NormalRoller, held_directions
from bsm_mesh.solve.zones.mesh import ContinuumMesh

SAME_POINT = 1e-9  # m; a support point nearer than this to a corner is that corner (as in `blocks_at`)
SMOOTH = np.cos(np.radians(15.0))  # edges that turn by less than twice this share one normal at their common node
RANK = 1e-9  # of a node's greatest eigenvalue: held directions that differ by less than 4e-5 rad are one
CONFLICT = 1e-6  # of the greatest prescribed displacement: a larger misfit is a contradiction

Rows = tuple[IntArray, FloatArray, FloatArray]
"""Nodes (k,), directions (k, 2) and displacements (k,) [m]: ``direction . u(node) = displacement``."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class HeldDisplacements:
    """Prescribed values of the supports, in the unknowns of a basis.

    Attributes
    ----------
    turn : sparse (N, N) or None
        Turns unknowns in the nodes' axes into x and y components; None: no node has inclined axes.
    held : (N,) bool
        Which unknowns (in the nodes' axes) are given.
    given : (N,) float64 [m]
        Their values.
    rows : sparse (m, N)
        Further constraints that take in many unknowns (x and y components): ``rows @ u = values``.
    values : (m,) float64 [m]
        Their prescribed values.
    """

    turn: Any
    held: BoolArray
    given: FloatArray
    rows: Any
    values: FloatArray


class SupportRows(NamedTuple):
    """Displacements that the supports prescribe.

    Attributes
    ----------
    nodal : tuple
        Displacements of nodes along directions, as `Rows`.
    rows : sparse (m, N)
        Constraints that take in many unknowns.
    values : (m,) float64 [m]
        Their values.
    """

    nodal: Rows
    rows: Any
    values: FloatArray


def held_displacements(
    supports: Sequence[GivenSupport | Bars],
    blocks: Blocks,
    mesh: ContinuumMesh,
    basis: Any,
    averages: tuple[Any, Any],
    present: BoolArray,
) -> HeldDisplacements:
    """Return supports as constraints on the unknowns of `basis`.

    * On a boundary: every node of its edges. Where neighbouring edges of a `NormalRoller` turn by less than 30
      degrees (a curve) their common node takes the mean normal; at a sharper corner it is held across both.
    * `Fixed` blocks: every node of the block. Any other support of a block, which holds its centroid in one
      direction: the block's average displacement, by an equation that takes in all its nodes.
    * At a point: the nodes there, else the interpolated displacement of that point.

    Parameters
    ----------
    supports : sequence of supports
        Of a model, checked when it was made.
    blocks : Blocks
        Its blocks.
    mesh : ContinuumMesh
        The cells.
    basis : skfem.CellBasis
        Of the vector-valued element.
    averages : pair of sparse (n_blocks, N)
        Give the blocks' average displacement in x and y.
    present : (n,) bool
        Which blocks are there; the others are not held.

    Raises
    ------
    ModelError
        If supports prescribe different displacements of one node.
    """
    given = support_rows(supports, blocks, mesh, basis, averages, present)
    turn, held, values = _node_axes(*given.nodal, nodal_unknowns(basis), basis.N)
    return HeldDisplacements(turn=turn, held=held, given=values, rows=given.rows, values=given.values)


def support_rows(
    supports: Sequence[GivenSupport | Bars],
    blocks: Blocks,
    mesh: ContinuumMesh,
    basis: Any,
    averages: tuple[Any, Any],
    present: BoolArray,
) -> SupportRows:
    """Return the displacements that supports prescribe; parameters as for `held_displacements`.

    Raises
    ------
    ModelError
        For supports given as bars.
    """
    node_dofs = nodal_unknowns(basis)
    nodal: list[Rows] = [(np.zeros(0, np.int32), np.zeros((0, 2)), np.zeros(0))]
    rows, values = [sp.csr_matrix((0, basis.N))], [np.zeros(0)]
    for support in supports:
        if isinstance(support, Bars):
            raise ModelError("supports given as bars have no boundary or block that the continuum could hold")
        if support.boundary is not None:
            nodal.extend(_boundary_rows(support, blocks, mesh, present))
        elif isinstance(support, Fixed) and support.blocks is not None:
            nodal.extend(_rows_at(support, _nodes_of_blocks(mesh, _here(support.blocks, present), len(node_dofs))))
        elif support.blocks is not None:
            ids = _here(support.blocks, present)
            (direction,), displacement = held_directions(support, np.zeros((len(ids), 2)))
            rows.append(sp.csr_matrix(direction[0, 0] * averages[0][ids] + direction[0, 1] * averages[1][ids]))
            values.append(np.full(len(ids), displacement))
        else:
            assert support.point is not None
            at = np.array(support.point)
            near = np.flatnonzero(np.hypot(*(mesh.mesh.p.T - at).T) <= SAME_POINT)
            if near.size:
                nodal.extend(_rows_at(support, near))
                continue
            probe = sp.csr_matrix(basis.probes(at[:, None]))
            directions, displacement = held_directions(support, np.zeros((1, 2)))
            rows.extend(sp.csr_matrix(d @ probe) for d in directions)
            values.append(np.full(len(directions), displacement))
    node, direction, value = (np.concatenate(column) for column in zip(*nodal, strict=True))
    real = node < len(node_dofs)  # with first-order elements there are no mid-side nodes
    return SupportRows((node[real], direction[real], value[real]), sp.vstack(rows), np.concatenate(values))


def nodal_unknowns(basis: Any) -> IntArray:
    """Return the unknowns (x, y) of every node, (nodes, 2): the vertices, then the mid-side nodes if there are any."""
    parts = [basis.nodal_dofs, basis.facet_dofs] if basis.facet_dofs.size else [basis.nodal_dofs]
    unknowns: IntArray = np.hstack(parts).T
    return unknowns


def _rows_at(support: GivenSupport, nodes: IntArray) -> list[Rows]:
    directions, displacement = held_directions(support, np.zeros((len(nodes), 2)))
    return [(nodes, direction, np.full(len(nodes), displacement)) for direction in directions]


def _here(blocks: Sequence[int], present: BoolArray) -> IntArray:
    ids = np.array(blocks, dtype=np.int32)
    return ids[present[ids]]


def _nodes_of_blocks(mesh: ContinuumMesh, blocks: IntArray, count: int) -> IntArray:
    """Return all nodes of the cells of some blocks."""
    chosen = np.isin(mesh.block, blocks)
    nodes = np.concatenate([mesh.mesh.t[:, chosen].ravel(), mesh.mesh.p.shape[1] + mesh.mesh.t2f[:, chosen].ravel()])
    return np.unique(nodes[nodes < count])


def _boundary_rows(support: GivenSupport, blocks: Blocks, mesh: ContinuumMesh, present: BoolArray) -> list[Rows]:
    """Return the rows of a boundary: both ends and the mid-side node of every piece of its edges."""
    assert support.boundary is not None
    edges = blocks.boundary_edges(support.boundary)
    edges = edges[present[blocks.owner[edges]]]
    facet, place = mesh.facets_of(edges)
    ends = mesh.mesh.facets[:, facet]
    along = blocks.edge_vectors[edges[place]]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    at_ends = np.tile(normal, (2, 1))
    if isinstance(support, NormalRoller):
        total = np.zeros((mesh.mesh.p.shape[1], 2))
        np.add.at(total, ends.ravel(), at_ends)
        mean = total[ends.ravel()]
        length = np.hypot(*mean.T)
        mean /= np.where(length > 0, length, 1.0)[:, None]  # the two lips of a slit cancel: each keeps its own
        smooth = (mean * at_ends).sum(axis=1) >= SMOOTH
        at_ends = np.where(smooth[:, None], mean, at_ends)
    nodes = np.concatenate([ends.ravel(), mesh.mesh.p.shape[1] + facet])
    directions, displacement = held_directions(support, np.concatenate([at_ends, normal]))
    return [(nodes, direction, np.full(len(nodes), displacement)) for direction in directions]


def _node_axes(
    node: IntArray, direction: FloatArray, displacement: FloatArray, node_dofs: IntArray, size: int
) -> tuple[Any, BoolArray, FloatArray]:
    """Return turn, held and given of `HeldDisplacements` from the rows at nodes."""
    held_nodes, place = np.unique(node, return_inverse=True)
    gram, right = np.zeros((len(held_nodes), 2, 2)), np.zeros((len(held_nodes), 2))
    np.add.at(gram, place, direction[:, :, None] * direction[:, None, :])
    np.add.at(right, place, direction * displacement[:, None])
    straight = np.abs(gram[:, 0, 1]) <= RANK * np.trace(gram, axis1=1, axis2=2)
    strength, axes = np.linalg.eigh(gram)
    strength = np.where(straight[:, None], np.diagonal(gram, axis1=1, axis2=2), strength)
    axes = np.where(straight[:, None, None], np.eye(2), axes)
    is_held = strength > RANK * strength.max(axis=1, initial=0.0)[:, None]
    value = np.einsum("kij,ki->kj", axes, right) * is_held / np.where(is_held, strength, 1.0)
    _check_conflicts(np.einsum("kij,kj->ki", axes, value)[place], direction, displacement)

    dofs = node_dofs[held_nodes]
    held, given = np.zeros(size, dtype=bool), np.zeros(size)
    held[dofs] = is_held
    given[dofs] = value
    inclined = dofs[~straight]
    if inclined.size == 0:
        return None, held, given
    rest = np.setdiff1d(np.arange(size), inclined)
    rows = np.concatenate([rest, np.repeat(inclined, 2, axis=1).ravel()])
    columns = np.concatenate([rest, np.tile(inclined, (1, 2)).ravel()])
    entries = np.concatenate([np.ones(len(rest)), axes[~straight].ravel()])
    return sp.csr_matrix((entries, (rows, columns)), shape=(size, size)), held, given


def _check_conflicts(reached: FloatArray, direction: FloatArray, displacement: FloatArray) -> None:
    misfit = np.abs((reached * direction).sum(axis=1) - displacement)
    limit = CONFLICT * float(np.abs(displacement).max(initial=0.0))
    if misfit.size and misfit.max() > limit:
        raise ModelError(
            "the supports prescribe different displacements of one point, where blocks share a node of the "
            f"continuum (up to {misfit.max():g} m apart); prescribe the same, or hold fewer points"
        )
