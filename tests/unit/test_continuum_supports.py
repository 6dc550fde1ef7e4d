"""converters.continuum: supports of blocks and points, point loads, and what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from tests.scenes.continuum import EXACT, HEAVY, MU, PINNED, ROCK, E, slab
from tests.scenes.models import framed
from tests.scenes.shapes import grid, rectangle


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


class TestRefusals:
    @pytest.mark.parametrize(
        "rock",
        [bsm.Rock("rock", unit_weight=0), bsm.Rock("rock", unit_weight=0, young=E, poisson=MU, stiffness="rigid")],
        ids=["no E", "rigid"],
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
