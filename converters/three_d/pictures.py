"""Pictures of key blocks: the free faces, and whole blocks where they fall or slide, seen from any side."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.reading import as_path
from bsm_mesh.three_d.blocks.polygons import vector_areas
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.key_blocks.modes import FALLS, HELD, STAYS
from bsm_mesh.three_d.key_blocks.record import KeyBlocks

KINDS = (  # label and colour
    ("not removable", "#d9d9d9"),
    ("removable, stays", "#b9cfe4"),
    ("slides above the required factor", "#f2d16b"),
    ("slides below it", "#ee8a33"),
    ("falls", "#c5281c"),
)
MAX_NAMED = 12  # blocks: more names hide each other


def draw_key_blocks(
    path: str | os.PathLike[str],
    blocks: Polyhedra,
    found: KeyBlocks,
    *,
    azimuth: float | None = None,
    plunge: float | None = None,
    title: str = "",
) -> Path:
    """Draw the blocks at free faces by what block theory says of them, as PNG; return the path.

    Parameters
    ----------
    path : path
        The file, ``.png``.
    blocks : Polyhedra
        The rock.
    found : KeyBlocks
        Of this rock.
    azimuth, plunge : float [degrees]
        Direction in which one looks: clockwise from north, and downwards from the level, negative upwards; by default
        at the faces of the unstable blocks. Faces that turn their rock to the viewer are left out.
    title : str
        Heading.

    Raises
    ------
    ModelError
        If the name does not end in .png.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    target = as_path("path", path)
    if target.suffix.lower() != ".png":
        raise ModelError(f"{target}: the picture is a PNG; give a name that ends in .png")
    kind = _kinds(found)
    faces, colour, outward = _faces(blocks, found, kind)
    if azimuth is None or plunge is None:
        azimuth, plunge = _view(found, faces, colour, outward)
    seen = np.flatnonzero((outward @ _ahead(azimuth, plunge) < 0) | (colour >= 3))
    polygons, colour = [blocks.polygon(int(faces[k])) for k in seen], colour[seen]
    flat, depth = _seen(np.concatenate(polygons), azimuth, plunge)
    sizes = [len(corners) for corners in polygons]
    parts, depths = np.split(flat, np.cumsum(sizes)[:-1]), np.split(depth, np.cumsum(sizes)[:-1])
    order = np.argsort([-part.mean() for part in depths])  # the most distant first
    figure = Figure(figsize=(9, 7), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.axis("off")
    shades = [KINDS[k][1] for k in colour[order]]
    faces_drawn = PolyCollection([parts[k] for k in order], facecolors=shades, edgecolors="#555555", linewidths=0.4)
    axes.add_collection(faces_drawn)
    axes.autoscale_view()
    _name_blocks(axes, found, kind, azimuth, plunge)
    for number in sorted(set(kind.tolist())):
        label, shade = KINDS[number]
        axes.fill([], [], facecolor=shade, edgecolor="#555555", lw=0.4, label=f"{label}: {int((kind == number).sum())}")
    axes.legend(loc="lower left", fontsize=8, frameon=False)
    axes.set_title(title or f"Key blocks, looking {azimuth:03.0f}/{plunge:.0f}", loc="left", parse_math=False)
    with whole_file(target, parents=True) as draft:
        FigureCanvasAgg(figure).print_png(str(draft))
    return target


def _kinds(found: KeyBlocks) -> IntArray:
    """Return the number in `KINDS` of every block at a free face."""
    slides = np.where(found.round > 0, 3, 2)
    kinds: IntArray = np.select([found.mode == HELD, found.mode == STAYS, found.mode == FALLS], [0, 1, 4], slides)
    return kinds


def _faces(blocks: Polyhedra, found: KeyBlocks, kind: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the faces that are drawn, free ones and all of unstable blocks, their kinds and vectors of area.

    The vectors point out of the block.
    """
    row = np.full(blocks.count + 1, -1)
    row[found.block] = np.arange(found.count)
    rows = row[blocks.face_blocks]  # the last, -1, for no block
    comes = np.append(kind >= 3, False)
    own = comes[rows] & (blocks.face_blocks[:, ::-1] != blocks.face_blocks)
    free = np.zeros(len(rows), dtype=bool)
    free[found.free_faces] = True
    faces = np.flatnonzero(free | own.any(axis=1))
    side = np.where(own[faces].any(axis=1), np.argmax(own[faces], axis=1), np.argmax(rows[faces] >= 0, axis=1))
    sizes = np.diff(blocks.face_offsets)[faces]
    corners = np.concatenate([blocks.polygon(int(face)) for face in faces])
    vector = vector_areas(corners, np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32))
    return faces, kind[rows[faces, side]], vector * np.where(side == 0, 1.0, -1.0)[:, None]


def _view(found: KeyBlocks, faces: IntArray, kind: IntArray, outward: FloatArray) -> tuple[float, float]:
    """Return azimuth and plunge of a view on the free faces of the unstable blocks, or else on all free faces."""
    free = np.isin(faces, found.free_faces)
    comes = free & (kind >= 3)
    return _towards(-outward[comes if comes.any() else free].sum(axis=0))


def _ahead(azimuth: float, plunge: float) -> FloatArray:
    """Return the unit vector of a direction, (3,)."""
    alpha, fall = np.radians(azimuth), np.radians(plunge)
    return np.array([np.cos(fall) * np.sin(alpha), np.cos(fall) * np.cos(alpha), -np.sin(fall)])


def _towards(vector: FloatArray) -> tuple[float, float]:
    """Return azimuth and plunge of a direction, turned a little so that a box shows three sides [degrees]."""
    azimuth = float(np.degrees(np.arctan2(vector[0], vector[1]))) if np.hypot(*vector[:2]) > 1e-9 else 0.0
    plunge = float(np.degrees(np.arctan2(-vector[2], np.hypot(*vector[:2]))))
    return (azimuth + 25.0) % 360.0, float(np.clip(plunge, -60.0, 60.0))


def _seen(points: FloatArray, azimuth: float, plunge: float) -> tuple[FloatArray, FloatArray]:
    """Return points as they are seen, to the right and up (n, 2) [m], and their distances (n,)."""
    ahead, alpha = _ahead(azimuth, plunge), np.radians(azimuth)
    right = np.array([np.cos(alpha), -np.sin(alpha), 0.0])
    up = np.cross(right, ahead)
    return np.stack([points @ right, points @ up], axis=1), points @ ahead


def _name_blocks(axes: Any, found: KeyBlocks, kind: IntArray, azimuth: float, plunge: float) -> None:
    """Ring and name the unstable blocks, the largest first; slivers are not named."""
    rows = np.flatnonzero((kind >= 3) & ~found.sliver)
    rows = rows[np.argsort(-found.volume[rows])][:MAX_NAMED]
    place, _ = _seen(found.centroid[rows], azimuth, plunge)
    for (x, y), row in zip(place, rows, strict=True):
        factor = f" {found.factor[row]:.2f}" if found.mode[row] != FALLS else ""
        axes.annotate(
            f"{found.block[row]}{factor}",
            (x, y),
            xytext=(8, 8),
            textcoords="offset points",
            fontsize=8,
            color="#222222",
        )
        axes.plot([x], [y], "o", ms=14, mfc="none", mec="#222222", mew=1.0)
