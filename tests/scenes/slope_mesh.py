"""Meshes of jointed slopes as Gmsh writes them, and the same with other coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters import read_mesh

SIZE = 2.5  # of the elements [m]
Change = Callable[[float, int], str]
"""Returns a coordinate as a file writes it, x for axis 0 and y for axis 1."""


@cache
def slope_mesh(dip: float, steep: float, height: float, spacing: float) -> str:
    """Return a mesh file (MSH 4.1) of a slope with planes that daylight in its face, and steep joints."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        _draw(gmsh, dip, steep, height, spacing)
        gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        from tempfile import TemporaryDirectory

        with TemporaryDirectory() as folder:
            path = Path(folder) / "slope.msh"
            gmsh.write(str(path))
            return path.read_text()
    finally:
        gmsh.finalize()


def _draw(gmsh, dip: float, steep: float, height: float, spacing: float) -> None:  # type: ignore[no-untyped-def]
    occ, model = gmsh.model.occ, gmsh.model
    crest = 20 + height / math.tan(math.radians(60))
    outline = [(0, 0), (55, 0), (55, 10 + height), (crest, 10 + height), (20, 10), (0, 10)]
    points = [occ.addPoint(x, y, 0) for x, y in outline]
    lines = [occ.addLine(points[i], points[(i + 1) % 6]) for i in range(6)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])

    def across(x: float, y: float, angle: float) -> int:
        c, s = 100 * math.cos(math.radians(angle)), 100 * math.sin(math.radians(angle))
        return int(occ.addLine(occ.addPoint(x - c, y - s, 0), occ.addPoint(x + c, y + s, 0)))

    beds = [(1, across(20, 10 + k * spacing, dip)) for k in range(3)]
    cross = [(1, across(crest + x, 10 + height, steep)) for x in (3.3, 9.7)]
    out, parts = occ.fragment([(2, face)], beds + cross)
    occ.synchronize()
    for name, cut in (("bed", parts[1:4]), ("cross", parts[4:])):
        inner = sorted({c for piece in cut for d, c in piece if d == 1 and len(model.getAdjacencies(1, c)[0]) == 2})
        model.addPhysicalGroup(1, inner, name=f"joint:{name}")
    model.addPhysicalGroup(2, [tag for d, tag in out if d == 2], name="rock:granite")
    rim = [tag for _, tag in model.getEntities(1) if len(model.getAdjacencies(1, tag)[0]) == 1]
    boxes = {tag: model.getBoundingBox(1, tag) for tag in rim}
    model.addPhysicalGroup(1, [t for t, b in boxes.items() if b[4] < 1e-3], name="boundary:bottom")
    sides = [t for t, b in boxes.items() if b[3] < 1e-3 or b[0] > 55 - 1e-3]
    model.addPhysicalGroup(1, sides, name="boundary:sides")


def with_coordinates(text: str, change: Change) -> str:
    """Return a mesh file whose nodes have changed coordinates."""
    head, rest = text.split("$Nodes\n")
    nodes, tail = rest.split("$EndNodes")
    rows = [row.split() for row in nodes.splitlines()]
    new = [[change(float(x), k) for k, x in enumerate(row[:2])] + ["0"] if len(row) == 3 else row for row in rows]
    return head + "$Nodes\n" + "\n".join(" ".join(row) for row in new) + "\n$EndNodes" + tail


def slope_model(path: Path, text: str, *, unit: float = 1.0, blocks: str = "regions") -> bsm.Model:
    """Return a model of a mesh file, written to a path."""
    path.write_text(text)
    found, _ = read_mesh(path, unit_scale=unit, blocks=blocks)  # type: ignore[arg-type]
    return bsm.Model(
        blocks=found,
        rocks=[bsm.Rock("granite", unit_weight=26e3, young=20e9, poisson=0.25)],
        joints=[
            bsm.Joint("bed", 1e10, 2e9, law=bsm.MohrCoulomb(friction=30.0, cohesion=20e3)),
            bsm.Joint("cross", 1e10, 2e9, law=bsm.MohrCoulomb(friction=35.0)),
        ],
        default_joint="bed" if blocks == "elements" else None,
        supports=[bsm.Fixed(boundary="bottom"), bsm.Roller(boundary="sides", direction=0.0)],
    )


def moved(by: Sequence[float] = (0.0, 0.0), scale: float = 1.0, decimals: int | None = None) -> Change:
    """Return what moves and scales coordinates, and writes them with all digits or some decimals."""

    def change(x: float, axis: int) -> str:
        value = (x + by[axis]) * scale
        return repr(float(np.float64(value))) if decimals is None else f"{value:.{decimals}f}"

    return change
