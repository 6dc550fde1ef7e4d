"""A circular tunnel in rock with a set of inclined joints: change it and run `bsm-mesh run model.toml`.

`build` writes a Gmsh mesh. What counts are the names of its physical groups, `kind:name`:
surfaces `rock:gneiss`, curves `joint:J1` and `boundary:bottom`.
"""

from pathlib import Path

import gmsh
import numpy as np


def build(
    path: str | Path,
    radius: float = 2.0,
    width: float = 24.0,
    height: float = 24.0,
    dip: float = 60.0,
    spacing: float = 3.0,
    size: float = 0.9,
) -> None:
    """Write the mesh to `path`. Lengths in m, dip in degrees from the horizontal."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        ground = occ.addRectangle(-width / 2, -height / 2, 0, width, height)
        hole = occ.addDisk(0, 0, 0, radius, radius)
        rock, _ = occ.cut([(2, ground)], [(2, hole)])

        # Joints: parallel lines through the whole model, cut to the rock by intersecting them with it.
        direction = np.array([np.cos(np.radians(dip)), np.sin(np.radians(dip))])
        normal = np.array([-direction[1], direction[0]])
        reach = np.hypot(width, height)
        count = int(reach / 2 / spacing)
        lines = []
        for k in range(-count, count + 1):
            (x0, y0), (x1, y1) = (k + 0.5) * spacing * normal + np.outer([-reach, reach], direction)
            lines.append((1, occ.addLine(occ.addPoint(x0, y0, 0), occ.addPoint(x1, y1, 0))))
        joints, _ = occ.intersect(lines, rock, removeTool=False)

        # Fragmenting renumbers everything: groups are set afterwards, from the map of children.
        _, children = occ.fragment(rock, joints)
        occ.synchronize()
        surfaces = [tag for child in children[: len(rock)] for dim, tag in child if dim == 2]
        traces = [tag for child in children[len(rock) :] for dim, tag in child if dim == 1]
        gmsh.model.addPhysicalGroup(2, sorted(set(surfaces)), name="rock:gneiss")
        gmsh.model.addPhysicalGroup(1, sorted(set(traces)), name="joint:J1")
        sides: dict[str, list[int]] = {"bottom": [], "top": [], "sides": []}
        for _, tag in gmsh.model.getEntities(1):
            x0, y0, _, x1, y1, _ = gmsh.model.getBoundingBox(1, tag)
            if max(abs(y0 + height / 2), abs(y1 + height / 2)) < 1e-3:
                sides["bottom"].append(tag)
            elif max(abs(y0 - height / 2), abs(y1 - height / 2)) < 1e-3:
                sides["top"].append(tag)
            elif abs(x1 - x0) < 1e-3 and abs(abs(x0) - width / 2) < 1e-3:
                sides["sides"].append(tag)
        for name, tags in sides.items():
            gmsh.model.addPhysicalGroup(1, tags, name=f"boundary:{name}")

        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 32)  # elements round the full circle
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    build("tunnel.msh")
