"""Stiffness of faces: rock and joint in series (Wang Eqs. 3.24-3.27), and which joint a face has."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.face_stiffness import face_joints, face_stiffness
from bsm_mesh.model.faces import find_faces
from tests.scenes.shapes import grid, rectangle, turned

RTOL = 1e-12
E1, MU1, E2, MU2 = 50e9, 0.25, 2e9, 0.35
WIDE, TALL = rectangle(0, 0, 3, 2), rectangle(3, -1, 4, 3)  # meet along x = 3; h = 1.5 and 0.5


def two(rocks, joints=(), default_joint=None, degrees=0.0):
    polygons = [turned(p, degrees) for p in (WIDE, TALL)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=[rock.name for rock in rocks]),
        rocks=dict.fromkeys(rocks),
        joints=joints,
        default_joint=default_joint,
    )


def stiffness(model):
    found = face_stiffness(model, find_faces(model.blocks))
    assert len(found.normal) == 1
    return found.normal[0], found.shear[0]


def confined(E, mu):
    return (1 - mu) * E / ((1 + mu) * (1 - 2 * mu))


def shear(E, mu):
    return E / (2 * (1 + mu))


@pytest.mark.parametrize("choice", ["wang", "homogeneous", "triangle"])
def test_one_rock_has_moduli_over_the_distance_of_the_centroids(choice):
    rock = bsm.Rock("a", unit_weight=0, young=E1, poisson=MU1, stiffness=choice)
    EN, ET = rock.contact_moduli
    assert_allclose(stiffness(two((rock, rock))), (EN / 2.0, ET / 2.0), rtol=RTOL)  # Wang Eq. 3.24


def test_rigid_rocks_leave_the_joint_alone():
    assert_allclose(
        stiffness(two((bsm.Rock("a", unit_weight=0), bsm.Rock("b", unit_weight=0)), [bsm.Joint("J", 7e9, 2e9)], "J")),
        (7e9, 2e9),
    )


def test_rigid_rocks_without_a_joint_are_an_error():
    with pytest.raises(bsm.ModelError) as caught:
        stiffness(two((bsm.Rock("a", unit_weight=0), bsm.Rock("b", unit_weight=0, young=1e9, stiffness="rigid"))))
    for part in (
        "blocks 0 and 1 meet at (3, 0",
        "without a joint",
        "(a and b) is rigid",
        "default_joint = ...",
        'blocks = "regions"',
    ):
        assert part in str(caught.value)


def test_one_elastic_side_is_enough():
    assert_allclose(
        stiffness(two((bsm.Rock("a", unit_weight=0, young=E1, poisson=MU1), bsm.Rock("b", unit_weight=0))))[0],
        confined(E1, MU1) / 1.5,
    )


def joint_of(edge_low, edge_high, default):
    """Return the joint of the face of two squares, one above the other, from the joints of its two edges."""
    blocks = bsm.Blocks.from_polygons(grid(1, 2), rock="r")
    names = ("A", "B", "C")
    edge_joint = np.full(8, -1, dtype=np.int32)
    edge_joint[2] = -1 if edge_low is None else names.index(edge_low)
    edge_joint[4] = -1 if edge_high is None else names.index(edge_high)
    blocks = bsm.Blocks(
        vertices=blocks.vertices,
        offsets=blocks.offsets,
        nodes=blocks.nodes,
        rock=blocks.rock,
        rock_names=blocks.rock_names,
        edge_joint=edge_joint,
        joint_names=names,
    )
    joints = [bsm.Joint(n, 1e9, 1e9) for n in reversed(names)]  # another order than in the blocks
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2)],
        joints=joints,
        default_joint=default,
    )
    faces = find_faces(blocks)
    assert (faces.edge_b[0], faces.edge_a[0]) == (2, 4)
    found = face_joints(model, faces)[0]
    return None if found < 0 else joints[found].name


@pytest.mark.parametrize(
    ("edge_b", "edge_a", "default", "expected"),
    [
        ("A", "B", "C", "A"),
        ("A", None, "C", "A"),
        (None, "B", "C", "B"),
        (None, None, "C", "C"),
        ("B", "A", None, "B"),
        (None, "A", None, "A"),
        (None, None, None, None),
    ],
)
def test_precedence_of_joints(edge_b, edge_a, default, expected):
    assert joint_of(edge_b, edge_a, default) == expected


def test_the_centroid_on_the_line_of_a_face():
    """A U whose centroid lies on the line of an inner face: h = 0 there, not an infinite stiffness."""
    h = (1 + np.sqrt(13)) / 4  # the height of the legs above the inner floor at y = 1 so that the centroid is at y = 1
    u_shape = np.array([(0, 0), (3, 0), (3, 1 + h), (2, 1 + h), (2, 1), (1, 1), (1, 1 + h), (0, 1 + h)])
    blocks = bsm.Blocks.from_polygons([u_shape, rectangle(1, 1, 2, 2)], rock="r")
    rock = bsm.Rock("r", unit_weight=0, young=E1, poisson=MU1)
    found = face_stiffness(bsm.Model(blocks=blocks, rocks=[rock]), find_faces(blocks))
    assert (found.normal < 1e3 * confined(E1, MU1)).all()
    assert (found.normal > 0).all()


def test_a_face_before_the_centroid_has_a_positive_stiffness():
    l_shape = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    blocks = bsm.Blocks.from_polygons([l_shape, rectangle(1, 1, 2, 2)], rock="r")
    found = face_stiffness(
        bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=0, young=1e6, poisson=0.0)]), find_faces(blocks)
    )
    assert_allclose(found.normal, 1e6 / (1 / 6 + 0.5), rtol=RTOL)  # centroid at 5/6, face at 1


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.lists(st.floats(0, 2 * np.pi), min_size=3, max_size=9, unique=True), st.floats(0.05, 1), st.floats(0, 90))
def test_theleast_depth_of_concave_blocks_is_none_of_convex_ones(angles, flat, turn):
    angles = np.sort(angles)
    outline = turned(np.stack([np.cos(angles), flat * np.sin(angles)], axis=1), turn)
    try:
        blocks = bsm.Blocks.from_polygons([outline], rock="r")
    except bsm.ModelError:
        return  # no area
    along = blocks.edge_vectors
    length = np.hypot(*along.T)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    depth = ((blocks.vertices - blocks.moments.centroid[0]) * normal).sum(axis=1)
    # a third of the width, and area over outline is at most half the width
    assert depth.min() >= 2 / 3 * (1 - 1e-7) * blocks.moments.area[0] / length.sum()


def test_unknown_choice_is_refused():
    with pytest.raises(bsm.ModelError, match=re.escape("did you mean 'triangle'?")):
        bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2, stiffness="triangles")
