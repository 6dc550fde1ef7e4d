"""Abaqus: every block of elements of its own, joints as cohesive elements of zero thickness (COH2D4).

Read back by this package it gives the same rocks, joints, boundaries and areas. CalculiX reads it but for the joints.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.exports.parts import GRAVITY, JointedFaces, heading, left_out, quoted
from bsm_mesh.files import write_text
from bsm_mesh.model.loads import Pressure
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Fixed, NormalRoller, Roller

ROCK, STIFF = "unjointed rock", 1e13  # Pa/m: faces without a joint
RIGID = 1e13  # Pa: Young's modulus of a rock that has none


def write(model: Model, path: Path) -> tuple[str, ...]:
    """Write a model; return omissions."""
    blocks = model.blocks
    remarks = left_out(model, ("laws",))
    mesh = _elements(model)
    lines = ["*HEADING", f"Model: {heading(model)}"]  # a title that begins with * is no keyword
    lines += ["*NODE", *(f"{k}, {x:.17g}, {y:.17g}" for k, (x, y) in enumerate(mesh.points, start=1))]
    number, owner = 1, dict[int, int]()
    for size, kind in ((3, "CPE3"), (4, "CPE4")):
        for rock, name in enumerate(blocks.rock_names):
            rows = [(nodes, b) for nodes, b in mesh.cells if len(nodes) == size and blocks.rock[b] == rock]
            owner |= {number + k: b for k, (_, b) in enumerate(rows)}
            lines += _rows(f"*ELEMENT, TYPE={kind}, ELSET={_name('ROCK', name)}", [nodes for nodes, _ in rows], number)
            number += len(rows)
    for name, elements in _joint_elements(model, remarks).items():
        lines += _rows(f"*ELEMENT, TYPE=COH2D4, ELSET={_name('JOINT', name)}", elements, number)
        number += len(elements)
    for name, edges in blocks.boundaries.items():
        corners = np.unique([edges, blocks.following[edges]])
        lines += [f"*NSET, NSET={_name('BOUNDARY', name)}", *_sixteen(corners + 1)]
    for name, ids in blocks.excavations.items():
        inside = set(ids.tolist())
        lines += [f"*ELSET, ELSET={_name('EXCAVATION', name)}", *_sixteen(k for k, b in owner.items() if b in inside)]
    lines += _materials(model, remarks) + _boundary_conditions(model, remarks) + _step(model, remarks)
    write_text(path, "\n".join(lines) + "\n")
    return tuple(remarks)


class _Mesh:
    """Points, first the corners of the blocks as they are numbered, then centroids; and cells with their blocks."""

    def __init__(self, points: FloatArray, cells: list[tuple[list[int], int]]) -> None:
        self.points, self.cells = points, cells


def _elements(model: Model) -> _Mesh:
    """Return a triangle or a convex quadrilateral as one element, other blocks as a fan or cut to triangles."""
    import shapely

    blocks = model.blocks
    along, following = blocks.edge_vectors, blocks.following
    convex = np.ones(blocks.count, dtype=np.bool_)
    convex[blocks.owner[along[:, 0] * along[following, 1] - along[:, 1] * along[following, 0] <= 0]] = False
    points, cells = [*blocks.vertices], []
    for block, (a, b) in enumerate(zip(blocks.offsets[:-1], blocks.offsets[1:], strict=True)):
        corners = list(range(a, b))
        if b - a == 3 or (b - a == 4 and convex[block]):
            cells.append((corners, block))
            continue
        outline = shapely.Polygon(blocks.vertices[a:b])
        for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(outline)):
            ends = shapely.get_coordinates(shapely.orient_polygons(triangle))[:3]
            nearest = np.abs(blocks.vertices[a:b][None] - ends[:, None]).sum(axis=2).argmin(axis=1)
            cells.append(([corners[k] for k in nearest], block))
    return _Mesh(np.array(points), cells)


def _joint_elements(model: Model, remarks: list[str]) -> dict[str, list[list[int]]]:
    """Return cohesive elements on the faces that are whole edges of both blocks: b's edge, then a's the same way."""
    jointed, following = JointedFaces.of(model), model.blocks.following
    found: dict[str, list[list[int]]] = {}
    length = np.hypot(*model.blocks.edge_vectors.T)
    own = np.hypot(*(jointed.faces.end - jointed.faces.start).T)
    whole = np.minimum(length[jointed.faces.edge_a], length[jointed.faces.edge_b]) > own * (1 - 1e-9)
    whole &= np.maximum(length[jointed.faces.edge_a], length[jointed.faces.edge_b]) < own * (1 + 1e-9)
    for joint, a, b in zip(jointed.joint[whole], jointed.faces.edge_a[whole], jointed.faces.edge_b[whole], strict=True):
        name = model.joints[joint].name if joint >= 0 else ROCK
        found.setdefault(name, []).append([int(following[b]), int(b), int(following[a]), int(a)])
    if not whole.all():
        remarks.append(f"{int((~whole).sum())} faces at T-junctions: parts of edges hold no cohesive element")
    if ROCK in found:
        remarks.append(f"faces of rock without a joint: cohesive elements of {STIFF:g} Pa/m")
    return found


def _rows(head: str, rows: list[list[int]], first: int) -> list[str]:
    lines = [f"{k}, " + ", ".join(str(node + 1) for node in nodes) for k, nodes in enumerate(rows, start=first)]
    return [head, *lines] if rows else []


def _sixteen(numbers: IntArray | Iterable[int]) -> list[str]:
    texts = [str(int(n)) for n in numbers]
    return [", ".join(texts[k : k + 16]) for k in range(0, len(texts), 16)]


def _name(kind: str, name: str) -> str:
    return quoted(f"{kind}:{name}")


def _materials(model: Model, remarks: list[str]) -> list[str]:
    lines = []
    for rock in (rock for rock in model.rocks if rock.name in model.blocks.rock_names):
        name = _name("ROCK", rock.name)
        if rock.young is None:
            remarks.append(f"rock '{rock.name}' is rigid: E = {RIGID:g} Pa")
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL={name}", "1.", f"*MATERIAL, NAME={name}"]
        lines += ["*DENSITY", f"{rock.unit_weight / GRAVITY:.9g}"]
        lines += ["*ELASTIC", f"{rock.young or RIGID:.9g}, {rock.poisson or 0.0:.9g}"]
    joints = [(joint.name, joint.contact_stiffness) for joint in model.joints]
    for own, (normal, shear) in [*joints, (ROCK, (STIFF, STIFF))]:
        name = _name("JOINT", own)
        lines += [f"*COHESIVE SECTION, ELSET={name}, MATERIAL={name}, RESPONSE=TRACTION SEPARATION,"]
        lines += ["THICKNESS=SPECIFIED", "1.0, 1.0", f"*MATERIAL, NAME={name}"]
        lines += ["*ELASTIC, TYPE=TRACTION", f"{normal:.9g}, {shear:.9g}, {shear:.9g}"]
    for joint in model.joints:
        if joint.law is not None:
            remarks.append(f"joint '{joint.name}': strength; its cohesive elements are elastic")
    return lines


def _boundary_conditions(model: Model, remarks: list[str]) -> list[str]:
    lines = ["*BOUNDARY"]
    for number, support in enumerate(model.supports, start=1):
        if isinstance(support, Fixed) and support.blocks is not None:
            blocks = model.blocks
            corners = np.flatnonzero(np.isin(blocks.owner, np.asarray(support.blocks)))
            lines += [f"{corner + 1}, 1, 2" for corner in corners]
        elif isinstance(support, Fixed) and support.boundary is not None:
            lines.append(f"{_name('BOUNDARY', support.boundary)}, 1, 2")
        elif isinstance(support, Roller) and support.boundary is not None and support.direction % 90 == 0:
            axis = 1 if support.direction % 180 == 0 else 2
            lines.append(f"{_name('BOUNDARY', support.boundary)}, {axis}, {axis}")
        elif isinstance(support, NormalRoller) and (axis := _axis(model, str(support.boundary))):
            lines.append(f"{_name('BOUNDARY', str(support.boundary))}, {axis}, {axis}")
        else:
            remarks.append(f"support {number} ({type(support).__name__}): points and directions off the axes")
    return lines if len(lines) > 1 else []


def _axis(model: Model, boundary: str) -> int:
    """Return the axis, 1 or 2, that is normal to a straight boundary along the other one; else 0."""
    along = np.abs(model.blocks.edge_vectors[model.blocks.boundary_edges(boundary)])
    reach = 1e-6 * along.max()
    return 2 if (along[:, 1] <= reach).all() else 1 if (along[:, 0] <= reach).all() else 0


def _step(model: Model, remarks: list[str]) -> list[str]:
    """Return one static step with gravity and loads."""
    from bsm_mesh.model.loads import InSituTraction, point_forces_of

    loads = [load for load in model.loads if not isinstance(load, InSituTraction)]
    rocks = {rock.name: rock for rock in model.rocks if rock.name in model.blocks.rock_names}
    lines = ["*STEP, NLGEOM", "*STATIC", "*DLOAD"]
    lines += [f"{_name('ROCK', name)}, GRAV, {GRAVITY:g}, 0., -1." for name in rocks]
    forces = point_forces_of(loads, model.blocks)
    nodes, extra = _corner_loads(model, forces.block, forces.point, forces.force)
    if extra:
        remarks.append(f"{extra} forces that act off corners: they act at the nearest corner of their block")
    if any(isinstance(load, Pressure) for load in loads):
        remarks.append("pressures are forces at corners: they do not follow what turns")
    if nodes:
        lines += [
            "*CLOAD",
            *(f"{n + 1}, {axis + 1}, {f[axis]:.9g}" for n, f in nodes.items() for axis in (0, 1) if f[axis]),
        ]
    return [*lines, "*END STEP"]


def _corner_loads(
    model: Model, block: IntArray, point: FloatArray, force: FloatArray
) -> tuple[dict[int, FloatArray], int]:
    """Return the force at each corner, and how many act off corners."""
    blocks, found, extra = model.blocks, dict[int, FloatArray](), 0
    for number, where, value in zip(block, point, force, strict=True):
        first, last = blocks.offsets[number], blocks.offsets[number + 1]
        distance = np.hypot(*(blocks.vertices[first:last] - where).T)
        corner = int(first + distance.argmin())
        extra += bool(distance.min() > 1e-9)
        found[corner] = found.get(corner, np.zeros(2)) + value
    return found, extra
