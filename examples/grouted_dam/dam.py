"""A concrete dam 40 m high on bedded rock: `bsm-mesh run model.toml` builds its mesh from here."""

from pathlib import Path

from bsm_mesh.geometries import JointSet, Region, RockMass, cut_blocks, write_blocks

HEIGHT, BASE, CREST = 40.0, 32.0, 6.0


def build(path: str | Path, under: int = 6, upstream: int = 8, downstream: int = 9, beds: int = 5) -> None:
    """Write the mesh to `path`. The heel is at (0, 0); beds are as thick as the blocks under the base are long [m].

    Numbers are those of the blocks along the base, of those in a bed upstream and downstream of it, and of beds.
    """
    size = BASE / under
    left, right, bottom = -upstream * size, BASE + downstream * size, -beds * size
    mass = RockMass(
        regions=[
            Region(outline=[(left, bottom), (right, bottom), (right, 0), (left, 0)], rock="rock"),
            Region(
                outline=[(0, 0), (BASE, 0), (CREST, HEIGHT), (0, HEIGHT)],
                rock="concrete",
                border="contact",
                intact=True,
            ),
        ],
        joints=[
            JointSet(name="bedding", dip=0, spacing=size, start=(0, 0)),
            JointSet(name="cross", dip=-45, spacing=size / 2**0.5, start=(0, 0)),
        ],
        boundaries={
            "upstream": [(left, 0), (0, 0), (0, HEIGHT)],
            "downstream": [(BASE, 0), (right, 0)],
        },
    )
    write_blocks(cut_blocks(mass), path)
