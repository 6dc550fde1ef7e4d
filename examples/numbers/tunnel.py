"""Numbers of Example 1: stresses round a circular tunnel on three kinds of mesh, by two routes."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.converters.continuum import blocks_on_line, solve_continuum
from bsm_mesh.geometries import circular_tunnel
from examples.numbers.pages import Table, markdown
from tests.scenes.shapes import voronoi

PAGE = "examples/01_circular_tunnel/README.md"
section = import_module("examples.01_circular_tunnel.section")
MESHES = (
    ("triangles", "wang", (1.8, 0.9, 0.45)),
    ("triangles", "homogeneous", (1.8, 0.9, 0.45)),
    ("quads", "wang", (1.4, 0.7, 0.35)),
    ("radial", "wang", (0.52, 0.26, 0.13)),
)
DISTANCES = (11.0, 16.0, section.FAR, 44.0)
EDGES = np.array([2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])
ERRORS = ("section sigma_v L2", "greatest", "all blocks r < 3a L2")


@cache
def solved(kind: str, stiffness: str, size: float, far: float = section.FAR) -> tuple[bsm.Model, converters.Comparison]:
    """Return a model of one linear step, and its comparison with the continuum."""
    return section.solve(size, kind, stiffness, far)


def convergence() -> str:
    """Return the errors of all meshes, gravity and lateral pressure turned on."""
    lines = []
    for kind, stiffness, sizes in MESHES:
        for size in sizes:
            model, comparison = solved(kind, stiffness, size)
            found = (f"{error:.1f} %" for error in section.errors(model, comparison))
            lines.append((kind, stiffness, str(model.blocks.count), *found))
    return markdown(("mesh", "stiffness", "blocks", *ERRORS), lines)


def stresses() -> str:
    """Return the means over intervals of the section, of the triangles with the thesis's stiffness."""
    runs = [solved("triangles", "wang", size) for size in MESHES[0][2]]
    tables = []
    for component, name in ((1, "sigma_v"), (0, "sigma_h")):
        parts = []
        for model, comparison in runs:
            on = blocks_on_line(model.blocks, (section.A, 0), (5 * section.A, 0))
            parts.append(section.binned(comparison.along(on), component, EDGES))
        lines = [
            (f"{low:g}-{high:g}", *(" / ".join(f"{value:.0f}" for value in part[k]) for part in parts))
            for k, (low, high) in enumerate(pairwise(EDGES))
        ]
        tables.append(markdown((f"{name}, x [m]", *(f"{model.blocks.count} blocks" for model, _ in runs)), lines))
    return "\n\n".join(tables)


def domain() -> str:
    """Return by how much the continuum's vertical stress on the section changes with the distance to the sides."""
    found = []
    for far in DISTANCES:
        model, comparison = solved("triangles", "wang", 0.9, far)
        on = blocks_on_line(model.blocks, (section.A, 0), (5 * section.A, 0))
        _, fem, infinite = section.binned(comparison.along(on), 1, EDGES).T
        found.append(fem / infinite)  # each mesh has its blocks elsewhere: over Eq. 3.46 at the same places
    changes = np.abs(np.array(found) / found[-1] - 1).max(axis=1)
    lines = [(f"{far:g} m", f"{100 * change:.1f} %") for far, change in zip(DISTANCES, changes, strict=True)]
    return markdown(("to the right and the bottom", f"sigma_v differs from that of {DISTANCES[-1]:g} m"), lines[:-1])


def excavated() -> str:
    """Return the errors with the in-situ stress set directly and the tunnel then excavated, stiffness `homogeneous`."""
    lines = []
    for kind, sizes in (("triangles", (1.8, 0.9, 0.45)), ("quads", (0.75, 0.6, 0.45)), ("voronoi", (2000, 7000))):
        for size in sizes:
            count, *found = _errors(_blocks(kind, size))
            lines.append((kind, str(count), *(f"{100 * error:.1f} %" for error in found)))
    return markdown(("mesh", "blocks", *ERRORS), lines)


def zones() -> str:
    """Return the errors of all stresses near the tunnel: rigid blocks, and blocks with zones."""
    lines = []
    for kind, stiffness, sizes in MESHES:
        if stiffness != "wang":
            continue
        for size in sizes[:2]:
            model, comparison = solved(kind, stiffness, size)
            found = [section.errors(model, comparison)[2]]
            for order in (1, 2):
                rocks = [replace(rock, zones=bsm.Zones(order=order)) for rock in model.rocks]
                stress = bsm.run(model.replace(rocks=rocks)).stages[0].stress
                near = np.hypot(*comparison.centroid.T) < 3 * section.A
                fem = comparison.nominal.stress
                squares = [(comparison.area[near] * (s[near] ** 2).sum(axis=(1, 2))).sum() for s in (stress - fem, fem)]
                found.append(100 * np.sqrt(squares[0] / squares[1]))
            lines.append((kind, str(model.blocks.count), *(f"{error:.1f} %" for error in found)))
    return markdown(("mesh", "blocks", "rigid", "zones, first order", "zones, second order"), lines)


def _blocks(kind: str, size: float) -> bsm.Blocks:
    if kind == "voronoi":
        cells = voronoi(section.FAR, section.FAR + section.DEPTH, int(size), rounds=100,
                        circle=((0.0, section.FAR), section.A))  # fmt: skip
        blocks = bsm.Blocks.from_polygons([cell - (0, section.FAR) for cell in cells], rock="rock")
        inside = np.flatnonzero(np.hypot(*blocks.moments.centroid.T) < section.A)
        return _with_sides(replace(blocks, excavations={"tunnel": inside}))
    grading = {"size_at_wall": 0.22 * size, "grading_distance": 10.0} if kind == "triangles" else {}
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.MeshWarning)  # the tunnel's wall has rock on both sides before it is dug
        path = circular_tunnel.build(
            Path(folder) / "tunnel.msh", radius=section.A, depth=section.DEPTH, below=section.FAR, width=section.FAR,
            mesh=kind, size=size, core=True, **grading,
        )  # fmt: skip
        return converters.read_blocks(path)


def _with_sides(blocks: bsm.Blocks) -> bsm.Blocks:
    off, far = 1e-6, section.FAR
    return (
        blocks.with_boundary("left", lambda x, y: x < off)
        .with_boundary("right", lambda x, y: x > far - off)
        .with_boundary("bottom", lambda x, y: y < off - far)
    )


def _errors(blocks: bsm.Blocks) -> tuple[float, ...]:
    """Return the number of blocks that are left, and the three errors."""
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=section.GAMMA, young=50e9, poisson=section.MU, stiffness="homogeneous")],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.InSituTraction(boundary="right")],
        in_situ=bsm.InSitu(surface=section.DEPTH, k0=section.K0),
        stages=[bsm.Stage(name="tunnel", excavate=["tunnel"])],
    )
    stage = bsm.run(model, bsm.Options(scheme="linear")).stages[-1]
    kept = [blocks.polygon(b) for b in np.flatnonzero(stage.present)]
    left = _with_sides(bsm.Blocks.from_polygons(kept, rock="rock"))
    load = bsm.Pressure(boundary="right", pressure=(section.K0 * section.GAMMA * section.DEPTH, 0.0,
                                                    -section.K0 * section.GAMMA))  # fmt: skip
    fem = solve_continuum(bsm.Model(blocks=left, rocks=model.rocks, supports=model.supports, loads=[load])).stress
    difference, area = stage.stress[stage.present] - fem, left.moments.area
    on = blocks_on_line(left, (section.A + 0.3, 0.0), (5 * section.A, 0.0))
    vertical, exact, weight = difference[on, 1, 1], fem[on, 1, 1], area[on]
    near = np.hypot(*left.moments.centroid.T) < 3 * section.A
    squares = [(area[near] * (s[near] ** 2).sum(axis=(1, 2))).sum() for s in (difference, fem)]
    return (
        left.count,
        float(np.sqrt((weight * vertical**2).sum() / (weight * exact**2).sum())),
        float(np.abs(vertical).max() / np.abs(exact).max()),
        float(np.sqrt(squares[0] / squares[1])),
    )


TABLES: tuple[Table, ...] = (
    Table(name="tunnel-stresses", page=PAGE, make=stresses, tolerance=0.02, is_slow=True),
    Table(name="tunnel-convergence", page=PAGE, make=convergence, tolerance=0.02, is_slow=True),
    Table(name="tunnel-zones", page=PAGE, make=zones, tolerance=0.02, is_slow=True),
    Table(name="tunnel-domain", page=PAGE, make=domain, tolerance=0.02, is_slow=True),
    Table(name="tunnel-excavated", page=PAGE, make=excavated, tolerance=0.02, is_slow=True),
)
