"""A cavern excavated in two stages under a shear zone, in rock with two joint sets: change it and run it.

`build` cuts the rock into blocks and writes them as a Gmsh mesh with physical groups: `rock:gneiss`, `rock:shear_zone`,
`joint:J1`, `joint:wall` (both sides of the zone), `excavation:heading`, `excavation:bench`. Later regions lie over
earlier ones.
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
    spacing: float = 4.0,
    zone_width: float = 1.0,
    seed: int = 1,
) -> None:
    """Write the mesh to `path`. Lengths in m, angles in degrees."""
    frame = rectangle(-30, -20, 30, 32)
    zone = band([(-40, 14), (40, 22)], zone_width)
    mass = RockMass(
        regions=[
            Region(outline=frame, rock="gneiss"),
            Region(outline=zone, rock="shear_zone", border="wall", clipped=True),  # not beyond the frame
            Excavation(outline=vaulted_box(span, height - bench, rise, (0, bench)), name="heading"),
            Excavation(outline=rectangle(-span / 2, 0, span / 2, bench), name="bench"),
        ],
        joints=[
            JointSet(name="J1", dip=15, spacing=spacing),
            JointSet(name="J2", dip=75, spacing=Normal(spacing, 0.2 * spacing), scatter=2.0),
        ],
        seed=seed,  # same seed, same blocks
    )
    blocks = cut_blocks(mass)
    print(*blocks.report(), sep="\n")  # where the length of every joint went
    write_blocks(blocks, path)


if __name__ == "__main__":
    build("cavern.msh")
