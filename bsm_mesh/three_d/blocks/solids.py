"""Solids given one by one, by corners and faces: the arrays of their blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import as_given, raise_faults
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import rock_of_each
from bsm_mesh.model.quantities import MERGE_TOLERANCE
from bsm_mesh.model.values import Rules, parts_of


def arrays_of_solids(
    solids: Sequence[tuple[npt.ArrayLike, Sequence[Sequence[int]]]],
    rock: str | Sequence[str],
    joint: str | None,
    merge_tolerance: float,
) -> dict[str, Any]:
    """Return the arrays of `Polyhedra`: solids touch where they share a whole face."""
    rules = Rules("Polyhedra.from_solids")
    rules.number("merge_tolerance", merge_tolerance, MERGE_TOLERANCE)
    given = parts_of(solids)
    if given is None:
        rules.faults.append(f"{rules.thing}: solids = {as_given(solids)} must be a list of pairs (corners, faces)")
    count = len(given or [])
    names = rock_of_each(rules, rock, count)
    raise_faults(rules.faults)
    points, loops, owner = _corners_of(given or [])
    number = merge_points(points, merge_tolerance)
    _, kept = np.unique(number, return_index=True)
    faces, cells, _ = shared_faces([[int(number[i]) for i in loop] for loop in loops], owner)
    sizes = [len(loop) for loop in faces]
    rock_names = tuple(dict.fromkeys(names))
    return dict(
        vertices=points[kept],
        face_vertices=np.concatenate([[], *faces]).astype(np.int32),
        face_offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        face_cells=np.array(cells, dtype=np.int32).reshape(-1, 2),
        face_joint=np.array([0 if joint is not None and c[1] >= 0 else -1 for c in cells], dtype=np.int32),
        cell_block=np.arange(count, dtype=np.int32),
        rock=np.array([rock_names.index(name) for name in names], dtype=np.int32),
        rock_names=rock_names,
        joint_names=() if joint is None else (joint,),
    )


def shared_faces(loops: list[list[int]], owner: list[int]) -> tuple[list[list[int]], list[list[int]], list[int]]:
    """Return every face once, the two solids that it is of, and the face of every loop; a missing solid is -1.

    Raises
    ------
    ModelError
        For faces without area, and for solids that lie on the same side of a face.
    """
    matched: dict[tuple[int, ...], int] = {}
    faces: list[list[int]] = []
    cells: list[list[int]] = []
    faults: dict[tuple[int, int], str] = {}
    of_loop = []
    for corners, solid in zip(loops, owner, strict=True):
        f = matched.setdefault(tuple(sorted(corners)), len(faces))
        of_loop.append(f)
        if len({*corners}) < 3:
            faults[solid, solid] = (
                f"block {solid}: has a face without area; corners nearer than merge_tolerance are one"
            )
            continue
        if f == len(faces):
            faces.append(corners)
            cells.append([-1, -1])
        side = int(_rotated(corners) != _rotated(faces[f]))
        if (other := cells[f][side]) >= 0:
            faults[other, solid] = (
                f"block {solid}: lies on the same side of a face as block {other}; corners run counter-clockwise "
                "seen from outside, and blocks do not overlap"
            )
        cells[f][side] = solid
    raise_faults(list(faults.values()))
    return faces, cells, of_loop


def _rotated(loop: list[int]) -> list[int]:
    """Return a loop from its lowest corner on."""
    first = loop.index(min(loop))
    return loop[first:] + loop[:first]


def _corners_of(solids: Sequence[Any]) -> tuple[FloatArray, list[list[int]], list[int]]:
    """Return the corners of all solids, the loops of all faces in them, and the solid of every face."""
    points, loops, owner, faults, count = [np.empty((0, 3))], [], [], [], 0
    for s, solid in enumerate(solids):
        pair = parts_of(solid) or []
        faces = [parts_of(face) or [] for face in parts_of(pair[1]) or []] if len(pair) == 2 else []
        if not faces:
            faults.append(f"block {s}: {as_given(solid)} must be a pair (corners, faces)")
            continue
        try:
            corners = np.array(pair[0], dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            corners = np.empty(0)
        if corners.ndim != 2 or corners.shape[1] != 3 or not np.isfinite(corners).all():
            faults.append(
                f"block {s}: needs corners (x, y, z) of finite numbers, has an array of shape {corners.shape}"
            )
            continue
        known = range(len(corners))
        wrong = [k for k, face in enumerate(faces) if not all(i in known for i in face) or len({*face}) < 3]
        faults += [f"block {s}: face {k} must name 3 or more of the corners 0 .. {len(corners) - 1}" for k in wrong]
        loops += [[count + int(i) for i in face] for k, face in enumerate(faces) if k not in wrong]
        owner += [s] * (len(faces) - len(wrong))
        points.append(corners)
        count += len(corners)
    raise_faults(faults)
    return np.concatenate(points), loops, owner
