"""Blocks with zones that meet where they touched nothing before: statics, rest after a fall, and rigid blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.zones.moved_supports import slid_on
from bsm_mesh.solve.zones.supports import nodal_unknowns
from tests.scenes import meeting_zones as scenes
from tests.scenes.kinked_plane import KinkedPlane
from tests.scenes.shaken_zones import unwatched
from tests.scenes.shapes import rectangle, turned

SOFT = {"young": 1e10, "size": 0.5}


def solved(model):
    """Return results at rest, whose certificate holds."""
    results = bsm.run(model)
    assert results.status == "stable", results.stages[-1].reason
    assert results.check().ok
    return results


@pytest.mark.parametrize(
    ("load", "rtol"), [(2e3, 0), *(pytest.param(load, 1e-2, marks=pytest.mark.heavy) for load in (3e4, 1e4))]
)
def test_a_gap_between_two_beams_closes_under_load(load, rtol):
    """Shear and the height of the beams, L / 10, add the rest."""
    found = scenes.force_between(solved(scenes.beams(load)))
    assert_allclose(found, scenes.beams_exact(load), rtol=rtol)


@pytest.mark.parametrize("order", [1, pytest.param(2, marks=pytest.mark.heavy)])
def test_a_block_falls_onto_a_floor_and_rests(order):
    stage = solved(scenes.dropped(order=order, **SOFT)).stages[0]
    contacts = stage.contacts
    assert_allclose(np.abs(contacts.force[:, 1]).sum(), scenes.WEIGHT, rtol=1e-6)
    assert_allclose(contacts.length[np.abs(contacts.normal_force) > 0].sum(), 1.0, rtol=1e-2)
    assert_allclose(stage.displacement[1, 1], -0.02, atol=1e-4)


def test_a_splinter_does_not_hold_up_the_motion_of_others():
    """Its nodes have a ten thousandth of the mass of others: the time step is not theirs."""
    side = 0.005
    polygons = [rectangle(-1, -1, 3, 0), rectangle(0.2, 0.02, 1.2, 1.02), rectangle(2, 0, 2 + side, side)]
    stage = solved(scenes.meeting(polygons, young=1e10)).stages[0]
    assert_allclose(stage.displacement[1, 1], -0.02, atol=1e-4)
    assert_allclose(stage.reactions.sum(axis=0)[1], scenes.WEIGHT * (4 + 1 + side**2), rtol=1e-6)


@pytest.mark.heavy
def test_a_block_that_falls_far_is_unstable_as_a_rigid_one():
    """By a tenth of its size, without a contact."""
    model = scenes.dropped(1.0, **SOFT)
    stage = bsm.run(model).stages[0]
    assert (stage.status, list(stage.unstable_blocks)) == ("unstable", [1])
    assert bsm.run(scenes.rigid(model)).status == "unstable"


def leans_by_statics(degrees):
    found, exact = scenes.leaning_force(solved(scenes.leaning(degrees, gap=0.004, **SOFT)), degrees)
    assert_allclose(found, exact, rtol=1e-6)


@pytest.mark.heavy
def test_a_column_leans_on_a_wall_by_statics():
    leans_by_statics(0.0)


@pytest.mark.heavy
def test_so_it_does_where_all_is_turned():
    leans_by_statics(37.0)


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [1, 3, 7])
def test_stiff_blocks_in_a_row_come_to_rest_where_rigid_ones_do(seed):
    """Without friction there is one place of rest."""
    model = scenes.row(seed, smooth=True)
    zones, rigid = (solved(each).stages[0].displacement for each in (model, scenes.rigid(model)))
    assert_allclose(zones, rigid, atol=1e-3 * np.abs(rigid).max())


@pytest.mark.slow
def test_a_block_that_is_shaken_meets_a_wall():
    """The base moves back under it, by more than the gap. Further on, the wall's face takes part in the balance."""
    polygons = [rectangle(-1, -1, 3, 0), rectangle(1.205, 0, 2, 1), rectangle(0.2, 0, 1.2, 1)]
    pulse = bsm.Shaking(waveform="pulse", frequency=1.0, cycles=0.1, amplitude=-8.0, duration=0.3, contact_damping=0.5)
    model = scenes.meeting(polygons, held=(0, 1), friction=20.0, stages=[bsm.Stage(name="push", shaking=pulse)], **SOFT)
    stage = solved(model).stages[-1]
    assert 0.0 < stage.stage_displacement[2, 0] < 0.0055
    assert stage.shaking.peak_velocity[2] > 0.1


@pytest.mark.heavy
@pytest.mark.parametrize(("step", "passes"), [(0.002, True), (0.01, False)])
def test_a_step_between_two_blocks_adds_no_energy(step, passes):
    """The left half of the base falls by the step; a block is shaken towards the right half, 0.05 m in front of it."""
    base = [rectangle(-2, -1, 3, -0.5), rectangle(1, -0.5, 3, 0), rectangle(-1, step - 0.5, 1, 0)]
    pulse = bsm.Shaking(waveform="pulse", frequency=1.0, cycles=0.2, amplitude=-9.0, duration=0.25, contact_damping=0.2)
    given = {"held": (0, 1), "friction": 20.0, "young": 2e8, "kn": 2e8, "size": 3.0}
    model = scenes.meeting([*base, rectangle(0, 0, 0.95, 0.5)], stages=[bsm.Stage(name="push", shaking=pulse)], **given)
    stage = solved(model).stages[-1]
    assert stage.shaking.imbalance < 0.01
    front = 0.95 + stage.displacement[3, 0]
    assert front > 1.1 if passes else front < 1.0


def met(model):
    """Return the stages of a model after the first, in which blocks meet."""
    stages = unwatched(model)
    stages.solution(0, None, None)()
    return stages


def displaced(run, moved):
    """Return the displacements once blocks have moved by (n, 2 or 3) [m, m, rad] as a whole."""
    of, nodes, u = run.of, nodal_unknowns(run.of.basis), run.state.u.copy()
    for b, (x, y, *angle) in enumerate(moved):
        on = np.isin(nodes[:, 0], of.basis.element_dofs[:, of.mesh.block == b])
        arm = of.basis.doflocs[:, nodes[on, 0]].T - of.model.blocks.moments.centroid[b]
        u[nodes[on]] += (x, y) + (turned(arm, np.degrees(sum(angle))) - arm)
    return u


def points_between(model, moved, *, band=0.02):
    """Return blocks, places and normals of points once blocks have moved, as for `displaced`."""
    run = met(model)._run
    present, u = run.of.presence[0], displaced(run, moved)
    joints = slid_on(run.equations(present, run.loads_on(present)), u, present, band=band).joints
    here = ~joints.over
    return joints.block[here], joints.placed(u)[here], joints.frames(u)[0][here]


def carries(points, corner, normal):
    """Return whether a point at a corner has a normal, of either sign."""
    _, place, normals = points
    at = np.hypot(*(place - corner).T) < 1e-3
    return bool((at & (np.abs(normals @ normal) > 0.999)).any())


def test_the_corner_of_a_face_carries_after_the_end_of_another_passed_to_a_lower_face():
    """The right half of the base fell by 0.3 m, and the block slid half over it."""
    base = [rectangle(-2, -1, 2, 0), rectangle(2, -1, 4, 0)]
    model = scenes.meeting([*base, rectangle(0.5, 0, 1.5, 1)], young=1e10, held=(0, 1))
    points = points_between(model, [(0, 0), (0, -0.3), (1.0, 0)])
    assert carries(points, (2.0, 0.0), (0.0, 1.0))


def test_a_corner_below_an_edge_whose_ends_lie_on_two_blocks_carries_where_it_stands_out():
    """The right half of the base fell by 4 mm, less than a step, and the block slid half over it."""
    base = [rectangle(-2, -1, 2, 0), rectangle(2, -1, 4, 0)]
    model = scenes.meeting([*base, rectangle(0.5, 0, 1.5, 1)], young=1e10, held=(0, 1))
    fallen = 4e-3
    level = points_between(model, [(0, 0), (0, 0), (1.0, 0)])
    assert not carries(level, (2.0, 0.0), (0.0, 1.0))
    lies = points_between(model, [(0, 0), (0, -fallen), (1.0, -fallen / 2, -fallen)])
    assert carries(lies, (2.0, 0.0), (0.0, 1.0))


def test_a_corner_beyond_the_end_of_a_face_does_not_stop_the_block_that_passed_it():
    """The front of a slab is 20 mm beyond a kink, and just above it; the ground below the kink had moved by 0.03 mm."""
    plane = KinkedPlane.drawn(6, loose=True, bare=False)
    zones, model = bsm.Zones(size=8.0, order=1, displacement="large"), plane.model()
    run = unwatched(model.replace(rocks=[replace(model.rocks[0], zones=zones)]))._run
    present = run.of.presence[0]
    x, y = turned(np.array([(-plane.gap - 0.02, 0.0)]), plane.upper)[0]
    u = displaced(run, [(0, 0), (2e-5, -2e-5), (0, 0), (x, y)])
    joints = slid_on(run.equations(present, run.loads_on(present)), u, present, band=0.1).joints
    here = (joints.block == (3, 1)).all(axis=1) & ~joints.over
    assert not here.any()


def test_points_of_blocks_in_motion_represent_the_faces_as_they_are():
    """A block comes in over the end of another by 0.1 m, then by 0.6 m: as if it had come at once."""
    polygons = [rectangle(-1, -1, 1, 0), rectangle(1.1, 0.01, 2.1, 1.01)]
    run = met(scenes.meeting(polygons, young=1e10, held=(0, 1)))._run
    present = run.of.presence[0]
    given = run.equations(present, run.loads_on(present))
    first, last = (displaced(run, [(0, 0), (x, -0.009)]) for x in (-0.2, -0.7))
    after = slid_on(slid_on(given, first, present, band=0.02), last, present, band=0.02)
    at_once = slid_on(given, last, present, band=0.02)
    assert_allclose(np.sort(after.joints.met.length), np.sort(at_once.joints.met.length))


@pytest.mark.parametrize("swapped", [False, True])
def test_the_corner_of_a_face_carries_after_the_end_of_another_passed_to_the_face_beside_it(swapped):
    """The top of the left block falls from that corner on; its neighbour has risen by 0.01 m."""
    left, right = [(0, 0), (1, 0), (1, 1), (0, 1.3)], [(1, 0), (2, 0), (2, 1), (1, 1)]
    two = [right, left] if swapped else [left, right]
    moved = [(0, 0), (0, 0.01)]
    model = scenes.meeting([rectangle(-1, -1, 3, 0), *map(np.array, two)], young=1e10)
    points = points_between(model, [(0, 0), *(moved[::-1] if swapped else moved)])
    assert carries(points, (1.0, 1.0), (1.0, 0.0))


@pytest.mark.heavy
def test_equilibrium_in_stiff_rock_is_sought_until_rounding_alone_is_left():
    """Of rock of 1e13 Pa a residual of 1e-6 may be rounding, and the verdict refuses blocks that far out of balance."""
    assert solved(scenes.leaning(gap=0.4)).stages[0].steps[-1].residual < 1e-12


@pytest.mark.heavy
def test_the_tangent_is_the_derivative_of_the_forces():
    run = met(scenes.dropped(0.005, **SOFT))._run
    present = run.of.presence[0]
    equations = run.equations(present, run.loads_on(present))
    assert len(equations.joints.met.corner)
    u, step = run.state.u, 1e-6
    at = equations.at(u, equations.free.none)
    K = equations.tangent(at, 0.0).toarray()
    rows = np.flatnonzero(np.abs(K[:, equations.free.free.searchsorted(equations.joints.unknown[-1, 0])]) > 0)
    assert rows.size
    free = equations.free.free
    for k in rows[:8]:
        d = np.zeros_like(u)
        d[free[k]] = step
        up, down = (equations.at(v, equations.free.none).left for v in (u + d, u - d))
        assert_allclose((down - up) / (2 * step), K[:, k], atol=1e-8 * np.abs(K).max())


def test_a_run_goes_on_from_its_memory_with_the_points_that_met():
    run = met(scenes.dropped(0.005, **SOFT))._run
    joints, other = run.state.joints, type(run)(run.of, run.stiffness)
    assert len(joints.met.corner)
    other.recall(run.memory, 0)
    assert_allclose(other.state.joints.placed(run.state.u), joints.placed(run.state.u), rtol=0)
    assert_allclose(other.state.joints.normal_stiffness, joints.normal_stiffness, rtol=0)
