"""The independent check finds forces that were tampered with."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results.check import LINEAR_TOLERANCE, block_residuals
from tests.scenes.models import framed
from tests.scenes.shapes import grid

ROCK = bsm.Rock("r", unit_weight=26e3, young=1e9, poisson=0.2)


def results(origin=0.0):
    blocks = framed(bsm.Blocks.from_polygons(grid(4, 3), rock="r"), 4, 3)
    blocks = dataclasses.replace(blocks, vertices=blocks.vertices + origin)
    supports = [bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="left")]
    loads = [bsm.Pressure(boundary="right", pressure=1e5)]
    model = bsm.Model(blocks=blocks, rocks=[ROCK], supports=supports, loads=loads)
    return bsm.run(model, bsm.Options(scheme="linear"))


def tampered(found, **changes):
    return dataclasses.replace(found, stages=(dataclasses.replace(found.stages[0], **changes),))


def changed_contact(found, field, c, value):
    contacts = found.stages[0].contacts
    array = getattr(contacts, field).copy()
    array[c] += value
    return tampered(found, contacts=dataclasses.replace(contacts, **{field: array}))


def test_a_good_solution_passes():
    check = results().check()
    assert check.ok
    assert check.block_residual <= LINEAR_TOLERANCE
    assert check.tolerance == LINEAR_TOLERANCE
    assert str(check).startswith("in equilibrium: ")


@pytest.mark.parametrize("field", ["normal_force", "shear_force"])
def test_one_changed_contact_force_is_found(field):
    good = results()
    contacts, reference = good.stages[0].contacts, good.stages[0].reference_weight
    check = changed_contact(good, field, 3, 1e-6 * reference).check()
    assert not check.ok
    assert str(check).startswith("NOT in equilibrium")
    assert check.worst_block in (contacts.block_a[3], contacts.block_b[3])
    assert_allclose(check.block_residual, 1e-6, rtol=0.8)  # the moment over the radius of gyration may be larger


def test_a_moved_contact_point_is_found_by_its_moment():
    assert not changed_contact(results(), "point", 3, 1e-3).check().ok


def test_a_changed_reaction_is_found_twice():
    good = results()
    reactions = good.stages[0].reactions.copy()
    reactions[0, 1] += 1.0
    check = tampered(good, reactions=reactions).check()
    assert check.block_residual > LINEAR_TOLERANCE
    assert check.balance > LINEAR_TOLERANCE
    assert check.worst_block == 0


def test_a_changed_load_is_found():
    good = results()
    loads = good.stages[0].loads.copy()
    loads[5, 2] += 10.0
    check = tampered(good, loads=loads).check()
    assert check.worst_block == 5
    assert not check.ok


def test_not_a_number_is_not_in_equilibrium():
    assert not changed_contact(results(), "normal_force", 3, np.nan).check().ok


def test_the_checking_leaves_the_results_alone():
    found = results()
    before = found.stages[0].loads.copy()
    block_residuals(found, found.stages[0])
    found.check()
    assert_allclose(found.stages[0].loads, before, rtol=0)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-12])
def test_other_schemes_are_held_to_the_tolerance_that_they_were_solved_to(tolerance):
    found = results()
    assert dataclasses.replace(found, scheme="continuation", tolerance=tolerance).check().tolerance == tolerance
    assert dataclasses.replace(found, tolerance=tolerance).check().tolerance == min(tolerance, LINEAR_TOLERANCE)


def test_what_rounded_coordinates_make_is_no_fault():
    """A stage five thousand kilometres away: its points are known to a nanometre, and so are its moments."""
    check = results(origin=5e6).check()
    assert check.ok
    assert check.rounding > 1e-10
    assert results().check().rounding < 1e-13
    far = results(origin=5e6)
    contacts = far.stages[0].contacts
    beyond = 100 * check.rounding * far.stages[0].reference_weight / np.hypot(*contacts.force[3])
    assert not changed_contact(far, "point", 3, beyond).check().ok


def test_blocks_that_are_gone_do_not_count():
    good = results()
    loads = good.stages[0].loads.copy()
    loads[5] += 1e9
    present = np.ones(len(loads), dtype=bool)
    present[5] = False
    gone = tampered(good, loads=loads, present=present)
    assert_allclose(block_residuals(gone, gone.stages[0])[5], 0)
    assert gone.check().block_residual <= LINEAR_TOLERANCE
    assert gone.stages[0].total_load[1] == pytest.approx(-11 * 26e3)
    # its weight is missing from the balance, over the rest of loads and reactions
    right = np.hypot(26e3, 1e5)
    assert gone.check().balance == pytest.approx(26e3 / (8 * 26e3 + 3 * right + magnitude(good)), rel=1e-9)


def magnitude(found):
    return np.hypot(*found.stages[0].reactions[:, :2].T).sum()


def test_the_worst_stage_counts_also_where_it_is_not_a_number():
    good = results()
    bad = changed_contact(good, "normal_force", 3, np.nan)
    for stages in (good.stages + bad.stages, bad.stages + good.stages):
        check = dataclasses.replace(good, stages=stages).check()
        assert check.block_residual == np.inf
        assert not check.ok
