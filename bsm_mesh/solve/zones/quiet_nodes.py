"""Quiet boundaries of zones: viscous dashpots at the nodes of the boundary let waves out (Lysmer & Kuhlemeyer 1969).

Tractions on the boundary are ``-rho c_p v_n`` across it and ``-rho c_s v_t`` along it. A wave that enters with the
velocity v has twice these tractions of v besides.

References
----------
Lysmer & Kuhlemeyer (1969), Finite dynamic model for infinite media, J. Eng. Mech. Div. ASCE 95(4), 859-877.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.errors import ModelError
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.zones.supports import nodal_unknowns

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stages import Continuum


class QuietNodes(NamedTuple):
    """Dashpots at nodes.

    Attributes
    ----------
    dashpots : (k, 3) float64 [N s/m2]
        Along x and y; the third is 0.
    push : (k, 3) float64 [N s/m2, m]
        Forces of a wave over its velocity, or over its stress.
    """

    dashpots: FloatArray
    push: FloatArray

    def on_unknowns(self, basis: Any) -> BoolArray:
        """Return which unknowns of a basis belong to nodes with dashpots, (N,)."""
        found = np.zeros(basis.N, dtype=bool)
        found[nodal_unknowns(basis)[self.dashpots.any(axis=1)]] = True
        return found


def quiet_nodes(
    of: Continuum, stiffness: FloatArray, shaking: Shaking, axis: FloatArray, present: BoolArray
) -> QuietNodes:
    """Return the dashpots of all quiet boundaries of blocks (n,) that are there.

    Parameters
    ----------
    of : Continuum
        The cells.
    stiffness : (t, 3, 3) float64 [Pa]
        Of every cell.
    shaking : Shaking
        With the boundaries, and the one where a wave enters.
    axis : (2,) float64
        Direction in which the wave moves nodes.
    present : (n,) bool
        Which blocks are there.

    Raises
    ------
    ModelError
        If a boundary is neither horizontal nor vertical.
    """
    count = of.basis.N // 2
    dashpots, push = np.zeros((count, 3)), np.zeros((count, 3))
    for name in shaking.quiet:
        node, length, rates = _sides(of, stiffness, name, present)
        found = np.zeros((count, 2))
        np.add.at(found, node, length[:, None] * rates)
        dashpots[:, :2] += found
        if name == shaking.boundary:
            if shaking.quantity == "stress":
                np.add.at(push[:, :2], node, length[:, None] * axis)
            else:
                push[:, :2] += 2 * found * axis
    return QuietNodes(dashpots, push)


def _sides(
    of: Continuum, stiffness: FloatArray, name: str, present: BoolArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return nodes of a boundary's sides (q,), the length of each [m], and dashpots over it along x and y (q, 2)."""
    mesh, blocks = of.mesh, of.model.blocks
    edge = mesh.edge_of_piece
    piece = np.flatnonzero(np.isin(edge, blocks.boundary_edges(name)) & present[blocks.owner[edge]])
    ends = mesh.piece_ends[piece]
    along = np.diff(mesh.mesh.p.T[ends], axis=1)[:, 0]
    length = np.hypot(*along.T)
    if (np.abs(along).min(axis=1) > RULES.flat * length).any():
        raise ModelError(
            f"shaking: quiet: boundary '{name}' is inclined, and zones have dashpots along x and y only; give it "
            "horizontal and vertical sides, or leave zones out"
        )
    cell = mesh.mesh.f2t[0, mesh.piece_facet[piece]]
    block = mesh.block[cell]
    density = of.model.weights[block] / blocks.moments.area[block] / GRAVITY
    x, y, shear = (np.sqrt(density * stiffness[cell, k, k]) for k in range(3))
    is_level = np.abs(along[:, 0]) > np.abs(along[:, 1])
    rates = np.stack([np.where(is_level, shear, x), np.where(is_level, y, shear)], axis=1)
    nodes, shares = ends, np.array([0.5, 0.5])
    if of.discretization.order == 2:
        nodes = np.column_stack([ends, mesh.mesh.p.shape[1] + mesh.piece_facet[piece]])
        shares = np.array([1.0, 1.0, 4.0]) / 6
    width = nodes.shape[1]
    return nodes.ravel(), (length[:, None] * shares).ravel(), np.repeat(rates, width, axis=0)
