"""Jointed rock in three dimensions that several tests cut: a tunnel in three sets, random rock."""

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from bsm_mesh.geometries.orientations import upward_normals
from bsm_mesh.model.supports import Bars
from bsm_mesh.three_d.model.parts import some_polyhedra

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


def tunnel_rock(spacing=2.0, seed=0, radius=4.0, sides=10, shift=(0.0, 0.0, 0.0)):
    """Return rock of 24 x 16 x 24 m with a tunnel of ten sides along y, as wide as a circle of `radius` inside it."""
    angle = 2 * np.pi * np.arange(sides) / sides
    profile = radius / np.cos(np.pi / sides) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = np.array([-12.0, 0, -12]), np.array([12.0, 16, 12])
    joints = [
        three_d.JointPlane(name=j.name, dip=j.dip, dip_direction=j.dip_direction, point=np.add(j.point, shift))
        for j in planes(low, high, spacing, seed)
    ]
    opening = three_d.Opening(body=three_d.prism(profile, origin=shift), boundary="tunnel")
    return three_d.RockMass(box=(low + shift, high + shift), joints=joints, bodies=[opening])


def wedge_rock(first, second, face, top, height):
    """Return a slope with a wedge on two planes that meet at its toe, the wedge's number, volume and two areas.

    Planes are (dip, dip direction); the crest lies `height` above the origin, straight up the face. The closed forms
    are those of the tetrahedron between the four planes.
    """
    planes = np.array([first, second, face, top], dtype=float)
    one, two, front, above = upward_normals(planes[:, 0], planes[:, 1])
    run = height / np.tan(np.radians(face[0]))
    crest = np.array([-np.sin(np.radians(face[1])) * run, -np.cos(np.radians(face[1])) * run, height])
    level = above @ crest
    corners = [
        np.linalg.solve(rows, (0, 0, level)) for rows in ((one, front, above), (two, front, above), (one, two, above))
    ]
    left, right, back = corners
    points = np.array([np.zeros(3), *corners])
    low, high = points.min(axis=0) - height, points.max(axis=0) + height
    ahead = three_d.HalfSpaces(-front[None], np.zeros(1))
    over = three_d.HalfSpaces(np.array([front, -above]), np.array([0, -level]))
    rock = three_d.RockMass(
        box=(low, high),
        joints=[
            three_d.JointPlane(name=name, dip=dip, dip_direction=direction, point=(0, 0, 0))
            for name, (dip, direction) in (("A", first), ("B", second))
        ],
        bodies=[three_d.Opening(body=[ahead, over], boundary="slope")],
    )
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    number = int(np.argmin(np.linalg.norm(blocks.moments.centroid - points.mean(axis=0), axis=1)))
    areas = [np.linalg.norm(np.cross(end, back)) / 2 for end in (left, right)]
    return blocks, number, abs(np.linalg.det(corners)) / 6, areas


def wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion, force=(0, 0, 0)):
    """Return the factor of a wedge that slides on two planes (Hoek & Bray): strength over the pull down their line.

    A `force` [N], such as that of bolts, acts besides its weight.
    """
    one, two = upward_normals(np.array([first[0], second[0]], float), np.array([first[1], second[1]], float))
    line = np.cross(one, two)
    line *= -np.sign(line[2]) / np.linalg.norm(line)
    weight = np.array([0, 0, -unit_weight * volume]) + force
    on_one, on_two, pull = np.linalg.solve(np.array([one, two, -line]).T, -weight)
    assert min(on_one, on_two) > 0
    slope = np.tan(np.radians(friction))
    return (on_one * slope[0] + on_two * slope[1] + cohesion[0] * areas[0] + cohesion[1] * areas[1]) / pull


WEDGES = {  # planes, face, top (dip, dip direction), height, friction, cohesion, unit weight
    "Wyllie and Mah's chart": ((40, 165), (70, 285), (65, 210), (0, 210), 20.0, (35, 20), (0, 0), 25e3),
    "Hoek and Bray": ((45, 105), (70, 235), (65, 185), (12, 195), 40.0, (20, 30), (24e3, 48e3), 25e3),
    "without cohesion": ((45, 105), (70, 235), (65, 185), (12, 195), 40.0, (20, 30), (0, 0), 25e3),
    "symmetric": ((54.7356, 135), (54.7356, 225), (70, 180), (0, 180), 10.0, (30, 30), (0, 0), 26e3),
    "to the north": ((52, 60), (58, 330), (72, 15), (5, 15), 30.0, (30, 35), (10e3, 10e3), 25e3),
    "two cohesions": ((50, 110), (60, 210), (75, 160), (5, 160), 25.0, (25, 32), (15e3, 5e3), 26e3),
}


def dome(thickness, sectors, courses, radius=5.0):
    """Return a hemispherical dome of blocks with plane faces, and which blocks are its base.

    Joints across the meridians are quadrilaterals between chords; the base is a ring of blocks under the springing.
    """
    fall = np.linspace(0, np.pi / 2, courses + 1)
    fall[0] = 1e-3  # a small eye instead of a point at the crown
    turn = 2 * np.pi * np.arange(sectors + 1) / sectors
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    ring[-1] = ring[0]
    up = np.array([0, 0, 1.0])
    shells = [
        [r * (np.sin(angle) * ring + np.cos(angle) * up) for angle in fall]
        for r in (radius * (1 - thickness / 2), radius * (1 + thickness / 2))
    ]
    for shell in shells:
        shell.append(shell[-1] - 0.5 * up)
    faces = [(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    solids = []
    for course in range(courses + 1):
        for j in range(sectors):
            corners = [s[course + i][j + k] for s in shells for i, k in ((0, 0), (0, 1), (1, 1), (1, 0))]
            solids.append((np.array(corners), faces))
    blocks = bsm.Polyhedra.from_solids(solids, rock="stone", joint="J1")
    return blocks, np.arange(blocks.count) >= courses * sectors


def rotations_held(blocks, which):
    """Return bars that hold the rotations of some blocks, and leave their centres free: they translate only."""
    which = np.asarray(which, dtype=np.int32)
    count = 3 * len(which)
    return Bars(
        block=np.repeat(which, 3),
        point=np.repeat(blocks.moments.centroid[which], 3, axis=0),
        direction=np.tile(np.eye(3), (len(which), 1)),
        holds_rotation=np.ones(count, dtype=bool),
        value=np.zeros(count),
        support=np.zeros(count, np.int32),
        edge=np.full(count, -1, np.int32),
    )


def alone(model, block, present, *, turns=True):
    """Return a model of one block between the neighbours that are `present` (n,), all of them fixed.

    There is no stress before its weight acts. Unless it `turns`, its rotation is held: it moves as in block theory.
    """
    faces = model.blocks.contact_polygons
    kept = np.zeros(model.blocks.count, dtype=bool)
    kept[faces.block_b[faces.block_a == block]] = True
    kept[faces.block_a[faces.block_b == block]] = True
    kept &= present
    kept[block] = True
    part, _ = some_polyhedra(model.blocks, kept)
    number = int(kept[:block].sum())
    supports = [bsm.Fixed(blocks=np.delete(np.arange(part.count), number).tolist())]
    supports += [] if turns else [rotations_held(part, [number])]
    return model.replace(blocks=part, supports=supports, stages=[])
