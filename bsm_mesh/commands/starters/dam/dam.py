"""A gravity dam on bedded rock: does it slide? Change it and run `bsm-mesh run model.toml`.

`build` cuts dam and rock into blocks and writes them as a Gmsh mesh with physical groups: `rock:concrete`,
`rock:limestone`, `joint:contact` (under the dam), `joint:bedding`, `boundary:upstream` (where the water stands), ...
"""

from pathlib import Path

from bsm_mesh.geometries import JointSet, Region, RockMass, cut_blocks, dam, rectangle, write_blocks


def build(
    path: str | Path,
    height: float = 40.0,
    crest: float = 6.0,
    downstream: float = 52.0,
    bedding_dip: float = 8.0,
    bedding_spacing: float = 10.0,
) -> None:
    """Write the mesh to `path`. Lengths in m, angles in degrees; the dam's heel is the origin."""
    ground = rectangle(-60, -40, 110, 0)
    mass = RockMass(
        regions=[
            Region(outline=ground, rock="limestone"),
            Region(outline=dam(height, crest, downstream=downstream), rock="concrete", border="contact", intact=True),
        ],
        joints=[
            JointSet(name="bedding", dip=bedding_dip, spacing=bedding_spacing),
            JointSet(name="J2", dip=95.0, spacing=12.0),
        ],
        boundaries={"upstream": [(0, height), (0, 0)], "reservoir": [(0, 0), (-60, 0)]},
    )
    blocks = cut_blocks(mass)
    print(*blocks.report(), sep="\n")  # where the length of every joint went
    write_blocks(blocks, path)


if __name__ == "__main__":
    build("dam.msh")
