"""A semicircular arch of stones, scripted with Gmsh alone: change it and run `bsm-mesh run model.toml`.

`build` writes a Gmsh mesh. The names of its physical groups count, `kind:name`: surfaces `rock:granite`,
curves `joint:bed` (between stones) and `boundary:springing`.
"""

from pathlib import Path

import gmsh
import numpy as np


def build(
    path: str | Path, radius: float = 5.0, thickness: float = 0.8, stones: int = 15, opening: float = 180.0
) -> None:
    """Write the mesh to `path`. Lengths in m; `radius` is that of the middle line, `opening` the arch's angle.

    A further stone at each end is the abutment.
    """
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        geo = gmsh.model.geo
        start = np.radians(90 - opening / 2)
        angle = start + np.radians(opening) * np.arange(-1, stones + 2) / stones
        rims = [
            [geo.addPoint(r * np.cos(a), r * np.sin(a), 0) for a in angle]
            for r in (radius - thickness / 2, radius + thickness / 2)
        ]
        beds = [geo.addLine(inner, outer) for inner, outer in zip(*rims, strict=True)]
        inside, outside = ([geo.addLine(rim[k], rim[k + 1]) for k in range(stones + 2)] for rim in rims)
        surfaces = [
            geo.addPlaneSurface([geo.addCurveLoop([beds[k], outside[k], -beds[k + 1], -inside[k]])])
            for k in range(stones + 2)
        ]
        geo.synchronize()
        for curve in (*beds, *inside, *outside):
            gmsh.model.mesh.setTransfiniteCurve(curve, 2)  # one element a side, so one a stone
        for surface in surfaces:
            gmsh.model.mesh.setTransfiniteSurface(surface)
            gmsh.model.mesh.setRecombine(2, surface)
        gmsh.model.addPhysicalGroup(2, surfaces, name="rock:granite")
        gmsh.model.addPhysicalGroup(1, beds[1:-1], name="joint:bed")
        gmsh.model.addPhysicalGroup(1, [beds[0], beds[-1]], name="boundary:springing")
        gmsh.model.addPhysicalGroup(1, outside[1:-1], name="boundary:extrados")
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    build("arch.msh")
