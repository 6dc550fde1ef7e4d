"""converters.continuum: elasticity matched to the blocks, and blocks compared with the continuum."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.converters import compare, solve_continuum
from bsm_mesh.converters.continuum import affine_stiffness, blocks_on_line, compare_stages, matched_elasticity
from bsm_mesh.converters.continuum.differences import stress_errors
from bsm_mesh.results.stress import stress_is_known
from tests.scenes.continuum import EXACT, ROCK, E, slab
from tests.scenes.models import LINEAR, framed
from tests.scenes.shapes import grid, rectangle


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
        return model, compare(model, bsm.run(model, LINEAR), joints=False)

    def test_uniform_stress_agrees(self):
        _, comparison = self.compared()
        assert_allclose(comparison.stress_difference, 0, atol=1e-8 * 5e6)
        assert {e.name for e in comparison.stress_errors} == {"sigma_xx", "sigma_yy", "sigma_xy", "sigma_1", "stress"}
        assert all(e.l2 < 1e-8 and e.largest < 1e-8 for e in comparison.stress_errors)
        # Blocks at a support are rigid up to it: their displacement lacks half a block's strain, all others follow.
        strain = np.array([-2e6, -5e6]) / ROCK.contact_moduli[0]
        assert_allclose(comparison.displacement_difference[:, :2], np.tile(-strain / 2, (48, 1)), rtol=1e-6)
        assert comparison.displacement_errors[0].l2 < comparison.displacement_errors[1].l2

    def test_blocks_that_a_run_took_away_are_not_in_the_continuum(self):
        """A chip in the air falls and does not count; without it the elements stand as the blocks do."""
        chip = rectangle(-1.0, 3.0, -0.9, 3.1)
        model = bsm.Model(
            blocks=framed(bsm.Blocks.from_polygons([*grid(3, 4), chip], rock="rock"), 3, 4),
            rocks=[replace(ROCK, unit_weight=25e3)],
            joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30.0))],
            default_joint="J",
            supports=[bsm.Fixed(boundary="bottom")],
            loads=[bsm.Pressure(boundary="top", pressure=1e5)],
        )
        results = bsm.run(model, bsm.Options(falls=bsm.Falls(ignore_below=0.05)))
        assert [fall.block for fall in results.stages[-1].falls] == [12]
        (stage,) = compare_stages(model, results)
        assert stage.comparison is not None, stage.reason
        assert stage.comparison.force_error.l2 < 0.01

    def test_stress_where_supports_hold_a_block_at_two_points_does_not_count(self):
        """Statics does not tell where the reactions act: the average stress of such a block means nothing."""
        model, comparison = self.compared(supports=[bsm.Fixed(boundary="bottom")])
        known = stress_is_known(model.blocks, bsm.run(model, LINEAR).stages[-1])
        assert known.sum() == 40
        area = model.blocks.moments.area * known
        expected = stress_errors(
            comparison.stress * known[:, None, None], comparison.nominal.stress * known[:, None, None], area
        )
        assert comparison.stress_errors == expected

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
