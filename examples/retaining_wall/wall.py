"""A gravity wall of stone courses on rock: `bsm-mesh run model.toml` builds its mesh from here."""

import itertools
from pathlib import Path

from bsm_mesh.geometries.quadrilaterals import rectangle, sides_of, write_quadrilaterals

HEIGHT, FOOT, CREST = 5.0, 2.0, 1.0  # m; the back leans so that backfill lies above it


def build(path: str | Path, courses: int = 5) -> None:
    """Write the mesh to `path`: block 0 is the rock, the courses follow upwards; boundaries `bottom` and `back`."""

    def back(y: float) -> float:
        return FOOT + (CREST - FOOT) * y / HEIGHT

    levels = [HEIGHT * k / courses for k in range(courses + 1)]
    wall = [[(0.0, low), (back(low), low), (back(top), top), (0.0, top)] for low, top in itertools.pairwise(levels)]
    blocks = [rectangle(-3.0, -1.0, 5.0, 0.0), *wall]
    every = range(len(blocks))
    write_quadrilaterals(
        path,
        blocks,
        ["granite"],
        joints={"bed": sides_of(every, (0, 2))},
        boundaries={"bottom": [(0, 0)], "back": [(k, 1) for k in every[1:]]},
        name="retaining_wall",
    )
