"""Scheme "continuation": limits with closed-form or published answers, blocks that slide and topple to rest.

3DEC's sliding block (density 2000, g = 10, kn = ks = 10 MPa/m, base width 10): slides if tan psi > tan phi, topples if
tan psi > b / h. Arches: least thickness by limit analysis, see verification/masonry.py.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.arch import arch
from tests.scenes.models import GAMMA, LINEAR, admissible_at, model_of
from tests.scenes.shapes import rectangle, running_bond, turned

MOVING = bsm.Options(scheme="continuation")
THICKNESS = {8: 0.09997, 16: 0.10708, 32: 0.10720}


def solve(model, options=MOVING):
    """Run, and hold every stable result to its check."""
    results = bsm.run(model, options)
    assert np.isfinite(results.stages[-1].displacement).all()
    if results.status == "stable":
        assert results.check().ok, str(results.check())
    else:
        assert results.stages[-1].reason
    return results


def incline(height, friction, angle, kn=10e6, *, scale=1.0, degrees=0.0, force=1.0, base=(-40, -10, 30, 0)):
    """Return the block of 10 x `height` on a plane, in other units of length and force, and the frame turned."""
    polygons = [turned(scale * rectangle(*r), angle + degrees) for r in (base, (0, 0, 10, height))]
    unit = force / scale**2
    return model_of(polygons, friction=friction, kn=kn * unit, gamma=2e4 * unit, gravity_direction=degrees - 90.0)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("height", "friction", "angle", "status", "turns"),
    [
        (10, 40.1, 40, "stable", 0),
        (5, 20, 40, "unstable", None),
        (25, 40, 30, "stable", 90),
        (25, 20, 40, "unstable", None),
    ],
)
def test_block_on_an_incline(height, friction, angle, status, turns):
    """Stays; slides off; topples onto its side, where friction holds it; a tall one slides off, upright."""
    results = solve(incline(height, friction, angle, base=(-150, -10, 30, 0)))  # room to slide to rest
    stage = results.stages[-1]
    assert results.status == status
    assert list(stage.unstable_blocks) == ([1] if status == "unstable" else [])
    turn = np.degrees(stage.displacement[1, 2])
    if turns is not None:
        assert_allclose(turn, turns, atol=1.0)
    if turns == 90:  # on the way it has fallen: a limit below its movement says so
        short = solve(incline(height, friction, angle), bsm.Options(scheme="continuation", displacement_limit=5.0))
        assert short.status == "unstable"
        assert list(short.unstable_blocks) == [1]
        assert np.degrees(short.stages[-1].displacement[1, 2]) > 15


def test_forces_under_a_block_whose_heel_slips():
    """Heel and toe N / 2 -+ S h / (2 b); the heel carries its friction, the toe the rest."""
    stage = solve(incline(10, 40.1, 40)).stages[-1]
    weight, a = 2e4 * 100, np.radians(40)
    N, S = weight * np.cos(a), weight * np.sin(a)
    c = stage.contacts
    toe, heel = np.argsort(c.normal_force)
    slack = 3e-2  # the block leans by the closure of its joint, 40 mm in 10 m
    assert_allclose(-c.normal_force[[toe, heel]], [N / 2 + S / 2, N / 2 - S / 2], rtol=slack, atol=slack * N / 2)
    assert_allclose(abs(c.shear_force[heel]), -c.normal_force[heel] * np.tan(np.radians(40.1)), rtol=1e-9)
    assert c.status[heel] == bsm.results.ContactStatus.SLIPPING
    assert c.status[toe] == bsm.results.ContactStatus.STICKING
    assert c.utilisation.max() <= 1 + 1e-9


@pytest.mark.heavy
@pytest.mark.parametrize("kn", [1e9, 1e10])
@pytest.mark.parametrize("friction", [20.0, 35.0])
def test_limit_angle_of_sliding_within_a_hundredth_of_a_degree(friction, kn):
    base = (-3, -10, 15, 0)
    assert solve(incline(5, friction, friction - 0.01, kn, base=base)).status == "stable"
    assert solve(incline(5, friction, friction + 0.01, kn, base=base)).status == "unstable"


@pytest.mark.heavy
@pytest.mark.parametrize(("kn", "within"), [(1e10, 0.01), (1e9, 0.02)])
@pytest.mark.parametrize("n", THICKNESS)
def test_least_thickness_of_an_arch(n, kn, within):
    assert solve(arch(n, THICKNESS[n] * (1 + within), kn=kn)).status == "stable"
    fallen = solve(arch(n, THICKNESS[n] * (1 - within), kn=kn))
    assert fallen.status == "unstable"
    assert fallen.unstable_blocks.size >= n // 2
    assert not set(fallen.unstable_blocks) & {n, n + 1}


@pytest.mark.heavy
@pytest.mark.parametrize("n", [2, 3, 4])
def test_harmonic_stack(n):
    for scale, status in ((0.99, "stable"), (1.01, "unstable")):
        shift = np.concatenate([[0], np.cumsum([scale / (2 * k) for k in range(n, 0, -1)])])[: n + 1]
        results = solve(
            model_of([rectangle(s - 1, 0.5 * k, s, 0.5 * k + 0.5) for k, s in enumerate(shift)], friction=45, kn=1e10)
        )
        assert results.status == status
        if status == "stable":
            assert results.stages[-1].contacts.normal_force.max() < 0
        else:
            assert n in results.unstable_blocks


def column(n, degrees):
    stones = [rectangle(0, 0.5 * k, 1, 0.5 * k + 0.5) for k in range(n)]
    return model_of([rectangle(-20, -1, 20, 0), *stones], friction=60, kn=1e10, gravity_direction=-90.0 - degrees)


@pytest.mark.heavy
@pytest.mark.parametrize("n", [2, 3, 4])
def test_tilt_at_which_a_column_topples(n):
    """Atan(b / (n h)); once down it may reach rest, so what is looked at is how far it went."""
    limit = np.degrees(np.arctan(1 / (0.5 * n)))
    stands, topples = solve(column(n, limit - 0.05)), solve(column(n, limit + 0.05))
    assert stands.status == "stable"
    assert stands.stages[-1].max_displacement < 1e-3
    assert topples.status != "not_converged"
    assert topples.stages[-1].max_displacement > 0.4


def pushed_block(wall, kn):
    """Return block 2 on fixed block 1, pushed 30 kN at 0.3 m height, and, where asked for, block 3 0.5 m off."""
    polygons = [rectangle(0, -1, 4, 0), rectangle(0.5, 0, 1.5, 1)] + ([rectangle(2, 0, 3, 1)] if wall else [])
    push = [bsm.PointLoad(block=1, point=(0.5, 0.3), force=(30e3, 0))]
    return model_of(polygons, friction=30, kn=kn, fixed=(0, 2) if wall else (0,), loads=push)


@pytest.mark.parametrize("kn", [1e8, 1e9, pytest.param(1e10, marks=pytest.mark.heavy)])
def test_a_pushed_block_comes_to_rest_against_a_wall(kn):
    stage = solve(pushed_block(True, kn)).stages[-1]
    assert stage.status == "stable"
    assert_allclose(stage.displacement[1, 0], 0.5, atol=1e-3)
    c = stage.contacts
    at_wall = (c.block_a == 2) | (c.block_b == 2)
    assert c.normal_force[at_wall].sum() < 0
    assert (np.abs(c.shear_force) <= -c.normal_force * np.tan(np.radians(30)) + 1e-6).all()


@pytest.mark.heavy
@pytest.mark.parametrize("kn", [1e8, 1e10])
def test_a_pushed_block_without_the_wall_goes_on(kn):
    results = solve(pushed_block(False, kn))
    assert results.status == "unstable"
    assert list(results.unstable_blocks) == [1]


@pytest.mark.heavy
@pytest.mark.parametrize("case", [(10, 40.1, 40, "stable"), (5, 20, 40, "unstable"), (25, 40, 30, "unstable")])
def test_verdict_and_displacement_do_not_depend_on_frame_and_units(case):
    *given, status = case

    def stage_of(**frame):  # a limit of 5 m: how what has toppled continues is not looked at
        limit = bsm.Options(scheme="continuation", displacement_limit=5.0 * frame.get("scale", 1.0))
        return solve(incline(*given, **frame), limit).stages[-1]

    plain = stage_of()
    assert plain.status == status
    frames = [{"degrees": d} for d in (30.0, 90.0, 217.0)]
    units = [{"scale": 1e3}, {"scale": 1e-2, "force": 1e3}, {"force": 1e-6}]
    for frame in (*frames, *units):
        stage = stage_of(**frame)
        assert stage.status == status, frame
        assert list(stage.unstable_blocks) == list(plain.unstable_blocks)
        if status == "stable":
            back = turned(stage.displacement[:, :2] / frame.get("scale", 1.0), -frame.get("degrees", 0.0))
            assert_allclose(back, plain.displacement[:, :2], rtol=0, atol=1e-6 * max(plain.max_displacement, 0.1))
            assert_allclose(stage.displacement[:, 2], plain.displacement[:, 2], atol=1e-6)


@pytest.mark.parametrize("law", ["elastic", "friction"])
def test_a_wall_in_compression_agrees_with_the_linear_scheme(law):
    """Nothing slips or opens: they differ by displacement over block size, and a few matrices suffice."""
    walled = model_of(
        running_bond(6, 8), kn=1e10, supports=[bsm.Fixed(blocks=list(range(8)))], law=bsm.MohrCoulomb(friction=80)
    )
    if law == "elastic":
        walled = walled.replace(joints=(bsm.Joint("J", 1e10, 1e10),))
    linear, moving = bsm.run(walled, LINEAR).stages[-1], solve(walled).stages[-1]
    assert moving.status == "stable"
    size = linear.max_displacement
    assert_allclose(moving.displacement, linear.displacement, rtol=0, atol=20 * size * size / 0.5)
    assert sum(step.factorizations for step in moving.steps) <= 4
    assert_allclose(moving.contacts.normal_force.min(), linear.contacts.normal_force.min(), rtol=1e-3)
    assert_allclose(moving.reactions, linear.reactions, atol=1e-4 * moving.reference_weight)


@pytest.mark.parametrize(
    ("name", "friction"),
    [
        ("wall", 30),
        pytest.param("slab", 40, marks=pytest.mark.heavy),
        ("stack", 35),
        ("toppled", 40),
        ("arch", 89),
        ("thin arch", 89),
    ],
)
def test_a_stable_end_is_statically_admissible(name, friction):
    """The blocks where they reached rest can be at rest: a linear program over the forces in their contacts agrees."""
    slab = turned(rectangle(-0.4, 0, 0, 2), -15.0)
    model = {
        "wall": lambda: pushed_block(True, 1e10),
        "slab": lambda: model_of([rectangle(-5, -1, 5, 0), slab], friction=40, kn=1e10),
        "stack": lambda: model_of([rectangle(0.4 * k, 0.5 * k, 0.4 * k + 1, 0.5 * k + 0.5) for k in range(2)], kn=1e10),
        "toppled": lambda: incline(25, 40, 30, 1e10),
        "arch": lambda: arch(16, 0.12),
        "thin arch": lambda: arch(16, THICKNESS[16] * 1.01),
    }[name]()
    results = solve(model)
    assert results.status == "stable"
    assert admissible_at(results, friction)


def driven(displacement, degrees, aside=0.0):
    """Return two squares, the lower one moved in the direction 90 + `degrees` and held along `degrees`."""
    direction = {"direction": 90.0 + degrees, "displacement": displacement}
    supports = [bsm.PrescribedDisplacement(point=(x, 0), **direction) for x in (0.0, 1.0)]
    supports.append(bsm.Roller(point=(0.0, 0.0), direction=degrees))
    return model_of([rectangle(0, 0, 1, 1), rectangle(aside, 1, aside + 1, 2)], supports=supports)


@pytest.mark.parametrize("aside", [0.0, 0.3])
@pytest.mark.parametrize("degrees", [0.0, 30.0])
@pytest.mark.parametrize("displacement", [0.003, -0.003, 0.2, -0.2, 0.7])
def test_a_prescribed_displacement_carries_what_lies_on_it(displacement, degrees, aside):
    results = solve(driven(displacement, degrees, aside))
    stage = results.stages[-1]
    assert results.status == "stable"
    expected = displacement * np.array([-np.sin(np.radians(degrees)), np.cos(np.radians(degrees))])
    assert_allclose(stage.displacement[0, :2], expected, atol=1e-9)
    assert_allclose(stage.displacement[0, 2], 0, atol=1e-9)
    assert_allclose(stage.displacement[1, 1], expected[1], atol=1e-3)
    assert_allclose(stage.total_reaction, [0, 2 * GAMMA], atol=1e-4 * GAMMA)


@pytest.mark.heavy
def test_a_corner_lifted_past_the_friction_angle_lets_the_block_above_slide():
    polygons = [rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 1.5)]
    for lift, status in ((0.3, "stable"), (0.65, "unstable")):
        lifted = [
            bsm.PrescribedDisplacement(point=(0.0, 0.0), direction=90.0, displacement=lift),
            bsm.Fixed(point=(1.0, 0.0)),
        ]
        results = solve(model_of(polygons, friction=30, supports=lifted))
        assert results.status == status
        if status == "stable":
            assert_allclose(results.stages[-1].displacement[0, 2], -np.arcsin(lift), atol=1e-6)


@pytest.mark.heavy
@pytest.mark.parametrize(("friction", "status"), [(32.0, "stable"), (28.0, "unstable")])
def test_rollers_in_a_direction_of_30_degrees(friction, status):
    """A block on a slab that rollers normal to it carry and one along it holds; the slab leans by 30 degrees."""
    polygons = [turned(rectangle(0, 0, 2, 1), 30), turned(rectangle(0.5, 1, 1.5, 1.5), 30)]
    supports = [bsm.Roller(point=tuple(p), direction=120.0) for p in polygons[0][:2]]
    supports.append(bsm.Roller(point=(0.0, 0.0), direction=30.0))
    results = solve(model_of(polygons, friction=friction, supports=supports))
    assert results.status == status
    assert list(results.unstable_blocks) == ([1] if status == "unstable" else [])
    if status == "stable":
        assert_allclose(results.stages[-1].total_reaction, [0, 2.5 * GAMMA], atol=1e-5 * GAMMA)


def test_blocks_that_no_chain_of_contacts_joins_to_a_support_are_unstable():
    beside = solve(model_of([rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1), rectangle(5, 0, 6, 1)]))
    assert beside.status == "unstable"
    assert list(beside.unstable_blocks) == [1, 2]


@pytest.mark.parametrize("size", [0.1, 1.0])
def test_a_block_in_the_air_falls_from_where_it_was_given(size):
    """Beside blocks at rest: it falls until that is seen, and not beyond all bounds in one step."""
    polygons = [rectangle(0, 0, 10, 1), rectangle(4, 1, 5, 2), rectangle(7, 2.5, 7 + size, 2.5 + size)]
    results = bsm.run(model_of(polygons))
    assert results.status == "unstable"
    assert results.unstable_blocks.tolist() == [2]
    assert -2.0 < results.stages[-1].displacement[2, 1] < -0.01


def test_without_any_load_there_is_no_verdict():
    with pytest.raises(bsm.ModelError, match="nothing loads the model"):
        solve(model_of([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)], gamma=0.0))


@pytest.mark.heavy
@pytest.mark.parametrize(("drop", "status"), [(0.05, "stable"), (1.5, "unstable")])
def test_a_block_that_slides_over_a_ledge(drop, status):
    """It lands behind a low ledge and continues to the wall; in a fall of more than its size it is called free."""
    polygons = [
        rectangle(-2, -1, 4, 0),
        rectangle(4, -1 - drop, 9, -drop),
        rectangle(2, 0, 3, 1),
        rectangle(6, -drop, 7, 1),
    ]
    push = [bsm.PointLoad(block=2, point=(2, 0.3), force=(2e4, 0))]
    results = solve(model_of(polygons, friction=30, fixed=(0, 1, 3), loads=push))
    assert results.status == status
    if status == "stable":
        assert_allclose(results.stages[-1].displacement[2], [3, -drop, 0], atol=1e-3)


def glued(pull):
    """Return a unit block glued to a base by 20 kPa, lifted by `pull`."""
    joint = bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30, cohesion=5e3), tensile_strength=20e3)
    lift = [bsm.PointLoad(block=1, point=(0.5, 0.5), force=(0.0, pull))]
    return model_of([rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)], joint=joint, loads=lift)


def test_tensile_strength_holds_a_block_until_it_breaks():
    assert solve(glued(GAMMA + 19.9e3)).status == "stable"
    assert solve(glued(GAMMA + 20.1e3)).status == "unstable"


@pytest.mark.heavy
def test_saved_results_come_back(tmp_path):
    for model in (pushed_block(True, 1e9), pushed_block(False, 1e9)):
        results = solve(model)
        results.save(tmp_path)
        back = bsm.results.Results.load(tmp_path)
        old, new = results.stages[-1], back.stages[-1]
        assert back.status == results.status
        assert back.scheme == "continuation"
        assert new.reason == old.reason
        assert_allclose(new.displacement, old.displacement)
        assert_allclose(new.contacts.normal_force, old.contacts.normal_force)
        assert list(new.unstable_blocks) == list(old.unstable_blocks)
        assert len(new.steps) == len(old.steps)
        assert_allclose(back.check().block_residual, results.check().block_residual, rtol=1e-6, atol=1e-12)


CROSSING = [  # two joints that cross in (1.7044, 0.8132): blocks 2 and 3 meet in that point alone, 1 slides away
    [(-3.0, -1.0), (6.0, -1.0), (6.0, 0.0), (-3.0, 0.0)],
    [(0.1736, 1.9115), (0.0, 1.9429), (0.0, 0.3709), (1.7044, 0.8132)],
    [(2.3899, 1.5107), (0.1736, 1.9115), (1.7044, 0.8132), (2.4596, 1.0093)],
    [(0.0, 0.0), (2.5998, 0.0), (2.5734, 0.1897), (1.7044, 0.8132), (0.0, 0.3709)],
    [(2.8379, 0.0), (3.0, 0.0), (3.0, 1.1495), (2.4596, 1.0093), (2.5734, 0.1897)],
    [(2.3219, 2.0), (0.0, 2.0), (0.0, 1.9429), (2.3899, 1.5107)],
    [(3.0, 1.4004), (3.0, 2.0), (2.3219, 2.0), (2.3899, 1.5107)],
]
APEX = [
    [(-6, -1), (6, -1), (6, 0), (-6, 0)],
    [(-1, 0), (1, 0), (0, 1)],
    [(0, 1), (0.7, 1.7), (0, 2.4), (-0.7, 1.7)],
]


@pytest.mark.heavy
@pytest.mark.parametrize(("polygons", "fixed"), [(CROSSING, (0,)), (APEX, (0, 1))])
def test_wedges_that_meet_in_a_point_do_not_pass_through_each_other(polygons, fixed):
    model = model_of([np.array(p, dtype=float) for p in polygons], friction=10, fixed=fixed)
    results = bsm.run(model, MOVING)
    assert results.check().overlap <= 1.3e-3


@pytest.mark.heavy
@pytest.mark.parametrize("kn", [1e8, 1e12])
@pytest.mark.parametrize("friction", [0.0, 35.0])
@pytest.mark.parametrize("off", [0.0, 1e-3, -1e-3])
def test_a_square_balanced_on_its_corner_falls_on_a_face(off, friction, kn):
    """It is in equilibrium at 45 degrees, and falls from there; from beside it to the side on which it leans."""
    leaning = turned(rectangle(-0.5, -0.5, 0.5, 0.5), 45.0 + off)
    polygons = [rectangle(-3, -1, 3, 0), leaning - [0.0, leaning[:, 1].min()]]
    stage = bsm.run(model_of(polygons, kn=kn, friction=friction)).stages[-1]
    turn = np.degrees(stage.displacement[1, 2])
    assert stage.status == "stable"
    assert abs(turn) == pytest.approx(45.0, abs=0.1)
    assert off == 0 or np.sign(turn) == np.sign(off)
