"""Solids given one by one, by corners and faces: the arrays of their blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.blocks import merge_points


def arrays_of_solids(
    solids: Sequence[tuple[npt.ArrayLike, Sequence[Sequence[int]]]],
    rock: str | Sequence[str],
    joint: str | None,
    merge_tolerance: float,
) -> dict[str, Any]:
    """Return the arrays of `Polyhedra`: solids touch where they share a whole face."""
    names = [rock] * len(solids) if isinstance(rock, str) else list(rock)
    if len(names) != len(solids):
        raise ModelError(f"rock: {len(names)} names for {len(solids)} blocks; give one name, or one a block")
    points, loops, owner = _corners_of(solids)
    number = merge_points(points, merge_tolerance)
    _, kept = np.unique(number, return_index=True)
    matched: dict[tuple[int, ...], int] = {}
    faces: list[list[int]] = []
    cells: list[list[int]] = []
    for loop, solid in zip(loops, owner, strict=True):
        corners = [int(number[i]) for i in loop]
        f = matched.setdefault(tuple(sorted(corners)), len(faces))
        if f < len(faces):
            cells[f][1] = solid
        else:
            faces.append(corners)
            cells.append([solid, -1])
    sizes = [len(loop) for loop in faces]
    rock_names = tuple(dict.fromkeys(names))
    return dict(
        vertices=points[kept],
        face_vertices=np.concatenate([[], *faces]).astype(np.int32),
        face_offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        face_cells=np.array(cells, dtype=np.int32).reshape(-1, 2),
        face_joint=np.array([0 if joint is not None and c[1] >= 0 else -1 for c in cells], dtype=np.int32),
        cell_block=np.arange(len(solids), dtype=np.int32),
        rock=np.array([rock_names.index(name) for name in names], dtype=np.int32),
        rock_names=rock_names,
        joint_names=() if joint is None else (joint,),
    )


def _corners_of(
    solids: Sequence[tuple[npt.ArrayLike, Sequence[Sequence[int]]]],
) -> tuple[FloatArray, list[list[int]], list[int]]:
    """Return the corners of all solids, the loops of all faces in them, and the solid of every face."""
    points, loops, owner, faults, count = [np.empty((0, 3))], [], [], [], 0
    for s, (given, faces) in enumerate(solids):
        corners = np.array(given, dtype=np.float64)
        if corners.ndim != 2 or corners.shape[1] != 3 or not np.isfinite(corners).all():
            faults.append(f"block {s}: needs corners (x, y, z), has an array of shape {corners.shape}")
            continue
        wrong = [k for k, face in enumerate(faces) if not {*face} <= {*range(len(corners))} or len({*face}) < 3]
        faults += [f"block {s}: face {k} must name 3 or more of the corners 0 .. {len(corners) - 1}" for k in wrong]
        loops += [[count + i for i in face] for face in faces]
        owner += [s] * len(faces)
        points.append(corners)
        count += len(corners)
    raise_faults(faults)
    return np.concatenate(points), loops, owner
