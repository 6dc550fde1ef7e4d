"""Rock cut into cells by planes, discs and bodies: volumes exact to rounding, cells closed, faces shared."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.geometries import Exponential, GeometryError, three_d
from bsm_mesh.geometries.orientations import upward_normals
from bsm_mesh.geometries.three_d import rock_mass
from bsm_mesh.geometries.three_d.cell_complex import CellComplex
from bsm_mesh.geometries.three_d.crowding import expected_cells
from tests.scenes.rock_3d import planes, tunnel_rock

ROUNDING = 1e-12  # of a volume of some thousand m3
BOX = ((-3.0, -2.0, 0.0), (3.0, 3.0, 4.0))
VOLUME = 6 * 5 * 4


def blocks_of(**rock):
    return bsm.Polyhedra.from_cells(three_d.cut_cells(three_d.RockMass(**{"box": BOX, **rock})))


def a_set(name, dip, direction, **others):
    return three_d.JointSet(name=name, dip=dip, dip_direction=direction, **others)


def test_three_sets_at_right_angles_cut_cubes():
    sets = [a_set("A", 0, 0, spacing=1.0, origin=BOX[0])]
    sets += [a_set(f"B{d}", 90, d, spacing=1.0, origin=BOX[0]) for d in (0, 90)]
    blocks = blocks_of(joints=sets)
    assert blocks.count == VOLUME
    assert_allclose(blocks.moments.volume, 1, rtol=ROUNDING)
    assert blocks.contact_polygons.count == 5 * 5 * 4 + 6 * 4 * 4 + 6 * 5 * 3
    assert {name: len(faces) for name, faces in blocks.boundaries.items()} == {
        "bottom": 30, "top": 30, "south": 24, "north": 24, "west": 20, "east": 20,
    }  # fmt: skip


def test_every_block_lies_on_one_side_of_every_plane():
    """As many blocks as there are combinations of sides among random points and centroids; none is on both sides."""
    joints = planes(*BOX, 1.3, seed=4)
    blocks = blocks_of(joints=joints)
    normal = np.concatenate([upward_normals(np.array([j.dip]), np.array([j.dip_direction])) for j in joints])
    offset = (normal * np.array([j.point for j in joints])).sum(axis=1)
    sides = blocks.moments.centroid @ normal.T > offset
    assert len(np.unique(sides, axis=0)) == blocks.count
    points = np.random.default_rng(1).uniform(*BOX, size=(20_000, 3))
    known = {row.tobytes() for row in sides}
    assert {row.tobytes() for row in points @ normal.T > offset} <= known
    for block in range(blocks.count):
        corners = np.concatenate([blocks.polygon(face) for face in blocks.block_faces(block)])
        height = corners @ normal.T - offset
        assert (height * np.where(sides[block], 1, -1) > -1e-8).all()


@pytest.mark.parametrize(
    "joints",
    [
        [a_set("A", 50, 20, spacing=0.8, scatter=20), a_set("B", 70, 200, spacing=Exponential(1.0), scatter=50)],
        [a_set("A", 20, 0, spacing=1.0), a_set("B", 80, 100, spacing=0.7, persistence=0.5)],
        [a_set("A", 20, 0, spacing=1.0), a_set("B", 80, 100, density=1.0, radius=Exponential(1.0), scatter=30)],
        [a_set("A", 45, 0, spacing=1.0, origin=BOX[0]), a_set("B", 45, 180, spacing=1.0, origin=BOX[0])],
    ],
    ids=["scatter", "persistence", "discs", "through corners"],
)
@pytest.mark.parametrize("shift", [0.0, 4.5e6])
def test_no_volume_is_lost(joints, shift):
    low, high = np.add(BOX, (shift, shift, 0))
    moved = [three_d.JointSet(**{**fields(j), "origin": low}) if j.origin is not None else j for j in joints]
    blocks = blocks_of(box=(low, high), joints=moved, seed=3)
    assert blocks.count > 10
    assert_allclose(blocks.moments.volume.sum(), VOLUME, rtol=ROUNDING if shift == 0 else 1e-8)
    polygons = blocks.contact_polygons
    height = (polygons.corners - polygons.centroid[owner(polygons)]) * polygons.normal[owner(polygons)]
    assert_allclose(height.sum(axis=1), 0, atol=1e-8)  # plane to what is taken as touching
    assert (polygons.points("both").area > 0).all()


def fields(joint):
    return {name: getattr(joint, name) for name in joint.__slots__}


def owner(polygons):
    return np.repeat(np.arange(polygons.count), np.diff(polygons.offsets))


def test_a_disc_cuts_the_cells_whose_sections_have_their_centre_inside_it():
    layers = a_set("A", 90, 90, spacing=1.0, origin=BOX[0])
    disc = three_d.JointPlane(name="D", dip=0, dip_direction=0, point=(0, 0.5, 2), radius=1.2)
    blocks = blocks_of(joints=[layers, disc])
    assert blocks.count == 6 + 2  # of six layers those with centres .5 from the disc's centre
    cut = blocks.contact_polygons.joint == blocks.joint_names.index("D")
    assert_allclose(blocks.contact_polygons.area[cut], 5, rtol=ROUNDING)


@pytest.mark.heavy
def test_persistence_cuts_a_part_of_the_cells():
    sets = [a_set("A", 90, 90, spacing=0.1, origin=BOX[0]), a_set("B", 0, 0, spacing=0.2, origin=BOX[0])]
    whole = blocks_of(joints=sets)
    sets[1] = a_set("B", 0, 0, spacing=0.2, origin=BOX[0], persistence=0.3)
    parted = blocks_of(joints=sets)
    per_plane = (whole.count - 60) * 0.3
    assert parted.count - 60 == pytest.approx(per_plane, abs=4 * np.sqrt(per_plane * 0.7))
    assert_allclose(parted.moments.volume.sum(), VOLUME, rtol=ROUNDING)


def test_spacing_and_scatter_are_those_asked_for():
    drawn = a_set("A", 60, 120, spacing=Exponential(0.01), scatter=50).planes(*np.array(BOX), 1)
    mean = upward_normals(np.array([60.0]), np.array([120.0]))[0]
    place = np.sort(drawn.point @ mean)
    assert np.diff(place).mean() == pytest.approx(0.01, rel=0.05)
    resultant = np.linalg.norm(drawn.normal.sum(axis=0)) / len(drawn.normal)
    assert resultant == pytest.approx(1 / np.tanh(50) - 1 / 50, rel=2e-3)  # Fisher (1953)
    assert drawn.normal.mean(axis=0) @ mean / resultant == pytest.approx(1, abs=2e-3)


def test_a_network_of_discs_has_its_area_a_volume():
    drawn = a_set("A", 60, 120, density=20.0, radius=Exponential(0.5)).planes(*np.array(BOX), 1)
    inside = ((drawn.point > BOX[0]) & (drawn.point < BOX[1])).all(axis=1)
    assert np.pi * np.square(drawn.radius[inside]).sum() / VOLUME == pytest.approx(20, rel=0.1)


def test_a_tunnel_takes_its_volume_and_leaves_its_wall():
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock()))
    assert blocks.count == 1364
    profile = 10 * 4.0**2 * np.tan(np.pi / 10)
    assert_allclose(blocks.moments.volume.sum(), (24 * 24 - profile) * 16, rtol=ROUNDING)
    wall = blocks.boundaries["tunnel"]
    corners = blocks.vertices[
        np.concatenate([blocks.face_vertices[slice(*blocks.face_offsets[f : f + 2])] for f in wall])
    ]
    assert np.hypot(corners[:, 0], corners[:, 2]).max() < 4.0 / np.cos(np.pi / 10) + 1e-9


@pytest.mark.parametrize("trend", [0, 33])
def test_a_profile_need_not_be_convex(trend):
    """An L of three squares along an axis; as an excavation it divides the block, and its rock stays."""
    corner = [(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)]
    body = three_d.prism(corner, trend=trend, origin=(0, 0, 2), length=1.0)
    blocks = blocks_of(bodies=[three_d.Excavation(body=body, name="heading")])
    assert blocks.count == 2
    assert_allclose(blocks.moments.volume[blocks.excavations["heading"]], [3.0], rtol=ROUNDING)
    assert_allclose(blocks.moments.volume.sum(), VOLUME, rtol=ROUNDING)
    assert set(blocks.contact_polygons.joint) == {-1}


def test_a_slope_leaves_the_rock_below_face_and_top():
    """In the vertical plane through x: a floor of 3 m width, a face of 45 degrees and 2 m height, a level top."""
    air = three_d.slope(toe=(0, 0, 1), dip=45, dip_direction=90, height=2)
    blocks = blocks_of(bodies=[three_d.Opening(body=air, boundary="slope")])
    section = 3 * 1 + 2 * (1 + 3) / 2 + 1 * 3  # in front of the toe, under the face, behind the crest
    assert_allclose(blocks.moments.volume, [section * 5], rtol=ROUNDING)
    assert len(blocks.boundary_faces("slope")) >= 3


def test_a_hull_is_convex():
    cube = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (1, 2)]
    body = three_d.hull([*cube, (0.5, 0.5, 1.5)])
    blocks = blocks_of(bodies=[three_d.Opening(body=body, boundary="cavern")])
    assert len(body[0].offset) == 6
    assert_allclose(blocks.moments.volume.sum(), VOLUME - 1, rtol=ROUNDING)


def test_the_same_seed_gives_the_same_cells_and_another_set_changes_nothing():
    one = a_set("A", 50, 20, spacing=Exponential(1.0), scatter=20)
    first, again = (one.planes(*np.array(BOX), 5) for _ in range(2))
    assert np.array_equal(first.normal, again.normal)
    assert not np.array_equal(first.normal, one.planes(*np.array(BOX), 6).normal[: len(first.normal)])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: a_set("A", 95, 0, spacing=1.0), "dip = 95 must lie from 0 to 90 degrees"),
        (lambda: a_set("A", np.int64(95), 0, spacing=1.0), "dip = 95 must lie from 0 to 90 degrees"),
        (lambda: a_set("A", 45, 0), "give one of spacing"),
        (lambda: three_d.RockMass(box=BOX, joints=None), "joints = None must be a list"),
        (lambda: three_d.RockMass(box=BOX, bodies=[3]), r"bodies = \[3\] must be a list"),
        (lambda: three_d.Opening(body=3), "Opening: body = 3 must be a list"),
        (lambda: three_d.Excavation(body=[], name=""), "Excavation: name = '' cannot name a group"),
        (lambda: three_d.hull(None), "hull: give four or more points"),
        (lambda: three_d.cut_cells(None), r"cut_cells: rock = None must be a RockMass of geometries\.three_d"),
        (lambda: a_set("A", 45, 0, density=1.0), "density .* and radius .* go together"),
        (lambda: a_set("A", 45, 0, spacing=1.0, persistence=1.2), "persistence = 1.2 must be above 0 and at most 1"),
        (lambda: a_set("A", 45, 0, spacing=1.0, origin=(0, 0)), "origin = .* must be three numbers"),
        (lambda: three_d.RockMass(box=((0, 0, 0), (1, 0, 1))), "every coordinate of the second corner"),
        (lambda: three_d.prism([(0, 0), (1, 1), (1, 0), (0, 1)]), "no simple polygon"),
        (lambda: three_d.hull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]), "do not lie in one plane"),
        (
            lambda: blocks_of(joints=[three_d.JointPlane(name="F", dip=0, dip_direction=0, point=(0, 0, 9))]),
            "joint 'F' cuts no rock",
        ),
        (
            lambda: blocks_of(bodies=[three_d.Excavation(body=three_d.prism([(8, 0), (9, 0), (9, 1)]), name="E")]),
            "excavation 'E': there is no rock in it",
        ),
        (
            lambda: blocks_of(bodies=[three_d.Opening(body=three_d.prism([(-9, -9), (9, -9), (9, 9), (-9, 9)]))]),
            "the openings leave no rock",
        ),
    ],
)
def test_bad_descriptions_are_named(make, message):
    with pytest.raises(GeometryError, match=message):
        make()


@pytest.mark.heavy
def test_blocks_are_counted_before_they_are_cut():
    """Cubes to a seventh, for planes at the rim of the box count; scattered planes to a twentieth."""
    cubes = [a_set(f"A{d}{a}", d, a, spacing=0.25) for d, a in ((0, 0), (90, 0), (90, 90))]
    assert_allclose(expected(cubes), VOLUME * 4**3, rtol=0.15)
    walls = [a_set("A", 90, 0, spacing=0.05), a_set("B", 90, 90, spacing=0.05)]
    assert_allclose(expected(walls), 120 * 100, rtol=0.05)
    scattered = [a_set("A", 20, 0, spacing=0.6, scatter=40), a_set("B", 80, 100, spacing=0.5, scatter=40)]
    scattered.append(a_set("C", 70, 20, spacing=0.7, scatter=40))
    assert_allclose(expected(scattered), blocks_of(joints=scattered).count, rtol=0.05)
    assert expected([]) == 1


def expected(joints):
    low, high = np.array(BOX)
    return expected_cells([(j.planes(low, high, 0), j.persistence) for j in joints], low, high)


def test_spacings_in_millimetres_are_refused_before_rock_is_cut(monkeypatch):
    monkeypatch.setattr(CellComplex, "cut", lambda *_, **__: pytest.fail("rock was cut"))
    sets = [a_set(f"A{d}{a}", d, a, spacing=0.002) for d, a in ((0, 0), (90, 0), (90, 90))]
    with pytest.raises(GeometryError, match=r"into about 2e\+10 blocks.*check that lengths are in metres"):
        blocks_of(joints=sets)


def test_more_blocks_than_a_machine_holds_are_refused(monkeypatch):
    monkeypatch.setattr(rock_mass, "MAX_CELLS", 20)
    monkeypatch.setattr(rock_mass, "CROWDED", np.inf)
    sets = [three_d.JointSet(name=f"J{dip}", dip=dip, dip_direction=0, spacing=0.1) for dip in (0, 90)]
    with pytest.raises(GeometryError, match="'J0': the joints cut the box into more than"):
        three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (10, 10, 10)), joints=sets))
