"""A rock slope dug bench by bench, with bedding that dips out of it: change it and run `bsm-mesh run model.toml`.

`build` cuts the rock into blocks and writes them as a Gmsh mesh with physical groups: `rock:schist`, `joint:bedding`,
`joint:J2`, `excavation:bench 1` (the upper one), ..., `boundary:bottom`, ... Angles count from the x axis,
counter-clockwise: bedding at 30 rises to the right, as the slope does, and so dips out of it.
"""

import math
from pathlib import Path

from bsm_mesh.geometries import Excavation, JointSet, Region, RockMass, cut_blocks, rectangle, write_blocks


def build(
    path: str | Path,
    height: float = 20.0,
    angle: float = 70.0,
    benches: int = 2,
    berm: float = 3.0,
    bedding_dip: float = 30.0,
    bedding_spacing: float = 3.0,
    joint_dip: float = 110.0,
    joint_spacing: float = 5.0,
    seed: int = 1,
) -> None:
    """Write the mesh to `path`. Lengths in m, angles in degrees."""
    ahead, behind, below = 10.0, 25.0, 8.0
    rise = height / benches
    run = rise / math.tan(math.radians(angle))
    dug = []
    for bench in range(benches):
        toe, floor = bench * (run + berm), bench * rise  # from the lowest one up
        outline = [(-ahead, floor), (toe, floor), (toe + run, floor + rise), (-ahead, floor + rise)]
        dug.append(Excavation(outline=outline, name=f"bench {benches - bench}"))
    ground = rectangle(-ahead, -below, benches * (run + berm) - berm + behind, height)
    mass = RockMass(
        regions=[Region(outline=ground, rock="schist"), *dug],
        joints=[
            JointSet(name="bedding", dip=bedding_dip, spacing=bedding_spacing, start=(0, 0)),  # through the toe
            JointSet(name="J2", dip=joint_dip, spacing=joint_spacing, scatter=2.0),
        ],
        seed=seed,  # same seed, same blocks
    )
    blocks = cut_blocks(mass)
    print(*blocks.report(), sep="\n")  # where the length of every joint went
    write_blocks(blocks, path)


if __name__ == "__main__":
    build("slope.msh")
