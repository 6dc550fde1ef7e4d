"""Worked examples of docs/jointed_rock.md, own_mesh.md and first_problems.md: files as printed, commands in order."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from docs.code_blocks import files_of, typed
from tests.scenes.small_case import Case
from tests.scenes.typed_lines import mesh_by_gmsh, type_line

pytestmark = pytest.mark.usefixtures("drawn_here")
PAGE = Path(__file__).parents[2] / "docs/jointed_rock.md"
OWN = PAGE.with_name("own_mesh.md")
FIRST = PAGE.with_name("first_problems.md")


@pytest.fixture
def page(case: Case) -> str:
    text = PAGE.read_text(encoding="utf-8") + OWN.read_text(encoding="utf-8")
    for name, content in files_of(text).items():
        case.write(name, content)
    return text


@pytest.mark.slow
def test_every_command_of_the_page_runs(case: Case, page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(PAGE.parents[1]))
    for line in typed(page):
        type_line(case, line, PAGE.name)
    for name in ("rock.msh", "quality.png", "net.png", "out/model/summary.json"):
        assert (case.folder / name).is_file()


@pytest.mark.heavy
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_first_problem_from_nothing_to_its_verdict(case: Case, number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As typed; blocks and verdict are those of the page's table."""
    monkeypatch.setenv("PYTHONPATH", str(PAGE.parents[1]))
    text, section = FIRST.read_text(encoding="utf-8"), FIRST.read_text(encoding="utf-8").split("\n## ")[number]
    for name, content in files_of(section).items():
        case.write(name, content)
    commands = "\n".join(typed(section))
    for line in commands.splitlines():
        type_line(case, line, FIRST.name)
    (told,) = case.folder.glob("out/*/summary.json")
    end = json.loads(told.read_text(encoding="utf-8"))
    row = f"| {section.splitlines()[0]} | {end['blocks']} | {end['status']} |"
    assert row.lower() in text.lower()


def test_the_numbers_of_the_page(case: Case, page: str) -> None:
    from bsm_mesh.converters import read_mesh

    mesh_by_gmsh(case.folder, "tunnel.geo", "tunnel.msh")
    blocks, report = read_mesh(case.folder / "tunnel.msh", blocks="regions")
    assert blocks.count == 12
    assert f"{round(report.elements, -2)} triangles become twelve blocks" in page
    subprocess.run([sys.executable, "bench.py"], cwd=case.folder, check=True)
    names = {"SCHIST": "rock:schist", "BEDDING": "joint:bedding", "FAULT": "joint:fault", "BASE": "boundary:base"}
    blocks, report = read_mesh(case.folder / "bench.inp", groups=names, blocks="regions")
    assert (report.elements, blocks.count) == (240, 8)
    assert set(blocks.offsets[1:] - blocks.offsets[:-1]) == {4}


@pytest.mark.heavy
def test_oblique_joints_are_grouped_whole_and_alone(case: Case, page: str) -> None:
    """Every line of both sets in the rock, as long as geometry says, and no arc of the roof with them."""
    import shapely

    from bsm_mesh.converters import read_mesh

    subprocess.run([sys.executable, "horseshoe.py"], cwd=case.folder, check=True)
    blocks, report = read_mesh(case.folder / "horseshoe.msh", blocks="regions")
    assert f"{round(report.elements, -2)} triangles become {blocks.count} blocks" in page
    opening = shapely.box(-3, -3, 3, 0).union(shapely.Point(0, 0).buffer(3, quad_segs=500))
    rock = shapely.box(-12, -12, 12, 12).difference(opening)
    ends = blocks.vertices, blocks.vertices[blocks.following]
    for name, dip in (("J1", 35), ("J2", 110)):
        mine = blocks.edge_joint == blocks.joint_names.index(name)
        length = np.hypot(*(ends[1] - ends[0])[mine].T).sum() / 2  # on both sides
        d = np.radians(dip)
        along, across = np.array([np.cos(d), np.sin(d)]), np.array([-np.sin(d), np.cos(d)])
        lines = shapely.linestrings(
            [[k * 2.5 * across - 40 * along, k * 2.5 * across + 40 * along] for k in range(-8, 9)]
        )
        assert length == pytest.approx(shapely.length(shapely.intersection(lines, rock)).sum(), rel=1e-3)
