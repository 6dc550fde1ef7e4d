"""A wall of bricks with a door on its base: change it and run `bsm-mesh run model.toml`.

`build` writes a Gmsh mesh with physical groups: `rock:brick`, `rock:lintel`, `rock:ground`, `joint:bed`, `joint:head`,
`boundary:base`. Each brick is one block.
"""

from pathlib import Path

from bsm_mesh.geometries import Opening, Region, RockMass, bricks, cut_blocks, rectangle, write_blocks


def build(
    path: str | Path,
    width: float = 4.0,
    height: float = 2.5,
    length: float = 0.5,
    course: float = 0.25,
    door: float = 1.0,
    door_height: float = 1.5,
) -> None:
    """Write the mesh to `path`. Lengths in m; the lower left corner of the wall is the origin."""
    wall = rectangle(0, 0, width, height)
    middle = width / 2
    lintel = rectangle(middle - door, door_height, middle + door, door_height + course)
    beds, heads = bricks(length, course, within=wall)
    mass = RockMass(
        regions=[
            Region(outline=rectangle(-0.5, -0.5, width + 0.5, 0), rock="ground", border="bed"),
            Region(outline=wall, rock="brick"),
            Region(outline=lintel, rock="lintel", border="bed", intact=True),
            Opening(outline=rectangle(middle - door / 2, 0, middle + door / 2, door_height), boundary="door"),
        ],
        joints=[beds, heads],
        boundaries={"base": [(-0.5, -0.5), (width + 0.5, -0.5)]},
    )
    blocks = cut_blocks(mass)
    print(*blocks.report(), sep="\n")  # where the length of every joint went
    write_blocks(blocks, path)


if __name__ == "__main__":
    build("wall.msh")
