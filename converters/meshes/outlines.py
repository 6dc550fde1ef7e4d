"""Clean outlines in metres from surface elements: one plane, nodes merged, corners counter-clockwise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.cells import MeshCells
from bsm_mesh.converters.meshes.repeats import first_of_equal
from bsm_mesh.converters.meshes.report import Note, NoteKind, places
from bsm_mesh.converters.meshes.straight import Precision, straight_points
from bsm_mesh.errors import ModelError, counted, listing
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.block_faults import FARTHEST
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import edge_vectors, next_corner, polygon_moments
from bsm_mesh.section_plane import PLANE_TOLERANCE, section_axes

FLATNESS = 1e-11  # area over perimeter squared; `Blocks` refuses below 1e-12


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Outlines:
    """Simple outlines of surface elements.

    Attributes
    ----------
    points : (n_points, 2) float64 [m]
        The merged nodes.
    corners : (n_corners,) int32
        Points of the outlines, counter-clockwise, outline after outline.
    offsets : (n_outlines + 1,) int32
        Outline k owns ``corners[offsets[k]:offsets[k + 1]]``.
    outline_of : (n_elements,) int64
        Outline of each element of the mesh; -1 for those left out.
    pieces : (n_pieces, 2) int64
        End points of the line elements, then of the interface elements.
    piece_of : (n_elements,) int64
        Piece that represents each interface element; -1 for all other elements.
    notes : tuple of Note
        Repairs and omissions.
    precision : Precision
        Of the coordinates in the file.
    tolerance : float [m]
        Points nearer than this are one: the merge tolerance, or what rounding of the coordinates leaves.
    """

    points: FloatArray
    corners: IntArray
    offsets: IntArray
    outline_of: LongArray
    pieces: LongArray
    piece_of: LongArray
    notes: tuple[Note, ...]
    precision: Precision
    tolerance: float

    def straightened(self) -> Outlines:
        """Return outlines whose edges in one line, to the digits of the file, are in one line to rounding."""
        every = np.arange(len(self.corners))
        return replace(self, points=straight_points(self.points, self.corners, self.offsets, every, self.precision))


def outline_elements(cells: MeshCells, *, unit_scale: float, merge_tolerance: float) -> Outlines:
    """Return the outlines of the surface elements of a mesh.

    Nodes nearer than the tolerance become one; corners that then repeat, and elements that then have no
    area, are left out; clockwise elements are turned round; elements given twice become one.

    Parameters
    ----------
    cells : MeshCells
        The mesh.
    unit_scale : float [m]
        The mesh's unit of length.
    merge_tolerance : float [m]
        Nodes nearer than this are one.

    Raises
    ------
    ModelError
        If the mesh is not plane, lies in a tilted plane, or has coordinates that are no numbers.
    """
    used = _used_nodes(cells, unit_scale)
    axes, notes = _plane_axes(cells.source, cells.points, used)
    given = cells.points[used][:, axes]
    flat, precision = given * unit_scale, Precision.of(given, unit_scale, merge_tolerance)
    tolerance = max(merge_tolerance, precision.rounding) if merge_tolerance else 0.0
    label = merge_points(flat, tolerance)
    points = np.empty((int(label.max()) + 1, 2))
    points[label[::-1]] = flat[::-1]  # where nodes merge, the first one's place
    number = np.full(len(cells.points), -1, dtype=np.int32)
    number[used] = label
    if len(points) < len(flat):
        count = len(flat) - len(points)
        text = f"{count} nodes lie within {tolerance:.3g} m of another and are merged with it"
        notes.append(Note(kind=NoteKind.MERGED, count=count, text=text))
    return _clean(cells, points, number, tolerance, notes, precision)


def _used_nodes(cells: MeshCells, unit_scale: float) -> BoolArray:
    used = np.zeros(len(cells.points), dtype=np.bool_)
    used[cells.corners] = True
    used[cells.pieces.ravel()] = True
    farthest = FARTHEST / max(unit_scale, 1.0)  # also in the mesh's own unit: it is squared before it is scaled
    bad = np.flatnonzero(used & ~(np.abs(cells.points) < farthest).all(axis=1))
    if bad.size:
        raise ModelError(
            f"{cells.source}: coordinates of {counted(bad.size, 'node')} are no numbers below {farthest:g} "
            f"(counted from 0: {listing(bad)}); correct the mesh, or its unit of length"
        )
    return used


def _plane_axes(source: str, points: FloatArray, used: BoolArray) -> tuple[list[int], list[Note]]:
    """Return which coordinates are x (right) and y (up)."""
    if points.shape[1] == 2:
        return [0, 1], []
    extent = np.ptp(points[used], axis=0)
    if (axes := section_axes(extent.tolist())) is not None:
        right = "xy"[axes[0]]
        text = f"the mesh lies in the {right}z plane: {right} is taken as right, z as up"
        return list(axes), [] if axes == (0, 1) else [Note(kind=NoteKind.PLANE, count=1, text=text)]
    centred = points[used] - points[used].mean(axis=0)
    spread, directions = np.linalg.eigh(centred.T @ centred)
    if spread[0] <= PLANE_TOLERANCE**2 * spread[2]:
        normal = ", ".join(f"{component:.4g}" for component in directions[:, 0])
        raise ModelError(
            f"{source}: the mesh lies in a plane that is tilted to the axes (normal {normal}); "
            "rotate it into the xy plane, y up"
        )
    raise ModelError(
        f"{source}: the mesh is not plane (extent {extent[0]:.4g} x {extent[1]:.4g} x {extent[2]:.4g}); "
        "blocks are plane: take one cross-section"
    )


def _clean(
    cells: MeshCells, points: FloatArray, number: IntArray, tolerance: float, notes: list[Note], precision: Precision
) -> Outlines:
    given = number[cells.corners]
    corners, kept = _drop_repeated(given, cells.offsets)
    interface = (np.diff(cells.offsets) >= 4) & (kept == 2)
    element = np.flatnonzero(kept >= 3)
    corners = corners[np.repeat(kept >= 3, kept)]
    offsets = _offsets(kept[element])
    area, thin = _areas(points[corners], offsets, tolerance)
    _refuse_crossing(cells, element[thin], *_keep(thin, corners, offsets), points, tolerance)
    element, area, (corners, offsets) = element[~thin], area[~thin], _keep(~thin, corners, offsets)
    corners = _turn(corners, offsets, area < 0)
    first = first_of_equal(corners, offsets)
    once = first == np.arange(len(first))
    if element.size == 0:
        raise ModelError(
            f"{cells.source}: none of the {cells.count} surface elements has an area; "
            f"see whether the unit of length and the merge tolerance ({tolerance:g} m) fit the mesh"
        )
    outline_of = np.full(cells.count, -1, dtype=np.int64)
    outline_of[element] = (np.cumsum(once) - 1)[first]
    corners, offsets = _keep(once, corners, offsets)
    piece_of = np.full(cells.count, -1, dtype=np.int64)
    piece_of[interface] = len(cells.pieces) + np.arange(int(interface.sum()))
    flat = (outline_of < 0) & ~interface
    mended = (
        (NoteKind.INTERFACE, interface, "interface elements of zero thickness are not blocks"),
        (NoteKind.FLAT, flat, "elements without area are left out"),
        (NoteKind.CORNERS, (kept < np.diff(cells.offsets)) & ~interface & ~flat, "elements lose corners that coincide"),
        (NoteKind.FLIPPED, _among(cells, element[area < 0]), "elements are given clockwise and are turned round"),
        (NoteKind.JOINED, _among(cells, element[~once]), "elements are given more than once and are taken once"),
    )
    at = points[given[cells.offsets[:-1]]]
    return Outlines(
        points=points,
        corners=corners,
        offsets=offsets,
        outline_of=outline_of,
        pieces=np.concatenate([number[cells.pieces], _lips(given, cells.offsets, interface)]).astype(np.int64),
        piece_of=piece_of,
        notes=(*notes, *(_note(cells, at, *what) for what in mended if what[1].any())),
        precision=precision,
        tolerance=tolerance,
    )


def _among(cells: MeshCells, elements: LongArray) -> BoolArray:
    which = np.zeros(cells.count, dtype=np.bool_)
    which[elements] = True
    return which


def _note(cells: MeshCells, at: FloatArray, kind: NoteKind, which: BoolArray, what: str) -> Note:
    count = int(which.sum())
    elements = f"elements {listing(cells.numbers[which])}, {places(at[which])}"
    return Note(kind=kind, count=count, text=f"{count} {what} ({elements})")


def _offsets(sizes: LongArray) -> IntArray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)


def _drop_repeated(corners: IntArray, offsets: IntArray) -> tuple[IntArray, LongArray]:
    """Return the corners that differ from the next of the same outline, and how many each outline keeps."""
    differs = corners != corners[next_corner(offsets)]
    return corners[differs], np.add.reduceat(differs.astype(np.int64), offsets[:-1])


def _keep(which: BoolArray, corners: IntArray, offsets: IntArray) -> tuple[IntArray, IntArray]:
    """Return the corners and offsets of some outlines."""
    if which.all():
        return corners, offsets
    sizes = np.diff(offsets)
    return corners[np.repeat(which, sizes)], _offsets(sizes[which])


def _areas(vertices: FloatArray, offsets: IntArray, tolerance: float) -> tuple[FloatArray, BoolArray]:
    """Return the signed areas [m2], and which outlines are thinner than the tolerance or than rounding allows."""
    if len(offsets) == 1:
        return np.empty(0), np.empty(0, dtype=np.bool_)
    area = polygon_moments(vertices, offsets).area
    edge = np.hypot(*edge_vectors(vertices, offsets).T)
    longest = np.maximum.reduceat(edge, offsets[:-1])
    perimeter = np.add.reduceat(edge, offsets[:-1])
    thin: BoolArray = np.abs(area) <= np.maximum(tolerance * longest / 2, FLATNESS * perimeter**2)
    return area, thin


def _refuse_crossing(
    cells: MeshCells, element: LongArray, corners: IntArray, offsets: IntArray, points: FloatArray, tolerance: float
) -> None:
    """Refuse outlines without area whose corners are not on a line: two equal halves that run opposite ways."""
    if element.size == 0:
        return
    arm = points[corners] - points[corners[np.repeat(offsets[:-1], np.diff(offsets))]]
    following = arm[next_corner(offsets)]
    halves = np.add.reduceat(np.abs(arm[:, 0] * following[:, 1] - arm[:, 1] * following[:, 0]), offsets[:-1]) / 2
    reach = np.maximum.reduceat(np.hypot(*arm.T), offsets[:-1])
    bad = np.flatnonzero(halves > np.maximum(tolerance * reach, 100 * FLATNESS * reach**2))
    if bad.size:
        raise ModelError(
            f"{cells.source}: {bad.size} elements cross themselves (elements {listing(cells.numbers[element[bad]])}, "
            f"{places(points[corners[offsets[bad]]])}); give their corners in order round the element"
        )


def _turn(corners: IntArray, offsets: IntArray, which: BoolArray) -> IntArray:
    """Return the corners with some outlines reversed; each keeps its first corner."""
    if not which.any():
        return corners
    sizes = np.diff(offsets)
    start = np.repeat(offsets[:-1], sizes)
    within = np.arange(len(corners)) - start
    size = np.repeat(sizes, sizes)
    source = np.where(np.repeat(which, sizes), (size - within) % size, within)
    turned: IntArray = corners[start + source]
    return turned


def _lips(corners: IntArray, offsets: IntArray, interface: BoolArray) -> IntArray:
    """Return the two points of each interface element, (n_interfaces, 2)."""
    starts = offsets[:-1]
    both = np.stack([np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)], axis=1)
    lips: IntArray = both[interface]
    return lips
