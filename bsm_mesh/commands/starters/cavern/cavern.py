"""A cavern in two joint sets under a shear zone, excavated in two stages: change it and run it.

`build` cuts the rock into blocks and writes them as a Gmsh mesh with physical groups: `rock:gneiss`, `rock:shear_zone`,
`joint:J1`, `joint:J2`, `joint:wall` (both sides of the zone), `excavation:heading`, `excavation:bench`. Later regions
lie over earlier ones. A joint of each set goes through a point of its own near the roof: together they cut out a wedge.
"""

from pathlib import Path

from bsm_mesh.geometries import (
    Excavation,
    JointSet,
    Normal,
    Region,
    RockMass,
    band,
    cut_blocks,
    rectangle,
    vaulted_box,
    write_blocks,
)


def build(
    path: str | Path,
    span: float = 14.0,
    height: float = 12.0,
    bench: float = 6.0,
    rise: float = 4.0,
    spacing: float = 5.0,
    zone_width: float = 1.0,
    seed: int = 1,
) -> None:
    """Write the mesh to `path`. Lengths in m, angles in degrees; the middle of the floor is the origin."""
    frame = rectangle(-30, -20, 30, 32)
    zone = band([(-40, 15), (40, 24)], zone_width)
    law = Normal(spacing, 0.15 * spacing)  # mean and standard deviation
    mass = RockMass(
        regions=[
            Region(outline=frame, rock="gneiss"),
            Region(outline=zone, rock="shear_zone", border="wall", clipped=True),  # not beyond the frame
            Excavation(outline=vaulted_box(span, height - bench, rise, (0, bench)), name="heading"),
            Excavation(outline=rectangle(-span / 2, 0, span / 2, bench), name="bench"),
        ],
        joints=[
            JointSet(name="J1", dip=52, spacing=law, start=(-span / 4, height - 1), scatter=2.0),
            JointSet(name="J2", dip=126, spacing=law, start=(0.86 * span / 4, height - 1), scatter=2.0),
        ],
        seed=seed,  # same seed, same blocks
    )
    blocks = cut_blocks(mass)
    print(*blocks.report(), sep="\n")  # where the length of every joint went
    write_blocks(blocks, path)


if __name__ == "__main__":
    build("cavern.msh")
