"""Polyhedral blocks: volumes, inertia and contact polygons to rounding; closed forms of boxes and tetrahedra."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.flats import flat_areas
from tests.scenes.polyhedra import BOX_FACES, box

BELOW, ABOVE = box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))
ROUNDING = 1e-12  # of volumes and moments of bodies some metres large


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def two_boxes(turn=None, shift=(0, 0, 0)):
    turn = np.eye(3) if turn is None else turn
    solids = [box((0, 0, 0), (2, 3, 1)), box((0, 0, 1), (2, 3, 5))]
    solids = [(corners @ turn.T + shift, faces) for corners, faces in solids]
    return bsm.Polyhedra.from_solids(solids, rock="granite", joint="J1")


@pytest.mark.parametrize("shift", [(0, 0, 0), (4.5e6, 5.2e6, 300)])
def test_volume_centroid_and_inertia_of_turned_boxes(shift):
    turn = rotation(3)
    blocks = two_boxes(turn, shift)
    tolerance = ROUNDING if shift[0] == 0 else 1e-8  # a northing has nine digits behind the point
    assert_allclose(blocks.moments.volume, [6, 24], rtol=tolerance)
    assert_allclose(blocks.moments.centroid, [(1, 1.5, 0.5), (1, 1.5, 3)] @ turn.T + shift, atol=tolerance * 10)
    for inertia, (a, b, c) in zip(blocks.moments.inertia, [(2, 3, 1), (2, 3, 4)], strict=True):
        mass = a * b * c
        exact = turn @ np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) @ turn.T * mass / 12
        assert_allclose(inertia, exact, atol=10 * tolerance * mass)


def test_inertia_of_a_tetrahedron():
    """Second moments of the corner tetrahedron about its apex: x^2 1/60, x y 1/120."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    blocks = bsm.Polyhedra.from_solids([(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])], rock="a")
    second = np.full((3, 3), 1 / 120) + np.eye(3) / 120 - np.full((3, 3), 1 / 16) / 6
    assert_allclose(blocks.moments.inertia[0], np.trace(second) * np.eye(3) - second, atol=1e-16)


def test_the_contact_polygon_of_two_boxes():
    polygons = two_boxes().contact_polygons
    assert polygons.count == 1
    below, above = 0, 1
    assert {int(polygons.block_a[0]), int(polygons.block_b[0])} == {below, above}
    outward = 1 if polygons.block_b[0] == below else -1  # of block_b
    assert_allclose(polygons.normal[0], (0, 0, outward), atol=ROUNDING)
    assert_allclose(polygons.area, [6], rtol=ROUNDING)
    assert_allclose(polygons.centroid, [(1, 1.5, 1)], rtol=ROUNDING)
    assert_allclose(polygons.polar_moment, [2 * 3 * (4 + 9) / 12], rtol=ROUNDING)
    assert polygons.joint.tolist() == [0]


def one_polygon(corners):
    corners = np.asarray(corners, dtype=float)
    zero = np.zeros(1, np.int32)
    offsets = np.array([0, len(corners)], np.int32)
    return ContactPolygons(block_a=zero, block_b=zero + 1, joint=zero, face=zero, corners=corners, offsets=offsets)


POLYGONS = {
    "rectangle": [(0, 0), (3, 0), (3, 1), (0, 1)],
    "triangle": [(0, 0), (4, 1), (1, 2)],
    "pentagon": [(0, 0), (2, -1), (5, 1), (4, 3), (0.5, 2)],
    "with a short side": [(0, 0), (2, 0), (2, 1e-3), (1, 2)],
}


@pytest.mark.parametrize("name", POLYGONS)
@pytest.mark.parametrize("rule", ["corners", "both"])
def test_contact_points_bear_a_uniform_pressure_without_moment(name, rule):
    flat = np.column_stack([POLYGONS[name], np.zeros(len(POLYGONS[name]))])
    polygons = one_polygon(flat @ rotation(5).T + (3, 1, 2))
    points = polygons.points(rule)
    arm = points.point - polygons.centroid[0]
    assert_allclose(points.area.sum(), polygons.area[0], rtol=ROUNDING)
    assert_allclose(points.area @ arm, 0, atol=ROUNDING)
    if rule == "both":
        assert_allclose(points.area @ np.square(arm).sum(axis=1), polygons.polar_moment[0], rtol=ROUNDING)


def test_corners_bear_a_third_of_a_rectangle_and_a_quarter_of_a_triangle():
    for name, share in (("rectangle", 1 / 3), ("triangle", 1 / 4)):
        corners = POLYGONS[name]
        polygons = one_polygon(np.column_stack([corners, np.zeros(len(corners))]))
        at_corners = polygons.points().area[: len(corners)]
        assert_allclose(at_corners, share * polygons.area[0] / len(corners), rtol=ROUNDING)


def test_blocks_of_several_cells_have_the_moments_of_the_whole():
    """A box of 2 x 3 x 5 in two cells without a joint between them is one block."""
    blocks = two_boxes()

    class Two:
        vertices, face_vertices = blocks.vertices, blocks.face_vertices
        face_offsets, face_cells = blocks.face_offsets, blocks.face_cells
        face_joint = np.full(len(blocks.face_joint), -1, np.int32)
        joint_names, boundaries = (), {}
        cell_rock, rock_names = np.zeros(2, np.int32), ("granite",)
        cell_excavation, excavation_names = np.full(2, -1, np.int32), ()

    whole = bsm.Polyhedra.from_cells(Two())
    assert whole.count == 1
    assert whole.contact_polygons.count == 0
    assert len(whole.block_faces(0)) == 10
    assert_allclose(whole.moments.volume, [30], rtol=ROUNDING)
    assert_allclose(whole.moments.inertia[0], np.diag([34, 29, 13]) * 30 / 12, rtol=ROUNDING, atol=ROUNDING)
    parted = Two()
    parted.cell_excavation, parted.excavation_names = np.array([-1, 0], np.int32), ("heading",)
    parted = bsm.Polyhedra.from_cells(parted)
    assert parted.count == 2
    assert parted.excavations["heading"].tolist() == [1]
    assert parted.contact_polygons.joint.tolist() == [-1]


def test_arrays_are_read_only_also_in_another_process():
    blocks = pickle.loads(pickle.dumps(two_boxes()))
    assert blocks.count == 2
    for array in (blocks.vertices, blocks.face_cells, blocks.contact_polygons.corners):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"faces": BOX_FACES[:-1]}, "cell 0: the faces do not close"),
        ({"faces": [face[::-1] for face in BOX_FACES]}, "block 0: the volume is not positive"),
        ({"faces": [*BOX_FACES[:-1], (3, 0, 9)]}, "face 5 must name 3 or more of the corners 0 .. 7"),
        ({"corners": [(0, 0)]}, r"needs corners \(x, y, z\)"),
    ],
)
def test_bad_solids_are_named(change, message):
    corners, faces = box((0, 0, 0), (1, 1, 1))
    with pytest.raises(bsm.ModelError, match=message):
        bsm.Polyhedra.from_solids([(change.get("corners", corners), change.get("faces", faces))], rock="a")


@pytest.mark.parametrize(
    ("solids", "given", "message"),
    [
        (None, {}, "solids = None must be a list of pairs"),
        ([None], {}, "block 0: None must be a pair"),
        ([box((0, 0, 0), (1, 1, 1))] * 2, {}, "block 1: lies on the same side of a face as block 0"),
        ([BELOW, ABOVE, ABOVE], {}, "block 2: lies on the same side of a face as block 1"),
        ([box((0, 0, 0), (1, 1, 1))], {"rock": None}, "rock = None must be a list of texts"),
        ([box((0, 0, 0), (1, 1, 1))], {"merge_tolerance": -1.0}, "merge_tolerance = -1 m must be 0 to 1 m"),
    ],
)
def test_what_is_no_list_of_solids_is_named(solids, given, message):
    with pytest.raises(bsm.ModelError, match=message):
        bsm.Polyhedra.from_solids(solids, **{"rock": "granite", **given})


def test_cells_and_conditions_of_another_kind_are_named():
    with pytest.raises(bsm.ModelError, match=r"must be what geometries\.three_d.cut_cells returns"):
        bsm.Polyhedra.from_cells(None)
    with pytest.raises(bsm.ModelError, match="where must be a function of the arrays x, y, z"):
        two_boxes().with_boundary("top", lambda x, y, z: z)


def test_slivers_are_named():
    solids = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 1.0001))]
    assert bsm.Polyhedra.from_solids(solids, rock="a", joint="J").slivers.tolist() == [1]


def test_plane_parts_of_surfaces_are_faces_of_a_block_in_one_plane():
    """Two cubes as one block under a third: its top and bottom are 2 m2, each end 1 m2; a cube's faces are 1 m2."""
    solids = [box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1)), box((0, 0, 1), (1, 1, 2))]
    cells = bsm.Polyhedra.from_solids([(corners @ rotation(3).T, faces) for corners, faces in solids], rock="rock")
    blocks = bsm.Polyhedra(
        vertices=cells.vertices,
        face_vertices=cells.face_vertices,
        face_offsets=cells.face_offsets,
        face_cells=cells.face_cells,
        face_joint=cells.face_joint,
        cell_block=np.array([0, 0, 1], np.int32),
        rock=np.zeros(2, np.int32),
        rock_names=cells.rock_names,
        joint_names=cells.joint_names,
    )
    area = flat_areas(blocks)
    first, second = blocks.face_blocks.T
    top = (first >= 0) & (second >= 0) & (first != second)
    assert area[top].tolist() == [pytest.approx([2, 1] if first[top][0] == 0 else [1, 2])]
    assert not area[first == second].any()
    assert sorted(np.round(area[(first == 0) & (second < 0), 0])) == [1, 1, 2, 2, 2, 2, 2, 2, 2]
    assert (np.round(area[(first == 1) & (second < 0), 0]) == 1).all()
