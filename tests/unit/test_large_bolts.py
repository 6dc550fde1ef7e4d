"""Bolts in zones that displace by much: they turn with their ends, slip and yield."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.tangent import bolt_tangent
from tests.scenes.large_zones import bolted, bolted_exact
from tests.scenes.shaken_zones import unwatched
from tests.scenes.shapes import rectangle, turned


def slid(model, degrees=0.0):
    """Return how far the block slides, how far it turns, and the tension of its bolt, where it is at rest."""
    results = bsm.run(model)
    assert results.status == "stable", results.stages[-1].reason
    assert results.check().ok
    stage = results.stages[-1]
    moved = turned(stage.displacement[1:, :2], 30.0 - degrees)[0]
    return moved[0], stage.displacement[1, 2], stage.bolts.axial_force[-1]


@pytest.mark.parametrize(("degrees", "order"), [(0.0, 1), (37.0, 1), pytest.param(0.0, 2, marks=pytest.mark.heavy)])
def test_a_bolt_turns_as_its_block_slides(degrees, order):
    """By half a metre: the tension along the slope balances the weight."""
    moved, rotation, tension = slid(bolted(degrees, order=order), degrees)
    assert_allclose((moved, tension), bolted_exact(), rtol=1e-6)
    assert abs(rotation) < 1e-6


@pytest.mark.heavy
def apex(displacement):
    """Return a triangle that stands on its apex, held by two bolts to the walls beside it."""
    walls = [rectangle(-4, -1, 4, 0), rectangle(-4, 0, -2, 3), rectangle(2, 0, 4, 3)]
    zones = bsm.Zones(size=1.0, displacement=displacement)
    ties = [bsm.Bolt(start=(3 * s, 1.5), end=(0.3 * s, 1.5), diameter=0.025, kind="end_anchored") for s in (-1, 1)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([*walls, [(0, 0), (1, 2), (-1, 2)]], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=25e3, young=2e9, poisson=0.2, zones=zones)],
        joints=[bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=45))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 1, 2])],
        bolts=ties,
    )


def test_a_block_that_bolts_alone_keep_from_falling_over_has_a_certificate(tmp_path, capsys):
    """Their stiffness is in it: no direction in which blocks fall."""
    results = bsm.run(apex("large"))
    assert results.status == "stable"
    assert verify_certificate.main(results.save(tmp_path / "out")) == 0, capsys.readouterr().out


@pytest.mark.parametrize("displacement", ["small", "large"])
def test_the_stiffness_of_bolts_in_a_certificate_is_that_between_rigid_blocks(displacement):
    """Of blocks that hardly deform, with the turning of bolts under their tension."""
    walls = [rectangle(-3, -1, 5, 0), rectangle(-2, 0, 0, 3), rectangle(0, 0, 1, 3)]
    zones = bsm.Zones(size=1.0, order=1, displacement=displacement)
    tie = bsm.Bolt(start=(-1.6, 2.7), end=(0.8, 2.3), diameter=0.025, kind="end_anchored", pretension=1e5)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(walls, rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=25e3, young=1e14, poisson=0.2, zones=zones)],
        joints=[bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=45))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 1])],
        bolts=[tie],
    )
    stage = bsm.run(model).stages[0]
    position = stage.origin + stage.displacement
    rigid = InstalledBolts.of(model, np.zeros((3, 3)))
    exact = whole(*bolt_tangent(rigid, rigid.evaluate(position), turning=True))
    found = whole(stage.evidence.bolt_pair, stage.evidence.bolt_tangent)
    assert_allclose(found, exact, atol=1e-4 * np.abs(exact).max())
    assert np.abs(found).max() > 1e7


def whole(pair, blocks):
    """Return a matrix of three blocks as one."""
    found = np.zeros((9, 9))
    for (row, column), block in zip(pair, blocks, strict=True):
        found[3 * row : 3 * row + 3, 3 * column : 3 * column + 3] += block
    return found


def test_small_displacements_do_not_judge_a_block_on_a_corner():
    stage = bsm.run(apex("small")).stages[0]
    said = "block 3 touches block 0 with a corner alone, where zones in small displacement have no contact"
    assert stage.status == "not_converged"
    assert stage.reason.startswith(said)
    assert any(note.startswith(said) for note in stage.notes)


def test_a_bolt_of_a_later_stage_has_no_tension_before():
    """Its block hangs on a first bolt; another one at the same place carries a part of the load that is added."""
    model = bolted()
    later = dataclasses.replace(model.bolts[0], stage="later", name="second")
    push = turned(np.array([(1e4, 0.0)]), -30.0)[0]
    loads = [bsm.PointLoad(block=1, point=tuple(turned(np.array([(0.0, 0.5)]), -30.0)[0]), force=tuple(push))]
    first, _, tension = slid(model.replace(bolts=[model.bolts[0], later], stages=[bsm.Stage(name="later")]))
    assert_allclose(tension, 0.0, atol=1.0)
    then, _, more = slid(model.replace(bolts=[model.bolts[0], later], stages=[bsm.Stage(name="later", loads=loads)]))
    assert then > first + 0.01
    assert more > 1e3


@pytest.mark.heavy
def test_energies_balance_while_a_bolted_block_is_shaken():
    """It slides up and down the slope by centimetres, and the bolt turns; then it is at rest."""
    shaking = bsm.Shaking(waveform="sine", frequency=2.0, cycles=2, amplitude=1.0, duration=1.2, every=0.05)
    stages = [bsm.Stage(name="quake", shaking=dataclasses.replace(shaking, mass_damping=(0.2, 1.0)))]
    stage = bsm.run(bolted(young=1e9, kn=1e9, friction=10.0, stages=stages)).stages[-1]
    assert stage.shaking.imbalance < 1e-3
    assert stage.shaking.peak_velocity[1] > 0.05
    assert stage.status.value == "stable", stage.reason


def test_the_tangent_with_bolts_is_the_derivative_of_the_forces():
    stages = unwatched(bolted(young=1e9))
    stages.solution(0, None, None)()
    run = stages._run
    present = run.of.presence[0]
    equations = run.equations(present, run.loads_on(present))
    u, step, free = run.state.u, 1e-6, equations.free.free
    at = equations.at(u, equations.free.none)
    assert (at.bolts.tension > 0).all()
    K = (
        equations.tangent(at, 0.0)
        - equations.large.tangent(
            u, equations.joints, at.state, equations.joints.stiffness(at.state, equations.history, 1e-9)
        )
    ).toarray()
    assert np.abs(K).max() > 1e4
    for k in np.flatnonzero(np.abs(K).max(axis=0) > 0):
        d = np.zeros_like(u)
        d[free[k]] = step
        up, down = (equations.bolts.forces(equations.bolts.evaluate(v))[free] for v in (u + d, u - d))
        assert_allclose((down - up) / (2 * step), K[:, k], atol=1e-8 * np.abs(K).max())
