"""The implicit integrator of shaken stages: its equations, laws, bolts, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.step.equations import StepEquations
from tests.scenes.models import model_of
from tests.scenes.shaken import STAGE, quake, shaken, wall
from tests.scenes.shapes import rectangle, square
from tests.unit.test_shaken_stage import BOLT, HARD, UP, roof, wall_of

IMPLICIT = replace(HARD, record=quake(5.0, 1.0), integrator="implicit", time_step=0.1)


def shaken_again(model, shaking):
    return bsm.run(model.replace(stages=[bsm.Stage(name=STAGE, shaking=shaking)])).stages[-1]


def test_inertia_takes_the_place_of_the_regularisation():
    """Without contact a block moves by its weight over the inertia, from the reference."""
    loop = Continuation(model_of([square(0, 0), square(0, 3)]), Options(), lambda *_: None)
    system = loop.system
    contacts = system.gather(loop.begin.history, system.start, first=False)
    step = StepEquations(system, loop.factors, contacts, system.start, 0.0)
    inertia, reference = np.full_like(system.start, 1e6), np.full_like(system.start, 1e-3)
    inertial = step.with_inertia(inertia, reference)
    there = reference + system.loads / inertia
    assert_allclose(inertial.residual_at(there).forces, 0.0, atol=1e-9)
    assert_array_equal(inertial.updated(contacts, there).regularization_reference, reference)
    assert_array_equal(step.updated(contacts, there).regularization_reference, there)
    assert_array_equal(inertial.searched, system.start)


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["softening", "patton", "closure", "dilation", "tension"])
def test_energies_balance_under_laws(name):
    """Softening contacts that fail lose strength at once: time steps have a solution all the same."""
    stage = shaken_again(wall_of(name), IMPLICIT)
    assert stage.status == "stable"
    assert stage.shaking.imbalance < 1e-2
    assert_allclose(stage.shaking.slip_energy.sum(), stage.shaking.energy[-1, 5])


@pytest.mark.slow
def test_energies_balance_with_bolts_and_dashpots():
    damped = replace(IMPLICIT, record=quake(5.0, 1.5), contact_damping=0.3, mass_damping=(0.05, 2.0))
    stage = bsm.run(wall(damped, courses=5, bricks=1, bolts=[bsm.Bolt(**BOLT)])).stages[-1]
    assert stage.status == "stable"
    assert stage.shaking.imbalance < 1e-2
    assert (stage.shaking.energy[-1, 6:8] > 0).all()
    assert np.abs(stage.shaking.energy[:, 4]).max() > 0


@pytest.mark.heavy
def test_the_others_are_shaken_on_without_what_came_down():
    shaking = replace(UP, integrator="implicit", time_step=0.1, contact_damping=0.2)
    results = bsm.run(roof(shaking), bsm.Options(falls=bsm.Falls(on_fall="remove")))
    stage = results.stages[-1]
    assert results.status == "stable_after_falls"
    assert [fall.block for fall in stage.falls] == [2]
    assert stage.shaking.time[-1] == 3.0


def test_results_come_back_from_their_folder(tmp_path):
    results = bsm.run(wall(replace(IMPLICIT, every=0.25), courses=2, bricks=2))
    results.save(tmp_path / "out")
    again = bsm.Results.load(tmp_path / "out").stages[-1].shaking
    assert_array_equal(again.energy, results.stages[-1].shaking.energy)
    assert again.cycles == results.stages[-1].shaking.cycles


@pytest.mark.slow
def test_it_gives_up_where_contacts_bounce():
    """Without dashpots two bricks on soft joints chatter, and their impacts cannot balance as closely as is asked."""
    sine = bsm.Shaking(waveform="sine", frequency=5.0, amplitude=15.0, cycles=2, every=0.05)
    shaking = replace(sine, integrator="implicit", time_step=0.1)
    bricks = [rectangle(-2, -1, 3, 0), rectangle(0, 0, 1, 0.5), rectangle(0.02, 0.5, 1.02, 1)]
    asked = [shaking, replace(shaking, max_imbalance=1e-6), replace(shaking, max_imbalance=1e-6, contact_damping=0.3)]
    good, bounces, damped = (bsm.run(shaken(bricks, one, friction=30, kn=3e6)).stages[-1] for one in asked)
    assert good.status == "stable"
    assert bounces.status == "not_converged"
    assert "contacts bounce where the blocks at (" in bounces.reason
    assert "more than the explicit integrator takes; set contact_damping" in bounces.reason
    assert bounces.shaking.time[-1] < 0.4
    assert "gives up" not in damped.reason


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"integrator": "newmark"}, "integrator = 'newmark' is unknown"),
        ({"integrator": "implicit", "quiet": ["a"]}, "quiet boundaries need integrator = 'explicit'"),
        ({"integrator": "implicit", "mass_scaling": 2.0}, "mass_scaling has no use with integrator = 'implicit'"),
    ],
)
def test_faults_are_said(given, fault):
    with pytest.raises(bsm.ModelError, match=fault):
        bsm.Shaking(waveform="sine", frequency=2.0, amplitude=3.0, **given)


def test_dashpots_need_linear_springs():
    with pytest.raises(bsm.ModelError, match=r"needs linear springs, and joint 'J' has max_closure"):
        shaken_again(wall_of("closure"), replace(IMPLICIT, contact_damping=0.2))
