"""Blocks that touch others along an edge alone, once their neighbours are gone (``python -m benchmarks.edges``).

In space the loose blocks have a random share of the depth, and a random direction. How deep blocks overlap at the end
is measured in the plane of the scene.
"""

from __future__ import annotations

import sys
from collections import Counter
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from examples.numbers.pages import markdown
from tests.scenes.blocks_about_an_edge import BlocksAboutAnEdge

MAKER = "python -m benchmarks.edges"
MODELS = 60
DEEP = 5e-3  # m: more is no elastic penetration, nor what a first contact begins with


def run(seed: int) -> dict[str, Any]:
    """Return verdicts of a scene in the plane, as a slice of the whole depth, and narrower and turned."""
    scene = BlocksAboutAnEdge.drawn(seed)
    generator = np.random.default_rng([seed, MODELS])
    width, aside, direction = generator.uniform((0.3, 0, 0), (1, 1, 360)).tolist()
    narrower = scene.in_space(width=width, aside=aside, direction=direction)
    found: dict[str, Any] = {"seed": seed}
    models = {"plane": scene.model(), "slice": scene.in_space(), "turned": narrower}
    for name, model in models.items():
        stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
        found[name] = str(stage.status)
        depth = scene.depth(stage.displacement, direction if name == "turned" else 0.0)
        found[f"{name} moved"], found[f"{name} depth"] = stage.displacement.round(3).tolist(), round(depth, 4)
    return found


def table(rows: list[dict[str, Any]]) -> str:
    """Return how verdicts in space differ from those in the plane, and how many blocks went through others."""
    made = []
    for where in ("plane", "slice", "turned"):
        pairs = Counter((row["plane"], row[where]) for row in rows)
        others = sum(count for (plane, own), count in pairs.items() if plane != own)
        counts = [sum(n for (_, own), n in pairs.items() if own == s) for s in ("unstable", "stable", "not_converged")]
        through = sum(row[f"{where} depth"] > DEEP for row in rows)
        name = {"plane": "plane", "slice": "space, whole depth", "turned": "space, part of the depth, turned"}[where]
        made.append((name, *map(str, counts), str(others), str(through)))
    header = ("where", "unstable", "stable", "not converged", "not as in the plane", "overlap by more than 5 mm")
    return markdown(header, made)


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, MODELS, run, table))
