"""Meshes of volume elements that Gmsh makes: a box on an inclined joint under a lid, layers of prisms and hexahedra."""

import math
from pathlib import Path

import gmsh
import numpy as np

from bsm_mesh.geometries.session import gmsh_session

DIP = 30.0  # of the joint


def _write(path: Path, version=4.1, order=1):
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.write(str(path))


def _middles(dimension):
    return {
        tag: np.array(gmsh.model.occ.getCenterOfMass(dimension, tag)) for _, tag in gmsh.model.getEntities(dimension)
    }


def incline(path, *, version=4.1, order=1, names=None, binary=False, dip=DIP, direction=90.0, size=1.0):
    """Write a box of 2 x 2 x 3 m, cut by a plane through (1, 1, 1), its uppermost half metre an excavation.

    Dip and dip direction in degrees; north is +y. `size` is that of the elements [m].
    """
    called = {name: name for name in ("rock:granite", "excavation:lid", "joint:J1", "boundary:bottom")} | (names or {})
    with gmsh_session():
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", max(size, 1.0))
        gmsh.option.setNumber("Mesh.Binary", int(binary))
        occ = gmsh.model.occ
        box, lid = occ.addBox(0, 0, 0, 2, 2, 2.5), occ.addBox(0, 0, 2.5, 2, 2, 0.5)
        plane = occ.addRectangle(-1, -1, 1, 4, 4)
        down, east = math.radians(dip), math.radians(90 - direction)
        occ.rotate([(2, plane)], 1, 1, 1, 0, 1, 0, down)
        occ.rotate([(2, plane)], 1, 1, 1, 0, 0, 1, east)
        occ.fragment([(3, box), (3, lid)], [(2, plane)])
        occ.synchronize()
        volumes, surfaces = _middles(3), _middles(2)
        normal = np.array([math.sin(down) * math.cos(east), math.sin(down) * math.sin(east), math.cos(down)])
        wide = {s: gmsh.model.getBoundingBox(2, s)[3] for s in surfaces}  # of the plane's rest, beyond the box
        on_joint = [s for s, at in surfaces.items() if abs((at - 1) @ normal) < 1e-9 and wide[s] < 2.1]
        groups = {
            (3, "rock:granite"): list(volumes),
            (3, "excavation:lid"): [v for v, at in volumes.items() if at[2] > 2.5],
            (2, "joint:J1"): on_joint,
            (2, "boundary:bottom"): [s for s, at in surfaces.items() if at[2] < 1e-9],
        }
        for (dimension, name), tags in groups.items():
            if called[name]:
                gmsh.model.addPhysicalGroup(dimension, tags, name=called[name])
        _write(path, version, order)
    return path


def wedge(path):
    """Write a box of 4 x 3 x 2 m with a wedge of 1.125 m3 on two planes that meet in a line falling 45 degrees south.

    Face and top, boundaries of their own, are at y = 0 and z = 2; the wedge has its foot at (1, 0, 0.5).
    """
    dip, foot = math.acos(1 / math.sqrt(3)), (1, 0, 0.5)
    with gmsh_session():
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 2.0)
        occ = gmsh.model.occ
        box = occ.addBox(-1, 0, 0, 4, 3, 2)
        planes = [occ.addRectangle(-9, -9, 0.5, 20, 20) for _ in range(2)]
        for plane, azimuth in zip(planes, (135, 225), strict=True):
            angle = math.radians(azimuth)
            occ.rotate([(2, plane)], *foot, -math.cos(angle), math.sin(angle), 0, dip)
        occ.fragment([(3, box)], [(2, plane) for plane in planes])
        occ.synchronize()
        surfaces, volumes = _middles(2), _middles(3)
        within = {s for v in volumes for _, s in gmsh.model.getBoundary([(3, v)], oriented=False)}
        normals = {"A": (1, -1, 1), "B": (-1, -1, 1)}
        gmsh.model.addPhysicalGroup(3, list(volumes), name="rock:granite")
        for name, normal in normals.items():
            on = [s for s in within if abs((surfaces[s] - foot) @ np.array(normal)) < 1e-9]
            gmsh.model.addPhysicalGroup(2, on, name=f"joint:{name}")
        for name, axis, place in (("face", 1, 0.0), ("top", 2, 2.0), ("bottom", 2, 0.0)):
            on = [s for s in within if abs(surfaces[s][axis] - place) < 1e-9]
            gmsh.model.addPhysicalGroup(2, on, name=f"boundary:{name}")
        _write(path)
    return path


def layers(path, *, recombine, bent=0.0):
    """Write a box of 2 x 1 x 1 m of two layers, of prisms or hexahedra, the upper one of another rock."""
    with gmsh_session():
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.Binary", 0)
        geo = gmsh.model.geo
        corners = [geo.addPoint(*p, 0) for p in ((0, 0), (2, 0), (2, 1), (0, 1))]
        sides = [geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(sides)])
        for side, count in zip(sides, (3, 2, 3, 2), strict=True):
            geo.mesh.setTransfiniteCurve(side, count)
        geo.mesh.setTransfiniteSurface(surface)
        if recombine:
            geo.mesh.setRecombine(2, surface)
        lower = geo.extrude([(2, surface)], 0, 0, 0.5, numElements=[1], recombine=True)
        upper = geo.extrude([lower[0]], 0, 0, 0.5, numElements=[1], recombine=True)
        geo.synchronize()
        gmsh.model.addPhysicalGroup(3, [lower[1][1]], name="rock:slate")
        gmsh.model.addPhysicalGroup(3, [upper[1][1]], name="rock:gneiss")
        gmsh.model.addPhysicalGroup(2, [lower[0][1]], name="joint:bedding")
        gmsh.model.addPhysicalGroup(2, [surface], name="boundary:bottom")
        gmsh.model.mesh.generate(3)
        if bent:
            tags, at, _ = gmsh.model.mesh.getNodes(2, upper[0][1], includeBoundary=True)
            tag, at = int(tags[0]), at.reshape(-1, 3)[0]
            gmsh.model.mesh.setNode(tag, [at[0], at[1], at[2] + bent], [])
        gmsh.write(str(path))
    return path


def pocket(path):
    """Write a box of 3 x 3 x 2 m with a square of 1 m2 inside it, in the group of the joint J1."""
    with gmsh_session():
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 2.0)
        occ = gmsh.model.occ
        rock, joint = occ.addBox(0, 0, 0, 3, 3, 2), occ.addRectangle(1, 1, 1, 1, 1)
        occ.fragment([(3, rock)], [(2, joint)])
        occ.synchronize()
        bottom = min(_middles(2).items(), key=lambda item: item[1][2])[0]
        gmsh.model.addPhysicalGroup(3, [rock], name="rock:granite")
        gmsh.model.addPhysicalGroup(2, [joint], name="joint:J1")
        gmsh.model.addPhysicalGroup(2, [bottom], name="boundary:bottom")
        _write(path)
