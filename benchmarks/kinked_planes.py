"""Slabs that slide over a kink, where two blocks of ground meet (``python -m benchmarks.kinked_planes``).

The plane is steeper than the friction above the kink and below it, so no slab comes to rest. In half of the scenes the
ground rests on a third block and settles, the two sides of the kink by different amounts.
"""

from __future__ import annotations

import sys
from collections import Counter
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from examples.numbers.pages import markdown
from tests.scenes.kinked_plane import KinkedPlane

MAKER = "python -m benchmarks.kinked_planes"
MODELS = 60
FACES = {"joint on all faces": False, "outer faces without a joint": True}


def run(seed: int) -> dict[str, Any]:
    """Return the verdicts of a scene, in the plane and in space, with joints on all faces and not on outer ones."""
    generator = np.random.default_rng([seed, MODELS])
    width, aside, direction = generator.uniform((0.3, 0, 0), (1, 1, 360)).tolist()
    found: dict[str, Any] = {"seed": seed}
    for faces, bare in FACES.items():
        scene = KinkedPlane.drawn(seed, loose=bool(seed % 2), bare=bare)
        found["plane", faces] = str(bsm.run(scene.model()).status)
        found["space", faces] = str(bsm.run(scene.in_space(width=width, aside=aside, direction=direction)).status)
    return found


def table(rows: list[dict[str, Any]]) -> str:
    """Return how many slabs slide, and how many rest."""
    made = []
    for where in ("plane", "space"):
        for faces in FACES:
            for ground, odd in (("held", 0), ("on a block", 1)):
                found = Counter(row[where, faces] for row in rows if row["seed"] % 2 == odd)
                numbers = (str(found[status]) for status in ("unstable", "stable", "not_converged"))
                made.append((where, faces, ground, *numbers))
    return markdown(("where", "faces", "ground", "slides", "rests", "not converged"), made)


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, MODELS, run, table))
