"""Rock that yields in large displacement: objectivity, tangent, and loads in closed form."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.scheme import zoned
from bsm_mesh.solve.zones.stage_run import StageRun
from tests.scenes import meeting_zones as meeting
from tests.scenes.hoek_brown_hole import HoekBrownHole
from tests.scenes.plastic_zones import Hole, footing, in_large_displacement, slope, strut
from tests.scenes.shapes import turned

STEP = 1e-9  # m, of differences: so few points pass from one face of the yield surface to another


def equations_of(model):
    """Return the equations of a model without joints, and where its unknowns x, y of nodes are."""
    of = zoned(model, bsm.Options())
    run = StageRun(of, nominal_constants(model).stiffness[of.mesh.block])
    there = np.ones(model.blocks.count, dtype=bool)
    return run.equations(there, run.loads_on(there)), of.basis.doflocs


def strained(place, by=5e-4):
    """Return displacements (N,) that squeeze nodes upright, and shear and bend them some, more than the rock bears."""
    x, y = place
    u = np.zeros(place.shape[1])
    u[0::2], u[1::2] = (by * (x * y - 0.3 * y))[0::2], (by * (x * x - 2 * y))[1::2]
    return u


def turning(place, u, degrees):
    """Return displacements u (N,) of nodes that turn as a whole besides."""
    where = place[:, 0::2].T + u.reshape(-1, 2)
    return (turned(where, degrees) - place[:, 0::2].T).ravel()


ROCKS = [strut(1.0), in_large_displacement(slope(dilation=5.0)), in_large_displacement(HoekBrownHole().model(2, 2))]


@pytest.mark.parametrize("degrees", [37, 90, 180])
@pytest.mark.parametrize("rock", ROCKS)
def test_rock_that_yielded_and_turns_as_a_whole_keeps_its_stress(rock, degrees):
    """Its forces turn with it, and it yields further there as it does where it was."""
    equations, place = equations_of(rock)
    first, more = strained(place), strained(place, by=8e-4)
    before = equations.at(first, equations.free.none)
    assert before.plastic.yields.any()
    kept = equations.after(before, None)
    for u in (first, more):
        one, other = (kept.at(v, kept.free.none) for v in (u, turning(place, u, degrees)))
        relief = np.abs(one.plastic.relief).max()
        assert_allclose(other.plastic.relief, one.plastic.relief, atol=1e-9 * relief)
        forces = [(kept.load - each.residual).reshape(-1, 2) for each in (one, other)]
        assert_allclose(forces[1], turned(forces[0], degrees), atol=1e-9 * np.abs(forces[0]).max())
    assert not np.allclose(one.plastic.relief, before.plastic.relief, rtol=0.1)


def test_the_tangent_is_the_derivative_where_rock_yields_and_turned():
    equations, place = equations_of(strut(1.0, order=1, friction=20.0, dilation=5.0))
    u = turning(place, strained(place), 40.0)
    at = equations.at(u, equations.free.none)
    assert at.plastic.yields.any()
    K, free = equations.tangent(at, 0.0).toarray(), equations.free.free
    turn = np.eye(len(u)) if equations.free.turn is None else equations.free.turn.toarray()

    def forces(v):
        return equations.at(v, equations.free.none).left

    columns = [(forces(u - STEP * d) - forces(u + STEP * d)) / (2 * STEP) for d in turn.T[free]]
    assert_allclose(np.stack(columns, axis=1), K, atol=1e-5 * np.abs(K).max())


def yields_at_its_load(degrees):
    """2 c cos(phi) / (1 - sin(phi)); beyond it there is no equilibrium."""
    assert bsm.run(strut(0.995, degrees=degrees)).status == "stable"
    above = bsm.run(strut(1.005, degrees=degrees)).stages[0]
    assert above.status == "not_converged"
    assert "whose rock yields" in above.reason


@pytest.mark.heavy
def test_a_strut_carries_the_load_at_which_it_yields():
    yields_at_its_load(0.0)


@pytest.mark.heavy
def test_so_it_does_where_all_is_turned():
    yields_at_its_load(37.0)


@pytest.mark.heavy
@pytest.mark.parametrize("hole", [Hole(), HoekBrownHole()])
def test_a_hole_in_stiff_rock(hole):
    """Salencon's, and Carranza-Torres's of Hoek-Brown: small and large displacement agree, within .5 % of the form."""
    stiff = [dataclasses.replace(hole.rock(2, 30.0), young=1e3 * hole.young)]
    small = hole.model(24, 12).replace(rocks=stiff)
    one, other = (bsm.run(model).stages[-1] for model in (small, in_large_displacement(small)))
    assert other.status == "stable"
    stress, radius, _ = hole.errors(other.zones)
    assert stress < 5e-3
    assert abs(radius) < 5e-3
    assert_allclose(other.displacement, one.displacement, atol=1e-3 * np.abs(one.displacement).max())
    assert_allclose(other.zones.plastic_strain, one.zones.plastic_strain, atol=1e-3 * one.zones.plastic_strain.max())


@pytest.mark.slow
def test_strip_footing():
    """Clay carries (2 + pi) c within 1 %, as in small displacement."""
    results = bsm.run(in_large_displacement(footing([0.7, 0.95, 0.99, 1.01])))
    assert [stage.status.value for stage in results.stages] == ["stable", "stable", "stable", "not_converged"]


def test_strains_that_are_not_small_are_noted():
    soft, stiff = (bsm.run(strut(0.9, young=young)).stages[0] for young in (4e6, 1e9))
    assert "strain by" in soft.notes[-1]
    assert not any("strain by" in note for note in stiff.notes)


@pytest.mark.heavy
def test_a_stage_after_rock_yielded_begins_with_its_stress():
    """Unloaded and loaded again it is as before, and the certificate holds."""
    results = bsm.run(in_large_displacement(footing([0.9, 0.6, 0.9], size=0.6)))
    first, _, last = results.stages
    assert results.status == "stable"
    assert results.check().ok
    assert first.zones.yielded.any()
    assert_allclose(last.zones.plastic_strain, first.zones.plastic_strain, atol=1e-6 * first.zones.plastic_strain.max())
    assert_allclose(last.displacement, first.displacement, atol=1e-6 * np.abs(first.displacement).max())


def yields(model, cohesion):
    """Return a model whose rock yields in tension and shear."""
    law = {"cohesion": cohesion, "friction": 0.0, "tensile_strength": cohesion}
    zones = dataclasses.replace(model.rocks[0].zones, law="mohr_coulomb")
    return model.replace(rocks=[dataclasses.replace(model.rocks[0], zones=zones, **law)])


def test_a_block_that_yields_falls_onto_the_floor():
    """It is followed there, and equilibrium with yielding is found."""
    results = bsm.run(yields(meeting.dropped(young=1e9, size=0.5), 1e4))
    assert results.status == "stable", results.stages[0].reason
    assert results.check().ok
    assert results.stages[0].zones.yielded.any()
    assert_allclose(meeting.force_between(results), meeting.WEIGHT, rtol=1e-6)


@pytest.mark.heavy
def test_the_given_geometry_proves_nothing_of_blocks_that_moved():
    """A column that leans on its neighbour carries its weight, unless it crushes: that no forces on faces show."""
    strong, weak = (bsm.run(yields(meeting.leaning(young=1e10), cohesion)).stages[0] for cohesion in (1e7, 1e4))
    assert strong.status == "stable"
    assert weak.status == "not_converged"
    assert "whose rock yields" in weak.reason
    assert "they move before" in weak.reason
