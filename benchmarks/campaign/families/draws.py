"""Random numbers that several families share."""

from __future__ import annotations

import numpy as np


def blocks_wanted(generator: np.random.Generator, least: int, most: int) -> int:
    """Return a number of blocks: more often a small one."""
    return round(least * (most / least) ** (generator.random() ** 1.7))


def stiffness(generator: np.random.Generator) -> tuple[float, float]:
    """Return normal and shear stiffness [Pa/m]."""
    kn = 10 ** generator.uniform(8, 12)
    return float(kn), float(kn * generator.choice([1.0, 0.5, 0.1]))


def start_of(generator: np.random.Generator) -> float | None:
    """Return the ratio of in-situ stresses; None, as often: gravity is switched on."""
    ratio = float(generator.uniform(0.3, 1.6))
    return ratio if generator.random() < 0.5 else None


def near(generator: np.random.Generator, limit: float) -> float:
    """Return a number around a limit: half of them within 3 % of it."""
    return float(limit * (1 + generator.choice([-1.0, 1.0]) * 10 ** generator.uniform(-3, -0.5)))
