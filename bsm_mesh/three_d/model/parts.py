"""Some of the blocks as polyhedra of their own: those present at a stage."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


def some_polyhedra(blocks: Polyhedra, present: BoolArray) -> tuple[Polyhedra, IntArray]:
    """Return the blocks with `present` (n,) true, in their order, and the number of each of their faces in the whole.

    Faces against blocks that are not there become outer ones. Points keep their numbers.
    """
    if present.all():
        return blocks, np.arange(len(blocks.face_joint), dtype=np.int32)
    block_number = np.cumsum(present, dtype=np.int32) - 1
    cell_stays = present[blocks.cell_block]
    cell_number = np.append(np.where(cell_stays, np.cumsum(cell_stays) - 1, -1), -1).astype(np.int32)
    cells = cell_number[blocks.face_cells]
    face = np.flatnonzero((cells >= 0).any(axis=1)).astype(np.int32)
    turned = cells[face, 0] < 0
    cells = np.where(turned[:, None], cells[face][:, ::-1], cells[face])
    sizes = np.diff(blocks.face_offsets)[face]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
    within = np.where(np.repeat(turned, sizes), np.repeat(sizes, sizes) - 1 - within, within)
    new_face = np.full(len(blocks.face_joint), -1, np.int32)
    new_face[face] = np.arange(len(face))
    boundaries = {name: new_face[faces][new_face[faces] >= 0] for name, faces in blocks.boundaries.items()}
    part = Polyhedra(
        vertices=blocks.vertices,
        face_vertices=blocks.face_vertices[np.repeat(blocks.face_offsets[face], sizes) + within],
        face_offsets=offsets,
        face_cells=cells,
        face_joint=blocks.face_joint[face],
        cell_block=block_number[blocks.cell_block[cell_stays]],
        rock=blocks.rock[present],
        rock_names=blocks.rock_names,
        joint_names=blocks.joint_names,
        boundaries={name: faces for name, faces in boundaries.items() if faces.size},
    )
    return part, face
