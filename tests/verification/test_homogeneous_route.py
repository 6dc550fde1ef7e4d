"""Example 1 by the homogeneous route: in-situ stress set directly, then the tunnel excavated, on any mesh.

Stiffness `homogeneous` (E_N = E_T = E / (1 - mu^2)), against scikit-fem averaged over the blocks that are left.
The thesis's own route comes near the continuum on triangles only (test_wang_example_1.py).
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.converters.continuum import blocks_on_line, solve_continuum
from tests.scenes.models import LINEAR
from tests.scenes.shapes import voronoi

A, DEPTH, GAMMA, MU, FAR = 2.0, 11.0, 26e3, 0.25, 22.0
K0 = MU / (1 - MU)
SECTION_L2, SECTION_MAX, NEAR_L2 = 0.02, 0.04, 0.03  # quads, Voronoi, 1000 blocks and more
TRIANGLES = 0.03, 0.06, 0.06  # the same of 4000 triangles and more


def blocks_of(kind, size, folder):
    if kind == "voronoi":
        return voronoi_tunnel(size)
    pytest.importorskip("gmsh")
    from bsm_mesh.geometries import circular_tunnel

    grading = {"size_at_wall": 0.22 * size, "grading_distance": 10.0} if kind == "triangles" else {}
    path = circular_tunnel.build(
        folder / f"{size}.msh", radius=A, depth=DEPTH, below=FAR, width=FAR, mesh=kind, size=size, core=True, **grading
    )
    with pytest.warns(bsm.MeshWarning, match="both sides"):
        return converters.read_blocks(path)


def voronoi_tunnel(count):
    """Return Voronoi cells of half the ground; seeds near the wall are mirrored in it, so that edges run along it."""
    cells = voronoi(FAR, FAR + DEPTH, count, rounds=100, circle=((0.0, FAR), A))
    blocks = bsm.Blocks.from_polygons([cell - (0, FAR) for cell in cells], rock="rock")
    inside = np.flatnonzero(np.hypot(*blocks.moments.centroid.T) < A)
    return sides(dataclasses.replace(blocks, excavations={"tunnel": inside}))


def sides(blocks):
    off = 1e-6
    return (
        blocks.with_boundary("left", lambda x, y: x < off)
        .with_boundary("right", lambda x, y: x > FAR - off)
        .with_boundary("bottom", lambda x, y: y < off - FAR)
    )


def dug(blocks):
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=GAMMA, young=50e9, poisson=MU, stiffness="homogeneous")],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.InSituTraction(boundary="right")],
        in_situ=bsm.InSitu(surface=DEPTH, k0=K0),
        stages=[bsm.Stage(name="tunnel", excavate=["tunnel"])],
    )


def errors(blocks):
    """Return L2 and greatest error of sigma_v on section I-I, L2 of all stresses within 3 a, and the block count."""
    model = dug(blocks)
    results = bsm.run(model, LINEAR)
    assert results.check().ok
    assert not results.stages[0].displacement.any()
    stage = results.stages[-1]
    left = sides(bsm.Blocks.from_polygons([blocks.polygon(b) for b in np.flatnonzero(stage.present)], rock="rock"))
    load = bsm.Pressure(boundary="right", pressure=(K0 * GAMMA * DEPTH, 0.0, -K0 * GAMMA))
    fem = solve_continuum(bsm.Model(blocks=left, rocks=model.rocks, supports=model.supports, loads=[load])).stress
    found, area = stage.stress[stage.present], left.moments.area
    difference = found - fem
    on = blocks_on_line(left, (A + 0.3, 0.0), (5 * A, 0.0))
    vertical, exact, weight = difference[on, 1, 1], fem[on, 1, 1], area[on]
    near = np.hypot(*left.moments.centroid.T) < 3 * A
    squares = [(area[near] * (s[near] ** 2).sum(axis=(1, 2))).sum() for s in (difference, fem)]
    return (
        np.sqrt((weight * vertical**2).sum() / (weight * exact**2).sum()),
        np.abs(vertical).max() / np.abs(exact).max(),
        np.sqrt(squares[0] / squares[1]),
        left.count,
    )


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("kind", "size"), [("quads", 0.75), ("quads", 0.45), pytest.param("voronoi", 2000, marks=pytest.mark.slow)]
)
def test_quads_and_voronoi_blocks(kind, size, tmp_path):
    l2, largest, near, count = errors(blocks_of(kind, size, tmp_path))
    assert count >= 1000
    assert l2 <= SECTION_L2
    assert largest <= SECTION_MAX
    assert near <= NEAR_L2


@pytest.mark.slow
def test_triangles_converge(tmp_path):
    found = [errors(blocks_of("triangles", size, tmp_path)) for size in (1.8, 0.9, 0.45)]
    for l2, largest, near, count in found[1:]:
        assert count >= 4000
        assert (l2 <= TRIANGLES[0], largest <= TRIANGLES[1], near <= TRIANGLES[2]) == (True, True, True)
    sections, around = [row[0] for row in found], [row[2] for row in found]
    assert sections == sorted(sections, reverse=True)
    assert around == sorted(around, reverse=True)


def test_with_the_continuation_nothing_slips_and_the_answer_is_the_same(tmp_path):
    model = dug(blocks_of("triangles", 1.8, tmp_path))
    linear, moved = bsm.run(model, LINEAR), bsm.run(model, bsm.Options(scheme="continuation"))
    assert moved.status == "stable"
    one, other = linear.stages[-1], moved.stages[-1]
    assert_allclose(other.displacement, one.displacement, atol=1e-3 * one.max_displacement)
    assert_allclose(other.stress, one.stress, atol=1e-3 * np.abs(one.stress).max())
