"""Groups by meaning: the grammar, the renaming, and the fault with them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters import MeshReport, NoteKind, convert_mesh
from bsm_mesh.errors import ModelError
from bsm_mesh.model import Blocks

# Three unit squares in a row (elements 0, 1, 2); line elements on the two inner edges (0, 1), one at the left (2).
POINTS = np.array([(x, y) for y in (0.0, 1.0) for x in range(4)])
QUADS = [(k, k + 1, k + 5, k + 4) for k in range(3)]
LINES = [(1, 5), (2, 6), (0, 4)]
CELLS = [("quad", QUADS), ("line", LINES)]


def convert(
    sets: Mapping[str, list[Any]] | None = None, groups: Mapping[str, str] | None = None, **data: list[Any]
) -> tuple[Blocks, MeshReport]:
    arrays = {name: [np.array(values) for values in blocks] for name, blocks in data.items()}
    return convert_mesh(POINTS, CELLS, sets, groups=groups, cell_data=arrays)


def test_names_of_the_grammar_are_used_as_they_are() -> None:
    blocks, report = convert(
        {
            "rock:gneiss": [[0, 1], None],
            " Rock : schist": [[2], None],
            "excavation:core": [[1], None],
            "joint:J1": [None, [0]],
            "boundary:left": [None, [2]],
            "bolt:B1": [None, [1]],
        }
    )
    assert blocks.rock_names == ("gneiss", "schist")
    assert blocks.rock.tolist() == [0, 0, 1]
    assert blocks.excavations["core"].tolist() == [1]
    assert blocks.joint_names == ("J1",)
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == [1, 7]
    assert blocks.boundaries["left"].tolist() == [3]
    np.testing.assert_array_equal(report.bolts["B1"], [[(2, 0), (2, 1)]])
    assert report.groups["bolt:B1"] == 1
    assert report.notes == ()


def test_renaming_joins_groups_and_the_star_takes_the_rest() -> None:
    blocks, report = convert(
        {"Schist": [[0], []], "Old": [[1], []]}, {"Schist": "rock:s", "Old": "rock:s", "*": "rock:g"}
    )
    assert [blocks.rock_names[k] for k in blocks.rock] == ["s", "s", "g"]
    assert report.notes == ()


def test_values_of_an_array_are_groups_where_the_user_says_so() -> None:
    blocks, _ = convert(
        None,
        {"MaterialIDs=7": "rock:a", "MaterialIDs=-1": "rock:b", "MaterialIDs=3": "joint:J"},
        MaterialIDs=[[7.0, 7.0, -1.0], [3.0, 9.0, 7.0]],
    )
    assert [blocks.rock_names[k] for k in blocks.rock] == ["a", "a", "b"]
    assert np.flatnonzero(blocks.edge_joint >= 0).tolist() == [1, 7]


def test_elements_in_no_rock_are_left_out_and_counted() -> None:
    blocks, report = convert({"rock:a": [[0, 2], []], "excavation:1": [[1, 2], []]})
    assert blocks.count == 2
    assert blocks.excavations["1"].tolist() == [1]
    assert report.count(NoteKind.NO_ROCK) == 1
    assert "elements 1, near (1, 0)" in report.notes[0].text


def test_an_excavation_outside_all_rocks_is_an_error() -> None:
    """Each excavated surface is in two groups, its rock and the excavation: forgotten, nothing was to be excavated."""
    with pytest.raises(ModelError, match=r"'excavation:1': none of its 2 elements is in a rock; .*rock:NAME too"):
        convert({"rock:a": [[0], []], "excavation:1": [[1, 2], []]})


def test_groups_of_other_names_and_empty_groups_are_reported() -> None:
    _, report = convert({"rock:a": [[0, 1, 2], []], "Fault": [[], [0]], "Clay": [[1], []], "joint:J9": [[], []]})
    assert report.about(NoteKind.UNKNOWN_GROUP) == {"Clay": 1, "Fault": 1}
    assert report.about(NoteKind.EMPTY_GROUP) == {"joint:J9": 0}
    assert '"Fault" = "joint:Fault"' in "\n".join(report.lines())


@pytest.mark.parametrize(
    ("sets", "groups", "message"),
    [
        ({"rock:a": [[0], []]}, {"Shist": "rock:s"}, "no group 'Shist'"),
        ({"Schist": [[0], []]}, {"Shist": "rock:s"}, "did you mean 'Schist'"),
        ({"Schist": [[0], []]}, {"Schist": "schist"}, "not of the form kind:name"),
        ({"Schist": [[0], []]}, {"*": "joint:s"}, "must be rock:name"),
        ({"rock:a": [[0], [1]]}, None, "'rock:a': holds 1 line elements, and rock:NAME is for surfaces"),
        ({"rock:a": [[0], []], "joint:J": [[1, 2], []]}, None, "'joint:J': holds 2 surface elements"),
        ({"rock:a": [[0], []], "X": [[1], []]}, {"X": "boundary:b"}, r"'boundary:b' \(in the mesh: 'X'\)"),
        ({"rock:a": [[0, 1], []], "rock:b": [[1, 2], []]}, None, r"'rock:a' and in 'rock:b' \(elements 1\)"),
        ({"Schist": [[0], []]}, None, '"Schist" = "rock:granite"'),
        (None, None, r'"\*" = "rock:granite"'),
        ({"rock:a": [[0, 1], []], "joint:J": [[], [0]], "joint:K": [[], [0, 1]]}, None, "'joint:J' and in 'joint:K'"),
    ],
)
def test_a_wrong_group_is_one_clear_error(sets: Any, groups: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        convert(sets, groups)


def test_values_found_are_named_where_there_is_no_rock() -> None:
    with pytest.raises(ModelError, match="values found: region=1, region=4"):
        convert(region=[[1, 1, 4], [0, 0, 0]])
    with pytest.raises(ModelError, match=r"no group 'region=2'.*known: region=0, region=1, region=4"):
        convert(None, {"region=2": "rock:a"}, region=[[1, 1, 4], [0, 0, 0]])


def test_a_missing_boundary_is_told_with_the_curve_groups_that_the_mesh_has(tmp_path: Path) -> None:
    """An Abaqus node set under its own name: what stands under [groups] is said where the boundary is missed."""
    nodes = "*NODE\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n"
    (tmp_path / "a.inp").write_text(f"{nodes}*ELEMENT, TYPE=CPE4\n1, 1, 2, 3, 4\n*NSET, NSET=BASE\n1, 2\n")
    rock = '[groups]\n"*" = "rock:r"\n[rock.r]\nunit_weight = 26e3\n'
    model = f'[mesh]\nfile = "a.inp"\n{rock}[[support]]\nboundary = "base"\nfix = "all"\n'
    (tmp_path / "a.toml").write_text(model)
    with pytest.raises(ModelError) as caught:
        bsm.load(tmp_path / "a.toml")
    missing, groups = caught.value.faults
    assert "there is no boundary 'base'" in missing
    assert groups.endswith('under [groups] for example "BASE" = "joint:BASE" or "boundary:BASE"')
    (tmp_path / "a.toml").write_text(model.replace("[groups]", '[groups]\n"BASE" = "boundary:base"'))
    assert bsm.load(tmp_path / "a.toml").blocks.boundaries["base"].size == 1


def test_a_curve_may_be_joint_and_boundary() -> None:
    blocks, report = convert({"rock:a": [[0, 1, 2], []], "joint:J": [[], [0]], "boundary:wall": [[], [0]]})
    assert np.flatnonzero(blocks.edge_joint == 0).tolist() == blocks.boundaries["wall"].tolist() == [1, 7]
    assert report.about(NoteKind.INTERIOR) == {"boundary:wall": 2}


def test_a_printed_report_is_text() -> None:
    _, report = convert({"rock:a": [[0, 1, 2], []]})
    assert str(report) == "\n".join(report.lines())
    assert "rock:a: 3 blocks" in str(report)


def test_a_printed_report_says_whether_elements_or_regions_are_blocks() -> None:
    """Plane meshes and meshes in space have different defaults, so that a reader sees which was taken."""
    sets = {"rock:a": [[0, 1, 2], []]}
    for choice, made in (
        ({}, "3 blocks (blocks = 'elements')"),
        ({"blocks": "regions"}, "1 block (blocks = 'regions')"),
    ):
        _, report = convert_mesh(POINTS, CELLS, sets, **choice)
        assert str(report).splitlines()[0].endswith(made)
