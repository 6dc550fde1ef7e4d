"""Models of the examples, their runs and what statics says of them, each once."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

import bsm_mesh as bsm

EXAMPLES = Path(__file__).parents[1]


@cache
def load(name: str) -> bsm.Model:
    """Return the model of a file of the examples, by its path without suffix."""
    return bsm.load(EXAMPLES / f"{name}.toml")


@cache
def run(name: str) -> bsm.Results:
    """Return its results."""
    return bsm.run(load(name))


@cache
def statics(name: str) -> bsm.LimitAnalysis:
    """Return what limit analysis says of it as it is given."""
    return bsm.limit_analysis(load(name))


def admits(name: str) -> str:
    """Return that in a word."""
    return "admissible" if statics(name).admissible else "inadmissible"


def proves(name: str, what: str = "must move") -> str:
    """Return what that proves: `what` where no forces within strength balance the loads, else nothing."""
    return "nothing" if statics(name).admissible else what


def verdict(results: bsm.Results) -> str:
    """Return the verdict."""
    return results.status.value


def moved(results: bsm.Results, blocks: list[int] | None = None) -> np.ndarray:
    """Return how far centroids moved at the end, (k,) [m]."""
    distance = np.hypot(*results.stages[-1].displacement[:, :2].T)
    return distance if blocks is None else distance[blocks]


def millimetres(value: float, digits: int = 2) -> str:
    """Return a length [m] in mm, to two digits that count and at least that many decimals where it is small."""
    return f"{1e3 * value:.{digits}f} mm"
