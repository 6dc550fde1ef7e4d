"""A room 10 m wide in two joint sets, a crack above its roof: `bsm-mesh run model.toml` builds its mesh from here."""

from pathlib import Path

from bsm_mesh.geometries import Excavation, Fault, JointSet, Region, RockMass, cut_blocks, rectangle, write_blocks

CENTRE = (0.0, 0.0)
CRACK = [(2.25, 2.5), (1.93, 5.0)]  # from the roof to the first joint above


def build(path: str | Path, spacing: float = 5.0) -> None:
    """Write the mesh to `path`. Lengths in m, angles in degrees."""
    mass = RockMass(
        regions=[
            Region(outline=rectangle(-25, -20, 25, 20), rock="rock"),
            Excavation(outline=rectangle(-5, -2.5, 5, 2.5), name="room", border="joint"),
        ],
        joints=[
            JointSet(name="joint", dip=45.0, spacing=spacing, start=CENTRE),
            JointSet(name="joint", dip=-9.0, spacing=spacing, start=CENTRE),
            Fault(name="joint", lines=[CRACK]),
        ],
        dead_ends="cut",
    )
    write_blocks(cut_blocks(mass), path)
