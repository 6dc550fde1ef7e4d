"""In-situ stress on polyhedra: uniform stress, the weight of the ground, pyramids in a roof that it clamps."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from tests.scenes.models import model_of
from tests.scenes.polyhedra import box, model_in_space
from tests.scenes.rock_3d import planes

OPTIONS = bsm.Options(threads=1)
STRESS = {"xx": -3e6, "yy": -2e6, "zz": -1e6, "xy": 4e5, "yz": -3e5, "xz": 2e5}
TENSOR = np.array([[-3e6, 4e5, 2e5], [4e5, -2e6, -3e5], [2e5, -3e5, -1e6]])


def test_jointed_rock_rests_under_a_uniform_stress():
    """No block moves, and the mean stress of every free block is the given one."""
    rock = three_d.RockMass(box=((0, 0, 0), (4, 4, 4)), joints=planes((0, 0, 0), (4, 4, 4), 0.9, 3))
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    held = blocks.boundary_blocks("west", "east", "south", "north", "bottom", "top")
    joints = [
        bsm.Joint(name, normal_stiffness=1e10, shear_stiffness=5e9, law=bsm.MohrCoulomb(friction=40))
        for name in blocks.joint_names
    ]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0.0)],
        joints=joints,
        supports=[bsm.Fixed(blocks=held.tolist())],
        in_situ=bsm.InSitu(stress=STRESS),
    )
    (stage,) = bsm.run(model, OPTIONS).stages
    free = np.setdiff1d(np.arange(blocks.count), held)
    assert (stage.status, len(free) > 5) == ("stable", True)
    assert_allclose(stage.displacement, 0, atol=1e-15)
    assert_allclose(stage.stress[free], np.broadcast_to(TENSOR, (len(free), 3, 3)), atol=1e-9 * 3e6)


@pytest.mark.parametrize("level", [None, 11.0])
def test_the_weight_of_the_ground_squeezes_along_the_trend_and_across(level):
    """Cubes of 26 kN/m3 below a surface 10 m over them, K 2 along 30 degrees from north and 0.5 across.

    Under a water table contacts carry the effective stress, and the total stress is the same.
    """
    cubes = [box((i, j, k), (i + 1, j + 1, k + 1)) for i in range(3) for j in range(3) for k in range(3)]
    held = [n for n in range(27) if n != 13]
    field = bsm.InSitu(surface=13.0, surcharge=1e5, k0=2.0, k0_across=0.5, trend=30.0)
    water = None if level is None else bsm.Water(plane=bsm.HeadPlane(point=(0, 0, level), dip=0, dip_direction=0))
    model = model_in_space(cubes, fixed=held, friction=50, in_situ=field, water=water)
    (stage,) = bsm.run(model, OPTIONS).stages
    assert_allclose(stage.displacement, 0, atol=1e-14)
    vertical = -(26e3 * (13 - 1.5) + 1e5)
    along, across = (np.array([np.sin(a), np.cos(a), 0]) for a in np.radians([30, 120]))
    level = 2 * np.outer(along, along) + 0.5 * np.outer(across, across)
    assert_allclose(stage.stress[13], vertical * (level + np.diag([0, 0, 1])), rtol=1e-9, atol=1e-3)


def roof(faces, ratio, share, *, friction=45.0, apex=25.0, kn=1e10):
    """Return a pyramid over a roof with `share` of the horizontal stress that it needs; all other blocks are fixed.

    A face at the angle a from the vertical slips first when the block has sunk by u = s sin(phi - a) cos a /
    (cos phi (ks cos a + kn sin a tan phi)): the stress s gives it the horizontal force s cos a an area. The n faces
    then carry n (ks cos^2 a + kn sin^2 a) A u, and more sinking takes from it (Brady & Brown, roof wedges).
    """
    turn = 360 / faces
    joints = [
        three_d.JointPlane(
            name="J1",
            dip=90 - apex,
            dip_direction=turn * k,
            point=(np.sin(np.radians(turn * k)), np.cos(np.radians(turn * k)), 0),
        )
        for k in range(faces)
    ]
    cavern = three_d.prism([(-4, -1), (4, -1), (4, 0), (-4, 0)], origin=(0, -4, 0), length=8.0)
    rock = three_d.RockMass(
        box=((-5, -5, -2), (5, 5, 5)), joints=joints, bodies=[three_d.Opening(body=cavern, boundary="roof")]
    )
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    centroid = blocks.moments.centroid
    key = int(np.argmin(np.linalg.norm(centroid - [0, 0, 0.25 / np.tan(np.radians(apex))], axis=1)))
    a, phi, ks = np.radians(apex), np.radians(friction), ratio * kn
    polygons = blocks.contact_polygons
    area = polygons.area[polygons.of(key)].sum()
    slip = np.sin(phi - a) * np.cos(a) / (np.cos(phi) * (ks * np.cos(a) + kn * np.sin(a) * np.tan(phi)))
    carried = (ks * np.cos(a) ** 2 + kn * np.sin(a) ** 2) * area * slip  # over the stress
    stress = -share * 26e3 * blocks.moments.volume[key] / carried
    joint = bsm.Joint("J1", kn, ks, law=bsm.MohrCoulomb(friction=friction))
    field = bsm.InSitu(stress={"xx": stress, "yy": stress, "zz": 0.0})
    others = np.setdiff1d(np.arange(blocks.count), key)
    return key, model_of(blocks, gamma=26e3, joint=joint, fixed=others.tolist(), in_situ=field)


@pytest.mark.parametrize(("faces", "ratio"), [(3, 1.0), (4, 0.1), (6, 0.3)])
@pytest.mark.parametrize(("share", "status"), [(1 + 1e-4, "stable"), (1 - 1e-4, "unstable")])
def test_a_pyramid_in_a_roof_needs_its_horizontal_stress(faces, ratio, share, status):
    key, model = roof(faces, ratio, share)
    results = bsm.run(model, OPTIONS)
    assert (results.status, results.unstable_blocks.tolist()) == (status, [] if status == "stable" else [key])
