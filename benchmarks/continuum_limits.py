"""Rigid blocks under gravity beside finite elements, and a large continuum: ``python -m benchmarks.continuum_limits``.

Slopes are those of the campaign's families, with gravity switched on from zero stress, where friction leaves the
equilibrium undetermined: the first ten seeds whose blocks come to rest, both equilibria checked. With ``--into PAGE``
both tables take the place of what stands between that page's marks.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families.slopes import draw_leaning, draw_slope
from benchmarks.continuum import marks, put
from bsm_mesh.converters.continuum import compare_stages, solve_continuum_stages
from bsm_mesh.results.records import ContactStatus
from tests.scenes.large import blocky_rock

SLOPES = 10
MOST_SEEDS = 100
LARGE, HALVINGS = 1000, 2  # Voronoi blocks, and how often their fans are halved: 1e5 triangles
ROCK = {"young": 20e9, "poisson": 0.2}
HEADER = ("seed", "family", "blocks", "joints that slip or are open", "balance checked", "what compare says")
COMMAND = "python -m benchmarks.continuum_limits"


def slope(seed: int) -> tuple[str, bsm.Model]:
    """Return a random slope of rigid blocks whose gravity is switched on at once, and its family."""
    family, draw = (("slope", draw_slope), ("leaning", draw_leaning))[seed % 2]
    scene = draw(np.random.default_rng(seed)).scene
    return family, dataclasses.replace(scene, k0=None).model()


def slope_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for each of the first slopes at rest that small displacements hold for."""
    found, skipped = 0, 0
    for seed in range(MOST_SEEDS):
        family, model = slope(seed)
        results = bsm.run(model)
        (stage,) = compare_stages(model, results, refine=False)
        print(f"slope {seed}: {stage.sentence}", file=sys.stderr, flush=True)
        compared = stage.comparison
        if compared is None and "finite elements" not in stage.reason:
            skipped += 1
            continue
        found += 1
        checked, shares = "blocks" if results.check().ok else "none", "-"
        if compared is not None:
            checked = "both" if results.check().ok and compared.nominal.converged else checked
            shares = " and ".join(f"{100 * share:.0f} %" for share in compared.slipping)
        yield str(seed), family, str(model.blocks.count), shares, checked, stage.sentence
        if found == SLOPES:
            break
    yield "", "", "", "", "", f"{skipped} seeds between them collapse, or move too far for small displacements"


def large_model() -> bsm.Model:
    """Return elastic Voronoi rock at depth, of which a stage excavates a circle."""
    model = blocky_rock(LARGE).model(0.5)
    return model.replace(rocks=[dataclasses.replace(rock, **ROCK) for rock in model.rocks])


def large_text() -> str:
    """Return what solving the large continuum took."""
    model = large_model()
    began = time.perf_counter()
    stages = solve_continuum_stages(model, order=1, joints=True, refinements=HALVINGS)
    seconds = time.perf_counter() - began
    last = stages[-1]
    slipping = (last.contacts.status != ContactStatus.STICKING).mean()
    return (
        f"An excavation in {model.blocks.count} Voronoi blocks at depth, every side halved {HALVINGS} times: "
        f"{len(last.cell_block)} triangles, {last.contacts.length.size // 2} interface faces, {last.unknowns} "
        f"unknowns, in-situ state and excavation, {100 * slipping:.2g} % of the points slipping or open at the end: "
        f"{seconds:.0f} s in all, one thread; "
        f"{'equilibrium in both stages' if all(stage.converged for stage in stages) else 'no equilibrium'}."
    )


def main() -> int:
    """Make both tables, and print them or put them into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--into", type=Path, metavar="PAGE", help="a page in Markdown: what stands between its marks")
    given = parser.parse_args()
    rows = [HEADER, tuple("---" for _ in HEADER), *slope_rows()]
    text = "\n".join(f"| {' | '.join(row)} |" for row in rows) + f"\n\n{large_text()}\n"
    if given.into:
        put(given.into, text, marks(COMMAND))
    else:
        print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
