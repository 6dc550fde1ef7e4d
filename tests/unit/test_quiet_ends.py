"""Quiet boundaries: speeds of waves in blocks, energies, threads, falls, and supports that hold afterwards."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.contact.history import History
from bsm_mesh.model.loads import PointForces
from bsm_mesh.results.shaking import ENERGIES
from bsm_mesh.solve.motion.quiet_ends import QuietEnds
from bsm_mesh.solve.motion.wave_speeds import stiffness_of_blocks, waves_along
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.models import model_of
from tests.scenes.quiet import column, on_quiet_base
from tests.scenes.shaken import STAGE, quake
from tests.scenes.shapes import grid, rectangle, turned

WIDTH, HEIGHT = 2.0, 0.5
BED, HEAD = (8e9, 3e9), (20e9, 12e9)  # Pa/m, across and along


def stiffness_of(polygons, angle):
    """Return the stiffness of blocks cut by beds that dip by an angle, and by heads across them."""
    blocks = bsm.Blocks.from_polygons([turned(p, angle) for p in polygons], rock="rock")
    is_head = np.isclose(np.hypot(*blocks.edge_vectors.T), HEIGHT).astype(np.int32)
    model = model_of(polygons).replace(
        blocks=blocks.with_edge_joints(is_head, ("bed", "head")),
        joints=[bsm.Joint("bed", *BED), bsm.Joint("head", *HEAD)],
        default_joint="bed",
        in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": -1e6}),
    )
    position = np.zeros((blocks.count, 3))
    system = BlockSystem(model)
    contacts = system.gather(History.none(), position, first=True)
    return stiffness_of_blocks(contacts, system.evaluate(contacts, position), blocks)


@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_waves_through_two_joint_sets(angle):
    """Compliances of both sets are added (Amadei and Goodman 1981): moduli k s across, 1 / (1/k s + 1/k s) in shear."""
    polygons = grid(np.arange(5) * WIDTH, np.arange(9) * HEIGHT)
    stiffness = stiffness_of(polygons, angle)
    bed, head = np.array(BED) * HEIGHT, np.array(HEAD) * WIDTH
    shear = 1 / (1 / bed[1] + 1 / head[1])
    normal = turned(np.array([[0.0, 1.0], [1.0, 0.0]]), angle)
    for n, across in zip(normal, (bed[0], head[0]), strict=True):
        moduli, directions = waves_along(stiffness, n[None])
        assert_allclose(moduli[0], sorted([shear, across]), rtol=1e-6)
        assert_allclose(np.abs(directions[0] @ n), [across < shear, across > shear], atol=1e-6)


@pytest.mark.slow
def test_what_enters_leaves_or_stays_as_energy():
    stage = bsm.run(column(0, 12, wavelength=12.0, length=8.0)[0]).stages[-1]
    energy = dict(zip(ENERGIES, stage.shaking.energy.T, strict=True))
    assert stage.shaking.imbalance < 1e-3
    assert_allclose(energy["quiet"][-1], energy["input"][-1], rtol=1e-3)
    assert energy["kinetic"].max() > 0.1 * energy["input"][-1] > 0
    assert energy["kinetic"][-1] < 1e-3 * energy["kinetic"].max()


@pytest.mark.slow
def test_threads_change_no_digit(monkeypatch):
    monkeypatch.setattr("bsm_mesh.solve.motion.threads.AT_ONCE", 10)
    model, _ = column(90, 12, wavelength=12.0, length=0.5)
    one, other = (bsm.run(model, bsm.Options(threads=threads)).stages[-1] for threads in (1, 2))
    assert_array_equal(one.displacement, other.displacement)
    assert_array_equal(one.shaking.energy, other.shaking.energy)


def test_supports_hold_again_where_they_were_and_notes_name_the_wave():
    results = bsm.run(on_quiet_base())
    rest, stage = results.stages
    assert stage.status == "stable"
    assert results.check().ok
    assert stage.shaking.imbalance < 5e-3
    assert np.abs(results.histories["base"]["u"]).max() > 1e-3
    assert_allclose(stage.stage_displacement[:2], 0, atol=1e-9)
    assert_allclose(stage.total_reaction, rest.total_reaction, atol=1e-5 * np.abs(rest.total_reaction).max())
    assert any("a wave of up to 0.2 m/s entered through the quiet boundary 'bottom'" in note for note in stage.notes)


def test_blocks_without_contacts_carry_no_wave():
    model = on_quiet_base()
    alone = model.blocks.polygon(0)
    blocks = bsm.Blocks.from_polygons([alone], rock="rock").with_boundary("bottom", lambda x, y: y < -1 + 1e-6)
    with pytest.raises(bsm.ModelError, match="rock 'rock' at boundary 'bottom' has no closed contacts, so no waves"):
        bsm.run(model.replace(blocks=blocks, histories=[]))


def test_a_concave_block_whose_centroid_lies_beyond_a_quiet_boundary_is_refused():
    """The mass of its dashpot would be negative, and the block would fly away."""
    polygons = [rectangle(0, -1, 4, 0), [(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)]]
    model = model_of(polygons)
    model = model.replace(
        blocks=model.blocks.with_boundary("notch", lambda x, y: (np.abs(x - 1) < 1e-6) & (y > 1 - 1e-6)),
        supports=[bsm.Fixed(blocks=[0]), bsm.Roller(boundary="notch", direction=0)],
        stages=[bsm.Stage(name=STAGE, shaking=bsm.Shaking(record=quake(0.3, 1.0, 10.0), quiet=["notch"]))],
    )
    with pytest.raises(bsm.ModelError, match="quiet: block 1: the centroid is not inside boundary 'notch'"):
        bsm.run(model)


@pytest.mark.heavy
def test_others_are_shaken_on_without_what_came_down():
    """A block hangs by a weak joint from a roof that is quiet above."""
    polygons = [rectangle(-2, -3, 5, -2), rectangle(0, 2, 1, 3), rectangle(-2, 3, 1, 4), rectangle(1, 3, 3, 4)]
    up = bsm.Shaking(
        record=quake(0.3, 1.0, 10.0), direction=90.0, every=0.05, quantity="velocity", quiet=["top"], boundary="top"
    )
    glue = bsm.MohrCoulomb(friction=35, cohesion=1e5)
    model = model_of(polygons)
    model = model.replace(
        blocks=model.blocks.with_boundary("top", lambda x, y: y > 4 - 1e-6),
        supports=[bsm.Fixed(blocks=[0]), bsm.Fixed(boundary="top")],
        joints=[bsm.Joint("J", 1e9, 1e9, law=glue, tensile_strength=35e3)],
        stages=[bsm.Stage(name=STAGE, shaking=up)],
    )
    results = bsm.run(model, bsm.Options(falls=bsm.Falls(on_fall="remove")))
    stage = results.stages[-1]
    assert results.status == "stable_after_falls"
    assert [fall.block for fall in stage.falls] == [1]
    assert stage.shaking.time[-1] == 1.0
    assert stage.shaking.imbalance < 1e-2


def test_ends_go_to_some_of_the_blocks_and_back():
    block, rows = np.array([3, 1, 2], dtype=np.int32), np.arange(3.0)
    held = PointForces(block=block[:2], point=np.zeros((2, 2)), force=np.ones((2, 2)))
    names = "dashpot", "delay", "push", "stretch", "velocity"
    ends = QuietEnds(block=block, arm=np.eye(3, 2), direction=np.eye(3, 2), held=held, **dict.fromkeys(names, rows))
    part = SimpleNamespace(present=np.array([True, False, True, True]), block=np.array([0, 2, 3], dtype=np.int32))
    there = ends.in_part(part)
    assert_array_equal(there.block, [2, 1])
    assert_array_equal(there.held.block, [2])
    assert_array_equal(there.velocity, [0, 2])
    back = there.in_whole(part)
    assert_array_equal(back.block, [3, 2])
    assert_array_equal(back.held.block, [3])


def test_newmarks_method_needs_a_ground_that_moves():
    model = on_quiet_base()
    with pytest.raises(bsm.ModelError, match="the wave enters through 'bottom' while supports are at rest"):
        bsm.newmark(model)
