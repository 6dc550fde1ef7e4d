"""Zones and closed forms, and the cost of zones: ``python -m benchmarks.zones --into docs/verification_zones.md``."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.continuum import ROOT
from benchmarks.pages import add_into, processor, tell
from examples.numbers.pages import markdown
from tests.scenes import zones as scenes
from tests.scenes.hoek_brown_hole import HoekBrownHole
from tests.scenes.plastic_zones import Hole, footing

COMMAND = "python -m benchmarks.zones"
HEADER = ("case", "closed form", "first order", "second order")
COST_HEADER = ("blocks of the staged tunnel (756)", "zones", "processor time, s", "greatest displacement, mm")


def closed_forms() -> list[tuple[str, ...]]:
    """Return the lines of the table of closed forms."""
    stiffness = [f"{value:.4f}" for value in scenes.crack_exact()]
    discs = [scenes.disc(order, 0.08) for order in (1, 2)]
    cracks = [[f"{value:.4f}" for value in scenes.crack(order)] for order in (1, 2)]

    def both(case: str, exact: str, find: Callable[[int], float], form: str = "{:.6g}") -> tuple[str, ...]:
        return (case, exact, *(form.format(find(order)) for order in (1, 2)))

    return [
        both("modulus of jointed rock, GPa", "14.2857", scenes.modulus),
        both("shear modulus of jointed rock, GPa", "6.66667", scenes.shear_modulus),
        both("horizontal over vertical stress between rigid sides", ".111111", scenes.stress_ratio),
        ("slipping crack: loading, unloading, slip back, GN/m", ", ".join(stiffness), *(", ".join(c) for c in cracks)),
        both("hole in a plate (Kirsch), 496 quads: error of block means", "0", scenes.kirsch_error, "{:.2%}"),
        *(
            both(
                f"cantilever of 4 by 1 m, zones of {size:g} m: deflection over beam theory",
                "1",
                lambda order, size=size: scenes.cantilever(order, size),
                "{:.3f}",
            )
            for size in (1.0, 0.5, 0.25)
        ),
        ("Brazilian disc: tension in the middle over 2P/(pi D)", "1", *(f"{found[0]:.3f}" for found in discs)),
        ("Brazilian disc: compression there over 6P/(pi D)", "1", *(f"{found[1]:.3f}" for found in discs)),
    ]


PLASTIC_HEADER = ("rock that yields, zones of second order", "closed form", "found")
PARTS = (0.7, 0.9, 0.95, 0.97, 0.98, 0.99, 1.0, 1.005, 1.01, 1.02)  # of (2 + pi) c


def plastic() -> list[tuple[str, ...]]:
    """Return the lines of the table of rock that yields."""
    lines, hole = [], Hole()
    for rings, sectors in ((20, 12), (40, 24)):
        stress, radius, by_area = hole.errors(bsm.run(hole.model(rings, sectors)).stages[-1].zones)
        name = f"Salencon's hole, {2 * rings * sectors} zones"
        lines += [
            (f"{name}: error of stresses", "0", f"{stress:.2%}"),
            (f"{name}: plastic radius by the stress outside, m", f"{hole.radius:.4f}", _grown(hole, radius)),
            (f"{name}: plastic radius by the area that yielded, m", f"{hole.radius:.4f}", _grown(hole, by_area)),
        ]
    rock = HoekBrownHole()
    for rings, sectors in ((20, 12), (30, 24)):
        zones = bsm.run(rock.model(rings, sectors, dilation=10.0)).stages[-1].zones
        stress, radius, _ = rock.errors(zones)
        name = f"hole in Hoek-Brown rock, {2 * rings * sectors} zones"
        lines += [
            (f"{name}: error of stresses", "0", f"{stress:.2%}"),
            (f"{name}: plastic radius by the stress outside, m", f"{rock.radius:.4f}", _grown(rock, radius)),
            (
                f"{name}: convergence of the wall, mm",
                f"{1e3 * rock.convergence(10.0):.3f}",
                f"{1e3 * rock.wall(zones):.3f}",
            ),
        ]
    for size in (0.2, 0.1):
        stages = bsm.run(footing(PARTS, size=size)).stages
        carried, most = (PARTS[len(stages) - k] for k in (2, 1))
        name = f"strip footing on clay, zones of {size:g} m at its edge: load over (2 + pi) c"
        lines.append((name, "1", f"{carried:g} carried, {most:g} not"))
    return lines


def _grown(hole: Hole, error: float) -> str:
    return f"{hole.radius * (1 + error):.4f}"


def costs() -> list[tuple[str, ...]]:
    """Return the lines of the table of costs."""
    model = bsm.load(ROOT / "examples/staged_tunnel/model.toml")
    given = {"rigid": None, "zones = { order = 1 }": bsm.Zones(order=1), "zones = {}": bsm.Zones()}
    given['zones = { size = "1 m" }'] = bsm.Zones(size=1.0)
    lines = []
    for name, zones in given.items():
        elastic = {} if zones is None else {"young": 20e9, "poisson": 0.25, "zones": zones}
        other = model.replace(rocks=[replace(rock, **elastic) for rock in model.rocks])
        bsm.run(other)
        began = time.process_time()
        last = bsm.run(other).stages[-1]
        count = "none" if last.zones is None else str(len(last.zones.cells))
        lines.append((f"`{name}`", count, f"{time.process_time() - began:.2g}", f"{1e3 * last.max_displacement:.4g}"))
    return lines


LIMIT_HEADER = ("difference from rigid blocks", "E = 1e13 Pa", "E = 1e14 Pa")
STAGES = {"toppling_column": (0,), "staged_tunnel": (1, 2, 3)}


def rigid_limit() -> list[tuple[str, ...]]:
    """Return the lines of the table of zones in rock that is nearly rigid: difference of displacements."""
    lines = []
    for folder, stages in STAGES.items():
        model = bsm.load(ROOT / "examples" / folder / "model.toml")
        rigid = bsm.run(model).stages
        found = []
        for young in (1e13, 1e14):
            stiff = [replace(rock, young=young, poisson=0.0, zones=bsm.Zones(order=1)) for rock in model.rocks]
            found.append(bsm.run(model.replace(rocks=stiff)).stages)
        for number in stages:
            exact = rigid[number].displacement[:, :2]
            off = [np.linalg.norm(ends[number].displacement[:, :2] - exact) / np.linalg.norm(exact) for ends in found]
            lines.append((f"`{folder}`, {rigid[number].name}", *(f"{error:.3%}" for error in off)))
    return lines


RATIO_HEADER = ("time, processor", "s", "over the other")


def ratios() -> list[tuple[str, ...]]:
    """Return the lines of the table that compares times: with rigid blocks, and with scikit-fem."""
    rigid = _time(lambda: bsm.run(scenes.stack(None)))
    lines = [("300 blocks, rigid, to rest", f"{rigid:.2g}", "1")]
    for order in (1, 2):
        zoned = _time(lambda order=order: bsm.run(scenes.stack(bsm.Zones(size=0.6, order=order))))
        lines.append((f"300 blocks of 16 zones of order {order}, to rest", f"{zoned:.2g}", f"{zoned / rigid:.3g}"))
    model = scenes.slab(0.0068)
    zones = bsm.run(model).stages[0].zones
    assert zones is not None
    ours, theirs = _time(lambda: bsm.run(model)), _time(lambda: scenes.slab_by_skfem(zones))
    lines.append((f"{len(zones.cells)} zones, first order, by scikit-fem alone: one solution", f"{theirs:.2g}", "1"))
    lines.append(("the same, to rest: one factorization, forces, results", f"{ours:.2g}", f"{ours / theirs:.3g}"))
    return lines


def _time(run: Callable[[], object]) -> float:
    """Return the least processor time [s] of three runs, after one."""
    run()
    spent = []
    for _ in range(3):
        began = time.process_time()
        run()
        spent.append(time.process_time() - began)
    return min(spent)


def main() -> int:
    """Solve the cases, and print the tables or put them into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    said = f"The rock of the tunnel has E = 20 GPa and nu = .25 where it has zones. Measured on {processor()}."
    yields = markdown(PLASTIC_HEADER, plastic())
    tables = (
        markdown(HEADER, closed_forms()),
        yields,
        markdown(LIMIT_HEADER, rigid_limit()),
        said,
        markdown(COST_HEADER, costs()),
    )
    text = "\n\n".join((*tables, markdown(RATIO_HEADER, ratios())))
    tell(text, COMMAND, given.into)
    return 0


if __name__ == "__main__":
    sys.exit(main())
