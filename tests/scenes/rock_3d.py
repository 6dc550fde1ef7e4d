"""Jointed rock in three dimensions that several tests cut: a tunnel in three sets, random rock."""

import numpy as np

from bsm_mesh.geometries import three_d
from bsm_mesh.geometries.orientations import upward_normals

SETS = ((30.0, 45.0), (60.0, 160.0), (75.0, 290.0))  # dip, dip direction


def planes(low, high, spacing, seed, sets=SETS):
    """Return single joints of three sets whose spacings are random, from 3/4 to 5/4 of the mean."""
    generator = np.random.default_rng(seed)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T
    joints = []
    for number, (dip, direction) in enumerate(sets):
        normal = upward_normals(np.array([dip]), np.array([direction]))[0]
        height = corners @ normal
        place = height.min() + spacing * generator.uniform(0.2, 1)
        while place < height.max():
            name = f"J{number + 1}"
            joints.append(three_d.JointPlane(name=name, dip=dip, dip_direction=direction, point=normal * place))
            place += spacing * generator.uniform(0.75, 1.25)
    return joints


def tunnel_rock(spacing=2.0, seed=0, radius=4.0, sides=10):
    """Return rock of 24 x 16 x 24 m with a tunnel of ten sides along y, as wide as a circle of `radius` inside it."""
    angle = 2 * np.pi * np.arange(sides) / sides
    profile = radius / np.cos(np.pi / sides) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = (-12, 0, -12), (12, 16, 12)
    opening = three_d.Opening(body=three_d.prism(profile), boundary="tunnel")
    return three_d.RockMass(box=(low, high), joints=planes(low, high, spacing, seed), bodies=[opening])
