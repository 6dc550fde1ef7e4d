"""A slab of rock on a plane joint through a section, which lies in the mesh or is laid through it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes.marks import Marks, Place

WIDTH, HEIGHT = 20.0, 10.0


def plane(dip: float, *, level: float = 5.0) -> np.ndarray:
    """Return a line through the section at an angle [degrees], at the level in its middle [m]."""
    turn = np.radians(dip)
    along = 20 * np.array([np.cos(turn), np.sin(turn)])
    middle = np.array([WIDTH / 2, level])
    return np.array([middle - along, middle + along])


def write_section(path: Path, size: float, *, quads: bool, joint: np.ndarray | None = None, seed: int = 1) -> Path:
    """Return the path of a mesh of the section; with a joint it is cut by `fragment_by_joints`."""
    from bsm_mesh.geometries import Fault, fragment_by_joints, gmsh_session, name_groups, write_mesh

    with gmsh_session() as gmsh:
        rock = gmsh.model.occ.addRectangle(0, 0, 0, WIDTH, HEIGHT)
        gmsh.model.occ.synchronize()
        pieces, curves = [rock], {}
        if joint is not None:
            (pieces,), curves = fragment_by_joints([rock], [Fault(name="f", lines=[joint])])
        name_groups({"rock:a": pieces, **curves})
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.RandomSeed", seed)
        gmsh.option.setNumber("Mesh.RecombineAll", int(quads))
        gmsh.model.mesh.generate(2)
        write_mesh(path)
    return path


def slab(path: Path, friction: float, blocks: str, line: np.ndarray | None = None) -> bsm.Model:
    """Return the model of a mesh, its base held; the joint is laid along the line, where one is given."""
    lines = {} if line is None else {"f": [line]}
    found, _ = read_mesh(path, blocks=blocks, marks=Marks(lines=lines, boundaries={"base": Place(below=1e-6)}))
    return bsm.Model(
        blocks=found,
        rocks=[bsm.Rock("a", unit_weight=26e3, young=20e9, poisson=0.25)],
        joints=[bsm.Joint("f", 1e10, 1e10, law=bsm.MohrCoulomb(friction=friction))],
        supports=[bsm.Fixed(boundary="base")],
    )
