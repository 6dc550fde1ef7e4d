"""converters.continuum: the triangles, the constraints, the loads and the averages of the continuum solution."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenes import LINEAR, framed, grid, rectangle, running_bond, stress_on_sides, turned

import bsm_mesh as bsm
from converters import compare, solve_continuum
from converters.continuum import affine_stiffness, blocks_on_line, matched_elasticity
from converters.continuum.comparison import stress_errors
from converters.continuum.mesh import build_continuum_mesh

EXACT = 1e-9  # linear fields lie in both element spaces, the gravity column in the second-order one; rounding is lost
E, MU = 50e9, 0.25
STRESS = np.array([(-3.0, 1.2), (1.2, -7.0)]) * 1e6
ROCK = bsm.Rock("rock", young=E, poisson=MU)
HEAVY = bsm.Rock("rock", unit_weight=26e3, young=E, poisson=MU)
PINNED = [bsm.Fixed(point=(0, 0)), bsm.Roller(point=(4, 3), direction=90)]

L_SHAPE = np.array([(0, 0), (4, 0), (4, 0.5), (0.5, 0.5), (0.5, 3), (0, 3)])  # its centroid does not see all of it
SHAPES = {
    "triangles": [np.array(c)[k] for c in grid(4, 3) for k in ([0, 1, 2], [0, 2, 3])],
    "squares": grid(4, 3),
    "wall in bond": running_bond(6, 4),
    "posts on a beam": [rectangle(0, 0, 4, 1), *grid([0, 0.5, 2, 2.6, 4], [1, 3])],
    "concave": [L_SHAPE, rectangle(0.5, 0.5, 4, 3)],
    "triangle on long edges": [
        rectangle(0, 0, 4, 1),
        *([np.array([(0, 1), (1.5, 1), (0, 3)]), np.array([(1.5, 1), (4, 1), (4, 3)])]),
        np.array([(1.5, 1), (4, 3), (0, 3)]),
    ],
}


def slab(shape):
    return framed(bsm.Blocks.from_polygons(SHAPES[shape], rock="rock"), 4.0, 3.0)


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
        sides = p[:, t[1:]] - p[:, t[:1]]
        area = np.abs(sides[0, 0] * sides[1, 1] - sides[1, 0] * sides[0, 1]) / 2
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


def test_rocks_of_different_stiffness_in_series():
    blocks = framed(bsm.Blocks.from_polygons(grid(1, 2), rock=["hard", "soft"]), 1, 2)
    rocks = [bsm.Rock("hard", young=E, poisson=0.0), bsm.Rock("soft", young=E / 10, poisson=0.0)]
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


class TestSupportsOfBlocksAndPoints:
    def test_fixed_block_is_rigid(self):
        model = bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=[bsm.Fixed(blocks=[5])])
        solution = solve_continuum(model)
        assert_allclose(solution.displacement[5], 0, atol=1e-18)
        assert_allclose(solution.stress[5], 0, atol=1e-6)
        assert_allclose(solution.total_reaction, [0, 26e3 * 12], atol=EXACT * 1e6)

    def test_all_blocks_fixed(self):
        model = bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=[bsm.Fixed(blocks=range(12))])
        solution = solve_continuum(model)
        assert_array_equal(solution.point_displacement, 0)
        assert solution.unknowns == 0
        assert_allclose(solution.total_reaction, [0, 26e3 * 12], rtol=EXACT, atol=1e-6)

    def test_roller_of_blocks_holds_their_average(self):
        supports = [
            bsm.Roller(blocks=[0, 3], direction=80),
            bsm.PrescribedDisplacement(blocks=[1], direction=0, displacement=2e-3),
        ]
        solution = solve_continuum(bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=supports))
        held = np.array([np.cos(np.radians(80)), np.sin(np.radians(80))])
        assert_allclose(solution.displacement[[0, 3], :2] @ held, 0, atol=EXACT * 2e-3)
        assert_allclose(solution.displacement[1, 0], 2e-3, rtol=EXACT)
        assert_allclose(solution.total_reaction, [0, 26e3 * 12], atol=1e-7 * 1e6)

    def test_point_within_a_block(self):
        supports = [bsm.Fixed(point=(0.3, 0.4)), bsm.Roller(point=(3.6, 0.2), direction=90)]
        solution = solve_continuum(bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=supports))
        assert_allclose(solution.total_reaction, [0, 26e3 * 12], atol=1e-7 * 1e6)
        assert np.abs(solution.displacement[0, :2]).max() < np.abs(solution.displacement[:, :2]).max() / 3

    def test_repeated_supports_do_no_harm(self):
        once = [bsm.Fixed(boundary="bottom")]
        blocks = slab("squares")
        again = [
            *once,
            bsm.Roller(boundary="bottom", direction=30),
            bsm.Fixed(point=(0.25, 0.0)),
            bsm.Fixed(blocks=[0]),
        ]
        one, other = (
            solve_continuum(bsm.Model(blocks=blocks, rocks=[HEAVY], supports=s))
            for s in ([*once, bsm.Fixed(blocks=[0])], again)
        )
        assert_allclose(other.displacement, one.displacement, atol=1e-12 * np.abs(one.displacement).max())


class TestPointLoads:
    """The weak form with the fields (0, y) and (x, 0), which the bottom and left rollers allow, is exact."""

    blocks = slab("squares")
    loads = (
        bsm.PointLoad(block=7, point=(3.25, 1.75), force=(2e3, -5e3)),
        bsm.PointLoad(block=7, point=(4.0, 2.0), force=(-1e3, 1e3)),
        bsm.PointLoad(block=0, point=(0.5, 0.5), force=(0.0, -7e3)),
    )
    supports = (bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90))

    def test_resultant(self):
        model = bsm.Model(blocks=self.blocks, rocks=[ROCK], supports=self.supports, loads=self.loads)
        solution = solve_continuum(model)
        assert_allclose(solution.total_load, [1e3, -11e3], rtol=EXACT)
        assert solution.notes[0].startswith("point loads are spread over their blocks")

    def test_average_stress_of_the_whole(self):
        model = bsm.Model(blocks=self.blocks, rocks=[ROCK], supports=self.supports, loads=self.loads)
        area = self.blocks.moments.area
        total = (solve_continuum(model).stress * area[:, None, None]).sum(axis=0)
        assert_allclose(total[1, 1], sum(load.point[1] * load.force[1] for load in self.loads), rtol=1e-8)
        assert_allclose(total[0, 0], sum(load.point[0] * load.force[0] for load in self.loads), rtol=1e-8)

    def test_moment(self):
        """A lone block on a pin turns about it until the roller's reaction balances the moment."""
        block = framed(bsm.Blocks.from_polygons([rectangle(0, 0, 4, 3)], rock="rock"), 4, 3)
        load = bsm.PointLoad(block=0, point=(1.0, 2.5), force=(3e3, -4e3))
        model = bsm.Model(blocks=block, rocks=[ROCK], supports=PINNED, loads=[load])
        solution = solve_continuum(model, order=1)
        assert_allclose(solution.total_reaction, [-3e3, 4e3], rtol=1e-8)


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


class TestRefusals:
    @pytest.mark.parametrize(
        "rock", [bsm.Rock("rock"), bsm.Rock("rock", young=E, poisson=MU, stiffness="rigid")], ids=["no E", "rigid"]
    )
    def test_rigid_rock(self, rock):
        joint = bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9)
        model = bsm.Model(
            blocks=slab("squares"), rocks=[rock], joints=[joint], default_joint="J1",
            supports=[bsm.Fixed(boundary="bottom")],
        )  # fmt: skip
        with pytest.raises(bsm.ModelError, match="rock 'rock': a continuum solution needs an elastic rock"):
            solve_continuum(model)

    @pytest.mark.parametrize(
        "supports", [[], [bsm.Roller(boundary="left", direction=0)], [bsm.Fixed(point=(0, 0))]], ids=str
    )
    def test_free_to_move(self, supports):
        model = bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=supports)
        with pytest.raises(bsm.ModelError, match="free to move as a whole"):
            solve_continuum(model)

    def test_a_second_part_that_nothing_holds(self):
        blocks = framed(bsm.Blocks.from_polygons([*grid(4, 3), rectangle(9, 9, 10, 10)], rock="rock"), 10, 10)
        model = bsm.Model(blocks=blocks, rocks=[HEAVY], supports=[bsm.Fixed(boundary="bottom")])
        with pytest.raises(bsm.ModelError, match=r"about \(9.5, 9.5\)"):
            solve_continuum(model)

    def test_hinged_parts(self):
        blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1), rectangle(1, 1, 2, 2)], rock="rock")
        model = bsm.Model(blocks=blocks, rocks=[HEAVY], supports=[bsm.Fixed(blocks=[0])])
        with pytest.raises(bsm.ModelError, match=r"single point|free to move"):
            solve_continuum(model)

    def test_contradicting_supports(self):
        supports = [
            bsm.Fixed(boundary="bottom"),
            bsm.PrescribedDisplacement(boundary="left", direction=90, displacement=1e-3),
        ]
        blocks = framed(bsm.Blocks.from_polygons(grid(4, 3), rock="rock"), 4, 3)
        model = bsm.Model(blocks=blocks, rocks=[HEAVY])
        with pytest.raises(bsm.ModelError, match="different displacements of one point"):
            solve_continuum(model.replace(supports=supports))

    def test_contradicting_supports_of_blocks(self):
        supports = [bsm.Fixed(blocks=[0]), bsm.PrescribedDisplacement(blocks=[0], direction=90, displacement=1e-3)]
        model = bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=supports)
        with pytest.raises(bsm.ModelError, match="contradict"):
            solve_continuum(model)

    @pytest.mark.parametrize("options", [{"order": 3}, {"elasticity": "best"}])
    def test_unknown_options(self, options):
        model = bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=[bsm.Fixed(boundary="bottom")])
        with pytest.raises(bsm.ModelError, match="must be"):
            solve_continuum(model, **options)


def test_quadratic_triangles_are_in_vtk_order():
    solution = solve_continuum(
        bsm.Model(blocks=slab("concave"), rocks=[HEAVY], supports=[bsm.Fixed(boundary="bottom")])
    )
    p, t = solution.points, solution.triangles
    a, b, c = p[t[:, 0]], p[t[:, 1]], p[t[:, 2]]
    assert ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] > 0).all()
    for middle, one, other in ((3, a, b), (4, b, c), (5, c, a)):
        assert_allclose(p[t[:, middle]], (one + other) / 2, atol=1e-12)


class TestMatched:
    def test_hexagons_are_isotropic(self):
        angle = np.pi / 3 * np.arange(6) + 0.3
        hexagon = bsm.Blocks.from_polygons([np.stack([np.cos(angle), np.sin(angle)], axis=1)], rock="rock")
        found = affine_stiffness(hexagon, np.array([ROCK.contact_moduli]))[0]
        assert_allclose(found, matched_elasticity(ROCK, "polygon").matrix, atol=EXACT * E)

    def test_rectangles(self):
        found = affine_stiffness(
            bsm.Blocks.from_polygons([rectangle(3, 1, 5, 2)], rock="rock"), np.array([ROCK.contact_moduli])
        )[0]
        assert_allclose(found, matched_elasticity(ROCK, "quad").matrix, atol=EXACT * E)

    def test_notes_say_what_was_chosen(self):
        for shape, word in (("triangles", "triangles, isotropic"), ("squares", "quads, each")):
            model = bsm.Model(blocks=slab(shape), rocks=[ROCK], supports=[bsm.Fixed(boundary="bottom")])
            (note,) = solve_continuum(model, elasticity="matched").notes
            assert word in note


class TestCompare:
    @staticmethod
    def compared(**changes):
        model = bsm.Model(
            blocks=framed(bsm.Blocks.from_polygons(grid(8, 6), rock="rock"), 8, 6),
            rocks=[ROCK],
            supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
            loads=[bsm.Pressure(boundary="top", pressure=5e6), bsm.Pressure(boundary="right", pressure=2e6)],
        ).replace(**changes)
        return model, compare(model, bsm.run(model, LINEAR))

    def test_uniform_stress_agrees(self):
        _, comparison = self.compared()
        assert_allclose(comparison.stress_difference, 0, atol=1e-8 * 5e6)
        assert {e.name for e in comparison.stress_errors} == {"sigma_xx", "sigma_yy", "sigma_xy", "sigma_1", "stress"}
        assert all(e.l2 < 1e-8 and e.largest < 1e-8 for e in comparison.stress_errors)
        # Blocks at a support are rigid up to it: their displacement lacks half a block's strain, all others follow.
        strain = np.array([-2e6, -5e6]) / ROCK.contact_moduli[0]
        assert_allclose(comparison.displacement_difference[:, :2], np.tile(-strain / 2, (48, 1)), rtol=1e-6)
        assert comparison.displacement_errors[0].l2 < comparison.displacement_errors[1].l2

    def test_table(self):
        _, comparison = self.compared()
        rows = comparison.table()
        assert rows[-1].label == "wall time"
        assert rows[-1].unit == "s"
        rms = next(row for row in rows if row.label == "sigma_yy, r.m.s.")
        assert_allclose([rms.bsm, rms.fem], 5e6, rtol=1e-8)

    def test_joints_are_ignored_and_said_so(self):
        joint = bsm.Joint("J1", normal_stiffness=1e10, shear_stiffness=1e9)
        _, comparison = self.compared(joints=[joint], default_joint="J1")
        assert comparison.notes[0] == "joints are ignored: 82 of 82 faces ('J1') are taken as unbroken rock"

    def test_section(self):
        model, comparison = self.compared()
        section = comparison.along(blocks_on_line(model.blocks, (7.5, 2.5), (-1.0, 2.5)))
        assert_array_equal(section.block, np.arange(16, 24)[::-1])
        assert_allclose(section.bsm[:, 1, 1], section.fem[:, 1, 1], rtol=1e-8)

    def test_results_of_another_model(self):
        model, _ = self.compared()
        other = model.replace(loads=[])
        with pytest.raises(bsm.ModelError, match="not those of this model"):
            compare(other, bsm.run(model, LINEAR))

    def test_measures(self):
        """L2 is weighted by area; a component that the continuum lacks is measured by the whole stress."""
        fem = np.zeros((2, 2, 2))
        fem[:, 1, 1] = [-2.0, -4.0]
        bsm_stress = fem.copy()
        bsm_stress[1, 1, 1] = -5.0
        bsm_stress[0, 0, 1] = bsm_stress[0, 1, 0] = 0.5
        by_name = {e.name: e for e in stress_errors(bsm_stress, fem, np.array([3.0, 1.0]))}
        assert_allclose(by_name["sigma_yy"].l2, np.sqrt(1 / (3 * 4 + 16)))
        assert_allclose(by_name["sigma_yy"].largest, 1 / 4)
        assert by_name["sigma_yy"].worst_block == 1
        assert_allclose(by_name["sigma_yy"].worst_difference, -1)
        assert_allclose(by_name["sigma_xy"].l2, np.sqrt(3 * 0.25 / (3 * 4 + 16)))
        assert_allclose(by_name["sigma_xy"].largest, 0.5 / 4)
        assert_allclose(by_name["sigma_xx"].l2, 0)
        assert_allclose(by_name["stress"].rms_difference, np.sqrt((3 * 0.5 + 1) / 4))
