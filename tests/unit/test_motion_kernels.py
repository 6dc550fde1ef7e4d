"""Explicit motion: free fall, sliding, collisions of turned blocks; forces are those of the step's equations."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.solve.motion import threads as motion_threads
from bsm_mesh.solve.motion.contact_columns import CONTACT, SLIP, WIDTH, chosen, chunked, column_of, put
from bsm_mesh.solve.motion.contact_kernels import ROOM
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.joint_kernels import grow
from bsm_mesh.solve.motion.kernels import set_turns
from bsm_mesh.solve.motion.masses import MotionSettings
from bsm_mesh.solve.motion.window_columns import ExtremeLines, share_of
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.steps import begun, still

UNDAMPED = MotionSettings(damping=0.0, damps_impacts=False, real_masses=True)
INELASTIC = MotionSettings(damping=0.0, damps_impacts=True, real_masses=True)
BASE = rectangle(-20, -1, 20, 0)


def follow(motion: ExplicitMotion, until, windows: int = 400) -> None:
    """Go on, with contacts searched as blocks move, until a condition holds."""
    for _ in range(windows):
        motion.advance()
        assert not motion.diverged
        if motion.passed > 0.5 * motion.system.d:
            motion.search()
        if until(motion):
            return
    pytest.fail("it never came to that")


@pytest.mark.parametrize("turn", [0.3, 1.7, 3.0])
def test_a_free_block_falls_by_half_the_square_of_its_velocity(turn):
    block = turned(rectangle(-0.5, -0.5, 0.5, 0.5), np.degrees(turn), (0.0, 8.0))
    motion = ExplicitMotion(begun(model_of([BASE, block])), UNDAMPED)
    follow(motion, lambda m: m.residual.position[1, 1] < -0.5)
    assert motion.velocity[1, 1] ** 2 / 2 == pytest.approx(-motion.residual.position[1, 1], rel=1e-2)
    assert_allclose(motion.residual.position[1, [0, 2]], 0, atol=1e-9)


@pytest.mark.parametrize(("slope", "friction"), [(30.0, 15.0), (50.0, 35.0)])
def test_a_sliding_block_accelerates_by_what_friction_leaves(slope, friction):
    polygons = [turned(p, slope) for p in (BASE, rectangle(-0.5, 0, 0.5, 1))]
    motion = ExplicitMotion(begun(model_of(polygons, friction=friction)), INELASTIC)
    follow(motion, lambda m: np.hypot(*m.residual.position[1, :2]) > 0.2)
    early = motion.velocity[1, :2], motion.residual.position[1, :2]
    follow(motion, lambda m: np.hypot(*m.residual.position[1, :2]) > 1.0)
    gained = (motion.velocity[1, :2] ** 2).sum() - (early[0] ** 2).sum()
    moved = np.hypot(*(motion.residual.position[1, :2] - early[1]))
    angle = np.radians(slope)
    wanted = np.sin(angle) - np.cos(angle) * np.tan(np.radians(friction))
    assert gained / 2 / moved == pytest.approx(wanted, rel=0.02)


def test_a_block_that_friction_holds_slips_nowhere():
    polygons = [turned(p, 30.0) for p in (BASE, rectangle(-0.5, 0, 0.5, 1))]
    motion = ExplicitMotion(
        begun(model_of(polygons, friction=40.0)),
        MotionSettings(damping=0.5, damps_impacts=False, real_masses=False),
        ramp=300,
    )
    follow(motion, lambda m: m.is_loaded and m.residual.max_norm < 1e-5)
    assert motion.residual.at.sticking[motion.residual.at.closed].all()
    assert np.abs(motion.residual.position).max() < 1e-3


@pytest.mark.parametrize("turn", [0.3, 1.7, 3.0])
def test_blocks_in_collision_keep_their_momentum(turn):
    """Across gravity: along it both gain what falls give them."""
    squares = [turned(rectangle(a, 0, a + 1, 1), np.degrees(turn)) for a in (0.0, 1.05)]
    far = turned(rectangle(0, 30, 1, 31), np.degrees(turn))
    step = begun(model_of([far, *squares]))
    along = np.array([np.cos(turn), np.sin(turn)])
    velocity = still(3, b1=(*(0.5 * along), 0.0))
    motion = ExplicitMotion(step, UNDAMPED, velocity=velocity)
    follow(motion, lambda m: (m.velocity[2, :2] @ along) - (m.velocity[1, :2] @ along) > 0.1)
    fall = motion.velocity[1:, :2].sum(axis=0) - 0.5 * along
    assert fall[0] == pytest.approx(0.0, abs=1e-6)  # gravity acts in y alone
    assert motion.velocity[2, :2] @ along > 0.3


def test_an_impact_loses_its_energy():
    block = rectangle(-0.5, 0.05, 0.5, 1.05)
    motion = ExplicitMotion(begun(model_of([BASE, block])), INELASTIC, velocity=still(2, b1=(0, -0.5, 0)))
    speed = []
    for _ in range(60):
        motion.advance()
        speed.append(motion.velocity[1, 1])
    assert min(speed) < -0.4
    assert max(speed) < 0.05


@pytest.mark.parametrize("keys", [{}, {"dilation_angle": 5.0, "dilation_slip": 1e-3}])
def test_one_thread_and_two_give_equal_digits(keys, monkeypatch):
    monkeypatch.setattr(motion_threads, "AT_ONCE", 100)
    columns = [(x + 0.5 * (y % 1), y) for y in np.arange(0, 10, 0.5) for x in np.arange(0, 20, 1.0)]
    walls = [rectangle(x, y, x + 1, y + 0.5) for x, y in columns]
    ends = []
    for threads in (1, 2):
        model = model_of([BASE, *walls])
        step = begun(model.replace(joints=[replace(model.joints[0], **keys)]), threads=threads)
        velocity = np.random.default_rng(3).normal(scale=0.01, size=step.start.shape)
        velocity[0] = 0.0
        motion = ExplicitMotion(step, INELASTIC, velocity=velocity)
        for _ in range(3):
            motion.advance()
        assert len(motion._rows) > 200  # a thread each
        ends.append((motion.residual.position, motion.velocity, motion.contacts.slip_path))
    for one, two in zip(*ends, strict=True):
        assert_array_equal(one, two)


@pytest.mark.parametrize("softening", [None, 0.4])
def test_lines_of_strength_follow_what_slip_has_taken(softening):
    """They are kept from window to window while no state that the law asks for has changed."""
    polygons = [turned(p, 45.0) for p in (BASE, rectangle(-0.5, 0, 0.5, 1))]
    law = bsm.MohrCoulomb(friction=35, residual_friction=15, softening_slip=softening)
    motion = ExplicitMotion(begun(model_of(polygons, law=law, kn=1e8)), INELASTIC)
    steepest = motion._extreme.low[1].max()
    for _ in range(4):
        motion.advance()
    wanted = ExtremeLines(motion.contacts, motion.system.catalogue.laws)
    for kept, new in zip((*motion._extreme.low, *motion._extreme.high), (*wanted.low, *wanted.high), strict=True):
        assert_array_equal(kept, new)
    assert wanted.low[1].max() < steepest


def test_a_thread_that_fails_lets_the_others_end(monkeypatch):
    """They meet after every cycle: the others would wait for it for ever."""
    monkeypatch.setattr(motion_threads, "AT_ONCE", 10)
    own, advance = threading.get_ident(), motion_threads._Strip.advance

    def failing(strip, *given):
        if threading.get_ident() != own:
            raise ArithmeticError("of this test")
        return advance(strip, *given)

    monkeypatch.setattr(motion_threads._Strip, "advance", failing)
    walls = [rectangle(x, 0, x + 1, 0.5) for x in np.arange(0, 10, 1.0)]
    motion = ExplicitMotion(begun(model_of([BASE, *walls]), threads=2), INELASTIC)
    with pytest.raises(ArithmeticError, match="of this test"):
        motion.advance()


def moved_in(model, windows, **moving):
    """Return where blocks are after windows of so many cycles each, undamped, and their velocity."""
    motion = ExplicitMotion(begun(model), UNDAMPED, velocity=still(model.blocks.count, **moving))
    for cycles in windows:
        motion.advance(cycles)
    assert motion.cycles == sum(windows)
    return motion.residual.position, motion.velocity


def around(turn: float, *points: tuple[float, float]) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in turned(np.array(points), turn)]


@pytest.mark.parametrize("turn", [0.0, 17.0, 97.0, 172.0])
@pytest.mark.parametrize("kind", ["plain", "cohesive", "patton", "hyperbolic", "stiffening", "bolted", "dowelled"])
def test_forces_within_a_window_are_those_of_the_equations(turn, kind):
    """A window begins with forces from the equations; a long one, in which blocks turn, goes as several short ones."""
    polygons = [turned(p, turn) for p in (BASE, rectangle(-0.5, 0, 0.5, 1), rectangle(0.5, 0, 1.5, 1.2))]
    given = {}
    if kind == "cohesive":
        given["law"] = bsm.MohrCoulomb(friction=30.0, cohesion=5e3)
    elif kind == "patton":
        given["law"] = bsm.Patton(friction=30.0, dilation=8.0, cohesion=5e3)
    elif kind == "bolted":
        start, end = around(turn, (0.0, 0.9), (0.3, -0.8))
        given["bolts"] = [bsm.Bolt(start=start, end=end, kind="grouted", diameter=0.03, young=2e11, bond_strength=2e5)]
    elif kind == "dowelled":
        start, end = around(turn, (0.0, 0.9), (0.0, -0.8))
        given["bolts"] = [bsm.Bolt(start=start, end=end, diameter=0.03, bond_strength=1.0, bearing_stiffness=1e9)]
    along = 0.05 * np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    model = model_of(polygons, **given)
    if kind == "hyperbolic":
        model = model.replace(joints=[replace(model.joints[0], max_closure=4e-5)])
    elif kind == "stiffening":
        law = bsm.MohrCoulomb(friction=60.0, cohesion=1e5)
        stiffens = {"shear_stiffness_exponent": 0.8, "reference_stress": 1e7}
        model = model.replace(joints=[replace(model.joints[0], law=law, **stiffens)])
    (long, fast), (short, quick) = (
        moved_in(model, windows, b1=(*along, 0.06), b2=(0, 0, -0.05)) for windows in ((40,), 8 * (5,))
    )
    moved = np.abs(long).max()
    assert moved > 1e-4
    assert np.abs(long[1:, 2]).min() > 1e-5
    off = 1e-2 if kind in ("cohesive", "patton") else 1e-5  # what breaks in a cycle breaks a cycle earlier or later
    assert_allclose(long, short, rtol=0, atol=off * moved)
    assert_allclose(fast, quick, rtol=0, atol=10 * off * np.abs(fast).max())


@pytest.mark.parametrize("count", [0, 1, WIDTH - 1, WIDTH, 2 * WIDTH + 3])
def test_contacts_come_out_of_chunks_as_they_went_in(count):
    slid = np.arange(1.0, count + 1)
    chunks, rows = chunked(SLIP, {"slid": slid}, count), np.arange(count)[::-3]
    assert_array_equal(column_of(chunks, "slid", count), slid)
    assert_array_equal(chunks["slid"].sum(), slid.sum())  # filled up with zeros
    part = chosen(chunks, rows)
    assert_array_equal(column_of(part, "slid", len(rows)), slid[rows])
    part["slid"] *= -1
    put(chunks, rows, part)
    slid[rows] *= -1
    assert_array_equal(column_of(chunks, "slid", count), slid)


@pytest.mark.parametrize("young", [None, 1e9])
@pytest.mark.parametrize("keys", [{"shear_stiffness_exponent": 0.8}, {"shear_stiffness": None}])
def test_shear_stiffness_in_cycles_is_that_of_the_contacts(young, keys):
    """And so is the part of the force that is left as pressure falls; as it rises all of it is."""
    law = bsm.BartonBandis(jrc=9, jcs=60e6, residual_friction=28.0)
    model = model_of([BASE, rectangle(-0.5, 0, 0.5, 1)])
    rock = replace(model.rocks[0], young=young, poisson=None if young is None else 0.2)
    joint = replace(model.joints[0], law=law, reference_stress=1e4, **keys)
    motion = ExplicitMotion(begun(model.replace(rocks=[rock], joints=[joint])), INELASTIC)
    contacts, growing = motion.contacts, motion.contacts.features.growing
    growths = share_of(contacts, motion.residual.at, motion.system.catalogue, motion._rows, motion._columns).growths
    growths["stiffest"] = 1e30
    chunk, place = divmod(int(np.searchsorted(motion._rows, growing.rows[0])), WIDTH)
    sheared, room, before = np.zeros(1, CONTACT), np.zeros(1, ROOM), np.inf
    for pressure in (0.0, 10.0, 3e3, 2e5, 4e4):
        wanted = float(growing.stiffness(np.full(len(growing.rows), pressure))[0][0])
        room["trial"], sheared["carried"] = pressure, 1.0
        grow(sheared[0], growths[chunk], room[0])
        assert sheared["shear_stiffness"][0, place] == pytest.approx(wanted, rel=1e-5)
        if np.isfinite(before):
            assert sheared["carried"][0, place] == pytest.approx(min(wanted / before, 1.0), rel=1e-5)
        before = wanted


@pytest.mark.parametrize("young", [None, 1e9])
@pytest.mark.parametrize("limit", [2e-4, 1e-3])
def test_a_hyperbolic_joint_gives_back_what_an_impact_gave_it(limit, young):
    """Undamped it throws a block as fast as it came, or hardly faster; between rigid rock, where it ends hard, less."""
    model = model_of([BASE, rectangle(-0.5, 0.05, 0.5, 1.05)], kn=1e8)
    rock = replace(model.rocks[0], young=young, poisson=None if young is None else 0.2)
    model = model.replace(joints=[replace(model.joints[0], max_closure=limit)], rocks=[rock])
    motion = ExplicitMotion(begun(model), UNDAMPED, velocity=still(2, b1=(0, -0.3, 0)))
    speed, deepest = [], 0.0
    for _ in range(60):
        motion.advance(40)
        speed.append(motion.velocity[1, 1])
        deepest = min(deepest, motion.residual.position[1, 1] + 0.05)
    assert min(speed) < -0.3
    assert (0.3 if young is None else 0.9 * 0.43) < max(speed) < 1.05 * 0.43  # the root of 0.3^2 + 2 * 0.05
    assert deepest > -1e-2


@pytest.mark.parametrize(("softening", "far"), [(0.002, 0.012), (0.002, 0.6), (0.05, 0.6), (0.4, 0.6)])
def test_a_sliding_block_is_slowed_by_what_slip_leaves(softening, far):
    """Half the square of its velocity is what friction, which falls from 35 to 15 degrees, leaves of its fall."""
    polygons = [turned(p, 45.0) for p in (BASE, rectangle(-0.5, 0, 0.5, 1))]
    law = bsm.MohrCoulomb(friction=35, residual_friction=15, softening_slip=softening)
    motion = ExplicitMotion(begun(model_of(polygons, law=law, kn=1e8)), INELASTIC)
    follow(motion, lambda m: np.hypot(*m.residual.position[1, :2]) > far)
    moved = np.hypot(*motion.residual.position[1, :2])
    peak, left = np.tan(np.radians([35, 15]))
    friction = left * moved + (peak - left) * (softening / 2)
    wanted = np.sin(np.pi / 4) * moved - np.cos(np.pi / 4) * friction
    assert (motion.velocity[1, :2] ** 2).sum() / 2 == pytest.approx(wanted, rel=0.03, abs=6e-4)
    assert motion.contacts.slip_path.max() == pytest.approx(moved, rel=0.02)


@pytest.mark.parametrize(("strength", "holds"), [(60e3, True), (15e3, False)])
def test_a_block_hangs_by_the_tensile_strength_of_its_joint(strength, holds):
    """Its joint of a square metre carries 25 kN; what breaks has failed and falls."""
    model = model_of([rectangle(-4, 1, 4, 2), rectangle(-0.5, 0, 0.5, 1)])
    model = model.replace(joints=[replace(model.joints[0], tensile_strength=strength)])
    motion = ExplicitMotion(begun(model), MotionSettings(damping=0.5, damps_impacts=False, real_masses=True), ramp=200)
    for _ in range(20):
        motion.advance(100)
    assert bool(motion.residual.position[1, 1] > -1e-3) is holds
    assert bool(motion.contacts.failed.any()) is not holds


DOWEL = {"kind": "grouted", "diameter": 0.03, "bond_strength": 1.0, "bearing_stiffness": 1e9, "spacing": 1.5}


def doweled(turn, load, **given):
    """Return a block on a frictionless joint, pushed along it, which a bolt across it holds by shear alone."""
    start, end = around(turn, (0.0, 0.9), (0.0, -0.8))
    (force,) = around(turn, (load, 0.0))
    (point,) = around(turn, (0.0, 0.0))
    bolt = bsm.Bolt(start=start, end=end, **DOWEL, **given)
    polygons = [turned(p, turn) for p in (BASE, rectangle(-0.5, 0, 0.5, 1))]
    push = bsm.PointLoad(block=1, point=point, force=force)
    return bolt, model_of(polygons, friction=0.0, bolts=[bolt], loads=[push], gravity_direction=turn - 90.0)


@pytest.mark.parametrize("turn", [0.0, 35.0, 160.0])
def test_a_dowel_carries_what_pushes_a_block(turn):
    load = 10e3
    bolt, model = doweled(turn, load)
    damped = MotionSettings(damping=0.5, damps_impacts=False, real_masses=False)
    motion = ExplicitMotion(begun(model), damped, ramp=300)
    follow(motion, lambda m: m.is_loaded and m.residual.max_norm < 1e-5)
    moved = turned(motion.residual.position[1:, :2], -turn)[0]
    assert moved[0] == pytest.approx(load * DOWEL["spacing"] / bolt.dowel_stiffness, rel=0.02)
    force = motion.system.bolts.evaluate(motion.residual.position).dowels.force
    assert abs(force[0]) == pytest.approx(load * DOWEL["spacing"], rel=1e-3)


@pytest.mark.parametrize("turn", [0.0, 70.0])
def test_a_block_accelerates_by_what_a_dowel_at_its_strength_leaves(turn):
    strengths = {"bearing_strength": 60e6, "yield_strength": 400e6}
    strength = bsm.Bolt(start=(0, 1), end=(0, -1), **DOWEL, **strengths).dowel_strength / DOWEL["spacing"]
    _, model = doweled(turn, 3 * strength, **strengths)
    motion = ExplicitMotion(begun(model), INELASTIC)

    def along(m):
        return turned(m.residual.position[1:, :2], -turn)[0, 0], turned(m.velocity[1:, :2], -turn)[0, 0]

    follow(motion, lambda m: along(m)[0] > 0.02)
    before = along(motion)
    follow(motion, lambda m: along(m)[0] > 0.06)
    after = along(motion)
    gained = (after[1] ** 2 - before[1] ** 2) / 2 / (after[0] - before[0])
    assert gained == pytest.approx(2 * strength / 25e3, rel=0.03)  # over the weight: a velocity is a root of a height


@pytest.mark.parametrize("degrees", [-90.0, -120.0, 35.0])
def test_supports_that_settle_or_move_along_a_slope_carry_their_block(degrees):
    """The base is moved 5 mm, as fast as blocks fall, and held across; what is on it lands on it, thrown or not."""
    move = 5e-3
    supports = [
        bsm.PrescribedDisplacement(blocks=[0], direction=degrees, displacement=move),
        bsm.Roller(blocks=[0], direction=degrees + 90.0),
    ]
    step = begun(model_of([BASE, rectangle(-0.5, 0, 0.5, 1)], friction=50.0, supports=supports))
    motion = ExplicitMotion(step, MotionSettings(damping=0.5, damps_impacts=True, real_masses=True))
    follow(motion, lambda m: m.is_loaded and m.residual.max_norm < 1e-3)
    wanted = move * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    assert_allclose(motion.residual.position[0, :2], wanted, rtol=0, atol=1e-9)
    settled = 25e3 / 1e9
    assert motion.residual.position[1, 1] == pytest.approx(wanted[1] - settled, abs=0.1 * settled)
    assert abs(motion.residual.position[1, 2]) < 1e-4
    assert motion.residual.at.closed.sum() == 2


@pytest.mark.parametrize("degrees", [30.0, 75.0, 140.0])
def test_a_block_on_an_inclined_roller_falls_along_it(degrees):
    """It is held across the direction in which it may move: all its height becomes velocity."""
    supports = [bsm.Fixed(blocks=[0]), bsm.Roller(blocks=[1], direction=degrees + 90.0)]
    model = model_of([BASE, rectangle(-0.5, 8, 0.5, 9)], supports=supports)
    motion = ExplicitMotion(begun(model), UNDAMPED)
    follow(motion, lambda m: np.hypot(*m.residual.position[1, :2]) > 0.3)
    moved, velocity = motion.residual.position[1, :2], motion.velocity[1, :2]
    across = np.array([-np.sin(np.radians(degrees)), np.cos(np.radians(degrees))])
    assert abs(moved @ across) < 1e-9
    assert moved[1] < 0
    assert (velocity**2).sum() / 2 == pytest.approx(-moved[1], rel=0.02)


def test_turns_within_a_window_are_exact_however_far_a_splinter_spins():
    turn = np.concatenate([np.linspace(-20, 20, 4001), np.linspace(-0.11, 0.11, 101), [0.0, 1e-7]])
    moved = np.zeros((len(turn), 3))
    moved[:, 2] = turn
    sine, versine = np.zeros((2, len(turn)), np.float32)
    set_turns(moved, np.arange(len(turn)), sine, versine)
    assert_allclose(sine, np.sin(turn), rtol=2e-7, atol=1e-7)
    assert_allclose(versine, 2 * np.sin(turn / 2) ** 2, rtol=2e-7, atol=1e-13)
