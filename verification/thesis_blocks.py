"""Chapter 3 and appendix B of the thesis: blocks, contacts, supports, loads, average stress, equation by equation."""

from __future__ import annotations

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.contact.kernels import add_contact_forces, spring_forces
from bsm_mesh.model.face_stiffness import face_stiffness
from bsm_mesh.model.faces import find_faces
from bsm_mesh.solve.algebra.block_matrix import block_pattern, fill_stiffness
from bsm_mesh.solve.algebra.loads import external_loads
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import grid, rectangle, running_bond, turned
from verification.case import Answer, Case
from verification.thesis_matrices import Array, GlobalSystem, matrix_b, matrix_d, matrix_k, matrix_t

EXACT = 1e-12
KN, KS, GAMMA = 2e9, 7e8, 26e3
EDGE, CORNER = np.array([0], np.int32), np.array([1], np.int32)  # the block with the edge, and the one with the corner


def _pairs(count: int = 50) -> list[tuple[Array, Array, Array, float, Array]]:
    """Return random pairs of blocks: their centroids, contact point, angle of the normal, displacements (2, 3)."""
    rng = np.random.default_rng(1992)
    return [(*rng.normal(size=(3, 2)), rng.uniform(-180, 180), rng.normal(size=(2, 3))) for _ in range(count)]


def _springs(pair: tuple[Array, Array, Array, float, Array], normal: float, shear: float) -> Array:
    """Return normal and shear force of the program's springs at a contact."""
    ci, cj, point, degrees, U = pair
    direction = matrix_t(degrees)[:1]
    stiffness = np.array([normal]), np.array([shear])
    return np.concatenate(spring_forces(CORNER, EDGE, point[None], direction, *stiffness, np.array([ci, cj]), U))


def relative_displacement() -> Answer:
    """Compare springs of unit stiffness along the axes give the relative displacement itself."""
    exact = [matrix_d(ci, cj, point) @ U.ravel() for ci, cj, point, _, U in _pairs()]
    found = [_springs((ci, cj, point, 0.0, U), 1.0, 1.0) for ci, cj, point, _, U in _pairs()]
    return np.array(exact), np.array(found)


def contact_forces() -> Answer:
    """Compare normal and shear force of a contact at any angle."""
    exact = [
        matrix_k(KN, KS) @ matrix_t(degrees) @ matrix_d(ci, cj, point) @ U.ravel()
        for ci, cj, point, degrees, U in _pairs()
    ]
    return np.array(exact), np.array([_springs(pair, KN, KS) for pair in _pairs()])


def forces_on_blocks() -> Answer:
    """Compare a contact's force and moment on both of its blocks."""
    exact, found = [], []
    for ci, cj, point, degrees, U in _pairs():
        local, total = U[0, :2], np.zeros((2, 3))
        of = np.array([local[0]]), np.array([local[1]])
        add_contact_forces(CORNER, EDGE, point[None], matrix_t(degrees)[:1], *of, np.array([ci, cj]), total)
        force = matrix_t(degrees).T @ local
        exact.append([matrix_b(ci, point).T @ force, -matrix_b(cj, point).T @ force])
        found.append(total)
    return np.array(exact), np.array(found)


def contact_matrix() -> Answer:
    """Compare the 3 x 3 blocks of one contact: the program's matrix is the thesis's times -1."""
    exact, found = [], []
    pattern = block_pattern(2, CORNER, EDGE)
    for ci, cj, point, degrees, _ in _pairs():
        system = GlobalSystem(np.array([ci, cj]))
        system.add_contact(0, 1, point, degrees, KN, KS)
        exact.append([-system.K[:3, :3], -system.K[:3, 3:], -system.K[3:, 3:]])
        found.append(
            fill_stiffness(
                pattern.row_start, CORNER, EDGE, pattern.place, 3, point[None], matrix_t(degrees)[:1],
                np.array([KN]), np.array([KS]), np.array([ci, cj]),
            )
        )  # fmt: skip
    return np.array(exact), np.array(found)


def elastic_moduli() -> Answer:
    """Compare E' and G of plane strain, of the rocks of Table A.1."""
    exact, found = [], []
    for E, mu in ((174.4e9, 0.23), (96.5e9, 0.30), (2e9, 0.15), (26e9, 0.26)):
        exact += [(1 - mu) * E / ((1 + mu) * (1 - 2 * mu)), E / (2 * (1 + mu))]
        found += bsm.Rock("r", unit_weight=0, young=E, poisson=mu).contact_moduli
    return np.array(exact), np.array(found)


def _of_face(lower: bsm.Rock, upper: bsm.Rock, joint: bsm.Joint | None) -> Array:
    """Return Kn and Ks of the face between a block 3 m high and one of 1 m on it."""
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 2, 3), rectangle(0, 3, 2, 4)], rock=["lower", "upper"])
    joints = {"joints": [joint], "default_joint": joint.name} if joint else {}
    model = bsm.Model(blocks=blocks, rocks=[lower, upper], supports=[bsm.Fixed(blocks=[0])], **joints)
    found = face_stiffness(model, find_faces(blocks))
    return np.array([found.normal[0], found.shear[0]])


E1, MU1, E2, MU2 = 50e9, 0.25, 18e9, 0.15
LOWER, UPPER = (
    bsm.Rock(n, unit_weight=0, young=E, poisson=mu) for n, E, mu in (("lower", E1, MU1), ("upper", E2, MU2))
)
RIGID = bsm.Rock("upper", unit_weight=0)


def _moduli(E: float, mu: float) -> Array:
    return np.array([(1 - mu) * E / ((1 + mu) * (1 - 2 * mu)), E / (2 * (1 + mu))])


def one_rock() -> Answer:
    """Compare between a block and a rigid one only the first yields, over the distance h of its centroid."""
    return _moduli(E1, MU1) / 1.5, _of_face(LOWER, RIGID, None)


def two_rocks() -> Answer:
    """Compare two rocks in series, each over the distance of its centroid."""
    return 1 / (1.5 / _moduli(E1, MU1) + 0.5 / _moduli(E2, MU2)), _of_face(LOWER, UPPER, None)


def rock_and_joint() -> Answer:
    """Compare rock and joint in series."""
    rock = 1 / (1.5 / _moduli(E1, MU1) + 0.5 / _moduli(E2, MU2))
    return 1 / (1 / rock + 1 / np.array([KN, KS])), _of_face(LOWER, UPPER, bsm.Joint("J", KN, KS))


def filled_joint() -> Answer:
    """Compare a joint with a thick filling: E' and G of the filling over its thickness."""
    joint = bsm.Joint("J", filling=bsm.Filling(thickness=0.02, young=1e8, poisson=0.3))
    return _moduli(1e8, 0.3) / 0.02, _of_face(bsm.Rock("lower", unit_weight=0), RIGID, joint)


STIFF = 1e7  # of a boundary bar, over the contacts': more costs the thesis's way digits, less misses the displacement
TURN = 20.0


def _held_wall() -> tuple[list[Array], list[tuple[int, Array, float, float]], tuple[int, Array, Array]]:
    """Return outlines of a turned wall, bars (block, point, angle, displacement), and a load (block, point, force)."""
    polygons = [turned(p, TURN) for p in grid(3, 4)]
    bars = [(b, polygons[b][k], 90.0 + TURN, 0.0) for b in range(3) for k in (0, 1)]
    bars += [(0, polygons[0][3], TURN, 0.0), (5, polygons[5][1], 75.0, 2e-3), (7, polygons[7][2], -20.0, -1e-3)]
    return polygons, bars, (10, polygons[10][3], np.array([3e5, -1e5]))


def held_wall() -> Answer:
    """Compare displacements of a wall on rollers at 20 degrees, two of its points displaced by given amounts."""
    polygons, bars, (loaded, at, push) = _held_wall()
    blocks = bsm.Blocks.from_polygons(polygons, rock="r")
    centroid, area = blocks.moments.centroid, blocks.moments.area
    inside = [(b, p + 1e-7 * (centroid[b] - p), angle, w) for b, p, angle, w in bars]  # at a corner it would hold all
    system = GlobalSystem(centroid)
    faces = find_faces(blocks)
    for edge_b, edge_a, start, end in zip(faces.edge_b, faces.edge_a, faces.start, faces.end, strict=True):
        i, j, along = blocks.owner[edge_b], blocks.owner[edge_a], end - start
        degrees = float(np.degrees(np.arctan2(-along[0], along[1])))
        for point in (start, end):
            half = np.hypot(*along) / 2
            system.add_contact(int(i), int(j), point, degrees, KN * half, KS * half)
    for b, p, angle, w in inside:
        system.add_bar(b, p, angle, w, STIFF * KN)
    for b in range(blocks.count):
        system.add_force(b, (0.0, -GAMMA * area[b], 0.0))
    system.add_force(loaded, matrix_b(centroid[loaded], at).T @ push)
    supports = [bsm.PrescribedDisplacement(point=tuple(p), direction=a, displacement=w) for _, p, a, w in inside]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=GAMMA)],
        joints=[bsm.Joint("J", KN, KS)],
        default_joint="J",
        supports=supports,
        loads=[bsm.PointLoad(block=loaded, point=tuple(at), force=tuple(push))],
    )
    return system.solve(), bsm.run(model, LINEAR).stages[-1].displacement


OUTLINES = ([(0, 0), (3, 0.5), (1, 2)], [(0, 0), (2, -0.3), (2.5, 1.4), (-0.2, 1)],
            [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])  # fmt: skip


def weights() -> Answer:
    """Compare weight of polygons along an inclined gravity, their areas by Shapely."""
    from shapely import Polygon

    blocks = bsm.Blocks.from_polygons([turned(p, 0.0, (5.0 * k, 0.0)) for k, p in enumerate(OUTLINES)], rock="r")
    model = bsm.Model(
        blocks=blocks, rocks=[bsm.Rock("r", unit_weight=GAMMA)], supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-60.0, joints=[bsm.Joint("J", KN, KS)], default_joint="J",
    )  # fmt: skip
    weight = GAMMA * np.array([Polygon(outline).area for outline in OUTLINES])
    exact = np.outer(weight, [np.cos(np.radians(-60)), np.sin(np.radians(-60)), 0.0])
    return exact, external_loads(model)


def loads_at_points() -> Answer:
    """Compare force and moment of point loads about the centroid."""
    from shapely import Polygon

    rng = np.random.default_rng(338)
    outline = np.array(OUTLINES[1], dtype=float)
    centroid = np.array(Polygon(outline).centroid.coords[0])
    points, forces = outline[[0, 2]] * 0.9 + 0.1 * centroid, rng.normal(size=(2, 2)) * 1e5
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([outline], rock="r"),
        rocks=[bsm.Rock("r", unit_weight=0)],
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.PointLoad(block=0, point=tuple(p), force=tuple(f)) for p, f in zip(points, forces, strict=True)],
    )
    exact = sum(matrix_b(centroid, p).T @ f for p, f in zip(points, forces, strict=True))
    return exact, external_loads(model)[0]


def balance() -> Answer:
    """Compare contact forces and weights of every brick of a leaning wall, added up anew; the exact sum is nothing."""
    polygons = running_bond(8, 6)
    model = model_of(polygons, gamma=GAMMA, joint=bsm.Joint("J", KN, KS), fixed=range(6), gravity_direction=-82.0)
    contacts, centroid = bsm.run(model, LINEAR).stages[-1].contacts, model.blocks.moments.centroid
    total = np.column_stack([model.gravity_forces, np.zeros(len(polygons))])
    for a, b, point, force in zip(contacts.block_a, contacts.block_b, contacts.point, contacts.force, strict=True):
        total[b] += matrix_b(centroid[b], point).T @ force
        total[a] -= matrix_b(centroid[a], point).T @ force
    return np.zeros(3 * (len(polygons) - 6)), total[6:].ravel() / (GAMMA * 0.5)


def _field(x: Array, y: Array) -> Array:
    """Return a stress field in equilibrium with the weight, (..., 2, 2) [Pa]."""
    xx, xy = -2e6 + 3e5 * x - 1e5 * y, 4e5 + 2e5 * x - 3e5 * y
    yy = -5e6 + 1e5 * x + (GAMMA - 2e5) * y
    return np.moveaxis(np.array([(xx, xy), (xy, yy)]), (0, 1), (-2, -1))


def average_stress() -> Answer:
    """Compare the mean of a linear stress field over polygons, from tractions on their edges and the weight."""
    from shapely import Polygon

    exact, found = [], []
    for outline in OUTLINES:
        corners = turned(np.array(outline, dtype=float), 50.0, (1.5, -0.5))
        blocks = bsm.Blocks.from_polygons([corners], rock="r").with_boundary("outline", lambda x, y: x == x)
        along = blocks.edge_vectors[blocks.boundaries["outline"]]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        edges = blocks.boundaries["outline"]
        ends = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
        traction = np.einsum("eaij,ej->eai", _field(ends[..., 0], ends[..., 1]), normal)
        model = bsm.Model(
            blocks=blocks,
            rocks=[bsm.Rock("r", unit_weight=GAMMA)],
            supports=[bsm.Fixed(blocks=[0])],
            loads=[bsm.EdgeTractions(boundary="outline", values=traction)],
        )
        exact.append(_field(*np.array(Polygon(corners).centroid.coords[0])))
        found.append(bsm.run(model, LINEAR).stages[-1].stress[0])
    return np.array(exact), np.array(found)


CASES = (
    Case(name="relative-displacement", what="how far two blocks move apart at a point", source="wang",
         quantity="displacement [m]", compute=relative_displacement, tolerance=EXACT,
         equations=("3.1", "3.2", "3.3", "3.4", "3.5", "3.6", "3.7", "3.8", "3.9", "3.10")),
    Case(name="contact-forces", what="normal and shear force of a contact", source="wang", quantity="force [N/m]",
         compute=contact_forces, tolerance=EXACT, equations=("3.11", "3.12", "3.13", "3.14", "3.15")),
    Case(name="forces-on-blocks", what="force and moment of a contact on its two blocks", source="wang",
         quantity="force [N/m], moment [N]", compute=forces_on_blocks, tolerance=EXACT, equations=("3.16", "3.17")),
    Case(name="contact-matrix", what="stiffness matrix of one contact", source="wang", quantity="stiffness [N/m2]",
         compute=contact_matrix, tolerance=EXACT, equations=("3.18", "3.19")),
    Case(name="elastic-moduli", what="E' and G of four rocks", source="wang", quantity="modulus [Pa]",
         compute=elastic_moduli, tolerance=EXACT, equations=("3.20", "3.21")),
    Case(name="one-rock", what="stiffness of a face of elastic on rigid rock", source="wang",
         quantity="Kn, Ks [Pa/m]", compute=one_rock, tolerance=EXACT, equations=("3.22", "3.23", "3.24")),
    Case(name="two-rocks", what="stiffness of a face between two rocks", source="wang", quantity="Kn, Ks [Pa/m]",
         compute=two_rocks, tolerance=EXACT, equations=("3.25", "3.26")),
    Case(name="rock-and-joint", what="stiffness of a joint between two rocks", source="wang",
         quantity="Kn, Ks [Pa/m]", compute=rock_and_joint, tolerance=EXACT, equations=("3.27",)),
    Case(name="filled-joint", what="stiffness of a joint with a thick filling", source="wang",
         quantity="Kn, Ks [Pa/m]", compute=filled_joint, tolerance=EXACT, equations=("3.26",)),
    Case(name="held-wall", what="a wall on inclined rollers with given displacements, by bars of "
         f"{STIFF:.0e} times the contacts' stiffness", source="lagrange", quantity="displacement [m], turn",
         compute=held_wall, tolerance=1e-6, equations=("3.28", "3.29", "3.30", "3.31", "3.32", "3.33", "3.34", "3.35",
                                                       "3.40", "3.41")),
    Case(name="weights", what="weights of polygons along inclined gravity", source="shapely", quantity="force [N/m]",
         compute=weights, tolerance=EXACT, equations=("3.36", "3.37")),
    Case(name="loads-at-points", what="point loads about the centroid", source="wang",
         quantity="force [N/m], moment [N]", compute=loads_at_points, tolerance=EXACT, equations=("3.38",)),
    Case(name="balance", what="the remainder of all forces on each brick of a leaning wall", source="statics",
         quantity="force over weight", compute=balance, tolerance=1e-11, equations=("3.39",)),
    Case(name="average-stress", what="mean of a linear stress field over three polygons", source="shapely",
         quantity="stress [Pa]", compute=average_stress, tolerance=EXACT,
         equations=("3.43", "3.44", "3.45", "B.1", "B.13", "B.16", "B.17", "B.18")),
)  # fmt: skip
