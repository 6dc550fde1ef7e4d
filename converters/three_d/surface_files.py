"""Surfaces in OBJ and STL files: points and faces, as text and back; STL in its binary form too."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError

OBJ, STL = ENDINGS = (".obj", ".stl")
HEADER, RECORD = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
Surface = tuple[FloatArray, list[list[int]]]


def read_surface(file: Path) -> Surface:
    """Return the points (k, 3) of a file and its faces, lists of point numbers, in their order.

    Raises
    ------
    ModelError
        If it is neither OBJ nor STL, or damaged; the message has the line.
    """
    if file.suffix.lower() not in ENDINGS:
        raise ModelError(f"{file}: surfaces are read from OBJ and STL; give a file that ends in {' or '.join(ENDINGS)}")
    content = file.read_bytes()
    if file.suffix.lower() == STL:
        count = int.from_bytes(content[80:HEADER], "little")
        if len(content) == HEADER + count * RECORD.itemsize:
            corners = np.frombuffer(content, RECORD, count, HEADER)["corners"].reshape(-1, 3).astype(np.float64)
            return _finite(file, corners), np.arange(len(corners)).reshape(-1, 3).tolist()
    lines = content.decode(errors="replace").splitlines()
    points, faces = _obj(file, lines) if file.suffix.lower() == OBJ else _stl(file, lines)
    return _finite(file, np.array(points, dtype=np.float64).reshape(-1, 3)), faces


def surface_text(ending: str, points: FloatArray, names: Sequence[str], solids: Sequence[Sequence[IntArray]]) -> str:
    """Return solids of points (k, 3) and faces, counter-clockwise from outside, as the text of an OBJ or STL file."""
    lines = [] if ending == STL else [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    for name, faces in zip(names, solids, strict=True):
        if ending == OBJ:
            lines += [f"o {name}", *(f"f {' '.join(str(corner + 1) for corner in face.tolist())}" for face in faces)]
        else:
            triangles = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
            lines += [f"solid {name}", *(_facet(points[list(one)]) for one in triangles), f"endsolid {name}"]
    return "\n".join([*lines, ""])


def _obj(file: Path, lines: list[str]) -> tuple[list[list[float]], list[list[int]]]:
    points: list[list[float]] = []
    faces: list[list[int]] = []
    for number, line in enumerate(lines, start=1):
        key, *words = line.split() or [""]
        try:
            if key == "v":
                points.append(_three(words))
            elif key == "f":
                given = [int(word.partition("/")[0]) for word in words]
                face = [one - 1 if one > 0 else len(points) + one for one in given]
                if len(face) < 3 or min(face) < 0 or max(face) >= len(points):
                    raise ValueError
                faces.append(face)
        except ValueError:
            raise ModelError(
                f"{file}, line {number}: {line[:60]!r} is no {'point' if key == 'v' else 'face'}; write the file again"
            ) from None
    return points, faces


def _stl(file: Path, lines: list[str]) -> tuple[list[list[float]], list[list[int]]]:
    points = []
    for number, line in enumerate(lines, start=1):
        key, *words = line.split() or [""]
        if key == "vertex":
            try:
                points.append(_three(words))
            except ValueError:
                raise ModelError(f"{file}, line {number}: {line[:60]!r} is no point; write the file again") from None
    if len(points) % 3:
        raise ModelError(f"{file}: {len(points)} points are no whole triangles; write the file again")
    return points, np.arange(len(points)).reshape(-1, 3).tolist()


def _three(words: list[str]) -> list[float]:
    x, y, z = (float(word) for word in words[:3])
    return [x, y, z]


def _finite(file: Path, points: FloatArray) -> FloatArray:
    if not np.isfinite(points).all():
        raise ModelError(f"{file}: has a coordinate that is no number; write the file again")
    return points


def _facet(corners: FloatArray) -> str:
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    unit = (normal / max(float(np.linalg.norm(normal)), 1e-300)).tolist()
    loop = "".join(f"\n    vertex {x!r} {y!r} {z!r}" for x, y, z in corners.tolist())
    return f"  facet normal {unit[0]:.9g} {unit[1]:.9g} {unit[2]:.9g}\n   outer loop{loop}\n   endloop\n  endfacet"
