"""What each kind of damping does to a rocking block, and to the energies of a wall that is shaken."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.results.shaking import ENERGIES
from examples.numbers.pages import Table, markdown
from tests.scenes.shaken import QUIET, quake, rocking, wall

DAMPINGS = (0.0, 0.2, "housner")
SLENDERNESS, TILT, STIFFNESS = (2, 4, 8), 0.5, 4e9  # height over width; of the angle at which it stands on edge; Pa/m
SWINGS = 2
OF_A_WALL: dict[str, dict[str, object]] = {
    "none": {},
    "`contact_damping = 0.2`": {"contact_damping": 0.2},
    '`contact_damping = "housner"`': {"contact_damping": "housner"},
    "`mass_damping = { ratio = 0.02, frequency = 2 }`": {"mass_damping": (0.02, 2.0)},
}


def swings_of(slenderness: float, damping: float | str, stiffness: float = STIFFNESS) -> list[float]:
    """Return the first swings after impacts of a block 2 m high, over the angle at which it stands on edge."""
    half_width = 1.0 / slenderness
    angle = np.arctan2(half_width, 1.0)
    shaking = bsm.Shaking(**QUIET, cycles=2.6, every=2e-3, contact_damping=damping)
    time, turn, _ = rocking(half_width, 1.0, TILT * angle, shaking, kn=stiffness)
    through = time[np.flatnonzero(np.sign(turn[1:]) != np.sign(turn[:-1]))]
    impacts = through[np.insert(np.diff(through) > 0.1, 0, True)]
    return [float(np.abs(turn[(time > a) & (time < c)]).max() / angle) for a, c in pairwise(impacts[: SWINGS + 1])]


def swings_of_housner(slenderness: float) -> list[float]:
    """Return the same by Housner (1963): the rate of turn after an impact is 1 - 3/2 sin^2 a of that before."""
    kept = (1 - 1.5 * np.sin(np.arctan2(1.0, slenderness)) ** 2) ** (2 * np.arange(1, SWINGS + 1))
    swings: list[float] = (1 - np.sqrt(1 - kept * (1 - (1 - TILT) ** 2))).tolist()
    return swings


def rocking_by_damping() -> str:
    """Return a row for every slenderness: swings by damping, and those of Housner."""
    rows = []
    for slenderness in SLENDERNESS:
        found = [swings_of(slenderness, damping) for damping in DAMPINGS] + [swings_of_housner(slenderness)]
        rows += [
            (str(slenderness), str(k + 1), *("-" if len(one) <= k else f"{one[k]:.4f}" for one in found))
            for k in range(SWINGS)
        ]
    names = [f"`{damping}`" if isinstance(damping, float) else f'`"{damping}"`' for damping in DAMPINGS]
    return markdown(("height over width", "swing", *names, "Housner (1963)"), rows)


def energies_by_damping() -> str:
    """Return a row for every damping: energies of a wall after a record of 0.3 g, greatest and left movement."""
    shaking = bsm.Shaking(record=quake(3.0, 5.0), every=0.05)
    rows = []
    for name, given in OF_A_WALL.items():
        stage = bsm.run(wall(replace(shaking, **given), courses=8, bricks=2)).stages[-1]
        found = stage.shaking
        assert found is not None
        energy = dict(zip(ENERGIES, found.energy[-1].tolist(), strict=True))
        taken = [f"{energy[part]:.0f}" for part in ("input", "slip", "dashpots", "mass_damping")]
        moved = f"{1000 * stage.max_stage_displacement:.2f}"
        rows.append((name, *taken, f"{100 * found.imbalance:.1g}", f"{found.peak_velocity.max():.3f}", moved))
    header = (
        "damping",
        "input, J/m",
        "slip",
        "dashpots",
        "mass damping",
        "error, %",
        "greatest velocity, m/s",
        "left, mm",
    )
    return markdown(header, rows)


TABLES = (
    Table(name="rocking", page="docs/earthquakes.md", make=rocking_by_damping, is_slow=True),
    Table(name="damped", page="docs/earthquakes.md", make=energies_by_damping, tolerance=0.15),
)
