"""Cross-sections of other programs: parts of a drawing, their rocks, excavations and joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.geometries import GeometryError, cut_blocks, read_section

FRAME = [(0, 0), (20, 0), (20, 10), (0, 10), (0, 0)]
LAYER = [(0, 4), (20, 6)]
LENS = [(12, 7), (16, 7), (16, 9), (12, 9), (12, 7)]
PIT = [(4, 10), (4, 8), (8, 8), (8, 10), (4, 10)]
GIVEN = {"outline": "external", "materials": ["material"], "rocks": {"granite": (10, 1), "schist": (1, 9)}}


def drawing(folder: Path, **layers: list[list[tuple[float, float]]]) -> Path:
    """Return a table of lines, a layer a set."""
    rows = [
        f"{layer}{number},{layer},{x},{y}"
        for layer, lines in layers.items()
        for number, line in enumerate(lines)
        for x, y in line
    ]
    path = folder / "section.csv"
    path.write_text("\n".join(["trace,set,x,y", *rows]) + "\n")
    return path


def areas(rock) -> dict[str, float]:
    """Return the area of every rock of the blocks that a rock mass is cut to."""
    cut = cut_blocks(rock)
    found = dict.fromkeys(cut.rock_names, 0.0)
    for block, first in enumerate(cut.faces[:-1]):
        for ring in range(first, cut.faces[block + 1]):  # holes run the other way
            x, y = cut.points[cut.corners[cut.rings[ring] : cut.rings[ring + 1]]].T
            found[cut.rock_names[cut.rock[block]]] += (np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2
    return found


def test_layers_of_rock_have_the_area_that_is_drawn(tmp_path: Path):
    rock = read_section(drawing(tmp_path, external=[FRAME], material=[LAYER]), **GIVEN)
    found = areas(rock)
    assert_allclose([found["granite"], found["schist"]], [100, 100], rtol=1e-9)


def test_a_lens_lies_over_its_host(tmp_path: Path):
    path = drawing(tmp_path, external=[FRAME], material=[LAYER, LENS])
    rock = read_section(path, **{**GIVEN, "rocks": {**GIVEN["rocks"], "clay": (14, 8)}})
    found = areas(rock)
    assert_allclose([found[name] for name in ("granite", "schist", "clay")], [100, 92, 8], rtol=1e-9)


def test_an_outline_of_several_lines_whose_ends_differ_by_rounding(tmp_path: Path):
    sides = [[FRAME[k], (FRAME[k + 1][0] + 1e-7, FRAME[k + 1][1] - 1e-7)] for k in range(4)]
    found = areas(read_section(drawing(tmp_path, external=sides, material=[[(-1, 3.9), (21, 6.1)]]), **GIVEN))
    assert_allclose(sum(found.values()), 200, rtol=1e-6)


def test_joints_and_excavations_by_layer(tmp_path: Path):
    """Two layers with traces make one joint; millimetres become metres."""
    lines = [(2, 0), (2, 10)], [(0, 9), (20, 9)]
    layers = {"external": [FRAME], "material": [LAYER], "pit": [PIT], "J": [lines[0]], "K": [lines[1]]}
    drawn = {name: [[(1e3 * x, 1e3 * y) for x, y in line] for line in of] for name, of in layers.items()}
    rock = read_section(
        drawing(tmp_path, **drawn), **GIVEN, excavations={"pit": "cut"}, joints={"J": "bedding", "K": "bedding"},
        border="contact", scale=1e-3,
    )  # fmt: skip
    (joint,) = rock.joints
    assert joint.name == "bedding"
    assert_allclose(sorted(map(np.ndarray.tolist, joint.lines)), sorted(map(list, lines)), atol=1e-9)
    (pit,) = [region for region in rock.regions if hasattr(region, "name")]
    assert pit.name == "cut"
    assert {tuple(corner) for corner in pit.outline.round(9).tolist()} == set(PIT)
    assert [region.border for region in rock.regions if region is not pit] == ["contact", "contact"]
    assert len(areas(rock)) == 2


@pytest.mark.parametrize(
    ("layers", "changes", "words"),
    [
        ({"external": [FRAME[:3]], "material": [LAYER]}, {}, "layer 'external' bounds no area; draw closed lines"),
        ({"external": [FRAME], "material": [[(0, 4), (15, 5)]]}, {}, "1 of the material boundaries end inside a rock"),
        ({"external": [FRAME], "material": [LAYER]}, {"rocks": {"granite": (10, 1)}}, "has no rock; give a point"),
        (
            {"external": [FRAME], "material": [LAYER]},
            {"rocks": {"granite": [(10, 1), (10, 9)], "schist": (1, 9)}},
            "has points of granite and schist; give one rock",
        ),
        (
            {"external": [FRAME], "material": [LAYER]},
            {"rocks": {**GIVEN["rocks"], "clay": (30, 5)}},
            "the point (30, 5) of rock 'clay' lies in no part of the section",
        ),
        ({"external": [FRAME], "material": [LAYER]}, {"outline": "frame"}, "has no set 'frame'"),
    ],
)
def test_faults(tmp_path: Path, layers, changes, words):
    path = drawing(tmp_path, **layers)
    with pytest.raises(GeometryError) as fault:
        read_section(path, **{**GIVEN, **changes})
    assert words in str(fault.value)
    assert "section.csv" in str(fault.value)
