"""The page of ``bsm-mesh view`` opens without errors and network, its sliders change the picture, clicks tell truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.result_files import corner_displacement
from bsm_mesh.pages.view import write_view
from bsm_mesh.results import Results
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.text.tables import engineering
from tests.scenes.large import tilted_wall
from tests.scenes.models import LINEAR
from tests.scenes.openings import OPENED, ROOF, opening
from tests.viewers.chromium import Page, chromium, missing

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]


@pytest.fixture(scope="module")
def driver() -> Iterator[Any]:
    with chromium() as started:
        yield started


def opened(driver: Any, folder: Path, results: Results) -> Page:
    results.save(folder)
    return Page(driver, write_view(folder))


@pytest.fixture(scope="module")
def bolted(driver: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Page]:
    """Return 24 blocks with joints, bolts, water and two stages, and their page."""
    results = bsm.run(opening(bolted=True))
    return results, opened(driver, tmp_path_factory.mktemp("bolted") / "out", results)


@pytest.fixture(autouse=True)
def reset(request: pytest.FixtureRequest) -> None:
    """Open the page anew for every test of it."""
    if "bolted" in request.fixturenames:
        request.getfixturevalue("bolted")[1].open()


def test_it_opens_without_errors_and_without_network(bolted: tuple[Results, Page]) -> None:
    _, page = bolted
    assert page.errors() == []
    assert page.driver.execute_script("return performance.getEntriesByType('resource').length") == 0
    assert page.title().startswith("stage dig: stable")


def test_the_slider_of_states_changes_the_picture(bolted: tuple[Results, Page]) -> None:
    _, page = bolted
    before = page.picture()
    page.set("frame", 0)
    assert page.title().startswith("stage initial: stable")
    assert page.picture() != before
    page.set("stage", "1")
    assert page.title().startswith("stage dig: stable")
    assert page.errors() == []


def test_the_slider_of_movements_changes_the_picture(bolted: tuple[Results, Page]) -> None:
    _, page = bolted
    pictures = []
    for factor in (
        "0",
        page.driver.execute_script("return Bokeh.documents[0].get_model_by_name('factor').categories.at(-1)"),
    ):
        page.set("factor", factor)
        pictures.append(page.picture())
    assert pictures[0] != pictures[1]


def test_blocks_and_joints_are_drawn_where_they_are(bolted: tuple[Results, Page]) -> None:
    """By exact rotation, taken so many times; a line that a joint is in ends where its blocks' corners are."""
    results, page = bolted
    page.set("factor", "50")
    (xs, ys), joints = (page.drawn(kind) for kind in ("blocks", "joints"))
    blocks, last = results.blocks, results.stages[-1]
    corners = blocks.vertices + 50 * corner_displacement(blocks, last.displacement)
    for block in np.flatnonzero(last.present):
        mine = slice(blocks.offsets[block], blocks.offsets[block + 1])
        np.testing.assert_allclose(np.column_stack([xs[block], ys[block]]), corners[mine], atol=1e-5)
    assert [xs[block] for block in OPENED] == [[]] * len(OPENED)
    faces = joint_faces(results, last)
    ends = np.concatenate([faces.start + 50 * faces.start_displacement, faces.end + 50 * faces.end_displacement])
    drawn = np.column_stack([np.concatenate([np.array(x, dtype=float) for x in part]) for part in joints])
    drawn = drawn[np.isfinite(drawn[:, 0])]
    assert drawn.shape == ends.shape
    np.testing.assert_allclose(drawn[np.lexsort(drawn.round(4).T)], ends[np.lexsort(ends.round(4).T)], atol=1e-3)


def test_a_block_that_has_turned_far(driver: Any, bolted: tuple[Results, Page], tmp_path: Path) -> None:
    results, _ = bolted
    last = results.stages[-1]
    moved = last.displacement.copy()
    moved[ROOF[0]] = (0.3, -0.2, 2.5)
    turned = replace(results, stages=(results.stages[0], replace(last, displacement=moved)))
    page = opened(driver, tmp_path / "out", turned)
    page.set("factor", "1")
    xs, ys = (values[ROOF[0]] for values in page.drawn("blocks"))
    mine = slice(results.blocks.offsets[ROOF[0]], results.blocks.offsets[ROOF[0] + 1])
    expected = (results.blocks.vertices + corner_displacement(results.blocks, moved))[mine]
    np.testing.assert_allclose(np.column_stack([xs, ys]), expected, atol=1e-5)


def test_colours_by_any_array(bolted: tuple[Results, Page]) -> None:
    _, page = bolted
    seen = [page.picture()]
    for name in ("sigma 1", "displacement y", "rock", "none"):
        page.set("blocks_by", name)
        seen.append(page.picture())
    page.set("joints_by", "pressure")
    page.set("bolts_by", "none")
    seen.append(page.picture())
    assert len(set(seen)) == len(seen)
    assert page.errors() == []


def test_a_click_on_a_block_tells_its_numbers(bolted: tuple[Results, Page]) -> None:
    results, page = bolted
    page.set("factor", "1")
    page.click(2.25, 2.3)
    told, last, block = page.told(), results.stages[-1], ROOF[0]
    assert told[""] == f"Block {block}, rock"
    assert told["displacement"] == engineering(float(np.hypot(*last.displacement[block, :2])), "m")
    assert told["stress yy"] == engineering(float(last.stress[block, 1, 1]), "Pa")
    page.set("frame", 0)
    assert page.told()["stress yy"] == engineering(float(results.stages[0].stress[block, 1, 1]), "Pa")


def test_a_number_that_is_not_known_is_not_told_as_0(driver: Any, bolted: tuple[Results, Page], tmp_path: Path) -> None:
    results, _ = bolted
    last = results.stages[-1]
    stress = last.stress_effective.copy()
    stress[ROOF[0]] = np.nan
    page = opened(
        driver, tmp_path / "out", replace(results, stages=(*results.stages[:1], replace(last, stress_effective=stress)))
    )
    page.set("factor", "1")
    page.click(2.25, 2.3)
    assert page.told()["stress effective yy"] == "not known"
    assert page.told()["displacement"] != "not known"


def test_a_click_on_a_joint_and_on_a_bolt(bolted: tuple[Results, Page]) -> None:
    results, page = bolted
    page.set("factor", "1")
    page.click(1.3, 2.0)
    told = page.told()
    assert told[""] == "Joint between blocks 7 and 13" or told[""] == "Joint between blocks 13 and 7"
    c = results.stages[-1].contacts
    mine = ((c.block_a == 7) & (c.block_b == 13)) | ((c.block_a == 13) & (c.block_b == 7))
    pressure = float(-(c.normal_force[mine].sum()) / c.length[mine].sum())
    assert told["pressure"] == engineering(float(np.float32(pressure)), "Pa")
    assert told["status"] == "sticking"
    page.click(2.5, 2.75)
    told = page.told()
    assert told[""] == "Bolt B1"
    assert told["axial force"] == engineering(float(results.stages[-1].bolts.axial_force[0]), "N of one bolt")


def test_what_is_excavated_is_not_there(bolted: tuple[Results, Page]) -> None:
    _, page = bolted
    page.set("frame", 0)
    page.click(2.3, 1.6)
    assert page.told()[""] == "Block 8, rock"
    page.set("frame", 1)
    assert "is not there in this state" in (page.text("told") or "")


def test_blocks_that_come_down_are_listed_and_found(driver: Any, tmp_path: Path) -> None:
    results = bsm.run(opening(bolted=False))
    page = opened(driver, tmp_path / "out", results)
    assert set(results.unstable_blocks) <= set(ROOF)
    rows = driver.execute_script("return Bokeh.documents[0].get_model_by_name('falls').source.data.block")
    assert rows == results.unstable_blocks.tolist()
    before = page.picture()
    driver.execute_script("Bokeh.documents[0].get_model_by_name('falls').source.selected.indices = [0]")
    assert page.told()[""] == f"Block {results.unstable_blocks[0]}, rock"
    assert page.picture() != before
    assert page.errors() == []


def test_names_are_no_html(driver: Any, tmp_path: Path) -> None:
    """Titles, rocks and joints of a file from elsewhere do nothing in the page."""
    evil = "<img src=x onerror=document.title='owned'></script><script>document.title='owned'</script>"
    model = opening(bolted=True)
    rocks = [bsm.Rock(evil, unit_weight=25e3)]
    blocks = bsm.Blocks.from_polygons([model.blocks.polygon(b) for b in range(24)], rock=evil)
    page = opened(driver, tmp_path / "out", bsm.run(model.replace(blocks=blocks, rocks=rocks, title=evil)))
    page.set("blocks_by", "rock")
    page.click(2.25, 2.3)
    assert page.told()[""].endswith(evil)
    assert driver.title != "owned"
    assert page.errors() == []


def test_ten_thousand_blocks(driver: Any, tmp_path: Path) -> None:
    """How quick it is ``python -m tests.viewers`` prints; here it is right."""
    results = bsm.run(tilted_wall(10_000).model(), LINEAR)
    page = opened(driver, tmp_path / "out", results)
    block = 5050
    page.set("factor", "0")
    at = results.blocks.moments.centroid[block]
    page.zoom(*at, 5.0)
    page.click(*at)
    assert page.told()[""].startswith(f"Block {block}, ")
    moved = float(np.hypot(*results.stages[0].displacement[block, :2]))
    assert page.told()["displacement"] == engineering(float(np.float32(moved)), "m")
    assert page.errors() == []
