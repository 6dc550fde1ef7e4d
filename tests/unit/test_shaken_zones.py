"""Zones that are shaken: compiled forces against exact ones, closed forms, energies, verdicts, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.results.shaking import ENERGIES
from tests.scenes.quiet import velocities
from tests.scenes.shaken import LAWS, quake
from tests.scenes.shaken_zones import (
    PILE,
    STAGE,
    STILL,
    WEIGHT,
    at_displacements,
    bar,
    column,
    newmarks_block,
    passed,
    shaken_zones,
    started,
    through_a_joint,
)
from tests.scenes.shapes import rectangle, turned

FRICTION = bsm.MohrCoulomb(friction=35.0)
JOINTS = {
    "elastic": {},
    "cohesion": {"law": bsm.MohrCoulomb(friction=35.0, cohesion=1e5), "tensile_strength": 2e4},
    "Patton": {"law": bsm.Patton(friction=30, dilation=10, cohesion=5e4, residual_friction=30)},
    "closure": {"law": FRICTION, "max_closure": 1e-3},
    "growing": {"law": FRICTION, "reference_stress": 1e5, "shear_stiffness_exponent": 0.5},
}


def shaking(**given):
    usual = {"waveform": "sine", "frequency": 2.0, "amplitude": 3.0, "cycles": 2, "every": 0.02}
    return bsm.Shaking(**{**usual, **given})


@pytest.mark.parametrize("displacement", ["small", "large"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", JOINTS)
def test_compiled_forces_are_those_of_the_equations(name, order, displacement):
    """After one short cycle from rest the velocities are the forces over the masses."""

    def moved(place, block):
        random = np.random.default_rng(1)
        return 1e-4 * random.standard_normal((4, 2))[block] + 1e-5 * random.standard_normal(place.shape)

    zones = bsm.Zones(size=0.7, order=order, displacement=displacement)
    model = shaken_zones(PILE, STILL, joint=bsm.Joint("J", 1e9, 5e8, **JOINTS[name]), zones=zones, young=1e9)
    motion = at_displacements(model, moved)
    rock, residual = motion._rock, motion.at.residual
    motion.go_on(1e-3 * motion.memory.stable)
    forces = motion.memory.velocity / motion.memory.time_step * rock.mass[:, None]
    exact = rock.projected(rock.on_nodes(residual))
    assert motion.memory.cycles == 1
    assert_allclose(forces, exact, atol=3e-7 * np.abs(exact).max())


@pytest.mark.heavy
@pytest.mark.parametrize("order", [1, 2])
def test_a_bar_on_a_base_that_starts_moves_as_its_waves_do(order):
    found, exact, stage = started(order)
    assert_allclose(found, exact, atol=1e-3 * np.abs(exact).max())
    assert stage.shaking.imbalance < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [0.0, 37.0])
def test_newmarks_block_slides_over_zones(degrees):
    model, exact = newmarks_block(degrees=degrees, how={"direction": degrees})
    results = bsm.run(model)
    stage = results.stages[-1]
    assert results.status == "stable"
    along, across = turned(stage.stage_displacement[1, :2], -degrees)
    assert_allclose([along, across], [-exact, 0.0], rtol=3e-3, atol=1e-7)
    energy = dict(zip(ENERGIES, stage.shaking.energy[-1], strict=True))
    assert_allclose([energy["input"], energy["slip"]], 0.2 * WEIGHT / 2 * exact, rtol=3e-3)
    assert stage.shaking.imbalance < 1e-4
    assert "energy balance" in " ".join(stage.notes)


@pytest.mark.slow
@pytest.mark.parametrize(("direction", "name"), [(0, "u"), (90, "v")])
def test_a_quiet_end_lets_a_wave_out(direction, name):
    model, speed, _ = column(direction)
    results = bsm.run(model)
    assert results.status == "stable", results.stages[-1].reason  # nothing loads it before
    found = results.stages[-1].shaking
    time, velocity = velocities(results, name)
    assert velocity.max() == pytest.approx(0.01, rel=0.05)  # means over a block and between two times
    assert np.abs(velocity[time > passed(speed)]).max() < 1e-3 * velocity.max()
    energy = dict(zip(ENERGIES, found.energy[-1], strict=True))
    assert energy["quiet"] == pytest.approx(energy["input"], rel=1e-3)
    assert found.imbalance < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("direction", "name"), [(0, "u"), (90, "v")])
def test_an_elastic_joint_lets_through_what_its_stiffness_says(direction, name):
    stiffness = 2e9
    model, speed, density = column(direction, joint=(stiffness, 12.0))
    time, velocity = velocities(bsm.run(model), name)
    exact = through_a_joint(model, time, stiffness, speed, density)
    assert_allclose(velocity, exact, atol=0.01 * np.abs(exact).max())


HARD = bsm.Shaking(record=quake(10.0, 1.0), every=0.05)  # half of g
SMALL = bsm.Zones(size=1.0)
LARGE = bsm.Zones(size=1.0, displacement="large")


@pytest.mark.heavy
@pytest.mark.parametrize("name", LAWS)
def test_energies_balance_under_every_law(name):
    model = shaken_zones(PILE, HARD, joint=bsm.Joint("J", 1e9, 1e9, **LAWS[name]), zones=LARGE, young=1e9)
    stage = bsm.run(model).stages[-1]
    energy = dict(zip(ENERGIES, stage.shaking.energy[-1], strict=True))
    assert stage.status == "stable"
    assert stage.shaking.imbalance < 5e-3
    assert energy["slip"] > 0.25 * energy["input"] > 0
    assert_allclose(stage.shaking.slip_energy.sum(), energy["slip"])


@pytest.mark.heavy
@pytest.mark.parametrize("damping", [0.3, "housner"])
def test_dashpots_of_joints_take_energy(damping):
    how = {"contact_damping": damping, "every": 0.1}
    model = shaken_zones(PILE, replace(HARD, **how), joint=bsm.Joint("J", 1e8, 1e8), zones=SMALL, young=1e8)
    found = bsm.run(model).stages[-1].shaking
    energy = dict(zip(ENERGIES, found.energy[-1], strict=True))
    assert found.imbalance < 5e-3
    assert energy["dashpots"] > 0.9 * energy["input"] > 0


@pytest.mark.heavy
@pytest.mark.parametrize("bolt", [{}, {"bond_strength": 2e4}, {"kind": "end_anchored", "pretension": 2e4}])
def test_bolts_water_and_an_excavated_stage_before(bolt):
    """Slip of less than a hundredth of a block stretches the bolt, which is inclined."""
    model = shaken_zones(
        PILE,
        bsm.Shaking(record=quake(9.0, 1.0), every=0.1),
        joint=bsm.Joint("J", 1e9, 1e9, law=FRICTION),
        zones=SMALL,
        young=1e9,
        bolts=[bsm.Bolt(start=(0.3, 0.8), end=(0.7, -0.8), diameter=0.02, stage="cut", **bolt)],
        water=bsm.Water(table=[(-2, 0.4), (3, 0.4)]),
        before=[bsm.Stage(name="cut", excavate=[3])],
    )
    results = bsm.run(model)
    found = results.stages[-1].shaking
    assert [stage.status.value for stage in results.stages] == ["stable"] * 3
    assert found.imbalance < 5e-3
    assert np.abs(found.energy[:, ENERGIES.index("bolts")]).max() > 0
    assert found.peak_velocity[3] == 0  # it is gone
    assert results.check().ok


@pytest.mark.heavy
def test_water_in_joints_does_work():
    water = bsm.Water(table=[(-2, 0.4), (3, 0.4)], joint_pressure={"J": 8e3})
    given = {"joint": bsm.Joint("J", 1e8, 1e8, law=FRICTION), "zones": SMALL, "young": 1e9, "water": water}
    results = bsm.run(shaken_zones(PILE, bsm.Shaking(record=quake(6.0, 1.0), every=0.1), **given))
    found = results.stages[-1].shaking
    assert results.status == "stable"
    assert found.imbalance < 1e-4


def test_every_block_has_its_peak_velocity():
    """Blocks without joints share all nodes of their zones: those of a row move much alike."""
    hit = shaking(direction=90.0, amplitude=0.1, cycles=1)
    grid = [rectangle(x, y, x + 1, y + 1) for y in range(3) for x in range(4)]
    blocks = bsm.Blocks.from_polygons(grid, rock="rock").with_boundary("foot", lambda x, y: np.abs(y) < 1e-9)
    model = bar(hit, 3.0, 3, zones=bsm.Zones(size=2.0, order=1), young=1e8).replace(blocks=blocks)
    rows = bsm.run(model).stages[-1].shaking.peak_velocity.reshape(3, 4)
    assert (rows.min(axis=1) > 0.95 * rows.max(axis=1)).all()  # but for the triangles at both sides
    assert (np.diff(rows[:, 0]) > 0).all()


def test_the_peak_acceleration_is_that_of_a_rigid_block():
    """A block on springs, on a base that shakes up and down: stiff zones follow the rigid block."""
    hit = shaking(direction=90.0, frequency=5, cycles=1)
    polygons = [rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)]
    joint = bsm.Joint("J", 1e7, 1e7, law=FRICTION)
    model = shaken_zones(polygons, hit, joint=joint, zones=bsm.Zones(size=1.0, order=1), young=1e9)
    rigid = model.replace(rocks=[bsm.Rock("rock", unit_weight=WEIGHT, young=1e9, poisson=0.2)])
    found, expected = (bsm.run(each).stages[-1].shaking.peak_acceleration[1] for each in (model, rigid))
    assert expected > 1.5 * BaseMotion(hit).peaks[0]
    assert_allclose(found, expected, rtol=2e-3)


@pytest.mark.slow
def test_the_peak_acceleration_of_a_block_that_slides_is_that_of_friction():
    """Friction of .2 gives a block no more than .2 g; its nodes have more."""
    model, _ = newmarks_block(zones=bsm.Zones(size=1.0, order=1, displacement="large"), how={"contact_damping": 0.2})
    found = bsm.run(model).stages[-1].shaking
    assert_allclose(found.peak_acceleration[1], 0.2 * GRAVITY, rtol=0.02)


@pytest.mark.parametrize("zones", [SMALL, LARGE])
def test_nothing_moves_what_nothing_shakes(zones):
    still = replace(STILL, duration=0.02, every=0.02)
    model = shaken_zones(PILE, still, zones=zones, young=1e9, in_situ=bsm.InSitu(stress={"yy": -1e4, "xx": -1e4}))
    stage = bsm.run(model).stages[-1]
    assert stage.status == "stable"
    assert_allclose(stage.stage_displacement, 0.0, atol=1e-9)
    assert stage.shaking.imbalance == 0


def bonded(zones):
    """Return a block on a slope of 30 degrees that its cohesion holds until it is shaken."""
    slope = [turned(polygon, 30.0) for polygon in (rectangle(-8, -1, 1, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    joint = bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=20, cohesion=6e3, residual_friction=15))
    return shaken_zones(slope, bsm.Shaking(record=quake(6.0, 1.0), every=0.1), joint=joint, zones=zones, young=1e9)


@pytest.mark.slow
def test_a_block_that_slides_on_is_named():
    results = bsm.run(bonded(LARGE))
    stage = results.stages[-1]
    assert stage.status == "unstable"
    assert stage.reason == "after the shaking blocks moved on by more than their size"
    assert stage.unstable_blocks.tolist() == [1]
    assert "these were shaken" in stage.proof.text


@pytest.mark.slow
def test_small_displacements_do_not_follow_it():
    stage = bsm.run(bonded(SMALL)).stages[-1]
    assert stage.status == "not_converged"
    assert 'give zones displacement = "large"' in stage.reason


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda: shaken_zones(PILE, shaking(integrator="implicit")), 'know no integrator = "implicit"'),
        (lambda: shaken_zones(PILE, shaking(mass_scaling=2.0)), "know no mass_scaling"),
        (
            lambda: shaken_zones(
                PILE,
                shaking(),
                zones=bsm.Zones(size=1.0, law="mohr_coulomb"),
                rock={"cohesion": 1e6, "friction": 30.0},
            ),
            "know no rock that yields",
        ),
    ],
)
def test_what_they_do_not_know_is_refused(change, words):
    with pytest.raises(bsm.ModelError, match=words):
        bsm.run(change())


def test_supports_and_boundaries_that_they_do_not_know_are_refused():
    held = [bsm.Fixed(blocks=[0]), bsm.Roller(blocks=[1], direction=0.0)]
    with pytest.raises(bsm.ModelError, match="a support that holds blocks"):
        bsm.run(shaken_zones(PILE, shaking(), supports=held))
    side = turned(rectangle(0, 0, 2, 2), 10.0)
    blocks = bsm.Blocks.from_polygons([side], rock="rock").with_boundary("foot", lambda x, y: y < 0.36)
    model = bar(shaking(quiet=("foot",)), 2.0, 1, zones=SMALL, young=1e9).replace(
        blocks=blocks, supports=[bsm.Fixed(boundary="foot")]
    )
    with pytest.raises(bsm.ModelError, match="boundary 'foot' is inclined"):
        bsm.run(model)


@pytest.mark.heavy
def test_energies_that_do_not_balance_are_no_answer():
    joint = bsm.Joint("J", 1e9, 1e9, **LAWS["growing"])
    model = shaken_zones(PILE, replace(HARD, max_imbalance=1e-8), joint=joint, zones=LARGE, young=1e9)
    stage = bsm.run(model).stages[-1]
    assert stage.status == "not_converged"
    assert "energy balance of the shaking has an error of" in stage.reason
    assert "give shaking a smaller time_step (now" in stage.reason


@pytest.mark.heavy
def test_results_come_back_from_their_folder(tmp_path):
    hard = replace(HARD, every=0.25)
    model = shaken_zones(PILE, hard, zones=LARGE, young=1e9, histories=[bsm.History(name="b", block=1)])
    results = bsm.run(model)
    results.save(tmp_path / "out")
    again = bsm.Results.load(tmp_path / "out")
    one, other = results.stages[-1], again.stages[-1]
    assert_array_equal(one.shaking.energy, other.shaking.energy)
    assert [step.time for step in one.steps] == [step.time for step in other.steps]
    assert len(one.steps) == 5  # four times, and rest
    assert (tmp_path / "out" / "energy.csv").is_file()
    assert STAGE in (tmp_path / "out" / "summary.json").read_text(encoding="utf-8")


@pytest.mark.slow
def test_newmarks_method_finds_the_yield_acceleration_of_zones():
    """A trial that finds no equilibrium has moved where limit analysis proves it: friction alone holds .2 g."""
    model, _ = newmarks_block(zones=SMALL)
    found = bsm.newmark(model, shaken=False)
    for side in found.sides:
        assert side.yields == pytest.approx(0.2, rel=0.01)
        assert abs(side.limit.unstable) == pytest.approx(0.2, rel=0.01)
