"""Which edges of the blocks lie on which curves of the mesh."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.groups import NamedGroup
from bsm_mesh.converters.meshes.report import MOST_LOST, Note, NoteKind, places
from bsm_mesh.errors import counted, listing, raise_faults
from bsm_mesh.model.edges import EdgeTable, LongArray
from bsm_mesh.model.polygons import next_corner, owner_of_corner

ALONG = 1e-6  # of the shorter length: how far off a line may lie along an edge
ENOUGH = 0.5 - 1e-6  # of an edge's length: covered so far, the edge belongs to the curve


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Coverage:
    """Which pieces of curves run along which edges.

    Attributes
    ----------
    piece, edge : (k,) int64
        Piece ``piece[i]`` runs along edge ``edge[i]``.
    share : (k,) float64
        Part of the edge's length that the piece covers.
    same_as : (n_pieces,) int64
        First piece between the same two points.
    paired : (n_edges,) bool
        Whether an edge of opposite direction lies on the other side of each edge.
    """

    piece: LongArray
    edge: LongArray
    share: FloatArray
    same_as: LongArray
    paired: BoolArray

    def edges_of(self, pieces: LongArray) -> tuple[LongArray, FloatArray]:
        """Return the edges of which the pieces cover half or more, and how much of each."""
        chosen = self._chosen(pieces)
        edges, inverse = np.unique(self.edge[chosen], return_inverse=True)
        share: FloatArray = np.bincount(inverse, self.share[chosen], minlength=len(edges)).astype(np.float64)
        enough = share >= ENOUGH
        return edges[enough], share[enough]

    def loose(self, pieces: LongArray, edges: LongArray) -> LongArray:
        """Return those of the pieces that run along none of the edges."""
        chosen = self._chosen(pieces)
        bounds = np.zeros(len(self.same_as), dtype=np.bool_)
        bounds[self.piece[chosen][np.isin(self.edge[chosen], edges)]] = True
        loose: LongArray = np.unique(self.same_as[pieces][~bounds[self.same_as[pieces]]])
        return loose

    def _chosen(self, pieces: LongArray) -> BoolArray:
        wanted = np.zeros(len(self.same_as), dtype=np.bool_)
        wanted[self.same_as[pieces]] = True
        chosen: BoolArray = wanted[self.piece]
        return chosen


def cover_edges(
    pieces: LongArray, ends: FloatArray, table: EdgeTable, vertices: FloatArray, offsets: IntArray, tolerance: float
) -> Coverage:
    """Return which pieces run along which edges.

    A piece between the two points of an edge lies along it. The rest (fewer than two edges found, so
    perhaps a corner in the middle of an edge) is matched by geometry with the edges that have no partner.

    Parameters
    ----------
    pieces : (n_pieces, 2) int64
        Points at the pieces' ends; -1 for points at which no block has a corner.
    ends : (n_pieces, 2, 2) float64 [m]
        Coordinates of the pieces' ends.
    table : EdgeTable
        The blocks' edges.
    vertices : (n_vertices, 2) float64 [m]
        The blocks' corners.
    offsets : (n_blocks + 1,) int32
        The blocks' first corners.
    tolerance : float [m]
        The merge tolerance.
    """
    first, last = np.sort(ends.view([("x", "f8"), ("y", "f8")])[..., 0], axis=1).T
    _, same, inverse = np.unique(np.stack([first, last], axis=1), axis=0, return_index=True, return_inverse=True)
    same_as = same[inverse.reshape(-1)]
    unique = np.unique(same_as)
    query, edge = table.joining(pieces[unique, 0], pieces[unique, 1])
    unpaired = table.unpaired()
    paired = ~unpaired
    free = unpaired
    free[edge] = False
    few = unique[np.bincount(query, minlength=len(unique)) < 2]
    near_piece, near_edge, share = _along(ends[few], vertices, offsets, np.flatnonzero(free), tolerance)
    return Coverage(
        piece=np.concatenate([unique[query], few[near_piece]]),
        edge=np.concatenate([edge, near_edge]),
        share=np.concatenate([np.ones(len(edge)), share]),
        same_as=same_as,
        paired=paired,
    )


def _along(
    ends: FloatArray, vertices: FloatArray, offsets: IntArray, edges: LongArray, tolerance: float
) -> tuple[LongArray, LongArray, FloatArray]:
    """Return piece, edge and the share of the edge covered, for pieces that run along a part of an edge."""
    import shapely

    if len(ends) == 0 or len(edges) == 0:
        return np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0)
    sides = np.stack([vertices[edges], vertices[next_corner(offsets)[edges]]], axis=1)
    reach = np.maximum(tolerance, ALONG * np.hypot(*(ends[:, 1] - ends[:, 0]).T))
    tree = shapely.STRtree(shapely.linestrings(sides))
    piece, side = tree.query(shapely.linestrings(ends), predicate="dwithin", distance=reach)
    start, vector = ends[piece, 0], ends[piece, 1] - ends[piece, 0]
    length = np.hypot(*vector.T)
    edge_length = np.hypot(*(sides[side, 1] - sides[side, 0]).T)
    direction = vector / np.maximum(length, np.finfo(np.float64).tiny)[:, None]
    relative = sides[side] - start[:, None]
    along = np.einsum("nij,nj->ni", relative, direction)
    off = np.abs(relative[..., 0] * direction[:, None, 1] - relative[..., 1] * direction[:, None, 0]).max(axis=1)
    slack = np.maximum(tolerance, ALONG * np.minimum(length, edge_length))
    overlap = np.minimum(length, along.max(axis=1)) - np.maximum(0.0, along.min(axis=1))
    good = (off <= slack) & (overlap > slack)
    return piece[good], edges[side[good]], overlap[good] / edge_length[good]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LoosePieces:
    """Pieces of a curve that bound no element.

    Attributes
    ----------
    group : str
        The curve, ``kind:name``.
    ends : (k, 2, 2) float64 [m]
        Ends of the pieces.
    laid : float [m]
        Length of the pieces that do bound one.
    """

    group: str
    ends: FloatArray
    laid: float


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class CurveEdges:
    """Edges on the curves of one kind.

    Attributes
    ----------
    edges : dict of str to (k,) int32
        Edges on each curve; curves on no edge are left out.
    loose : tuple of LoosePieces
        Pieces that bound no element.
    """

    edges: dict[str, IntArray]
    loose: tuple[LoosePieces, ...]


def edges_on_curves(curves: dict[str, list[NamedGroup]], coverage: Coverage, ends: FloatArray) -> CurveEdges:
    """Return the edges on each named curve, and the pieces that bound no element."""
    found: dict[str, IntArray] = {}
    left: list[LoosePieces] = []
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    for name, parts in curves.items():
        pieces = np.concatenate([part.pieces for part in parts])
        edges, _ = coverage.edges_of(pieces)
        loose = coverage.loose(pieces, edges)
        if edges.size:
            found[name] = edges.astype(np.int32)
        if loose.size:
            laid = float(length[np.setdiff1d(coverage.same_as[pieces], loose)].sum())
            left.append(LoosePieces(group=str(parts[0].name), ends=ends[loose], laid=laid))
    return CurveEdges(edges=found, loose=tuple(left))


def loose_notes(pieces: Iterable[LoosePieces], vertices: FloatArray, offsets: IntArray) -> list[Note]:
    """Return notes on pieces that bound no block: those that would divide one, by its outline, are lost."""
    notes = []
    for loose in pieces:
        middle, name = loose.ends.mean(axis=1), loose.group
        dividing = _dividing(loose.ends, vertices, offsets)
        lost = float(np.hypot(*(loose.ends[dividing, 1] - loose.ends[dividing, 0]).T).sum())
        if lost > MOST_LOST * (lost + loose.laid):
            text = (
                f"{lost:.3g} of {lost + loose.laid:.3g} m of '{name}' run through blocks and divide none "
                f"({places(middle[dividing])}); let the mesh follow the curve, or lay a joint by [joint.NAME] along"
            )
            notes.append(Note(kind=NoteKind.LOST, name=name, count=int(dividing.sum()), text=text))
            middle = middle[~dividing]
        if len(middle):
            what = "bounds no block and is left out" if len(middle) == 1 else "bound no block and are left out"
            text = f"{counted(len(middle), 'piece')} of '{name}' {what} ({places(middle)})"
            notes.append(Note(kind=NoteKind.LOOSE, name=name, count=len(middle), text=text))
    return notes


def _dividing(ends: FloatArray, vertices: FloatArray, offsets: IntArray) -> BoolArray:
    """Return which pieces run through a block that they divide together; dead ends divide none."""
    import shapely

    rings = shapely.linearrings(vertices, indices=owner_of_corner(offsets))
    lines = shapely.linestrings(ends)
    piece, block = shapely.STRtree(shapely.polygons(rings)).query(lines, predicate="intersects")
    divides = np.zeros(len(ends), dtype=np.bool_)
    if not piece.size:
        return divides
    inside = shapely.length(shapely.intersection(lines[piece], shapely.polygons(rings[block]))) > 0
    piece, block = piece[inside], block[inside]
    order = np.argsort(block, kind="stable")
    crossed, index = np.unique(block[order], return_inverse=True)
    within = shapely.multilinestrings(lines[piece[order]], indices=index.reshape(-1))
    noded = shapely.union(rings[crossed], within, grid_size=ALONG**2 * float(np.ptp(vertices, axis=0).max()))
    several = shapely.get_num_geometries(shapely.polygonize(noded[:, None])) > 1
    divides[piece[np.isin(block, crossed[several])]] = True
    return divides


def interior_notes(boundaries: Mapping[str, IntArray], paired: BoolArray, vertices: FloatArray) -> list[Note]:
    """Return a note on each boundary with rock on both sides."""
    notes = []
    for name, edges in boundaries.items():
        inside = edges[paired[edges]]
        if inside.size:
            text = (
                f"'boundary:{name}' has blocks on both sides along {counted(inside.size, 'edge')} "
                f"({places(vertices[inside])}); this is usual for a face that a later stage excavates. Before that "
                "stage a pressure on it loads the blocks of both sides"
            )
            notes.append(Note(kind=NoteKind.INTERIOR, name=f"boundary:{name}", count=int(inside.size), text=text))
    return notes


def joint_of_edges(joints: dict[str, IntArray], vertices: FloatArray, n_edges: int) -> tuple[Sequence[str], IntArray]:
    """Return the names of the joints and the index of every edge's joint, -1 for none.

    Raises
    ------
    ModelError
        If an edge lies on two joints.
    """
    names = list(joints)
    index = np.full(n_edges, -1, dtype=np.int32)
    faults = []
    for k, edges in enumerate(joints.values()):
        for j in np.unique(index[edges][index[edges] >= 0]):
            both = edges[index[edges] == j]
            faults.append(
                f"{both.size} edges are in 'joint:{names[j]}' and in 'joint:{names[k]}' "
                f"(edges {listing(both)}, {places(vertices[both])}); give each curve one joint"
            )
        index[edges] = k
    raise_faults(faults)
    return names, index
