"""Numbers of docs/theory_continuum.md and docs/theory_stages.md: the elastic continuum of a mesh of blocks."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters.continuum import nominal_elasticity
from examples.numbers.pages import Table, markdown
from tests.scenes.models import LINEAR
from tests.scenes.shapes import gmsh_quads, gmsh_triangles, grid, voronoi
from tests.scenes.uniform_stress import STRESSES, effective_stiffness, with_outline

PAGE = "docs/theory_continuum.md"
YOUNG = 50e9
SIDE = 40.0
MESHES = ("aligned squares", "triangles", "quadrilaterals", "Voronoi, centroidal")
ROWS = (  # mesh, stiffness, Poisson's ratio
    *((mesh, stiffness, 0.25) for mesh in MESHES for stiffness in ("wang", "homogeneous")),
    ("triangles", "triangle", 0.25),
    *(("triangles", "wang", poisson) for poisson in (0.15, 0.35)),
)


class Answer(NamedTuple):
    """What a mesh answers with: moduli over exact ones, Poisson's ratios, scatter of stresses over the stress."""

    modulus: float
    poisson: float
    exact_poisson: float
    shear: float
    uniaxial: float
    sheared: float


@cache
def _blocks(mesh: str) -> bsm.Blocks:
    lines = np.linspace(0.0, SIDE, 32)
    cells = {
        "aligned squares": lambda: grid(lines, lines),
        "triangles": lambda: gmsh_triangles(SIDE, SIDE, 1.25),
        "quadrilaterals": lambda: gmsh_quads(SIDE, SIDE, 1.25),
        "Voronoi, centroidal": lambda: voronoi(SIDE, SIDE, 1000, rounds=100),
    }
    return with_outline(cells[mesh]())


def _inner(blocks: bsm.Blocks) -> np.ndarray:
    """Return which blocks lie away from the sides, whose half blocks do not strain."""
    return np.abs(blocks.moments.centroid / SIDE - 0.5).max(axis=1) < 0.4


def answer(mesh: str, stiffness: str, poisson: float) -> Answer:
    """Return what the inner blocks of a mesh answer with, by their mean strains under three uniform stresses."""
    blocks = _blocks(mesh)
    rock = bsm.Rock("rock", unit_weight=0, young=YOUNG, poisson=poisson, stiffness=stiffness)
    inner = _inner(blocks)
    stages: list[bsm.results.StageResult] = []

    def solve(model: bsm.Model) -> bsm.results.StageResult:
        stages.append(bsm.run(model, LINEAR).stages[-1])
        return stages[-1]

    compliance = np.linalg.inv(effective_stiffness(blocks, rock, inner, solve))
    exact = nominal_elasticity(rock)
    across = (compliance[0, 0] + compliance[1, 1]) / 2
    scatter = [
        float(np.abs(stage.stress[inner] - stress).max() / 1e6) for stage, stress in zip(stages, STRESSES, strict=True)
    ]
    return Answer(
        1 / across / exact.modulus,
        -compliance[0, 1] / across,
        exact.poisson,
        1 / compliance[2, 2] / exact.shear,
        max(scatter[:2]),
        scatter[2],
    )


def constants() -> str:
    """Return the table of constants and scatter."""
    lines = []
    for mesh, stiffness, poisson in ROWS:
        found = answer(mesh, stiffness, poisson)
        moduli = (f"{found.modulus:.3f}", f"{found.poisson:.3f} ({found.exact_poisson:.3f})", f"{found.shear:.3f}")
        scatter = (f"{100 * value:.1f} %" for value in (found.uniaxial, found.sheared))
        lines.append((mesh, f"`{stiffness}`", f"{poisson:g}", *moduli, *scatter))
    header = ("mesh", "stiffness", "µ", "E*", "ν* (exact)", "G*", "single blocks, uniaxial", "under shear")
    return markdown(header, lines)


def gravity_turned_on() -> str:
    """Return the table of horizontal stresses in level ground whose weight is turned on between rollers."""
    lines = []
    for mesh in MESHES:
        (mean, single), (flat, _) = (_horizontal(mesh, stiffness) for stiffness in ("wang", "homogeneous"))
        lines.append((mesh, f"{mean:.2f}", f"{100 * single:.0f} %", f"{flat:.2f}"))
    return markdown(
        ("mesh", "`wang`: mean over exact", "single blocks off by, r.m.s.", "`homogeneous`: mean over exact"), lines
    )


def _horizontal(mesh: str, stiffness: str) -> tuple[float, float]:
    """Return mean and scatter of the horizontal stress of the inner blocks, over the exact one."""
    weight, poisson, off = 26e3, 0.25, 1e-6
    blocks = (
        _blocks(mesh)
        .with_boundary("sides", lambda x, y: (x < off) | (x > SIDE - off))
        .with_boundary("bottom", lambda x, y: y < off)
    )
    rock = bsm.Rock("rock", unit_weight=weight, young=YOUNG, poisson=poisson, stiffness=stiffness)
    held = [bsm.Roller(boundary="sides", direction=0), bsm.Fixed(boundary="bottom")]
    stress = bsm.run(bsm.Model(blocks=blocks, rocks=[rock], supports=held), LINEAR).stages[-1].stress
    inner = _inner(blocks)
    exact = -poisson / (1 - poisson) * weight * (SIDE - blocks.moments.centroid[inner, 1])
    area, across = blocks.moments.area[inner], stress[inner, 0, 0]
    mean = float((area * across).sum() / (area * exact).sum())
    return abs(mean), float(np.sqrt((area * (across - exact) ** 2).sum() / (area * exact**2).sum()))


TABLES: tuple[Table, ...] = (
    Table(name="constants", page=PAGE, make=constants, tolerance=0.02),
    Table(name="gravity-turned-on", page="docs/theory_stages.md", make=gravity_turned_on, tolerance=0.02),
)
