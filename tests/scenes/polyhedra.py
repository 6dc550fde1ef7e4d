"""Models of polyhedra that several tests solve: boxes, prisms of polygons, blocks on an incline."""

import numpy as np
from scipy.spatial import ConvexHull

import bsm_mesh as bsm
from tests.scenes.models import model_of

BOX_FACES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
CELL_ARRAYS = ("vertices", "face_vertices", "face_offsets", "face_cells", "face_joint", "rock_names", "joint_names")


def box(low, high):
    """Return corners and faces of a box."""
    (x, y, z), (X, Y, Z) = low, high
    corners = [(x, y, z), (X, y, z), (X, Y, z), (x, Y, z), (x, y, Z), (X, y, Z), (X, Y, Z), (x, Y, Z)]
    return np.array(corners, dtype=float), BOX_FACES


def prism(polygon, depth=1.0):
    """Return corners and faces of a convex polygon (k, 2) in x and z, counter-clockwise, from y = 0 to `depth`."""
    polygon, k = np.asarray(polygon, dtype=float), len(polygon)
    front, back = ([(x, y, z) for x, z in polygon] for y in (0.0, depth))
    sides = [(i, k + i, k + (i + 1) % k, (i + 1) % k) for i in range(k)]
    return np.array(front + back), [tuple(range(k)), tuple(range(2 * k - 1, k - 1, -1)), *sides]


def rotation(azimuth, dip):
    """Return the matrix that dips a body by an angle and turns it about z by another [degrees]."""
    a, d = np.radians(azimuth), np.radians(dip)
    about_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(d), 0, np.sin(d)], [0, 1, 0], [-np.sin(d), 0, np.cos(d)]])
    return about_z @ about_y


def turned(solids, matrix):
    """Return solids turned by a matrix."""
    return [(corners @ matrix.T, faces) for corners, faces in solids]


def model_in_space(solids, *, fixed=(0,), friction=30.0, cohesion=0.0, kn=1e9, ks=1e9, law=None, **more):
    """Return a model of solids on one kind of joint, some of them fixed."""
    joint = bsm.Joint(
        "J1",
        normal_stiffness=kn,
        shear_stiffness=ks,
        law=law or bsm.MohrCoulomb(friction=friction, cohesion=cohesion),
    )
    return model_of(
        bsm.Polyhedra.from_solids(solids, rock="granite", joint="J1"), gamma=26e3, joint=joint, fixed=fixed, **more
    )


def on_incline(dip, azimuth=0.0, **more):
    """Return a cube of 1 m on a plane that dips."""
    solids = [box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))]
    return model_in_space(turned(solids, rotation(azimuth, dip)), **more)


def hull(points):
    """Return the corners of a hull of points, and its triangles, counter-clockwise seen from outside."""
    found = ConvexHull(points)
    number = np.full(len(points), -1)
    number[found.vertices] = np.arange(len(found.vertices))
    corner = points[found.simplices]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = (across * found.equations[:, :3]).sum(axis=1) < 0
    faces = np.where(inward[:, None], found.simplices[:, ::-1], found.simplices)
    return points[found.vertices], number[faces].tolist()
