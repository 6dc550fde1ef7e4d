"""Contact polygons in space found again where blocks have slid: clipping, edges, walls, what continues in them."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import bsm_mesh as bsm
from bsm_mesh.certificate.verify_certificate import main as verify
from bsm_mesh.movements import turned as turned_by
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.three_d.contacts.clipping import CORNER_OF_A, CORNER_OF_B, EDGES, clip, near_blocks
from bsm_mesh.three_d.contacts.contact_set import given_points
from bsm_mesh.three_d.contacts.history import SLOTS, PointHistory, faces_of
from bsm_mesh.three_d.step.block_system import BlockSystem
from tests.scenes.polyhedra import CELL_ARRAYS, box, model_in_space, rotation, turned
from tests.scenes.space_steps import assert_tangent

OPTIONS = bsm.Options(threads=1)
TABLES = [box((0, 0, -1), (0.5, 0.5, 0)), box((0.5, 0, -1), (1, 0.5, 0))]
CUBE = box((0, 0, 0), (0.5, 0.5, 0.5))
SQUARES = [box((0, 0, -0.5), (0.5, 0.5, 0)), box((0.5, 0, -0.5), (1, 0.5, 0))]
ROCK = [bsm.Rock("rock", unit_weight=26e3)]


def random_polygon(rng):
    """Return the corners of a convex polygon, counter-clockwise."""
    hull = shapely.MultiPoint(rng.normal(size=(8, 2)) + rng.normal(size=2)).convex_hull
    return np.array(shapely.geometry.polygon.orient(hull).exterior.coords)[:-1]


def shared_by(a, b, least):
    """Return corners (k, 2) that two polygons share, what meets there, and both numbers of it."""
    most = len(a) + len(b) + 2
    flat, corners, marks = np.zeros((2, most, 2)), np.empty((2, most, 2)), np.empty((2, most, 4), dtype=np.int64)
    flat[0, : len(a)], flat[1, : len(b)] = a, b
    count = clip(flat, len(a), len(b), least, corners, marks)
    return corners[0, :count], marks[0, :count, 0], marks[0, :count, 1:3]


@pytest.mark.parametrize("seed", range(20))
def test_what_two_polygons_share_is_what_shapely_says(seed):
    rng = np.random.default_rng(seed)
    a, b = random_polygon(rng), random_polygon(rng)
    corners, kind, edge = shared_by(a, b, 1e-9)
    whole = shapely.Polygon(a).intersection(shapely.Polygon(b))
    found = shapely.Polygon(corners) if len(corners) > 2 else shapely.Polygon()
    assert_allclose(found.symmetric_difference(whole).area, 0, atol=1e-8)
    ends = {CORNER_OF_A: a, CORNER_OF_B: b}
    for corner, of, (one, other) in zip(corners, kind, edge, strict=True):
        if of == EDGES:
            sides = [shapely.LineString([p[k], p[(k + 1) % len(p)]]) for p, k in ((a, one), (b, other))]
            assert max(side.distance(shapely.Point(corner)) for side in sides) < 1e-8
        else:
            assert np.linalg.norm(ends[of] - corner, axis=1).min() < 1e-8


@pytest.mark.parametrize("turned_over", [False, True])
def test_edges_within_rounding_of_each_other_cross_between_their_ends(turned_over):
    """An edge from .9 to 1.1 roundings outside another crosses the limit of rounding; not four lengths beside it."""
    a = np.array([(0, -0.9e-9), (1, -1.1e-9), (1, 1), (0, 1)])
    a = a[[1, 0, 3, 2]] * (-1, 1) + (1, 0) if turned_over else a
    corners, _, _ = shared_by(a, np.array([(-9.0, 0), (9, 0), (9, 9), (-9, 9)]), 1e-9)
    assert ((corners > -1e-8) & (corners < 1 + 1e-8)).all()


def test_pairs_of_near_blocks_are_those_whose_boxes_are_near():
    rng = np.random.default_rng(3)
    low = rng.uniform(size=(60, 3))
    high, moves = low + rng.uniform(0, 0.2, size=(60, 3)), rng.uniform(size=60) < 0.5
    apart = np.maximum(low[:, None] - high[None], low[None] - high[:, None]).max(axis=2)
    exact = {(i, j) for i in range(60) for j in range(i + 1, 60) if apart[i, j] <= 0.05 and (moves[i] or moves[j])}
    assert {tuple(pair) for pair in near_blocks(low, high, moves, 0.05)} == exact


def system_and_contacts(movement, tilt=(0.2, -0.3, 0.15)):
    """Return the block system of a cube on the first of two tables, and contacts where the cube moved (6,).

    The whole model is turned.
    """
    model = model_in_space([*TABLES, CUBE], fixed=(0, 1), kn=1e7, ks=3e6)
    engine = Continuation(model, OPTIONS, lambda *_: None)
    system, turn = engine.system, np.tile(tilt, (3, 1))
    position = np.hstack([turned_by(system.centroid, turn) - system.centroid, turn])
    moved = np.zeros_like(position)
    moved[2] = movement
    moved[:, :3], moved[:, 3:] = (turned_by(moved[:, c : c + 3], turn) for c in (0, 3))
    position = system.moved_by(position, moved)
    first = system.gather(PointHistory.none(), system.start, first=True)
    history, _ = system.commit(first, system.evaluate(first, system.start), system.start)
    return engine, system.gather(history, position, first=False), position


def areas(contacts):
    """Return the area in which the cube touches either table."""
    c = contacts.candidates
    return [c.length[(c.block_a == table) | (c.block_b == table)].sum() for table in (0, 1)]


@pytest.mark.parametrize("cube", [0, 1])
@pytest.mark.parametrize(("slide", "crossings_with_cube"), [((0.3, 0), False), ((0, 0.3), True)])
def test_contact_points_go_with_the_block_with_which_they_move(cube, slide, crossings_with_cube):
    """A cube over the edge of a table: its corners go with it, crossings with the table or, along its edge, with it."""
    solids = [box((-1, -1, -1), (0.5, 2, 0)), box((0.2, 0, 0), (0.7, 0.5, 0.5)) if slide[1] else CUBE]
    system = BlockSystem(model_in_space(solids[:: 1 if cube else -1], fixed=(1 - cube,)))
    position = system.start.copy()
    position[cube, :2] = slide
    contacts = system.gather(PointHistory.none(), position, first=False)
    c, corner = contacts.candidates, contacts.key % SLOTS < SLOTS - 1
    _, _, arm, _ = contacts.frames(position)
    at_edge = (system.placed(position)[c.block_a] + arm)[corner, 0] > 0.5 - 1e-9
    assert at_edge.tolist().count(True) == 2
    assert ((c.block_a == cube)[corner] == (~at_edge | crossings_with_cube)).all()
    at = system.evaluate(contacts, position)
    history, _ = system.commit(contacts, at, position)
    again = system.gather(history, position, first=False)
    assert_allclose(again.candidates.length.sum(), 0.5 * (0.3 if slide[1] else 0.2), rtol=1e-9)
    assert again.key.tolist() == contacts.key.tolist()


@pytest.mark.parametrize("cube", [0, 1])
def test_points_as_given_lie_on_the_block_that_slides_on_a_larger_plane(cube):
    """A cube on one half of a base of two cells, whichever is numbered first."""
    solids = [*SQUARES, CUBE]
    cells = bsm.Polyhedra.from_solids(solids if cube else solids[::-1], rock="rock")
    arrays = {name: getattr(cells, name) for name in CELL_ARRAYS}
    number = np.array([0, 0, 1] if cube else [0, 1, 1], np.int32)
    blocks = bsm.Polyhedra(**arrays, cell_block=number, rock=np.zeros(2, np.int32))
    points = given_points(model_in_space([CUBE]).replace(blocks=blocks, rocks=ROCK, supports=[]), np.zeros(2, bool))
    assert len(points.key) == 5
    assert (points.block_a == cube).all()


@pytest.mark.parametrize("cube", [0, 1])
def test_points_at_the_foot_of_a_step_lie_on_the_block_that_stands_there(cube):
    """The rock of a step goes on below its foot and has no corner there. A block that tilts takes its own along."""
    solids = [*SQUARES, box((0.5, 0, 0), (1, 0.5, 0.5)), CUBE]
    cells = bsm.Polyhedra.from_solids(solids if cube else solids[::-1], rock="rock")
    arrays = {name: getattr(cells, name) for name in CELL_ARRAYS}
    number = np.array([0, 0, 0, 1] if cube else [0, 1, 1, 1], np.int32)
    blocks = bsm.Polyhedra(**arrays, cell_block=number, rock=np.zeros(2, np.int32))
    points = given_points(model_in_space([CUBE]).replace(blocks=blocks, rocks=ROCK, supports=[]), np.zeros(2, bool))
    place = blocks.moments.centroid[points.block_a] + points.geometry[:, :3]
    foot = np.isclose(place[:, 0], 0.5) & np.isclose(place[:, 2], 0)
    assert foot.sum() == 4  # two of the step, two of the floor
    assert (points.block_a[foot] == cube).all()
    assert (np.einsum("ij,ij->i", points.geometry[foot, 6:9], [CUBE[0].mean(axis=0)] - place[foot]) > 0).all()


def test_stiffness_is_that_of_both_rocks_whichever_block_a_point_lies_on():
    """Half the cube is over the edge: corners lie on it, crossings on the table. Rocks and depths differ."""
    model = model_in_space([box((-1, -1, -2), (0.5, 2, 0)), CUBE], fixed=(0,))
    rocks = [
        bsm.Rock(name, unit_weight=26e3, young=young, poisson=0.2) for name, young in (("granite", 1e7), ("marl", 1e6))
    ]
    blocks = model.blocks
    arrays = {name: getattr(blocks, name) for name in (*CELL_ARRAYS, "cell_block")}
    arrays["rock_names"] = ("granite", "marl")
    two = bsm.Polyhedra(**arrays, rock=np.array([0, 1], np.int32))
    system = BlockSystem(model.replace(blocks=two, rocks=rocks))
    position = system.start.copy()
    position[1, :3] = 0.3, 0, -1e-4
    contacts = system.gather(PointHistory.none(), position, first=False)
    assert set(contacts.candidates.block_a) == {0, 1}
    stiffness = contacts.normal_stiffness / contacts.candidates.length
    assert_allclose(stiffness, stiffness[0], rtol=1e-3)


@pytest.mark.parametrize("slide", [0.1, 0.3, 0.45])
def test_a_cube_that_slides_from_one_block_to_the_next_bears_on_both(slide):
    """Areas are exact, so are force and moment of a uniform penetration."""
    engine, contacts, position = system_and_contacts((slide, 0, -1e-4, 0, 0, 0))
    assert_allclose(areas(contacts), [0.5 * (0.5 - slide), 0.5 * slide], rtol=1e-9)
    at = engine.system.evaluate(contacts, position)
    force, moment = (turned_by(at.forces[2:, c : c + 3], -np.array([[0.2, -0.3, 0.15]]))[0] for c in (0, 3))
    assert_allclose(force, [0, 0, 1e7 * 0.25 * 1e-4], atol=1e-6)
    assert_allclose(moment, 0, atol=1e-6)


def test_free_faces_of_rigid_rock_without_a_joint_do_not_touch():
    """The wall and the cube's front have no joint; what has one, the cube's bottom, touches what it comes to."""
    wall = box((1, 0, 0), (1.5, 0.5, 0.5))
    model = model_in_space([*TABLES, CUBE, wall], fixed=(0, 1, 3)).replace(default_joint=None)
    system = Continuation(model, OPTIONS, lambda *_: None).system
    position = system.start.copy()
    position[2, :3] = 0.48, 0, -1e-4
    first = system.gather(PointHistory.none(), system.start, first=True)
    history, _ = system.commit(first, system.evaluate(first, system.start), system.start)
    contacts = system.gather(history, position, first=False)
    assert_allclose(areas(contacts), [0.5 * 0.02, 0.5 * 0.48], rtol=1e-9)
    assert 3 not in [*contacts.candidates.block_a, *contacts.candidates.block_b]


def test_half_a_cube_over_the_edge_bears_on_the_rest():
    _, contacts, _ = system_and_contacts((0.75, 0, -1e-4, 0, 0, 0))
    assert_allclose(areas(contacts), [0, 0.5 * 0.25], atol=1e-12)


def test_a_cube_that_has_not_slid_keeps_its_polygons():
    _, contacts, _ = system_and_contacts((0.01, 0, -1e-4, 0, 0, 0), tilt=(0, 0, 0))
    assert not len(contacts.renewed.key)
    face_a, face_b = faces_of(contacts.key)
    assert (face_a == face_b).all()


@pytest.mark.parametrize("movement", [(0.2, 0.1, -2e-3, 0.01, 0.02, 0.3), (0.7, 0.1, 0.132, 0.02, 0.3, 0.1)])
def test_the_tangent_of_renewed_contacts_is_the_derivative_of_their_forces(movement):
    """Flat and tilted: corners on faces, faces on corners, edges on edges."""
    engine, contacts, position = system_and_contacts(movement)
    step = StepEquations(engine.system, engine.factors, contacts, position, 0.0)
    down = np.zeros_like(position)
    down[2] = 1e-4, 2e-4, -5e-3, 1e-3, 2e-3, 1e-3
    position = step.moved_by(position, down)
    at = step.evaluate(position)
    assert at.closed.any()
    moment = at.forces[:, 3:] + np.cross(step.system.placed(position), at.forces[:, :3])
    assert_allclose(moment.sum(axis=0), 0, atol=1e-9 * np.abs(at.forces).max())
    assert_tangent(step, position)


def test_shear_and_slip_go_on_where_polygons_are_found_again():
    """Of a cube that slides at its full strength: force, slip and failure of all points together."""
    engine, contacts, position = system_and_contacts((0.002, 0, -1e-4, 0, 0, 0))
    system = engine.system
    at = system.evaluate(contacts, position)
    history, _ = system.commit(contacts, at, position)
    position = position.copy()
    position[2, :3] += turned_by(np.array([[0.04, 0, 0]]), np.array([[0.2, -0.3, 0.15]]))[0]
    again = system.gather(history, position, first=False)
    assert len(again.renewed.key)
    after = system.evaluate(again, position)
    here = again.candidates.history >= 0
    c = again.candidates
    table = np.minimum(c.block_a, c.block_b) == 0
    on_cube = np.where(c.block_a == 2, 1.0, -1.0)[:, None] * turned_by(again.old_shear, position[c.block_b, 3:])
    total = np.linalg.norm(on_cube[table].sum(axis=0))
    assert_allclose(total, np.tan(np.radians(30)) * 1e7 * 1e-4 * 0.25, rtol=1e-6)
    assert (after.size <= after.strength * (1 + 1e-12)).all()
    slid = again.along(again.old_place - again.first_place)
    slid = np.where(c.block_a == 2, 1.0, -1.0)[:, None] * turned_by(slid, position[c.block_b, 3:])
    way = turned_by(np.array([[0.002, 0, 0]]), np.array([[0.2, -0.3, 0.15]]))[0]
    assert_allclose(slid[table & here], np.tile(way, (sum(table & here), 1)), atol=1e-12)
    assert again.mated[table & here].all()


def test_a_polygon_that_is_gone_leaves_forces_on_its_faces_alone():
    """A cube on two tables has come to one of them: the other's polygon, as given, is stale at every search."""
    cube = box((0.25, 0, 0), (0.75, 0.5, 0.5))
    system = BlockSystem(model_in_space([*TABLES, cube], fixed=(0, 1), kn=1e7, ks=3e6))
    history, position = PointHistory.none(), system.start.copy()
    position[2, :3] = -0.25, 0, -1e-4
    for _ in range(2):
        contacts = system.gather(history, position, first=False)
        history, _ = system.commit(contacts, system.evaluate(contacts, position), position)
        assert 1 not in [*contacts.candidates.block_a, *contacts.candidates.block_b]
    shear = np.zeros_like(history.shear)
    shear[0, 0] = 1.0  # in one point alone
    again = system.gather(replace(history, shear=shear), position, first=False)
    assert_allclose(again.old_shear[again.key == history.key[0]], shear[:1])


@pytest.fixture(scope="module")
def stopped():
    """Return results of a cube that slides down to a wall: neither touches the other as given."""
    wall = [box((1, 0, -1), (1.2, 1, 0)), box((1.2, 0, -1), (2.2, 1, 0)), box((1.2, 0, 0), (2.2, 1, 1))]
    solids = [box((0, 0, -1), (1, 1, 0)), *wall, box((0, 0, 0), (1, 1, 1))]
    model = model_in_space(turned(solids, rotation(0, 35)), fixed=(0, 1, 2, 3), friction=20)
    return bsm.run(model, OPTIONS)


@pytest.mark.heavy
def test_a_cube_slides_to_a_wall_and_rests_on_it(stopped):
    """The way is the gap, to a thousandth; the tables and the wall, which pushes back, carry the weight."""
    stage = stopped.stages[0]
    along, across = np.array([[np.cos(a), 0, -np.sin(a)] for a in np.radians([35, -55])])
    assert (stage.status, stage.displacement[4, :3] @ along) == ("stable", pytest.approx(0.2, rel=1e-3))
    c = stage.contacts
    push = np.where(c.block_b == 4, 1.0, -1.0)[:, None] * c.force
    on = [push[((c.block_a == k) | (c.block_b == k)) & (c.block_a + c.block_b == k + 4)].sum(axis=0) for k in range(4)]
    assert_allclose(np.sum(on, axis=0), [0, 0, 26e3], atol=1.0)
    assert on[3] @ along < 0
    assert on[0] @ across > 0
    assert on[1] @ across > 0


@pytest.mark.heavy
def test_its_certificate_holds(stopped, tmp_path):
    stopped.save(tmp_path / "out")
    assert verify(tmp_path / "out") == 0


def slide_at(turn, dip, friction, half, overhang):
    """Return the slides [m] at which a rigid cube on the edge of a table has turned by angles (k,) [rad].

    Its bottom slides over the edge with friction. It begins to turn where the reaction, which friction moves ahead of
    the centre by ``half * tan(friction)``, reaches the edge at ``overhang`` before the centre's start.
    """
    mu, gravity = np.tan(friction), 9.81 * np.array([np.sin(dip), -np.cos(dip)])
    onset = overhang - mu * half

    def rates(_, y):
        s, angle, speed, spin = y  # of the centre past the edge along the bottom
        c, e = np.cos(angle), np.sin(angle)
        along, across = np.array([c, -e]), np.array([e, c])
        turning = s * np.array([-e, -c]) + half * np.array([c, -e])
        curved = 2 * speed * spin * np.array([-e, -c]) + spin**2 * (s * np.array([-c, e]) + half * np.array([-e, -c]))
        push = across - mu * along
        matrix = np.array([[*pair] for pair in zip(along, turning, -push, strict=True)])
        matrix = np.vstack([matrix, [0, 2 * half**2 / 3, -(s + mu * half)]])
        return [speed, spin, *np.linalg.solve(matrix, [*(gravity - curved), 0])[:2]]

    start = [-mu * half, 0, np.sqrt(2 * (gravity[0] + mu * gravity[1]) * onset), 0]
    path = solve_ivp(rates, (0, 0.4), start, rtol=1e-9, max_step=1e-3).y
    return np.interp(turn, path[1], overhang + path[0] * np.cos(path[1]) + half * np.sin(path[1]))


@pytest.mark.heavy
def test_a_cube_pushed_over_an_edge_turns_as_a_rigid_body_does_and_falls():
    """By 1, 5 and 10 degrees where the equations of motion say, to a hundredth; by no degree before."""
    turns, dip, at = [], 35.0, np.radians([1, 5, 10])
    back = rotation(0, dip).T

    def observe(record, state):
        movement = state().position[2]
        turns.append([(back @ movement[:3])[0], (back @ movement[3:])[1]])

    model = model_in_space(turned([*TABLES, CUBE], rotation(0, dip)), fixed=(0, 1))
    end = Continuation(model, OPTIONS, observe).run()
    slide, turn = np.array(turns).T
    assert (end.status, end.unstable_blocks.tolist()) == ("unstable", [2])
    assert turn[slide < 0.58].max() < np.radians(0.1)
    exact = slide_at(at, np.radians(dip), np.radians(30), 0.25, 0.75)
    assert_allclose(np.interp(at, turn[slide > 0.58], slide[slide > 0.58]), exact, rtol=0.01)


@pytest.mark.heavy
@pytest.mark.parametrize("base", [0, 2])
def test_a_stack_slides_evenly_whatever_its_numbers(base):
    """The base pushes it by its weight across the slope, to a thousandth, over two lengths of a block."""
    pushes, back = [], rotation(0, 35).T

    def observe(record, state):
        motion = state()
        pushes.append([(back @ motion.position[1, :3])[0], (back @ motion.at.forces[base, :3])[2]])

    solids = [box((0.3, 0.1, 0), (1.3, 0.9, 0.6)), box((0.3, 0.1, 0.6), (1.3, 0.9, 1.2))]
    solids.insert(base, box((0, -1, -1), (8, 2, 0)))
    model = model_in_space(turned(solids, rotation(0, 35)), fixed=(base,), friction=20)
    assert Continuation(model, OPTIONS, observe).run().status == "unstable"
    slide, push = np.array(pushes).T
    weight = model.unit_weights[0] * 2 * 0.48 * np.cos(np.radians(35))
    assert slide.max() > 2
    assert_allclose(-push[slide > 0.5], weight, rtol=1e-3)
