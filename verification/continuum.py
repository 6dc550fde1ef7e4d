"""Elastic rock: what blocks on springs represent, against closed forms and finite elements."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from tests.scenes.kirsch import error_near, model_of, plate
from tests.scenes.models import LINEAR, framed, stress_on_sides
from tests.scenes.shapes import gmsh_triangles, grid
from verification.case import Answer, Case
from verification.thesis_matrices import Array

E, MU, S = 50e9, 0.25, 1e6
UNIAXIAL, SHEAR = np.diag([0.0, -S]), np.array([(0.0, S), (S, 0.0)])
G, LAME = E / (2 * (1 + MU)), E * MU / ((1 + MU) * (1 - 2 * MU))


def mean_strain(polygons: list[Array], side: float, rock: bsm.Rock, stress: Array) -> Array:
    """Return the mean strain of the inner blocks of a square under a uniform stress, (2, 2)."""
    blocks = framed(bsm.Blocks.from_polygons(polygons, rock="rock"), side, side)
    x = blocks.moments.centroid
    inner = np.abs(x / side - 0.5).max(axis=1) < 0.4  # away from the sides, whose half blocks do not strain
    held = bsm.Fixed(blocks=[int(np.argmin(np.hypot(*(x - side / 2).T)))])  # the loads balance: it carries nothing
    model = bsm.Model(blocks=blocks, rocks=[rock], supports=[held], loads=stress_on_sides(stress))
    moved = bsm.run(model, LINEAR).stages[-1].displacement[inner, :2]
    gradient = np.linalg.lstsq(np.column_stack([np.ones(inner.sum()), x[inner]]), moved, rcond=None)[0][1:]
    return (gradient + gradient.T) / 2


def _rock(stiffness: str) -> bsm.Rock:
    return bsm.Rock("rock", unit_weight=0, young=E, poisson=MU, stiffness=stiffness)


def squares(stiffness: str) -> Answer:
    """Compare confined modulus, lateral strain and shear modulus of a grid of squares, over E."""
    rock = _rock(stiffness)
    E_N, E_T = rock.contact_moduli
    cells = grid(11, 11)
    pressed, sheared = mean_strain(cells, 11.0, rock, UNIAXIAL), mean_strain(cells, 11.0, rock, SHEAR)
    exact = np.array([E_N / E, 0.0, E_T / 2 / E])
    return exact, np.array([-S / pressed[1, 1], pressed[0, 0] * E, S / (2 * sheared[0, 1])]) / [E, S, E]


@cache
def _triangles(size: float) -> list[Array]:
    return list(gmsh_triangles(40.0, 40.0, size))


def triangle_strains(size: float) -> Answer:
    """Compare strains of triangles of the stiffness `triangle` with those of elastic rock."""
    cells, rock = _triangles(size), _rock("triangle")
    pressed, sheared = mean_strain(cells, 40.0, rock, UNIAXIAL), mean_strain(cells, 40.0, rock, SHEAR)
    e_yy = -S / (LAME + 2 * G - LAME**2 / (LAME + 2 * G))  # plane strain, free to the sides
    exact = np.array([e_yy, -LAME / (LAME + 2 * G) * e_yy, S / G])
    return exact * E / S, np.array([pressed[1, 1], pressed[0, 0], 2 * sheared[0, 1]]) * E / S


SPACING, JN, JS = 2.0, 10e9, 5e9
BEDS = 20


def jointed_rock(*, elements: bool) -> Answer:
    """Compare moduli across and along joints 2 m apart, of blocks or of elements with interfaces [GPa]."""
    side = BEDS * SPACING
    blocks = framed(bsm.Blocks.from_polygons(grid([0.0, 1.0], np.arange(BEDS + 1) * SPACING), rock="rock"), 1.0, side)
    joint = bsm.Joint("J", JN, JS)
    found = []
    across, along = (0.0, -S), (S, 0.0)
    for E_rock, mu, traction in ((50e9, 0.0, across), (40e9, 0.0, along)):  # shear modulus 20 GPa
        rock = bsm.Rock("rock", unit_weight=0, young=E_rock, poisson=mu)
        held = [bsm.Fixed(boundary="bottom")]
        loads = [bsm.Traction(boundary="top", traction=traction)]
        if traction is along:  # complementary shear on the sides, so that the column does not bend
            loads += [
                bsm.Traction(boundary=name, traction=(0.0, sign * S)) for name, sign in (("left", -1), ("right", 1))
            ]
        model = bsm.Model(blocks=blocks, rocks=[rock], joints=[joint], default_joint="J", supports=held, loads=loads)
        moved = (solve_continuum(model, joints=True) if elements else bsm.run(model, LINEAR).stages[-1]).displacement
        rise = (BEDS - 3) * SPACING
        k = 1 if traction is across else 0
        found.append(abs(S * rise / (moved[-2, k] - moved[1, k])) / 1e9)
    exact = [1 / (1 / 50.0 + 1 / (10.0 * SPACING)), 1 / (1 / 20.0 + 1 / (5.0 * SPACING))]
    return np.array(exact), np.array(found)


def kirsch_by_elements() -> Answer:
    """Compare block averages of the stresses by second-order triangles, for r < 3 a: the L2 error itself."""
    corners = plate(24)
    return 0.0, float(error_near(solve_continuum(model_of(corners, "homogeneous")).stress, corners))


@cache
def kirsch_by_blocks(around: int) -> float:
    """Return the L2 error of the stresses of blocks, `around` of them along a quarter of the hole, for r < 3 a."""
    corners = plate(around)
    return float(error_near(bsm.run(model_of(corners, "homogeneous"), LINEAR).stages[-1].stress, corners))


def column_by_elements() -> Answer:
    """Compare settlement of a confined column under its weight, finite elements, with the closed form [mm]."""
    n, gamma = 20, 26e3
    blocks = framed(bsm.Blocks.from_polygons(grid(1, n), rock="rock"), 1.0, float(n))
    rock = bsm.Rock("rock", unit_weight=gamma, young=1e9, poisson=0.0, stiffness="homogeneous")
    model = bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(boundary="bottom")])
    y = np.arange(n) + 0.5
    exact = -gamma / 1e9 * (n * y - y**2 / 2 - 1 / 24)  # mean of the parabola over each block
    by_elements = solve_continuum(model).displacement[:, 1]
    return 1e3 * exact, 1e3 * by_elements


CASES = (
    *(Case(name=f"squares-{name}", what=f"grid of squares, stiffness `{name}`", source="springs",
           quantity="M / E, lateral strain, G / E", compute=partial(squares, name), tolerance=1e-12)
      for name in ("wang", "homogeneous", "triangle")),
    Case(name="triangles", what="about 2000 triangles, stiffness `triangle`, are the elastic rock", source="elasticity",
         quantity="strains times E over stress", compute=partial(triangle_strains, 1.25), tolerance=1e-3),
    Case(name="jointed-rock", what="rock with joints 2 m apart, as blocks", source="goodman", quantity="E*, G* [GPa]",
         compute=partial(jointed_rock, elements=False), tolerance=1e-9),
    Case(name="jointed-rock-by-elements", what="the same by finite elements with interfaces", source="goodman",
         quantity="E*, G* [GPa]", compute=partial(jointed_rock, elements=True), tolerance=5e-9),
    Case(name="kirsch-by-elements", what=f"circular hole, quarter of {len(plate(24))} quads, elements: mean error",
         source="kirsch", quantity="L2 error", compute=kirsch_by_elements, tolerance=5e-4, equations=("3.46",)),
    Case(name="kirsch-by-blocks", what=f"circular hole, {len(plate(48))} blocks `homogeneous`: mean error near it",
         source="kirsch", quantity="L2 error", compute=lambda: (0.0, kirsch_by_blocks(48)), tolerance=0.02,
         equations=("3.46",)),
    Case(name="column-by-elements", what="settlement of a column by finite elements, block averages",
         source="elasticity", quantity="settlement [mm]", compute=column_by_elements, tolerance=1e-11),
)  # fmt: skip
