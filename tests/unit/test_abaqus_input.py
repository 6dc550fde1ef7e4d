"""Abaqus input of any writer: blocks of nodes, types, sets in any order, parts and instances, surfaces, faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes.from_inp import read_inp
from bsm_mesh.errors import ModelError

# Six squares of 1 m, three side by side, two rows; nodes 1 to 12, elements 1 to 6.
NODES = "".join(f"{4 * j + i + 1}, {i}., {j}.\n" for j in range(3) for i in range(4))
ELEMENTS = "".join(
    f"{3 * j + i + 1}, {4 * j + i + 1}, {4 * j + i + 2}, {4 * j + i + 6}, {4 * j + i + 5}\n"
    for j in range(2)
    for i in range(3)
)
MESH = f"*NODE\n{NODES}*ELEMENT, TYPE=CPE4\n{ELEMENTS}"
ALL = {"*": "rock:a"}


def written(tmp_path: Path, text: str) -> Path:
    (tmp_path / "a.inp").write_text(text, encoding="utf-8")
    return tmp_path / "a.inp"


@pytest.mark.parametrize("kind", ["CPE4", "cps4r", "CAX4", "S4R", "AC2D4", "CPEG4H"])
def test_types_of_any_case_and_writer(tmp_path: Path, kind: str) -> None:
    blocks, _ = read_mesh(written(tmp_path, MESH.replace("CPE4", kind)), groups=ALL)
    assert (blocks.count, blocks.moments.area.sum()) == (6, 6.0)


def test_sets_before_their_elements_of_sets_and_generated(tmp_path: Path) -> None:
    sets = "*Elset, elset=low, generate\n1, 3, 1\n*ELSET,\nELSET=UP\n4, 5,\n6\n*ELSET, ELSET=BOTH\nLOW, up\n"
    _, report = read_mesh(written(tmp_path, sets + MESH), groups={"low": "rock:a", "UP": "rock:b"})
    assert report.groups == {"rock:a": 3, "rock:b": 3}
    _, report = read_mesh(written(tmp_path, sets + MESH), groups={"BOTH": "rock:c"})
    assert report.groups["rock:c"] == 6


def test_several_blocks_of_nodes_continued_lines_and_comments(tmp_path: Path) -> None:
    first, second = NODES[: NODES.index("6,")], NODES[NODES.index("6,") :]
    long = "*ELEMENT, TYPE=CPS4, ELSET=ROCK\n1, 1, 2,\n6, 5\n2, 2, 3,\n7, 6\n"
    text = f"*Heading\n a, b\n** nothing\n*NODE, NSET=A\n{first}*Node\n{second}{long}"
    blocks, _ = read_mesh(written(tmp_path, text), groups={"ROCK": "rock:a"})
    assert blocks.count == 2


def test_node_sets_and_surfaces_are_boundaries_and_joints(tmp_path: Path) -> None:
    """The base by its nodes, the right side by sides of elements, the middle as a joint by its nodes."""
    sets = "*NSET, NSET=BASE\n1, 2, 3, 4\n*NSET, NSET=MIDDLE, GENERATE\n5, 8\n*ELSET, ELSET=EAST\n3, 6\n"
    sets += "*SURFACE, NAME=RIGHT, TYPE=ELEMENT\nEAST, S2\n*SURFACE, NAME=TOP\n4, S3\n5, S3\n6, S3\n"
    groups = {"BASE": "boundary:base", "MIDDLE": "joint:m", "RIGHT": "boundary:right", "TOP": "boundary:top"}
    blocks, report = read_mesh(written(tmp_path, MESH + sets), groups={**ALL, **groups})
    assert report.groups == {"rock:a": 6, "joint:m": 6, "boundary:base": 3, "boundary:right": 2, "boundary:top": 3}
    for name, axis, value in (("base", 1, 0), ("right", 0, 3), ("top", 1, 2)):
        edges = blocks.boundaries[name]
        assert (blocks.vertices[edges, axis] == value).all()
        assert (blocks.vertices[blocks.following[edges], axis] == value).all()
    joint = np.flatnonzero(blocks.edge_joint >= 0)
    assert (blocks.vertices[joint, 1] == 1).all()


def test_instances_of_a_part(tmp_path: Path) -> None:
    part = f"*PART, NAME=Wall\n{MESH}*ELSET, ELSET=W, GENERATE\n1, 6\n*END PART\n"
    assembly = "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=W-1, PART=wall\n*END INSTANCE\n"
    assembly += "*INSTANCE, NAME=W-2, PART=Wall\n0., 2., 0.\n*END INSTANCE\n*END ASSEMBLY\n"
    blocks, report = read_mesh(written(tmp_path, part + assembly), groups={"W": "rock:a"})
    assert (blocks.count, report.groups["rock:a"]) == (12, 12)
    assert blocks.vertices[:, 1].max() == 4
    turned = assembly.replace("0., 2., 0.", "0., 0., 0.\n0., 0., 0., 0., 0., 1., 90.")
    with pytest.raises(ModelError, match="INSTANCE: is turned; turn the mesh itself"):
        read_mesh(written(tmp_path, part + turned), groups={"W": "rock:a"})


def test_a_set_of_one_instance_is_not_in_others(tmp_path: Path) -> None:
    """Both walls have nodes 1 to 4 and elements 1 to 3: a set, or a surface, names those of one of them."""
    part = f"*PART, NAME=Wall\n{MESH}*ELSET, ELSET=EAST\n3, 6\n*END PART\n"
    assembly = "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=W-1, PART=Wall\n*END INSTANCE\n"
    assembly += "*INSTANCE, NAME=W-2, PART=Wall\n0., 2., 0.\n*END INSTANCE\n"
    assembly += "*NSET, NSET=BASE, INSTANCE=w-1\n1, 2, 3, 4\n*ELSET, ELSET=LOW, INSTANCE=W-2\n1, 2, 3\n"
    assembly += "*SURFACE, NAME=RIGHT\nW-2.EAST, S2\n*NSET, NSET=TOP\nW-2.9, W-2.10\n*END ASSEMBLY\n"
    groups = {"LOW": "rock:low", "*": "rock:a"}
    groups |= {"BASE": "boundary:base", "RIGHT": "boundary:right", "TOP": "boundary:top"}
    blocks, report = read_mesh(written(tmp_path, part + assembly), groups=groups)
    found = {"rock:low": 3, "rock:a": 9, "boundary:base": 3, "boundary:right": 2, "boundary:top": 1}
    assert report.groups == found
    assert blocks.vertices[blocks.boundaries["base"], 1].max() == 0
    assert blocks.vertices[blocks.boundaries["right"], 1].min() == 2
    with pytest.raises(ModelError, match=r"line \d+: \*NSET: there is no instance 'W-3'; did you mean"):
        read_mesh(written(tmp_path, part + assembly.replace("w-1", "W-3")), groups=groups)


def test_an_instance_with_a_mesh_of_its_own(tmp_path: Path) -> None:
    """Abaqus/CAE writes the mesh of an independent instance into the instance."""
    text = "*PART, NAME=P\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n"
    assert read_mesh(written(tmp_path, f"{text}{MESH}*END INSTANCE\n*END ASSEMBLY\n"), groups=ALL)[0].count == 6
    with pytest.raises(ModelError, match=r"line 4: \*INSTANCE: neither it nor its part 'P' has nodes"):
        read_mesh(written(tmp_path, f"{text}*END INSTANCE\n*END ASSEMBLY\n"), groups=ALL)


def test_sets_on_the_line_of_nodes_of_elements_and_surfaces_of_nodes(tmp_path: Path) -> None:
    base, rest = NODES[: NODES.index("5,")], NODES[NODES.index("5,") :]
    text = f"*NODE, NSET=BASE\n{base}*NODE\n{rest}*ELEMENT, TYPE=CPE4\n{ELEMENTS}"
    text += "*ELSET, ELSET=UP\n4, 5, 6\n*NSET, NSET=ROUND, ELSET=UP\n*SURFACE, NAME=LEFT, TYPE=NODE\n1, 1.\n5\n9\n"
    groups = {"BASE": "boundary:base", "ROUND": "boundary:round", "LEFT": "boundary:left"}
    _, report = read_mesh(written(tmp_path, text), groups={**ALL, **groups})
    assert report.groups == {"rock:a": 6, "boundary:base": 3, "boundary:round": 5, "boundary:left": 2}


@pytest.mark.parametrize(
    ("keyword", "does"),
    [
        ("*System\n10., 0., 0.", "moves or turns the nodes"),
        ("*Ngen\n1, 4, 1", "makes nodes"),
        ("*NFILL\nA, B, 2, 4", "makes nodes"),
        ("*Ncopy, change number=20, old set=A, shift\n3., 0., 0.", "copies nodes"),
        ("*NMAP, NSET=A, TYPE=RECTANGULAR\n1.,0.,0.", "moves nodes"),
        ("*Elgen, elset=A\n1, 3", "makes elements"),
        ("*ELCOPY, OLD SET=A, ELEMENT SHIFT=10, SHIFT NODES=20", "copies elements"),
        ("*IMPERFECTION, INPUT=a.txt", "moves nodes"),
        ("*Symmetric Model Generation, revolve\n1", "makes nodes and elements"),
        ("*NODE, SYSTEM=C\n13, 1., 90.", "SYSTEM=C: coordinates of another system, not read; write x, y and z"),
        ("*ELEMENT, TYPE=CPE4, INPUT=e.txt", r"data lines in another file, not read; write \*ELEMENT into that file"),
        ("*SURFACE, NAME=S, COMBINE=UNION\nA, B", "a surface made of others, not read; list its elements"),
    ],
)
def test_what_makes_copies_or_moves_the_mesh_is_refused_by_name_and_line(
    tmp_path: Path, keyword: str, does: str
) -> None:
    with pytest.raises(ModelError, match=rf"a.inp, line 14: \*{keyword[1:5].upper()}.*{does}"):
        read_mesh(written(tmp_path, f"*NODE\n{NODES}{keyword}\n*ELEMENT, TYPE=CPE4\n{ELEMENTS}"), groups=ALL)


def test_systems_that_change_nothing_are_read(tmp_path: Path) -> None:
    text = MESH.replace("*NODE", "*SYSTEM\n*NODE, SYSTEM=R")
    assert read_mesh(written(tmp_path, text), groups=ALL)[0].count == 6


def test_all_refused_keywords_are_named_at_once(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        read_inp(written(tmp_path, f"{MESH}*NGEN\n1, 3\n*ELGEN\n1, 3\n"))
    assert [fault.partition(" ma")[0] for fault in caught.value.faults] == [
        f"{tmp_path / 'a.inp'}, line 21: *NGEN",
        f"{tmp_path / 'a.inp'}, line 23: *ELGEN",
    ]


def test_included_files(tmp_path: Path) -> None:
    (tmp_path / "nodes.inc").write_text(f"*NODE\n{NODES}")
    text = f"*INCLUDE, INPUT=nodes.inc\n*ELEMENT, TYPE=CPE4\n{ELEMENTS}"
    assert read_mesh(written(tmp_path, text), groups=ALL)[0].count == 6
    with pytest.raises(ModelError, match="include each other without end"):
        read_inp(written(tmp_path, "*INCLUDE, INPUT=a.inp\n"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("*ELEMENT, TYPE=CPE4\n1, 1, 2, 3, 4\n", "no \\*NODE block"),
        (MESH.replace("6, 7, 8, 12, 11\n", "6, 7, 8, 12\n"), "line 14: \\*ELEMENT: 29 numbers are no rows of 5"),
        (MESH.replace("6, 7, 8, 12, 11\n", "6, 7, 8, 99, 11\n"), "1 node of elements of the type CPE4 .* such as 99"),
        (MESH.replace("1, 0., 0.", "1, zero, 0."), "line 1: \\*NODE: could not convert"),
        (MESH + "*NSET, NSET=A, GENERATE\n1, two\n", "\\*NSET: '1, two' must be first, last, step"),
        (MESH + "*NSET, NSET=A, GENERATE\n1, 4, 0\n", "\\*NSET: '1, 4, 0' must be first, last, step"),
        (MESH + "*NSET, NSET=A, GENERATE\n1, 4, 1, 1\n", "\\*NSET: '1, 4, 1, 1' must be first, last, step"),
        (MESH + "*NSET, NSET=A, GENERATE\n1, 100000000000\n", "'1, 100000000000' generates more numbers than any mesh"),
        (
            MESH + "*ELSET, ELSET=A, GENERATE\n1, 1" + 30 * "0" + ", 1" + 29 * "0" + "\n",
            "generates more numbers than any",
        ),
        (MESH.replace("1, 0., 0.", "nan, 0., 0."), "line 1: \\*NODE: holds infinite or undefined values"),
        (MESH.replace("CPE4", "C3D4"), "three-dimensional"),
        (MESH + "*NODE\n1, 0.5, 0.\n2, 1., 0.\n", "node 1 is given twice, at different places .1 node in all"),
        (MESH.replace("*NODE\n", ""), "line 1: data without a keyword above"),
        (MESH.replace("1, 0., 0.", "1, , 0."), "line 1: .NODE: each line needs a number and two or three coordinates"),
        (MESH.replace("1, 0., 0.", "1, 0., 0., 0."), "line 1: .NODE: each line needs a number and two or three"),
    ],
)
def test_faults_are_told_with_their_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read_mesh(written(tmp_path, text), groups=ALL)


def test_a_name_that_is_not_there_shows_all_that_are(tmp_path: Path) -> None:
    sets = "*NSET, NSET=BASE\n1, 2, 3, 4\n*ELSET, ELSET=LOW\n1, 2, 3\n"
    with pytest.raises(ModelError, match=r"has no group 'BOTTOM' .known: BASE, LOW"):
        read_mesh(written(tmp_path, MESH + sets), groups={**ALL, "BOTTOM": "boundary:b"})
