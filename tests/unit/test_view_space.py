"""The page to explore for polyhedra: its numbers, its sides, nothing outside needed. In a browser: tests/viewers."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.pages.view import write_view
from bsm_mesh.pages.view_data import ViewData, read_view
from bsm_mesh.pages.view_page import list_of_falls
from bsm_mesh.pages.view_space import SpaceView, _geometry, view_of_space
from bsm_mesh.three_d.blocks.polygons import vector_areas
from tests.unit.test_space_pictures import ROOF

SINGLE = 1e-6  # single precision: six digits


@pytest.fixture(scope="module")
def roof(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run in whose last stage a pyramid falls from the roof of a room."""
    folder = tmp_path_factory.mktemp("roof")
    (folder / "roof.toml").write_text(ROOF, encoding="utf-8")
    bsm.run(folder / "roof.toml")
    return folder / "out/roof"


@pytest.fixture(scope="module")
def data(roof: Path) -> ViewData:
    return read_view(SavedResults(roof))


def test_numbers_of_blocks_are_those_of_the_results(roof: Path, data: ViewData) -> None:
    last, arrays = bsm.Results.load(roof).stages[-1], data.states[-1].layers["blocks"].arrays
    there = np.flatnonzero(last.present)
    assert np.isnan(arrays["displacement"][~last.present]).all()
    for name, values in {
        "displacement": np.linalg.norm(last.displacement[:, :3], axis=1),
        "displacement z": last.displacement[:, 2],
        "rotation y": last.displacement[:, 4],
        "stress yz": last.stress[:, 1, 2],
        "load z": last.loads[:, 2],
        "reaction moment x": last.reactions[:, 3],
    }.items():
        assert_allclose(arrays[name][there], values[there], rtol=SINGLE, atol=1e-30, err_msg=name)
    units = data.units["blocks"]
    assert (units["load z"], units["reaction moment x"], units["rotation y"]) == ("N", "N m", "rad")
    assert [state.frame.is_end for state in data.states] == [False, True, False, True]


def test_joints_are_the_contact_polygons(data: ViewData) -> None:
    """Points from the model's middle, polygon after polygon: their area is that of the file."""
    joints = data.states[-1].layers["joints"]
    assert len(joints.offsets) == len(joints.blocks) + 1
    areas = np.linalg.norm(vector_areas(joints.ends.astype(float), joints.offsets), axis=1)
    assert_allclose(areas, joints.arrays["area"], rtol=1e-4)
    assert data.units["joints"]["pressure"] == "Pa"
    assert data.names["joints"]["status"] == ("sticking", "slipping", "open")


def test_what_falls_is_listed_with_volume_and_weight(data: ViewData) -> None:
    """A pyramid of 4 / sqrt(3) m3 over a square of 4 m2."""
    (fall,) = data.falls
    assert fall["area"] == pytest.approx(4 / np.sqrt(3))
    assert fall["weight"] == pytest.approx(26e3 * 4 / np.sqrt(3), rel=1e-4)
    assert 1 < fall["z"] < 2.8
    pytest.importorskip("bokeh")
    table = list_of_falls(data)
    assert [column.title for column in table.columns] == ["block", "stage", "m3", "kN", "x, m", "y, m", "z, m"]
    assert table.source.data["weight"] == [pytest.approx(60.0, abs=0.1)]


def test_sides_enclose_the_blocks(roof: Path, data: ViewData) -> None:
    """Their volume by the divergence theorem, with outward normals, is that of all blocks."""
    view = view_of_space(roof)
    assert view.cut
    assert view.within
    content = _geometry(data, view)
    sides = content["sides"]
    corners = sides["corners"].reshape(-1, 3).astype(float)
    middle = np.add.reduceat(corners, sides["offsets"][:-1]) / np.diff(sides["offsets"])[:, None]
    volume = np.einsum("ij,ij->", middle, vector_areas(corners, sides["offsets"])) / 3
    assert volume == pytest.approx(data.blocks.moments.bulk.sum(), rel=1e-5)
    assert len(sides["block"]) == len(sides["other"]) == len(middle)
    assert content["eye"]["z"] < 0  # the eye is below the roof


def test_the_page_needs_nothing_else(roof: Path) -> None:
    for library in ("bokeh", "plotly"):
        pytest.importorskip(library)
    page = write_view(roof).read_text(encoding="utf-8")
    tags = re.findall(r"<(?:script|link|img|iframe)\b[^>]*>", re.sub(r"(?s)(<script[^>]*>).*?</script>", r"\1", page))
    assert tags
    assert not [tag for tag in tags if "src=" in tag or "href=" in tag]
    for words in ("Wedge in a roof", "outer faces", '<div id="scene">', "function bare_sides", "Plotly.react"):
        assert words in page, words


def test_a_missing_library_is_named(data: ViewData, monkeypatch: pytest.MonkeyPatch) -> None:
    from bsm_mesh.pages.view_space import space_page_of

    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(bsm.ModelError, match="pip install bokeh plotly"):
        space_page_of(data, "", SpaceView(np.eye(3), cut=False, within=False))
