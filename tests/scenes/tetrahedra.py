"""The same blocks of other cells: every cell is cut into tetrahedra, every face into triangles."""

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.polygons import next_corner


def of_tetrahedra(blocks):
    """Return blocks of cells about the middles of the cells given, over triangles about the middles of their faces."""
    offsets, sizes, count = blocks.face_offsets, np.diff(blocks.face_offsets), len(blocks.vertices)
    middle = np.add.reduceat(blocks.vertices[blocks.face_vertices], offsets[:-1]) / sizes[:, None]
    cells, inside = blocks.face_cells, blocks.face_cells >= 0
    faces_of = np.bincount(cells[inside], minlength=len(blocks.cell_block))
    sums = np.zeros((len(faces_of), 3))
    for side in (0, 1):
        np.add.at(sums, cells[inside[:, side], side], middle[inside[:, side]])
    face = np.repeat(np.arange(len(sizes)), sizes)
    triangle = np.column_stack(
        [blocks.face_vertices, blocks.face_vertices[next_corner(offsets)], count + face]
    )  # counter-clockwise seen from outside the first cell
    first = triangle[inside[face, 0]], triangle[inside[face, 1]][:, ::-1]
    parent = np.concatenate([face[inside[face, side]] for side in (0, 1)])
    cell = np.concatenate([cells[face[inside[face, side]], side] for side in (0, 1)])
    tetrahedron = np.column_stack([np.concatenate(first), count + len(sizes) + cell])
    sides = tetrahedron[:, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]].reshape(-1, 3)
    _, at, number = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_inverse=True)
    number = number.reshape(-1)
    both = np.full((len(at), 2), -1, np.int32)
    both[:, 0] = at // 4
    other = np.setdiff1d(np.arange(len(sides)), at)
    both[number[other], 1] = other // 4
    of_face = np.full(len(at), -1)
    of_face[number[::4]] = parent  # the first side of each is on the face given
    return bsm.Polyhedra(
        vertices=np.concatenate([blocks.vertices, middle, sums / faces_of[:, None]]),
        face_vertices=sides[at].reshape(-1).astype(np.int32),
        face_offsets=np.arange(0, 3 * len(at) + 1, 3, dtype=np.int32),
        face_cells=both,
        face_joint=np.where(of_face >= 0, blocks.face_joint[of_face], -1).astype(np.int32),
        cell_block=blocks.cell_block[cell],
        rock=blocks.rock,
        rock_names=blocks.rock_names,
        joint_names=blocks.joint_names,
        boundaries={
            name: np.flatnonzero(np.isin(of_face, own)).astype(np.int32) for name, own in blocks.boundaries.items()
        },
        excavations=blocks.excavations,
    )
