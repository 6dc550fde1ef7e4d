"""A circular tunnel in rock with two sets of joints, by Gmsh alone: change it and run `bsm-mesh run model.toml`.

`build` writes a Gmsh mesh. The names of its physical groups count, `kind:name`: surfaces `rock:gneiss` and
`excavation:tunnel` (a surface may have both), curves `joint:J1`, `joint:J2` and `boundary:bottom`. Each region
bounded by joints is a block (`blocks = "regions"`), whatever the size of the elements.
"""

from pathlib import Path

import gmsh
import numpy as np


def build(
    path: str | Path,
    radius: float = 2.5,
    width: float = 24.0,
    height: float = 24.0,
    dips: tuple[float, float] = (55.0, 122.0),
    spacing: float = 3.0,
    above: float = 1.8,
    size: float = 1.0,
) -> None:
    """Write the mesh to `path`. Lengths in m, dips in degrees from the horizontal; the tunnel's axis is the origin.

    A joint of each set goes through the point `above` the crown: they cut a wedge out of the roof.
    """
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        ground = occ.addRectangle(-width / 2, -height / 2, 0, width, height)
        tunnel = occ.addDisk(0, 0, 0, radius, radius)

        # Joints: parallel lines through the whole model, cut to the rock by intersecting them with it.
        sets = []
        for dip in dips:
            direction = np.array([np.cos(np.radians(dip)), np.sin(np.radians(dip))])
            normal = np.array([-direction[1], direction[0]])
            reach = np.hypot(width, height)
            count = int(reach / spacing)
            lines = []
            for k in range(-count, count + 1):
                middle = (0.2, radius + above) + k * spacing * normal
                (x0, y0), (x1, y1) = middle + np.outer([-reach, reach], direction)
                lines.append((1, occ.addLine(occ.addPoint(x0, y0, 0), occ.addPoint(x1, y1, 0))))
            sets.append(occ.intersect(lines, [(2, ground)], removeTool=False)[0])

        # Fragmenting renumbers everything: groups are set afterwards, from the map of children.
        _, children = occ.fragment([(2, ground), (2, tunnel), *sets[0], *sets[1]], [])
        occ.synchronize()
        rock, inside = ([tag for _, tag in child] for child in children[:2])
        gmsh.model.addPhysicalGroup(2, rock, name="rock:gneiss")
        gmsh.model.addPhysicalGroup(2, inside, name="excavation:tunnel")
        for name, pieces in (("J1", children[2 : 2 + len(sets[0])]), ("J2", children[2 + len(sets[0]) :])):
            gmsh.model.addPhysicalGroup(1, [tag for child in pieces for _, tag in child], name=f"joint:{name}")
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
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 32)  # straight sides round the full circle
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    build("tunnel.msh")
