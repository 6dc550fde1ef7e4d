"""The tunnel through joint sets, from the command line and in Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bsm_mesh.converters import read_mesh
from bsm_mesh.geometries import GeometryError, circle, find_case, horseshoe
from bsm_mesh.geometries.jointed_tunnel import build
from tests.scenes.small_case import Case

AREAS = {
    "circle": 48 / 2 * 9 * np.sin(2 * np.pi / 48),
    "horseshoe": 6 * 3 + 48 / 4 * 9 * np.sin(2 * np.pi / 48),
    "box": 36.0,
    "none": 0.0,
}


@pytest.mark.parametrize("shape", AREAS)
@pytest.mark.parametrize("engine", ["shapely", "gmsh"])
def test_every_shape(tmp_path: Path, shape: str, engine: str) -> None:
    path = find_case("jointed_tunnel").build(tmp_path / "t.msh", shape=shape, engine=engine)
    blocks, report = read_mesh(path, blocks="regions")
    assert blocks.moments.area.sum() == pytest.approx(900 - AREAS[shape], rel=1e-12)
    assert report.notes == ()
    assert ("tunnel" in blocks.boundaries) == (shape != "none")


@pytest.mark.heavy
def test_meshed_to_a_size(tmp_path: Path) -> None:
    fine, _ = read_mesh(build(tmp_path / "a.msh", size=0.8))
    coarse, _ = read_mesh(build(tmp_path / "b.msh"), blocks="regions")
    assert fine.count > 5 * coarse.count
    assert fine.moments.area.sum() == pytest.approx(coarse.moments.area.sum())


def test_from_the_command_line(case: Case) -> None:
    outcome = case.run("mesh", "jointed_tunnel", "--set", "dips=[0, 90]", "--set", "spacings=[3, 3]", "-o", "t.msh")
    assert outcome.new == ["t.msh"]
    assert "joint:J2" in outcome.out


def test_faults_are_collected(tmp_path: Path) -> None:
    with pytest.raises(GeometryError) as caught:
        build(tmp_path / "a.msh", shape="egg", span=-1, dips=[1], lenght=3)  # type: ignore[arg-type]
    assert len(caught.value.faults) == 4
    assert not list(tmp_path.iterdir())


def test_areas_of_the_outlines() -> None:
    from shapely import Polygon

    assert Polygon(circle(3)).area == pytest.approx(AREAS["circle"])
    assert Polygon(horseshoe(6, 6, sides=24)).area == pytest.approx(AREAS["horseshoe"])
