"""Volume elements as cells: their faces, each once, with the elements on both sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import counted, numbered, raise_faults
from bsm_mesh.model.edges import LongArray
from bsm_mesh.three_d.blocks.polygons import vector_areas

FACES = {  # corners of the faces, counter-clockwise seen from outside
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
CORNERS = {"tetra": 4, "hexahedron": 8, "wedge": 6, "pyramid": 5}
FLAT = 1e-6  # of an element's size: greatest height of a corner over a face that counts as plane


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElementCells:
    """Volume elements as the `Cells` that `Polyhedra.from_cells` takes; the arrays are described there."""

    vertices: FloatArray
    face_vertices: IntArray
    face_offsets: IntArray
    face_cells: IntArray
    face_joint: IntArray
    cell_rock: IntArray
    cell_excavation: IntArray
    joint_names: tuple[str, ...]
    rock_names: tuple[str, ...]
    excavation_names: tuple[str, ...]
    boundaries: Mapping[str, IntArray]


@dataclass(frozen=True, slots=True, eq=False)
class ElementFaces:
    """The faces of volume elements, each once.

    Attributes
    ----------
    loops : (n, 4) int64
        Corners, counter-clockwise seen from outside the first element; -1 after the third of a triangle.
    cells : (n, 2) int32
        The elements on both sides; the second is -1 where there is none.
    """

    loops: LongArray
    cells: IntArray

    def find(self, corners: LongArray) -> LongArray:
        """Return the faces with these corners (k, 4), in any order, -1 filling up; -1 where there is none."""
        keys = np.sort(np.concatenate([self.loops, corners]), axis=1)
        _, number = np.unique(keys, axis=0, return_inverse=True)
        number = number.reshape(-1)
        face = np.full(int(number.max(initial=-1)) + 1, -1, dtype=np.int64)
        face[number[: len(self.loops)]] = np.arange(len(self.loops))
        found: LongArray = face[number[len(self.loops) :]]
        return found


def element_faces(source: str, points: FloatArray, elements: Sequence[tuple[str, LongArray]]) -> ElementFaces:
    """Return the faces of elements, which are numbered in the order given; inverted ones are turned.

    Parameters
    ----------
    source : str
        Named in messages.
    points : (n, 3) float64 [m]
        Nodes.
    elements : sequence of (str, (m, k) int64)
        Kind of the elements, and their corners.

    Raises
    ------
    ModelError
        For elements without volume or with bent faces, and meshes whose elements do not share whole faces.
    """
    loops, owner, faults, first = [], [], list[str](), 0
    for kind, corners in elements:
        number = np.arange(first, first + len(corners))
        inverted = _check(points, kind, corners, number, faults)
        for face in FACES[kind]:
            loop = corners[:, face]
            loop = np.where(inverted[:, None], loop[:, ::-1], loop)
            loops.append(np.pad(loop, ((0, 0), (0, 4 - len(face))), constant_values=-1))
            owner.append(number)
        first += len(corners)
    raise_faults([f"{source}: {fault}" for fault in faults])
    loop, cell = np.concatenate(loops), np.concatenate(owner)
    order = np.argsort(cell, kind="stable")
    loop, cell = loop[order], cell[order]
    _, begin, number, count = np.unique(
        np.sort(loop, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    number = number.reshape(-1)
    if (count > 2).any():
        many = np.unique(cell[np.isin(number, np.flatnonzero(count > 2))])
        raise_faults(
            [f"{source}: {numbered('element', many)}: share a face with two others, so they overlap; repair the mesh"]
        )
    cells = np.stack([cell[begin], np.full(len(begin), -1)], axis=1)
    last = np.zeros(len(begin), dtype=np.int64)
    np.maximum.at(last, number, np.arange(len(number)))
    cells[count == 2, 1] = cell[last[count == 2]]
    rank = np.argsort(begin)
    found = ElementFaces(loops=loop[begin[rank]], cells=cells[rank].astype(np.int32))
    raise_faults([f"{source}: {fault}" for fault in _halves(found)])
    return found


def _check(points: FloatArray, kind: str, corners: LongArray, number: LongArray, faults: list[str]) -> np.ndarray:
    """Return which elements are inverted; add a fault for those without volume, or not convex with plane faces."""
    place = points[corners]
    middle, size = place.mean(axis=1), np.ptp(place, axis=1).max(axis=1)
    volume, height = np.zeros(len(corners)), []
    for face in FACES[kind]:
        loop = place[:, face]
        area = vector_areas(loop.reshape(-1, 3), np.arange(0, len(loop) * len(face) + 1, len(face)))
        volume += np.einsum("ij,ij->i", loop.mean(axis=1) - middle, area) / 3
        length = np.linalg.norm(area, axis=1)
        normal = area / np.where(length > 0, length, 1.0)[:, None]
        height.append(np.einsum("ikj,ij->ik", place - loop.mean(axis=1)[:, None], normal))
    inverted: np.ndarray = volume < 0
    flat = np.abs(volume) <= 1e-15 * size**3
    above = np.max([np.where(inverted[:, None], -h, h).max(axis=1) for h in height], axis=0)
    on_face = np.max([np.abs(h[:, face]).max(axis=1) for h, face in zip(height, FACES[kind], strict=True)], axis=0)
    bent = ~flat & (np.maximum(above, on_face) > FLAT * size)
    if flat.any():
        faults.append(f"{numbered('element', number[flat])}: no volume; repair the mesh")
    if bent.any():
        faults.append(
            f"{numbered('element', number[bent])}: a {kind} whose faces are not plane, or that is not convex; "
            "mesh this part with tetrahedra"
        )
    return inverted


def _halves(faces: ElementFaces) -> list[str]:
    """Return a fault where a quadrilateral of one element lies on triangles of others."""
    outer = faces.loops[faces.cells[:, 1] < 0]
    quad, triangle = outer[outer[:, 3] >= 0], outer[outer[:, 3] < 0][:, :3]
    if not (len(quad) and len(triangle)):
        return []
    parts = np.concatenate([np.delete(quad, k, axis=1) for k in range(4)])
    _, number = np.unique(np.sort(np.concatenate([parts, triangle]), axis=1), axis=0, return_inverse=True)
    number = number.reshape(-1)
    shared = np.intersect1d(number[: len(parts)], number[len(parts) :])
    if not len(shared):
        return []
    return [
        f"{counted(len(shared), 'triangle')} of elements on a quadrilateral of another: the mesh does not conform; "
        "put pyramids between hexahedra and tetrahedra"
    ]
