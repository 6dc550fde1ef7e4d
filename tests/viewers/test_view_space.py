"""The page of ``bsm-mesh view`` for polyhedra in a browser: blocks are where they are, widgets and clicks work."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.movements import carried
from bsm_mesh.pages.view import write_view
from tests.unit.test_space_pictures import ROOF
from tests.viewers.chromium import DRAWN, Page, chromium, missing

pytest.importorskip("plotly")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]

TRACES = "document.getElementById('scene').data"


class SpacePage(Page):
    """The page, whose scene Plotly draws."""

    def title(self) -> str:
        return str(
            self.driver.execute_script("return document.getElementById('scene')?._fullLayout?.title?.text ?? ''")
        )

    def trace(self, name: str) -> dict[str, Any]:
        """Return points (k, 3) [m], triangles (n, 3) and block of each point of a trace."""
        found = self.driver.execute_script(
            f"""const one = {TRACES}.find((trace) => trace.name === arguments[0]);
            return [[one.x, one.y, one.z], [one.i ?? [], one.j ?? [], one.k ?? []], one.meta?.owner ?? []]
              .map((part) => part.map((values) => (typeof values === "number" ? values : Array.from(values))))""",
            name,
        )
        points, triangles, owner = found
        return {
            "points": np.array(points, dtype=float).T,
            "triangles": np.array(triangles, dtype=int).T,
            "owner": np.array(owner, dtype=int),
        }

    def click_on(self, name: str, point: int) -> None:
        """Let Plotly report a click on a point of a trace: headless browsers pick nothing in WebGL reliably."""
        self.driver.execute_script(
            f"""const scene = document.getElementById("scene");
            const data = {TRACES}.find((trace) => trace.name === arguments[0]);
            scene.emit("plotly_click", {{points: [{{data, pointNumber: arguments[1]}}]}})""",
            name,
            point,
        )
        self.driver.execute_async_script(DRAWN)


def faults(page: Page) -> list[str]:
    """Return the errors of a page, without advice on graphics that a headless browser gives."""
    return [text for text in page.errors() if "WebGL" not in text and "willReadFrequently" not in text]


@pytest.fixture(scope="module")
def driver() -> Iterator[Any]:
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def fallen(driver: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[bsm.Results, SpacePage]:
    """Return results in which a pyramid falls from a roof, and their page."""
    folder = tmp_path_factory.mktemp("roof")
    (folder / "roof.toml").write_text(ROOF, encoding="utf-8")
    results = bsm.run(folder / "roof.toml")
    return results, SpacePage(driver, write_view(folder / "out/roof"))


@pytest.fixture(autouse=True)
def reset(fallen: tuple[bsm.Results, SpacePage]) -> None:
    """Open the page anew for every test."""
    fallen[1].open()


def test_it_opens_without_errors_and_without_network(fallen: tuple[bsm.Results, SpacePage]) -> None:
    _, page = fallen
    assert faults(page) == []
    assert page.driver.execute_script("return performance.getEntriesByType('resource').length") == 0
    assert page.title() == "stage room: unstable, 1 block falls: 1.6 % of the volume; true to scale"
    (block,) = fallen[0].unstable_blocks
    assert page.driver.execute_script(f"return {TRACES}.filter((t) => t.mode === 'text').at(-1).text") == [str(block)]


def test_the_block_that_falls_is_drawn_where_it_is(fallen: tuple[bsm.Results, SpacePage]) -> None:
    """By exact rotation, taken so many times; its surface encloses its volume."""
    results, page = fallen
    (block,) = results.unstable_blocks
    blocks, movement = results.blocks, results.stages[-1].displacement[[block]]
    mine = np.unique(np.concatenate([blocks.polygon(face) for face in blocks.block_faces(block)]).round(9), axis=0)
    arms = mine - blocks.moments.centroid[block]
    for times in (1, 2):
        page.set("factor", str(times))
        drawn = page.trace("falls")
        expected = mine + times * carried(arms, np.repeat(movement, len(mine), axis=0))
        assert set(drawn["owner"]) == {block}
        for point in drawn["points"]:
            assert np.linalg.norm(expected - point, axis=1).min() < 1e-5
    page.set("factor", "1")
    drawn = page.trace("falls")
    a, b, c = (drawn["points"][drawn["triangles"][:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(blocks.moments.bulk[block], rel=1e-4)


def test_outer_faces_and_states(fallen: tuple[bsm.Results, SpacePage]) -> None:
    """They hide the room, and are off at first; in the first stage nothing else is bare."""
    _, page = fallen
    hidden = len(page.trace("stays")["triangles"])
    page.set("shown", [0, 1, 2], key="active")
    assert len(page.trace("stays")["triangles"]) > hidden > 0
    page.set("stage", "1")
    assert page.title().startswith("stage initial: stable")
    assert len(page.trace("falls")["triangles"]) == 0
    page.set("shown", [0], key="active")
    assert len(page.trace("stays")["triangles"]) == 0
    assert faults(page) == []


def test_a_click_and_the_list_show_numbers(fallen: tuple[bsm.Results, SpacePage]) -> None:
    results, page = fallen
    (block,) = results.unstable_blocks
    page.click_on("falls", 0)
    told = page.told()
    assert told[""] == f"Block {block}, granite"
    assert told["volume"] == "2.309 m3"
    assert len(page.trace("chosen")["points"]) > 0
    page.click_on("stays", 0)
    assert page.told()[""] != f"Block {block}, granite"
    page.driver.execute_script(
        "Bokeh.documents[0].get_model_by_name('falls').source.selected.indices = [0]",
    )
    page.driver.execute_async_script(DRAWN)
    assert page.told()[""] == f"Block {block}, granite"


def test_colours_by_any_array(fallen: tuple[bsm.Results, SpacePage]) -> None:
    _, page = fallen
    titles = []
    for name in ("displacement z", "rock", "sigma 1"):
        page.set("blocks_by", name)
        titles.append(
            page.driver.execute_script(
                "return document.getElementById('scene').layout.coloraxis.colorbar.title.text",
            )
        )
    assert titles[0].startswith("blocks: displacement z")
    assert titles[1] == "blocks: rock"
    assert titles[2].startswith("blocks: sigma 1")
    assert titles[2].endswith("Pa")
