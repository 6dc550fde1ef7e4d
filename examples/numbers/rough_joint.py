"""Numbers of examples/rough_joint: the factor of safety by formula and as it is found, of each way to give strength."""

from __future__ import annotations

import math
from pathlib import Path

import bsm_mesh as bsm
from examples.numbers.pages import Table, markdown

PAGE = "examples/rough_joint/README.md"
FOLDER = Path(__file__).parents[1] / "rough_joint"
FILES = {
    "model.toml": "Barton-Bandis",
    "mohr_coulomb.toml": "a line through it at 0.5 and 2 MPa",
    "without_cohesion.toml": "that line without its cohesion",
}
DIP, STRESS = math.radians(40.0), 26e3 * 4.0 * math.cos(math.radians(40.0))


def barton(stress: float) -> float:
    """Return the strength [Pa] of the joint at a stress [Pa]."""
    roughness, wall = 10 * 20 ** (-0.02 * 10), 80e6 * 20 ** (-0.03 * 10)
    return stress * math.tan(math.radians(28 + roughness * math.log10(wall / stress)))


def line() -> tuple[float, float]:
    """Return cohesion [Pa] and tan(friction) of the line."""
    slope = (barton(2e6) - barton(0.5e6)) / 1.5e6
    return barton(0.5e6) - 0.5e6 * slope, slope


def factors() -> str:
    """Return the table of the example."""
    cohesion, slope = line()
    strengths = (barton(STRESS), cohesion + slope * STRESS, slope * STRESS)
    rows = []
    for (name, words), strength in zip(FILES.items(), strengths, strict=True):
        model = bsm.load(FOLDER / name)
        found = bsm.factor_of_safety(model)
        status = bsm.run(model, model.options).status
        exact = strength / (STRESS * math.tan(DIP))
        rows.append((name, words, f"{exact:.3f}", f"{found.stable:.3f} to {found.unstable:.3f}", str(status)))
    return markdown(("file", "strength of the joint", "factor by formula", "found between", "verdict"), rows)


def tested() -> str:
    """Return the line that a laboratory puts through its tests."""
    cohesion, slope = line()
    return f"""The line: {cohesion / 1e3:.0f} kPa and {math.degrees(math.atan(slope)):.1f}°. On the slope the stress is
{STRESS / 1e3:.0f} kPa. What does the line say there?"""


TABLES: tuple[Table, ...] = (
    Table(name="rough-joint-line", page=PAGE, make=tested),
    Table(name="rough-joint", page=PAGE, make=factors, tolerance=0.01),
)
