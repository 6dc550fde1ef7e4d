"""A slope is the same wherever it lies, in whatever unit, and to however many digits its file has the nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.limit_analysis import strength_limit
from tests.scenes.known_factors import arch, incline, tutorial_slope
from tests.scenes.slope_mesh import moved, slope_mesh, slope_model, with_coordinates

MAP = (512345.0, 4501234.0)  # easting and northing [m]
FOOT = 0.3048
SLOPES = [(35.0, 100.0, 20.0, 3.3), (40.0, 80.0, 15.0, 2.7), (30.0, 115.0, 25.0, 4.1), (25.0, 95.0, 12.0, 2.2)]
FILES: dict[str, tuple[dict[str, Any], float]] = {
    "map": ({"by": MAP}, 1.0),
    "mm": ({"scale": 1e3}, 1e-3),
    "mm, 1 decimal": ({"scale": 1e3, "decimals": 1}, 1e-3),
    "feet": ({"scale": 1 / FOOT}, FOOT),
    "feet, 4 decimals": ({"scale": 1 / FOOT, "decimals": 4}, FOOT),
    "feet on a map": ({"by": MAP, "scale": 1 / FOOT}, FOOT),
    **{f"{decimals} decimals": ({"decimals": decimals}, 1.0) for decimals in range(4, 10)},
    **{f"map, {decimals} decimals": ({"by": MAP, "decimals": decimals}, 1.0) for decimals in range(4, 8)},
}
SAME = 1e-5  # of the factor: half a unit of the fourth decimal turns a face of metres by as much


def model_of(path: Path, slope: tuple[float, float, float, float], name: str, blocks: str = "regions") -> bsm.Model:
    given, unit = ({}, 1.0) if name == "origin" else FILES[name]
    return slope_model(path, with_coordinates(slope_mesh(*slope), moved(**given)), unit=unit, blocks=blocks)


@pytest.mark.heavy
@pytest.mark.parametrize("slope", SLOPES)
def test_bound_of_the_factor(tmp_path: Path, slope: tuple[float, float, float, float]) -> None:
    """The same blocks, contacts and factor, and a proof of it: of half of these files it was spoilt by rounding."""
    first = model_of(tmp_path / "a.msh", slope, "origin")
    expected = strength_limit(first)
    assert expected.proof.witness is not None
    for name in FILES:
        model = model_of(tmp_path / "a.msh", slope, name)
        found = strength_limit(model)
        assert len(model.blocks.vertices) == len(first.blocks.vertices), name
        assert found.contacts.count == expected.contacts.count, name
        assert found.factor == pytest.approx(expected.factor, rel=SAME), name
        assert found.beyond == pytest.approx(expected.beyond, rel=SAME), name


@pytest.mark.slow
@pytest.mark.parametrize("slope", SLOPES[:2])
def test_bound_where_every_element_is_a_block(tmp_path: Path, slope: tuple[float, float, float, float]) -> None:
    expected = strength_limit(model_of(tmp_path / "a.msh", slope, "origin", "elements"))
    for name in ("map", "feet on a map", "4 decimals", "6 decimals", "8 decimals", "map, 4 decimals"):
        found = strength_limit(model_of(tmp_path / "a.msh", slope, name, "elements"))
        assert found.beyond == pytest.approx(expected.beyond, rel=SAME), name


@pytest.mark.parametrize("build", [incline, tutorial_slope, arch], ids=lambda build: build.__name__)
def test_bound_of_blocks_on_a_map(build: Callable[..., bsm.Model]) -> None:
    """Of blocks without a mesh."""
    given = {"incline": (40.0, 30.0), "tutorial_slope": (20.0,), "arch": (0.12, 20, 35.0)}[build.__name__]
    model = build(*given)
    expected = strength_limit(model)
    there = replace(model.blocks, vertices=model.blocks.vertices + MAP)
    found = strength_limit(model.replace(blocks=there))
    assert found.factor == pytest.approx(expected.factor, rel=SAME)
    assert found.beyond == pytest.approx(expected.beyond, rel=SAME)


@pytest.mark.slow
def test_factor_of_safety(tmp_path: Path) -> None:
    """In map coordinates, and rounded to 8 digits, it was a tenth more: another criterion decided."""
    slope = SLOPES[0]
    expected = bsm.factor_of_safety(model_of(tmp_path / "a.msh", slope, "origin"))
    assert expected.is_closed
    for name in ("map", "8 decimals", "map, 4 decimals", "feet"):
        found = bsm.factor_of_safety(model_of(tmp_path / "a.msh", slope, name))
        assert found.stable == pytest.approx(expected.stable, rel=SAME), name
        assert found.unstable == pytest.approx(expected.unstable, rel=SAME), name
