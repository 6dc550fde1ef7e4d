"""Networks by density and length: P21, lengths, directions, bridges of random length."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

from bsm_mesh.geometries import (
    Exponential,
    GeometryError,
    JointSet,
    Lognormal,
    PowerLaw,
    Region,
    RockMass,
    cut_blocks,
    rectangle,
)

LOW, HIGH = np.array([0.0, 0.0]), np.array([40.0, 25.0])
SEEDS = 40


def density(joints: JointSet, seed: int) -> float:
    """Return the length of the joints in the box over its area, P21 [m/m^2]."""
    traces = shapely.linestrings(joints.traces(LOW, HIGH, seed))
    return float(shapely.length(shapely.intersection(traces, shapely.box(*LOW, *HIGH))).sum()) / np.prod(HIGH - LOW)


@pytest.mark.parametrize(
    "others",
    [
        {"length": 3.0},
        {"length": Exponential(2.0), "scatter": 15.0},
        {"length": Lognormal(5.0, 4.0)},
        {"length": PowerLaw(2.5, 1.0, 60.0)},
        {},
        pytest.param({"persistence": 0.6, "bridge": Exponential(1.0)}, marks=pytest.mark.heavy),
        {"persistence": 0.6, "bridge": 1.0},
    ],
)
def test_the_density_is_that_which_is_asked_for(others: dict[str, Any]) -> None:
    """Baecher networks of any length, Poisson lines, Veneziano's: the mean over models within four standard errors."""
    joints = JointSet(name="J", dip=35, density=0.8, **others)
    found = np.array([density(joints, seed) for seed in range(SEEDS)])
    assert abs(found.mean() - 0.8) < 4 * found.std(ddof=1) / SEEDS**0.5 + 1e-3
    assert found.std() > 0


def test_lengths_and_directions_of_a_network() -> None:
    joints = JointSet(name="J", dip=120, density=3.0, length=Lognormal(2.0, 1.0), scatter=5)
    vectors = np.diff(joints.traces(LOW, HIGH, 3), axis=1)[:, 0]
    lengths = np.hypot(*vectors.T)
    error = 1.0 / len(lengths) ** 0.5
    assert abs(lengths.mean() - 2.0) < 4 * error
    assert lengths.std() == pytest.approx(1.0, rel=0.1)
    angle = np.degrees(np.arctan2(*vectors[:, ::-1].T)) % 180
    assert abs(angle.mean() - 120) < 4 * 5 * error
    assert angle.std() == pytest.approx(5, rel=0.1)


def test_power_law_lengths() -> None:
    law = PowerLaw(2.5, 1.0, 100.0)
    drawn = law.draw(200_000, np.random.default_rng(5))
    assert (drawn.min() >= 1, drawn.max() <= 100) == (True, True)
    assert drawn.mean() == pytest.approx(law.mean, rel=0.02)
    assert law.mean == pytest.approx(3 * (1 - 0.1) / (1 - 1e-3))  # (a - 1) / (a - 2) ... of the cut law
    assert PowerLaw(2.0, 1.0, np.e).mean == pytest.approx(1 / (1 - 1 / np.e))


def test_jointed_and_intact_lengths_of_random_bridges() -> None:
    joints = JointSet(name="J", dip=0, spacing=0.5, persistence=0.7, bridge=Exponential(0.9))
    traces = joints.traces(LOW, HIGH, 1)
    lengths = traces[:, 1, 0] - traces[:, 0, 0]
    assert lengths.mean() == pytest.approx(0.9 * 0.7 / 0.3, rel=0.05)
    assert lengths.std() == pytest.approx(lengths.mean(), rel=0.05)  # exponential


def test_blocks_of_a_network() -> None:
    """A network as dense as 4 m/m^2 of long traces cuts blocks; the same seed gives the same ones."""
    sets = [JointSet(name=f"J{dip}", dip=dip, density=2.0, length=Exponential(6.0)) for dip in (20, 100)]
    mass = RockMass(regions=[Region(outline=rectangle(0, 0, 8, 8), rock="gneiss")], joints=sets, seed=4)
    cut = cut_blocks(mass)
    assert cut.count > 50
    assert cut_blocks(mass).count == cut.count


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({}, "give one of spacing"),
        ({"spacing": 1, "density": 1}, "give one of spacing"),
        ({"spacing": 1, "length": 2}, "length belongs to density"),
        ({"density": 0}, "density = 0 is not a positive number; give density in m/m"),
        ({"density": 1, "length": -1}, "length = -1 is not a positive number"),
        ({"density": 1, "persistence": 0.5}, "persistence = 0.5 needs a bridge"),
    ],
)
def test_what_does_not_go_together(given: dict[str, Any], says: str) -> None:
    with pytest.raises(GeometryError, match=says):
        JointSet(name="J", dip=0, **given)


def test_too_many_traces_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"density = 1e\+06 m/m\^2 gives .* traces; give a lower density"):
        JointSet(name="J", dip=0, density=1e6, length=0.1).traces(LOW, HIGH, 0)
    with pytest.raises(GeometryError, match="exponent = 1 must be above 1"):
        PowerLaw(1, 1, 2)
