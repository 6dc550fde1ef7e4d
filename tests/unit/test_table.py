"""The contact table: two contacts a face, the corner on block a and the edge on block b (`bsm_mesh/__init__.py`)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.table import initial_contacts
from tests.scenes.reference import brute_faces
from tests.scenes.shapes import grid, rectangle, running_bond, turned

SCENES = {
    "grid": grid(3, 2),
    "bond": running_bond(4, 3),
    "inner": [rectangle(0, 0, 5, 1), rectangle(2, 1, 3, 2)],
    "outer": [rectangle(2, 0, 3, 1), rectangle(0, 1, 5, 2)],
    "staggered": [rectangle(0, 0, 2, 1), rectangle(1, 1, 3, 2)],
}


def table(polygons, contact_points="ends"):
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=0)],
        joints=[bsm.Joint("J", 1e9, 3e8)],
        default_joint="J",
        contact_points=contact_points,
    )
    return model.blocks, initial_contacts(model)


def same_corner(blocks, block, point):
    return np.hypot(*(blocks.polygon(block) - point).T).min() < 1e-9


@pytest.mark.parametrize("degrees", [0.0, 63.0])
@pytest.mark.parametrize("name", SCENES)
def test_block_a_has_the_corner_and_block_b_the_edge(name, degrees):
    blocks, contacts = table([turned(p, degrees) for p in SCENES[name]])
    assert contacts.count == 2 * len(brute_faces(SCENES[name]))
    for c in range(contacts.count):
        a, b, edge, point = contacts.block_a[c], contacts.block_b[c], contacts.edge[c], contacts.point[c]
        assert a != b
        assert blocks.owner[edge] == b
        assert same_corner(blocks, a, point)
        along = blocks.edge_vectors[edge]
        from_start = point - blocks.vertices[edge]
        assert abs(along[0] * from_start[1] - along[1] * from_start[0]) < 1e-9
        assert -1e-9 <= from_start @ along <= along @ along + 1e-9


@pytest.mark.parametrize("degrees", [0.0, 63.0])
@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize("name", SCENES)
def test_normals_point_out_of_block_b(name, points, degrees):
    blocks, contacts = table([turned(p, degrees) for p in SCENES[name]], points)
    along = blocks.edge_vectors[contacts.edge]
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    assert_allclose(contacts.normal, outward, atol=1e-12)
    from_b = contacts.point - blocks.moments.centroid[contacts.block_b]
    assert ((from_b * contacts.normal).sum(axis=1) > 0).all()


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize("name", SCENES)
def test_lengths_and_stiffness_add_up(name, points):
    _, contacts = table(SCENES[name], points)
    total = sum(np.hypot(*(end - start)) for _, _, start, end in brute_faces(SCENES[name]))
    assert_allclose(contacts.length.sum(), total, rtol=1e-12)
    assert_allclose(contacts.normal_stiffness, 1e9 * contacts.length, rtol=1e-12)
    assert_allclose(contacts.shear_stiffness, 3e8 * contacts.length, rtol=1e-12)


def test_moment_stiffness_of_ends_and_gauss_points():
    length, k = 2.0, 1e9  # docs/theory_contacts.md: k L^3 / 4 at the ends, the right k L^3 / 12 at Gauss points
    for points, share in (("ends", 4), ("gauss", 12)):
        _, contacts = table([rectangle(0, 0, length, 1), rectangle(0, 1, length, 2)], points)
        arm = contacts.point[:, 0] - length / 2
        assert_allclose((contacts.normal_stiffness * arm**2).sum(), k * length**3 / share, rtol=1e-12)
        assert_allclose(contacts.point[:, 1], 1.0)


def test_no_faces():
    _, contacts = table([rectangle(0, 0, 1, 1)])
    assert contacts.count == 0
