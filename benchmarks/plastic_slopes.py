"""When zones call a collapse, over random slopes: ``python -m benchmarks.plastic_slopes``.

Slopes without joints, of all kinds of strength and stiffness. Each is brought to its limit by dividing the strength.
Beyond it a collapse is wanted. Below it, in states that Newton's method has not finished, none may be called.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.tables import as_markdown
from benchmarks.pages import add_into, tell
from bsm_mesh.model.strength import with_strength
from bsm_mesh.solve.zones import newton
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.equilibrium import Equations
from bsm_mesh.solve.zones.newton import find_equilibrium
from bsm_mesh.solve.zones.plastic_collapse import distance_left, plastic_collapse
from bsm_mesh.solve.zones.scheme import zoned
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.stage_solution import RUNAWAY
from tests.scenes.plastic_zones import slope

MAKER = "python -m benchmarks.plastic_slopes"
TOLERANCE = 1.02  # of the factor at the limit
BEYOND = 1.1
CORRECTIONS = (0, 1, 2, 3, 4, 6, 8, 12, 20)  # of Newton's method, after which a state below the limit is asked


@dataclass
class Count:
    """States that were asked, and those called a collapse.

    Attributes
    ----------
    asked, called, at_rest : int
        All states; those called a collapse; of these the ones that come to rest within a block's size.
    nearest : float
        Greatest bound over the true displacement.
    """

    asked: int = 0
    called: int = 0
    at_rest: int = 0
    nearest: float = 0.0


def drawn(generator: np.random.Generator) -> bsm.Model:
    """Return a random slope 10 m high, of rock that yields."""
    friction, cohesion = float(generator.uniform(0, 40)), float(10 * 20e3 * generator.uniform(0.02, 0.25))
    part, tension = float(generator.choice([0.0, 0.5, 1.0])), float(generator.choice([1.0, 0.0, 0.3]))
    model = slope(
        friction=friction,
        cohesion=cohesion,
        run=float(generator.uniform(0.3, 2.5)),
        young=float(10 ** generator.uniform(7, 10)),
        dilation=part * friction * (1 - 1e-12),
        size=2.5,
        order=int(generator.choice([1, 2])),
    )
    (soil,) = model.rocks
    cut_off = 1e7 if tension == 1.0 else tension * cohesion
    return model.replace(rocks=[replace(soil, unit_weight=20e3, tensile_strength=cut_off)])


def equations_of(model: bsm.Model, factor: float) -> Equations:
    """Return the equations of the first stage of a slope, its strength divided by a factor."""
    weaker = with_strength(model, {"rock:soil": 1 / factor})
    continuum = zoned(weaker, bsm.Options())
    run = StageRun(continuum, nominal_constants(weaker).stiffness[continuum.mesh.block])
    there = np.ones(weaker.blocks.count, dtype=bool)
    return run.equations(there, run.loads_on(there))


def limit(model: bsm.Model) -> tuple[float, float] | None:
    """Return the greatest factor with an equilibrium and the least without one; None beyond 0.01 to 100."""
    low = high = None
    factor = 1.0
    while low is None or high is None or high / low > TOLERANCE:
        if not 0.01 < factor < 100:
            return None
        equations = equations_of(model, factor)
        if find_equilibrium(equations, np.zeros(len(equations.load)))[1]:
            low, factor = factor, factor * 1.5 if high is None else float(np.sqrt(factor * high))
        else:
            high, factor = factor, factor / 1.5 if low is None else float(np.sqrt(low * factor))
    return low, high


def ask_beyond(model: bsm.Model, factor: float, count: Count) -> None:
    """Count whether a collapse is called at a factor without equilibrium."""
    equations = equations_of(model, factor)
    start = np.zeros(len(equations.load))
    at, found = find_equilibrium(equations, start)
    if not found:
        count.asked += 1
        count.called += plastic_collapse(equations, at, start) is not None


def ask_below(model: bsm.Model, factor: float, count: Count) -> None:
    """Count whether a collapse is called in unfinished states at a factor with an equilibrium."""
    equations = equations_of(model, factor)
    start = np.zeros(len(equations.load))
    moved = float(np.abs(find_equilibrium(equations, start)[0].u).max())
    for corrections in CORRECTIONS:
        with patch.object(newton, "MAX_ITERATIONS", corrections):
            at, found = find_equilibrium(equations, start)
        if found:
            return
        called = plastic_collapse(equations, at, start) is not None
        count.asked += 1
        count.called += called
        count.at_rest += called and moved < RUNAWAY * equations.size
        count.nearest = max(count.nearest, distance_left(equations, at, start) / moved)


def table(models: int, seed: int = 0) -> str:
    """Return the table over so many random slopes, in Markdown, and a line on the bound."""
    generator = np.random.default_rng(seed)
    near, beyond, below = Count(), Count(), Count()
    for number in range(models):
        model = drawn(generator)
        bracket = limit(model)
        if bracket is None:
            continue
        ask_beyond(model, bracket[1], near)
        ask_beyond(model, BEYOND * bracket[1], beyond)
        ask_below(model, bracket[0], below)
        print(f"slope {number}: {near}, {beyond}, {below}", file=sys.stderr, flush=True)
    rows = [
        ["state", "number", "called a collapse"],
        [f"strength up to {100 * (TOLERANCE - 1):.0f} % below the last equilibrium", str(near.asked), str(near.called)],
        [f"{100 * (BEYOND - 1):.0f} % below that", str(beyond.asked), str(beyond.called)],
        ["strength of the last equilibrium, before Newton's method is at its end", str(below.asked), str(below.called)],
    ]
    return (
        f"{as_markdown(rows)}\n\nOf those called a collapse in the last row {below.at_rest} reach rest within a "
        "block's size. "
        f"The bound of the states there is at most {below.nearest:.2g} of the true displacement."
    )


def main() -> int:
    """Print the table, or write it into a page."""
    parser = argparse.ArgumentParser(prog=MAKER, description=__doc__.partition("\n")[0])
    parser.add_argument("--models", type=int, default=48, help="how many slopes (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    add_into(parser, MAKER)
    given = parser.parse_args()
    tell(table(given.models, given.seed), MAKER, given.into)
    return 0


if __name__ == "__main__":
    sys.exit(main())
