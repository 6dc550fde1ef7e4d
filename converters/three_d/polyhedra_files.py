"""Polyhedral blocks as a mesh of polyhedra, VTU: written with their groups, and read, those of other programs too."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.grid_reader import read_arrays
from bsm_mesh.converters.three_d.elements import ElementCells
from bsm_mesh.converters.three_d.vtu import loops_outwards
from bsm_mesh.converters.vtk_files import Faces, Grid, write_vtu
from bsm_mesh.converters.vtk_library import POLYHEDRON, names_of, numbered
from bsm_mesh.errors import ModelError, counted, placed
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.reading import as_path
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.blocks.solids import shared_faces

Arrays = Mapping[str, Any]


def write_polyhedra(blocks: Polyhedra, path: str | os.PathLike[str]) -> Path:
    """Write the cells of blocks as VTU, a polyhedron each; return the path.

    `read_polyhedra_file` gives equal blocks. Cells have the arrays ``block``, ``rock`` and ``excavation_<name>``, the
    field has ``face_joint`` and ``boundary_<name>`` of every face of every cell. Names of numbers are as in the plane.

    Raises
    ------
    ModelError
        If the name does not end in ``.vtu``.
    """
    target = as_path("write_polyhedra: path", path)
    if target.suffix != ".vtu":
        raise ModelError(f"{target}: polyhedra are written as VTU; give a name that ends in .vtu")
    first, second = blocks.face_cells.T
    inner = np.flatnonzero(second >= 0)
    face, side = np.concatenate([np.arange(len(first)), inner]), np.repeat([0, 1], [len(first), len(inner)])
    cell = np.concatenate([first, second[inner]])
    order = np.argsort(cell, kind="stable")
    face, side, cell = face[order], side[order], cell[order]
    owner, corner = loops_outwards(blocks, face, side)
    many, cells = len(blocks.vertices), np.arange(len(blocks.cell_block) + 1)
    of_cell, point = np.divmod(np.unique(cell[owner].astype(np.int64) * many + corner), many)
    data: dict[str, Any] = {"block": blocks.cell_block, "rock": blocks.rock[blocks.cell_block]}
    for name, ids in blocks.excavations.items():
        data[f"excavation_{name}"] = np.where(np.isin(blocks.cell_block, ids), 0, -1)
    fields: dict[str, Any] = {"face_joint": blocks.face_joint[face]}
    for name, ids in blocks.boundaries.items():
        fields[f"boundary_{name}"] = np.where(np.isin(face, ids), 0, -1)
    groups = [*(f"excavation:{name}" for name in blocks.excavations), *(f"boundary:{n}" for n in blocks.boundaries)]
    grid = Grid(
        points=blocks.vertices,
        offsets=np.searchsorted(of_cell, cells),
        connectivity=point,
        cell_type=POLYHEDRON,
        cell_data=data,
        names={
            **numbered("rock", blocks.rock_names),
            **numbered("joint", blocks.joint_names),
            **dict.fromkeys(groups, 0),
        },
        faces=Faces(
            cell_offsets=np.searchsorted(cell, cells),
            offsets=np.searchsorted(owner, np.arange(len(face) + 1)),
            connectivity=corner,
        ),
        field_data=fields,
    )
    write_vtu(target, grid, parents=True)
    return target


def read_polyhedra_file(
    path: str | os.PathLike[str],
    *,
    rock: str | None = None,
    blocks: Literal["elements", "regions"] = "regions",
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
) -> Polyhedra:
    """Return the blocks of a VTU file of convex polyhedra that share whole faces.

    The arrays and names that `write_polyhedra` writes are read where they are there; parameters as of
    `read_polyhedra`. Without the array ``block`` every cell is a block, or every region between joints.

    Raises
    ------
    ModelError
        If the file holds other cells, cells do not share whole faces, or have no rock.
    """
    file = as_path("mesh", path)
    if not file.is_file():
        raise ModelError(f"{file}: there is no such file")
    told, arrays = read_arrays(file.read_bytes(), file)
    if told["types"] != [POLYHEDRON]:
        raise ModelError(
            f"{file}: blocks are read from VTU with polyhedra alone (VTK's cell type {POLYHEDRON}), and this has the "
            f"types {', '.join(map(str, told['types']))}; write tetrahedra and hexahedra as MSH 4.1"
        )
    with placed(str(file)):
        return _blocks_of(arrays, told["names"], rock, blocks == "elements", unit_scale, merge_tolerance)


def _blocks_of(
    arrays: Arrays, names: Mapping[str, int], rock: str | None, whole: bool, scale: float, tolerance: float
) -> Polyhedra:
    points = arrays["points"] * scale
    merged = merge_points(points, tolerance)
    _, kept = np.unique(merged, return_index=True)
    cell = np.repeat(np.arange(len(arrays["offsets"]) - 1), np.diff(arrays["cell_face_offsets"]))
    starts, corner = arrays["face_offsets"], merged[arrays["face_connectivity"]]
    loops = [corner[starts[f] : starts[f + 1]].tolist() for f in arrays["cell_faces"].tolist()]
    faces, cells, of_loop = shared_faces(_outwards(loops, cell, points[kept]), cell.tolist())
    at = np.array(of_loop)
    shared: dict[str, Any] = {
        "vertices": points[kept],
        "face_vertices": np.concatenate(faces).astype(np.int32),
        "face_offsets": np.concatenate([[0], np.cumsum([len(loop) for loop in faces])]).astype(np.int32),
        "face_cells": np.array(cells, dtype=np.int32),
        "face_joint": _of_faces(arrays.get("field:face_joint"), at, len(faces)),
        "joint_names": names_of("joint", names),
        "boundaries": {
            name: np.unique(at[arrays[key] >= 0]).astype(np.int32)
            for name in _listed("boundary", names)
            if (key := f"field:boundary_{name}") in arrays and len(arrays[key]) == len(at)
        },
    }
    rocks, of_rock = _rocks(arrays, names, rock)
    excavated = {name: arrays[f"cell:excavation_{name}"] >= 0 for name in _listed("excavation", names)}
    if "cell:block" in arrays:
        block = arrays["cell:block"].astype(np.int32)
        _, leading = np.unique(block, return_index=True)
        ids = {name: np.unique(block[gone]).astype(np.int32) for name, gone in excavated.items()}
        return Polyhedra(**shared, cell_block=block, rock=of_rock[leading], rock_names=rocks, excavations=ids)
    gone = np.full(len(of_rock), -1, dtype=np.int32)
    for k, chosen in enumerate(excavated.values()):
        gone[chosen] = k
    own: dict[str, Any] = {"rock_names": rocks, "excavation_names": tuple(excavated)}
    return Polyhedra.from_cells(ElementCells(**shared, **own, cell_rock=of_rock, cell_excavation=gone), whole=whole)


def _outwards(loops: list[list[int]], cell: IntArray, points: FloatArray) -> list[list[int]]:
    """Return the loops of convex cells counter-clockwise as seen from outside; VTK knows no order of theirs."""
    sizes = np.array([len(loop) for loop in loops])
    corner, of_loop = points[np.concatenate(loops)], np.repeat(np.arange(len(loops)), sizes)
    first = np.cumsum(sizes) - sizes
    count = int(cell.max()) + 1
    in_cell = cell[of_loop]
    total = np.stack([np.bincount(in_cell, axis, count) for axis in corner.T], axis=1)
    middle = total / np.bincount(in_cell, minlength=count)[:, None]
    following = np.arange(len(corner)) + 1
    following[first + sizes - 1] = first
    arm = corner - corner[first][of_loop]
    area = np.stack([np.bincount(of_loop, axis, len(loops)) for axis in np.cross(arm, arm[following]).T], axis=1)
    inward = np.einsum("ij,ij->i", area, corner[first] - middle[cell]) < 0
    return [loop[::-1] if back else loop for loop, back in zip(loops, inward.tolist(), strict=True)]


def _of_faces(values: Any, at: IntArray, count: int) -> IntArray:
    """Return a number a face of those of all faces of all cells (k,), which both sides share; -1 without them."""
    found = np.full(count, -1, dtype=np.int32)
    if values is not None:
        if len(values) != len(at):
            raise ModelError(f"face_joint has {len(values)} numbers, and the cells have {counted(len(at), 'face')}")
        np.maximum.at(found, at, values.astype(np.int32))
    return found


def _rocks(arrays: Arrays, names: Mapping[str, int], rock: str | None) -> tuple[tuple[str, ...], IntArray]:
    """Return the names of the rocks, and the number of each cell's."""
    known = names_of("rock", names)
    found = arrays.get("cell:rock", np.full(len(arrays["offsets"]) - 1, -1)).astype(np.int32)
    without = (found < 0) | (found >= len(known))
    if without.any():
        if rock is None:
            raise ModelError(f"{counted(int(without.sum()), 'cell')} without a rock; give one rock for them all")
        known = known if rock in known else (*known, rock)
        found = np.where(without, known.index(rock), found).astype(np.int32)
    return known, found


def _listed(kind: str, names: Mapping[str, int]) -> list[str]:
    return [key.partition(":")[2] for key in names if key.startswith(f"{kind}:")]
