"""A network of joints for flow: nodes, and joint pieces between two of them that conduct by the cubic law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class Network(Portable):
    """Nodes and the pieces of joints between them.

    Attributes
    ----------
    point : (n, 2) float64 [m]
        The nodes.
    first, last : (m,) int32
        The nodes at both ends of every piece.
    """

    point: FloatArray
    first: IntArray
    last: IntArray

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def length(self) -> FloatArray:
        """Length of every piece, (m,) [m]."""
        length: FloatArray = np.hypot(*(self.point[self.last] - self.point[self.first]).T)
        return length

    def parts(self, open_piece: BoolArray) -> IntArray:
        """Return the number of the connected part of every node, (n,) int32, where pieces (m,) conduct."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        ends = self.first[open_piece], self.last[open_piece]
        size = len(self.point)
        graph = coo_array((np.ones(len(ends[0])), ends), shape=(size, size))
        part: IntArray = connected_components(graph, directed=False)[1]
        return part


def cubic_law(
    first: FloatArray, last: FloatArray, length: FloatArray, unit_weight: float, viscosity: float
) -> FloatArray:
    """Return the conductance of joint pieces, (m,) [m2/s]: discharge per metre of thickness over the drop of head.

    Between smooth parallel walls the discharge is ``q = a^3 rho g i / (12 mu)``. Where the aperture runs linearly from
    a1 to a2 the head is not linear; the law integrated along the piece has ``a^3 = 2 a1^2 a2^2 / (a1 + a2)``.

    Parameters
    ----------
    first, last : (m,) float64 [m]
        Hydraulic apertures at both ends; 0: sealed.
    length : (m,) float64 [m]
        Of the pieces.
    unit_weight : float [N/m3]
        Of the water, rho g.
    viscosity : float [Pa s]
        Its dynamic viscosity mu.

    References
    ----------
    P.A. Witherspoon, J.S.Y. Wang, K. Iwai, J.E. Gale, Validity of cubic law for fluid flow in a deformable rock
    fracture, Water Resources Research 16 (1980) 1016-1024.
    """
    total = first + last
    cube = 2 * first**2 * last**2 / np.where(total > 0, total, 1.0)
    conductance: FloatArray = cube * unit_weight / (12 * viscosity * length)
    return conductance


def sums_at_nodes(network: Network, of_first: FloatArray, of_last: FloatArray) -> FloatArray:
    """Return the sum at every node over its pieces (m,): `of_first` where it is the first, less `of_last`, (n,)."""
    n = len(network.point)
    at_first, at_last = (
        np.bincount(nodes, values, n).astype(np.float64)
        for nodes, values in ((network.first, of_first), (network.last, of_last))
    )
    sums: FloatArray = at_first - at_last
    return sums


def floating_nodes(
    network: Network, by_first: FloatArray, by_last: FloatArray, by_well: FloatArray, held: BoolArray
) -> BoolArray:
    """Return the nodes whose change no held node and no well feels, directly or through others, (n,).

    Parameters
    ----------
    network : Network
        Nodes and pieces.
    by_first, by_last : (m,) float64 [m/s]
        Derivatives of every piece's discharge by the unknowns of its first and of its last node.
    by_well : (n,) float64 [m/s]
        Derivatives of what wells take.
    held : (n,) bool
        Nodes whose unknown is known.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    n, first, last = len(held), network.first, network.last
    down, up, well = by_first != 0, by_last != 0, np.flatnonzero(by_well)
    felt_at = np.concatenate([last[down], first[up], np.full(len(well), n)])
    felt_at = np.where(np.append(held, True)[felt_at], n, felt_at)
    changes = np.concatenate([first[down], last[up], well])
    graph = coo_array((np.ones(len(felt_at)), (felt_at, changes)), shape=(n + 1, n + 1))
    floating = np.ones(n + 1, dtype=bool)
    floating[breadth_first_order(graph.tocsr(), n, return_predecessors=False)] = False
    return floating[:n]
