"""A rock slope 20 m high with bedding that dips out of it: `bsm-mesh run model.toml` builds its mesh from here."""

from pathlib import Path

from bsm_mesh.geometries import JointSet, Region, RockMass, cut_blocks, write_blocks

TOE, CREST, BEHIND, BELOW, AHEAD = (0.0, 0.0), (8.0, 20.0), 38.0, -8.0, -10.0


def build(
    path: str | Path, bedding_dip: float = 30.0, bedding_spacing: float = 3.0, joint_spacing: float = 5.0
) -> None:
    """Write the mesh to `path`. Lengths in m, angles in degrees; bedding rises into the slope, through its toe."""
    outline = [(AHEAD, BELOW), (BEHIND, BELOW), (BEHIND, CREST[1]), CREST, TOE, (AHEAD, TOE[1])]
    mass = RockMass(
        regions=[Region(outline=outline, rock="schist")],
        joints=[
            JointSet(name="bedding", dip=bedding_dip, spacing=bedding_spacing, start=TOE),
            JointSet(name="J2", dip=110.0, spacing=joint_spacing),
        ],
        boundaries={"face": [(AHEAD, TOE[1]), TOE, CREST], "back": [(BEHIND, BELOW), (BEHIND, CREST[1])]},
    )
    write_blocks(cut_blocks(mass), path)
