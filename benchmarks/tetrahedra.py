"""Random rock masses, and the same of tetrahedra: are the verdicts the same? (``python -m benchmarks.tetrahedra``).

The rock masses are those of `benchmarks.rock_masses` with at most 150 blocks. Each cell is cut into tetrahedra, so
that blocks and joints stay as they are, and their faces are many triangles.
"""

from __future__ import annotations

import sys
from typing import Any

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from benchmarks.rock_masses import rock_mass
from examples.numbers.pages import markdown
from tests.scenes.tetrahedra import of_tetrahedra

MAKER = "python -m benchmarks.tetrahedra"
MOST = 150  # blocks
CELLS = ("as given", "tetrahedra")


def judged(seed: int) -> dict[str, Any]:
    """Return the kind of a rock mass, and the verdict and the unstable blocks with both kinds of cells."""
    model, _, found = rock_mass(seed)
    if found["blocks"] > MOST:
        return found | {"small": False}
    blocks = model.blocks
    assert isinstance(blocks, bsm.Polyhedra)
    for name, made in zip(CELLS, (blocks, of_tetrahedra(blocks)), strict=True):
        stage = bsm.run(model.replace(blocks=made), bsm.Options(threads=1)).stages[-1]
        found[name] = str(stage.status), stage.unstable_blocks.tolist()
    return found | {"small": True}


def table(records: list[dict[str, Any]]) -> str:
    """Return by kind how many masses end alike."""
    rows = []
    for kind in ("roof", "slope"):
        ends = [[r[name] for name in CELLS] for r in records if r["small"] and r["kind"] == kind]
        unstable = sum(given[0] == "unstable" for given, _ in ends)
        verdicts = sum(given[0] == made[0] for given, made in ends)
        rows.append((kind, *map(str, (len(ends), unstable, verdicts, sum(given == made for given, made in ends)))))
    return markdown(("kind", "masses", "unstable", "same verdict of tetrahedra", "same unstable blocks too"), rows)


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, 60, judged, table))
