"""Water on blocks with zones that displace by much: it presses where their faces are."""

from __future__ import annotations

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.solve.zones import following
from bsm_mesh.solve.zones.large_water import water_near
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.supports import nodal_unknowns
from tests.scenes import meeting_zones as meeting
from tests.scenes.large_zones import bolted
from tests.scenes.shaken_zones import unwatched
from tests.scenes.shapes import rectangle

UNIT = 9810.0  # N/m3


def level(y):
    """Return water whose table is level."""
    return bsm.Water(table=[(-9.0, y), (9.0, y)])


@pytest.mark.heavy
@pytest.mark.parametrize("order", [1, 2])
def test_a_block_that_falls_into_water_is_lighter_by_it(order):
    """Archimedes: above the table it has its weight, and on the floor less that of the water beside it."""
    results = bsm.run(meeting.dropped(young=1e11, size=1.0, order=order, gap=0.05, water=level(0.04)))
    assert results.status == "stable", results.stages[0].reason
    assert results.check().ok
    stage = results.stages[0]
    deep = 0.04 - 0.05 - stage.displacement[1, 1]
    assert deep > 0.03
    assert_allclose(meeting.force_between(results), meeting.WEIGHT - UNIT * deep, rtol=1e-6)
    assert_allclose(stage.water[1, 1], UNIT * deep, rtol=1e-5)


@pytest.mark.heavy
def test_rock_deep_in_water_has_the_stress_of_its_buoyant_weight():
    """That is its effective stress; the total one has the water's pressure as well."""
    results = bsm.run(meeting.dropped(young=1e9, size=0.5, water=level(5.0)))
    stage = results.stages[0]
    carried = meeting.WEIGHT - UNIT
    assert_allclose(meeting.force_between(results), carried, rtol=1e-5)  # its volume changes by 2e-5
    assert_allclose(stage.stress_effective[1, 1, 1], -carried / 2, rtol=1e-4)  # half of it at mid-height
    middle = 5.0 - 0.5 - 0.02 - stage.displacement[1, 1]
    assert_allclose(stage.stress[1, 1, 1] - stage.stress_effective[1, 1, 1], -UNIT * middle, rtol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 4])
def test_stiff_blocks_that_meet_in_water_rest_as_rigid_ones(seed, tmp_path):
    """Under an inclined table that crosses them; the certificate finds its water on their outlines."""
    model = meeting.row(seed, smooth=True).replace(water=bsm.Water(table=[(-5.0, 0.4), (8.0, 1.4)]))
    zones, rigid = bsm.run(model), bsm.run(meeting.rigid(model))
    assert zones.status == rigid.status == "stable"
    one, other = (results.stages[0] for results in (zones, rigid))
    assert_allclose(one.displacement, other.displacement, atol=1e-4 * np.abs(other.displacement).max())
    assert_allclose(one.water, other.water, atol=1e-4 * np.abs(other.water).max())
    verify = [sys.executable, "-m", verify_certificate.__name__, zones.save(tmp_path / "out")]
    done = subprocess.run(verify, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_a_bolted_block_slides_in_water_as_a_rigid_one():
    """By a third of its length, through the table."""
    model = bolted().replace(water=level(0.3))
    rigid = model.replace(rocks=[dataclasses.replace(model.rocks[0], zones=None, young=None, poisson=None)])
    one, other = (bsm.run(each).stages[0] for each in (model, rigid))
    assert one.status.value == other.status.value == "stable"
    assert_allclose(one.displacement[1, :2], other.displacement[1, :2], rtol=1e-5)
    assert_allclose(one.bolts.axial_force, other.bolts.axial_force, rtol=1e-5)


@pytest.mark.heavy
def test_a_table_that_rises_acts_in_its_stage():
    """From dry to wet and back: the block is where it was."""
    stages = [bsm.Stage(name="wet", water=level(5.0)), bsm.Stage(name="dry", water=level(-5.0))]
    results = bsm.run(meeting.dropped(young=1e9, size=1.0, stages=stages))
    assert results.status == "stable"
    pressed = [np.abs(stage.contacts.normal_force).sum() for stage in results.stages]
    assert_allclose(pressed, [meeting.WEIGHT, meeting.WEIGHT - UNIT, meeting.WEIGHT], rtol=1e-5)
    first, _, last = (stage.displacement for stage in results.stages)
    assert_allclose(last, first, atol=1e-4 * np.abs(first).max())


def test_a_column_that_water_alone_rights_rests_at_its_tilt():
    """It leaves its heel. With water that does not change as it tilts it would have no equilibrium."""
    table = [(-9.0, 2.945), (-1.0, 2.945), (0.0, 0.052), (9.0, 0.052)]
    polygons = [rectangle(-9, -2, 9, 0), rectangle(-1, 0, 0, 4.093)]
    model = meeting.meeting(polygons, friction=78.0, kn=1e12, size=4.0, water=bsm.Water(table=table))
    zones, rigid = bsm.run(model), bsm.run(meeting.rigid(model))
    assert zones.status == "stable", zones.stages[0].reason
    assert zones.check().ok
    tilt = zones.stages[0].displacement[1, 2]
    assert tilt < -3e-3
    assert_allclose(tilt, rigid.stages[0].displacement[1, 2], rtol=1e-2)


def test_the_stiffness_of_the_water_is_the_derivative_of_its_forces():
    """Of the forces on a whole block, as it moves and turns."""
    run = unwatched(meeting.dropped(young=1e10, size=1.0, water=level(0.6)))._run
    of, u, present = run.of, run.state.u, np.ones(2, dtype=bool)
    given = of.basis.doflocs[:, nodal_unknowns(of.basis)[:, 0]].T
    x, y = (given - of.model.blocks.moments.centroid[1]).T
    unknowns = nodal_unknowns(of.basis)
    on = np.isin(unknowns[:, 0], of.basis.element_dofs[:, of.mesh.block == 1])
    modes = np.zeros((3, len(u)))
    for mode, (dx, dy) in zip(modes, ((1, 0), (0, 1), (-y, x)), strict=True):
        mode[unknowns[on]] = np.stack([dx * on, dy * on], axis=1)[on]
    near, step = water_near(run, u, present), 1e-5
    up, down = ([water_near(run, u + way * step * mode, present).force for mode in modes] for way in (1, -1))
    found = (np.array(down) - np.array(up)) / (2 * step) @ modes.T
    assert_allclose(modes @ near.stiffness @ modes.T, found.T, atol=1e-4 * UNIT)


def test_water_is_that_where_blocks_are_in_every_window_of_motion(monkeypatch):
    """A block falls into water onto a floor: at the begin of each window it displaces the water around it."""
    table, gap = 0.07, 0.09  # m
    model, found, go_on = meeting.dropped(young=1e10, gap=gap, water=level(table)), [], following.go_on

    def watched(motion):
        equations, u = motion.equations, motion.at.u
        deep = max(0.0, table - gap - u[above].mean())
        found.append((deep, equations.load_at(u)[above].sum()))
        go_on(motion)

    run = unwatched(model)._run
    of, present = run.of, np.ones(2, dtype=bool)
    above = nodal_unknowns(of.basis)[:, 1]
    above = above[np.isin(above, of.basis.element_dofs[:, of.mesh.block == 1])]
    monkeypatch.setattr(following, "go_on", watched)
    following.follow(run, run.equations(present, run.loads_on(present)), present)
    deep, force = np.array(found).T
    assert deep[0] == 0.0
    assert len(set(deep.round(3))) > 3
    assert deep[-1] == pytest.approx(table, rel=1e-2)
    assert_allclose(force, UNIT * deep - meeting.WEIGHT, rtol=1e-5)


def test_water_that_changes_between_parts_of_the_load_is_counted_once(monkeypatch):
    """A block sinks into water on a soft joint. At once no equilibrium is found here, so parts of the load follow."""
    soft, table = 1e5, 0.2  # N/m3, m
    model = meeting.dropped(young=1e10, gap=0.0, kn=soft, water=level(table))
    settled, parts = StageRun.settled, []

    def not_at_once(run, equations, present):
        equations, at, converged = settled(run, equations, present)
        parts.append(at.u)
        return equations, at, converged and len(parts) > 1

    monkeypatch.setattr(StageRun, "settled", not_at_once)
    results = bsm.run(model)
    assert results.status == "stable", results.stages[0].reason
    assert len(parts) == 5
    sunk = (meeting.WEIGHT - UNIT * table) / (soft + UNIT)
    assert_allclose(-results.stages[0].displacement[1, 1], sunk, rtol=1e-5)
    assert results.check().ok
