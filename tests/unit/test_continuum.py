"""converters.continuum: the triangles, and solutions that are known exactly."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from bsm_mesh.geometries import OutlineMesher
from bsm_mesh.solve.zones.mesh import Discretization, build_continuum_mesh, continuum_mesh
from tests.scenes.continuum import EXACT, HEAVY, MU, PINNED, ROCK, SHAPES, STRESS, E, cantilever, sag, slab
from tests.scenes.models import framed, stress_on_sides
from tests.scenes.shapes import grid, turned


def turned_blocks(blocks, degrees):
    """Return the blocks turned about the origin, with their boundaries."""
    names = ("offsets", "nodes", "rock", "rock_names", "edge_joint", "boundaries")
    return bsm.Blocks(vertices=turned(blocks.vertices, degrees), **{n: getattr(blocks, n) for n in names})


@pytest.mark.parametrize("shape", SHAPES)
class TestMesh:
    def test_fills_every_block(self, shape):
        blocks = slab(shape)
        found = build_continuum_mesh(blocks)
        p, t = found.mesh.p, found.mesh.t
        x, y = p[:, t]
        area = np.abs((x * np.roll(y, -1, axis=0) - np.roll(x, -1, axis=0) * y).sum(axis=0)) / 2
        assert area.min() > 0
        assert_allclose(np.bincount(found.block, area), blocks.moments.area, rtol=1e-12)

    def test_neighbours_share_whole_sides(self, shape):
        found = build_continuum_mesh(slab(shape))
        ends = found.mesh.p[:, found.mesh.facets[:, found.mesh.boundary_facets()]]
        assert_allclose(np.hypot(*(ends[:, 1] - ends[:, 0])).sum(), 2 * (4 + 3), rtol=1e-12)

    def test_pieces_lie_on_their_edges(self, shape):
        blocks = slab(shape)
        found = build_continuum_mesh(blocks)
        edges = np.arange(len(blocks.vertices))[::-1]
        facets, place = found.facets_of(edges)
        ends = found.mesh.p[:, found.mesh.facets[:, facets]]
        length = np.bincount(place, np.hypot(*(ends[:, 1] - ends[:, 0])))
        assert_allclose(length, np.hypot(*blocks.edge_vectors[edges].T), rtol=1e-12)


def test_triangles_stay_as_they_are():
    assert build_continuum_mesh(slab("triangles")).mesh.t.shape == (3, len(SHAPES["triangles"]))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("elasticity", ["nominal", "matched"])
@pytest.mark.parametrize("shape", ["triangles", "squares"])
def test_uniform_stress_is_exact(shape, elasticity, order):
    model = bsm.Model(blocks=slab(shape), rocks=[ROCK], supports=PINNED, loads=stress_on_sides(STRESS))
    solution = solve_continuum(model, elasticity=elasticity, order=order)
    assert_allclose(solution.stress, np.broadcast_to(STRESS, solution.stress.shape), atol=EXACT * 7e6)
    assert_allclose(solution.total_reaction, 0, atol=EXACT * 7e6)


@pytest.mark.parametrize("shape", ["wall in bond", "posts on a beam", "concave", "triangle on long edges"])
def test_uniform_stress_is_exact_where_edges_are_cut(shape):
    model = bsm.Model(blocks=slab(shape), rocks=[ROCK], supports=PINNED, loads=stress_on_sides(STRESS))
    solution = solve_continuum(model)
    assert_allclose(solution.stress, np.broadcast_to(STRESS, solution.stress.shape), atol=EXACT * 7e6)
    strain = (1 + MU) / E * (STRESS - MU * np.trace(STRESS) * np.eye(2))
    turn = -strain[1, 0] - strain[1, 1] * 3 / 4  # the roller at (4, 3) keeps v = 4 (e_yx + turn) + 3 e_yy = 0
    expected = model.blocks.moments.centroid @ (strain + np.array([(0, -turn), (turn, 0)])).T
    assert_allclose(solution.displacement[:, :2], expected, atol=EXACT * np.abs(expected).max())
    assert_allclose(solution.displacement[:, 2], turn, rtol=EXACT)


@pytest.mark.parametrize("shape", SHAPES)
def test_gravity_column_is_exact(shape):
    sides = [bsm.Roller(boundary=side, direction=0) for side in ("left", "right")]
    blocks = slab(shape)
    model = bsm.Model(blocks=blocks, rocks=[HEAVY], supports=[*sides, bsm.NormalRoller(boundary="bottom")])
    solution = solve_continuum(model)
    vertical = -26e3 * (3 - blocks.moments.centroid[:, 1])
    assert_allclose(solution.stress[:, 1, 1], vertical, atol=EXACT * 78e3)
    assert_allclose(solution.stress[:, 0, 0], MU / (1 - MU) * vertical, atol=EXACT * 78e3)
    assert_allclose(solution.total_load, [0, -26e3 * 12], atol=EXACT * 1e6)
    assert_allclose(solution.total_reaction, [0, 26e3 * 12], atol=EXACT * 1e6)
    y, v = solution.points[:, 1], solution.point_displacement[:, 1]
    confined = (1 - MU) * E / ((1 + MU) * (1 - 2 * MU))
    assert_allclose(v, -26e3 * (3 * y - y**2 / 2) / confined, atol=EXACT * 26e3 * 4.5 / confined)


@pytest.mark.parametrize("shape", SHAPES)
def test_an_earthquake_pulls_on_every_part_of_a_block(shape):
    """A slab between walls and on ice: the stress grows linearly from one side, as in the gravity column."""
    sides = [bsm.NormalRoller(boundary=side) for side in ("left", "bottom", "top")]
    blocks = slab(shape)
    model = bsm.Model(blocks=blocks, rocks=[HEAVY], supports=sides, gravity_horizontal=0.2, gravity_vertical=1.0)
    solution = solve_continuum(model)
    horizontal = 0.2 * 26e3 * (4 - blocks.moments.centroid[:, 0])
    assert_allclose(solution.total_load, [0.2 * 26e3 * 12, 0], atol=EXACT * 1e6)
    assert_allclose(solution.stress[:, 0, 0], horizontal, atol=EXACT * 78e3)


def test_rocks_of_different_stiffness_in_series():
    blocks = framed(bsm.Blocks.from_polygons(grid(1, 2), rock=["hard", "soft"]), 1, 2)
    rocks = [
        bsm.Rock("hard", unit_weight=0, young=E, poisson=0.0),
        bsm.Rock("soft", unit_weight=0, young=E / 10, poisson=0.0),
    ]
    loads = [bsm.Pressure(boundary="top", pressure=1e6)]
    supports = [bsm.Roller(boundary="bottom", direction=90), bsm.Fixed(point=(0, 0))]
    solution = solve_continuum(bsm.Model(blocks=blocks, rocks=rocks, supports=supports, loads=loads))
    assert_allclose(solution.displacement[:, 1], [-1e6 / E / 2, -1e6 / E - 1e7 / E / 2], rtol=EXACT)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("degrees", [30.0, -77.0])
def test_inclined_supports_as_straight_ones(degrees, order):
    """A turned model has the turned displacements: rollers at an angle are exact, not nearly so."""
    flat, leaning = slab("wall in bond"), turned_blocks(slab("wall in bond"), degrees)
    flat_supports = [bsm.Roller(boundary="left", direction=0), bsm.NormalRoller(boundary="bottom")]
    supports = [bsm.Roller(boundary="left", direction=degrees), bsm.NormalRoller(boundary="bottom")]
    pull = bsm.PrescribedDisplacement(boundary="right", direction=20.0, displacement=1e-3)
    leaning_pull = bsm.PrescribedDisplacement(boundary="right", direction=20.0 + degrees, displacement=1e-3)
    one = solve_continuum(bsm.Model(blocks=flat, rocks=[HEAVY], supports=[*flat_supports, pull]), order=order)
    other = solve_continuum(
        bsm.Model(blocks=leaning, rocks=[HEAVY], supports=[*supports, leaning_pull], gravity_direction=degrees - 90),
        order=order,
    )
    assert_allclose(other.displacement[:, :2], turned(one.displacement[:, :2], degrees), atol=1e-9 * 1e-3)
    assert_allclose(other.displacement[:, 2], one.displacement[:, 2], atol=1e-9 * 1e-3)


def test_prescribed_displacement_of_a_boundary():
    supports = [
        bsm.Roller(boundary="left", direction=0),
        bsm.PrescribedDisplacement(boundary="right", direction=180, displacement=4e-3),
        bsm.Roller(boundary="bottom", direction=90),
        bsm.Roller(boundary="top", direction=90),
    ]
    solution = solve_continuum(bsm.Model(blocks=slab("squares"), rocks=[ROCK], supports=supports))
    confined = (1 - MU) * E / ((1 + MU) * (1 - 2 * MU))
    assert_allclose(solution.stress[:, 0, 0], -1e-3 * confined, rtol=EXACT)
    assert_allclose(solution.stress[:, 1, 1], -1e-3 * confined * MU / (1 - MU), rtol=EXACT)


def test_a_curved_boundary_of_normal_rollers_lets_its_nodes_slide():
    """A ring whose hole may not change: pressure outside, no displacement normal to the hole, but free along it."""
    angle = np.linspace(0, 2 * np.pi, 49)[:-1]
    rings = [r * np.stack([np.cos(angle), np.sin(angle)], axis=1) for r in (1.0, 1.5, 2.0)]
    cells = [
        np.array([inner[i], outer[i], outer[(i + 1) % 48], inner[(i + 1) % 48]])
        for inner, outer in pairwise(rings)
        for i in range(48)
    ]
    blocks = bsm.Blocks.from_polygons(cells, rock="rock").with_boundary("hole", lambda x, y: np.hypot(x, y) < 1.01)
    supports = [
        bsm.NormalRoller(boundary="hole"),
        bsm.PrescribedDisplacement(point=(2.0, 0.0), direction=90, displacement=1e-3),
    ]
    solution = solve_continuum(bsm.Model(blocks=blocks, rocks=[ROCK], supports=supports))
    assert_allclose(solution.displacement[:, 2], 0.5e-3, rtol=1e-2)  # it turns as a whole, all but freely


def test_edge_tractions_are_linear_along_an_edge_that_is_cut():
    """Hydrostatic pressure on a wall whose edges are cut by its neighbours: the resultant to rounding."""
    blocks = slab("wall in bond")
    edges = blocks.boundaries["top"]
    ends = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
    values = np.stack([0 * ends[..., 0], -1e3 * (1 + ends[..., 0])], axis=-1)
    supports = [bsm.Fixed(boundary="bottom")]
    by_edge = bsm.Model(
        blocks=blocks, rocks=[ROCK], supports=supports, loads=[bsm.EdgeTractions(boundary="top", values=values)]
    )
    by_field = by_edge.replace(loads=[bsm.Pressure(boundary="top", pressure=(1e3, 1e3, 0.0))])
    one, other = solve_continuum(by_edge), solve_continuum(by_field)
    assert_allclose(one.total_load, [0, -1e3 * (4 + 8)], atol=1e-6)
    assert_allclose(other.point_displacement, one.point_displacement, atol=EXACT * np.abs(one.point_displacement).max())


def test_quadratic_triangles_are_in_vtk_order():
    solution = solve_continuum(
        bsm.Model(blocks=slab("concave"), rocks=[HEAVY], supports=[bsm.Fixed(boundary="bottom")])
    )
    p, t = solution.points, solution.cells
    a, b, c = p[t[:, 0]], p[t[:, 1]], p[t[:, 2]]
    assert ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] > 0).all()
    for middle, one, other in ((3, a, b), (4, b, c), (5, c, a)):
        assert_allclose(p[t[:, middle]], (one + other) / 2, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
class TestMeshing:
    def test_gmsh_and_refinement_fill_every_block(self, shape):
        """Areas of the blocks; pieces along every edge from its start to its end, of the size asked for."""
        blocks = slab(shape)
        coarse, fine = (
            continuum_mesh(blocks, Discretization(mesher=OutlineMesher(size=0.4), refinements=k)) for k in (0, 1)
        )
        halved = continuum_mesh(blocks, Discretization(refinements=2))
        for found in (coarse, fine, halved):
            x, y = found.mesh.p[:, found.mesh.t]
            area = np.abs((x * np.roll(y, -1, axis=0) - np.roll(x, -1, axis=0) * y).sum(axis=0)) / 2
            assert_allclose(np.bincount(found.block, area), blocks.moments.area, rtol=1e-12)
            ends = found.mesh.p.T[found.piece_ends]
            assert_allclose(ends[found.piece_start[:-1], 0], blocks.vertices, atol=1e-12)
            assert_allclose(ends[found.piece_start[1:] - 1, 1], blocks.vertices[blocks.following], atol=1e-12)
            inner = np.diff(found.edge_of_piece) == 0
            assert_allclose(ends[1:, 0][inner], ends[:-1, 1][inner], atol=1e-12)
        assert (
            np.hypot(*(coarse.mesh.p[:, coarse.mesh.facets[0]] - coarse.mesh.p[:, coarse.mesh.facets[1]])).max() < 0.6
        )
        assert len(fine.block) == 4 * len(coarse.block)

    @pytest.mark.parametrize("order", [1, 2])
    def test_patch_with_interfaces(self, shape, order):
        """Uniform stress in any mesh, across joints that only add their closure."""
        blocks = slab(shape)
        joint = bsm.Joint("J", normal_stiffness=1e14, shear_stiffness=1e14)
        loads = [bsm.Pressure(boundary=side, pressure=p) for side, p in (("top", 7e6), ("right", 3e6))]
        model = bsm.Model(
            blocks=blocks,
            rocks=[ROCK],
            joints=[joint],
            default_joint="J",
            supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
            loads=loads,
        )
        for keys in ({"refinements": 1}, {"mesher": OutlineMesher(size=0.7)}):
            found = solve_continuum(model, order=order, joints=True, **keys)
            assert_allclose(
                found.cell_stress, np.broadcast_to(np.diag([-3e6, -7e6]), found.cell_stress.shape), atol=7e6 * 1e-3
            )


@pytest.mark.parametrize(("order", "poisson", "most"), [(1, 0.2, 1.5), (1, 0.45, 0.6), (2, 0.2, 1.0), (2, 0.45, 1.0)])
def test_triangles_about_the_centroid_beside_quads(order, poisson, most):
    """One triangle among squares makes all of them four triangles: how far the sag is from that of a fine mesh.

    First-order quads bend half as well again in common rock, and half as well where it is nearly incompressible.
    """
    fine = cantilever(64, poisson, mixed=False)
    exact = sag(fine, solve_continuum(fine).displacement)
    errors = []
    for mixed in (False, True):
        model = cantilever(16, poisson, mixed=mixed)
        stage = solve_continuum(model, order=order)
        assert stage.cells.shape[1] == ((3, 6) if mixed else (4, 8))[order - 1]
        errors.append(abs(sag(model, stage.displacement) / exact - 1))
    assert errors[1] < most * errors[0]
