"""Elements between joints become blocks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters import NoteKind, convert_mesh, read_mesh
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries import (
    Excavation,
    Fault,
    JointSet,
    Opening,
    Region,
    RockMass,
    cut_blocks,
    gmsh_session,
    mesh_blocks,
    name_groups,
    write_blocks,
    write_mesh,
)
from tests.scenes.networks import box, circle

GRID = [(x, y) for y in range(5) for x in range(5)]
QUADS = [(k, k + 1, k + 6, k + 5) for k in range(19) if k % 5 < 4]


def quads(
    joint: list[tuple[int, int]], rock: dict[str, list[int]] | None = None, **others: object
) -> tuple[object, ...]:
    """Return the blocks of a 4 x 4 mesh of squares with one joint."""
    groups = rock or {"rock:gneiss": list(range(16))}
    sets = {name: [ids, None] for name, ids in groups.items()}
    sets["joint:J1"] = [None, list(range(len(joint)))]
    return convert_mesh(GRID, [("quad", QUADS), ("line", joint)], sets, blocks="regions")


def test_a_joint_through_the_mesh_makes_two_blocks_with_four_corners() -> None:
    blocks, report = quads([(k, k + 1) for k in range(10, 14)])
    assert blocks.count == 2
    np.testing.assert_array_equal(np.diff(blocks.offsets), [4, 4])
    np.testing.assert_allclose(blocks.moments.area, [8, 8])
    assert blocks.edge_joint.tolist().count(0) == 2
    assert report.notes == ()


def test_an_l_shaped_joint_makes_a_concave_block() -> None:
    blocks, _ = quads([(2, 7), (7, 12), (12, 11), (11, 10)])
    np.testing.assert_allclose(sorted(blocks.moments.area), [4, 12])
    assert sorted(np.diff(blocks.offsets)) == [4, 6]


def test_a_joint_that_ends_in_the_rock_bounds_nothing_and_is_reported() -> None:
    blocks, report = quads([(10, 11), (11, 12)])
    assert blocks.count == 1
    assert report.about(NoteKind.DEAD_END) == {"joint:J1": 2}
    assert "2 m in all" in report.notes[0].text
    assert np.all(blocks.edge_joint < 0)


def test_rocks_are_not_joined_across_their_border() -> None:
    blocks, _ = quads([(20, 21)], {"rock:gneiss": list(range(8)), "rock:schist": list(range(8, 16))})
    assert blocks.count == 2
    assert [blocks.rock_names[k] for k in blocks.rock] == ["gneiss", "schist"]


def test_a_block_with_a_hole_is_divided() -> None:
    ring = [(6, 7), (7, 8), (8, 13), (13, 18), (18, 17), (17, 16), (16, 11), (11, 6)]
    blocks, report = quads(ring)
    assert report.count(NoteKind.DIVIDED) == blocks.count - 1
    assert blocks.moments.area.sum() == pytest.approx(16)
    assert 4.0 in blocks.moments.area.round(9)


def test_a_block_that_touches_itself_is_divided() -> None:
    at_node_12 = [(6, 7), (7, 12), (12, 11), (11, 6), (12, 13), (13, 18), (18, 17), (17, 12)]
    blocks, _ = quads(at_node_12)  # two squares touch at a corner in the middle: the rest goes round both
    assert blocks.moments.area.sum() == pytest.approx(16)
    assert blocks.count >= 4


def test_excavations_stay_blocks_of_their_own(tmp_path: Path) -> None:
    regions = [Region(outline=box(0, 0, 10, 10), rock="gneiss"), Excavation(outline=box(4, 4, 6, 10), name="1")]
    blocks, _ = read_mesh(write_blocks(cut_blocks(RockMass(regions=regions)), tmp_path / "a.msh"), blocks="regions")
    assert blocks.count == 2
    assert blocks.moments.area[blocks.excavations["1"]] == pytest.approx([12])


@pytest.mark.parametrize("size", [pytest.param(0.7, marks=pytest.mark.heavy), 2.0])
def test_coarse_and_fine_elements_give_the_same_blocks(tmp_path: Path, size: float) -> None:
    regions = [
        Region(outline=box(-10, -10, 10, 10), rock="gneiss"),
        Opening(outline=circle(3, 24), boundary="tunnel"),
    ]
    joints = [
        JointSet(name="J1", dip=30, spacing=3),
        JointSet(name="J2", dip=110, spacing=2.5, persistence=0.7, bridge=1.2),
        Fault(name="F", lines=[[(-10, -7), (0, -5), (3, -7), (10, -2)]]),
    ]
    cut = cut_blocks(RockMass(regions=regions, joints=joints))
    coarse, _ = read_mesh(write_blocks(cut, tmp_path / "coarse.msh"), blocks="regions")
    fine, report = read_mesh(mesh_blocks(cut, tmp_path / "fine.msh", size=size), blocks="regions")
    assert coarse.count == fine.count
    assert len(coarse.vertices) == len(fine.vertices)
    np.testing.assert_allclose(np.sort(coarse.moments.area), np.sort(fine.moments.area), rtol=1e-10)
    assert coarse.moments.area.sum() == pytest.approx(400 - 3**2 * 12 * np.sin(np.pi / 12), rel=1e-12)
    assert report.count(NoteKind.DEAD_END) > 0
    elements, _ = read_mesh(tmp_path / "fine.msh")
    assert elements.count > 4 * fine.count


def test_triangles_of_a_block_that_sees_not_all_of_its_outline_meet_those_beside_it(tmp_path: Path) -> None:
    turn = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    levels = np.sort(np.random.default_rng(3).uniform(2.2, 9.8, 60))
    lines = [[(2, 11), (2, 2), (8, 2), (8, 11)], *([(2, y), (8, y)] for y in levels)]
    joints = [Fault(name=f"J{k}", lines=[np.array(line) @ turn]) for k, line in enumerate(lines)]
    frame = np.array(box(0, 0, 10, 10)) @ turn
    cut = cut_blocks(RockMass(regions=[Region(outline=frame, rock="gneiss")], joints=joints))
    path = write_blocks(cut, tmp_path / "a.msh")
    elements, _ = read_mesh(path)
    outer = elements.edge_table.unpaired()
    assert np.hypot(*elements.edge_vectors[outer].T).sum() == pytest.approx(40)
    blocks, report = read_mesh(path, blocks="regions")
    assert (blocks.count, report.notes) == (62, ())
    assert max(np.diff(blocks.offsets)) == 8


def test_corners_between_a_joint_and_none_and_between_boundaries_stay() -> None:
    blocks, _ = quads([(10, 11), (11, 12)], {"rock:gneiss": list(range(8)), "rock:schist": list(range(8, 16))})
    assert np.diff(blocks.offsets).tolist() == [5, 5]
    length = np.hypot(*blocks.edge_vectors.T)
    assert length[blocks.edge_joint == 0].tolist() == [2, 2]
    sets = {"rock:gneiss": [list(range(16)), None], "boundary:half": [None, [0, 1]]}
    blocks, _ = convert_mesh(GRID, [("quad", QUADS), ("line", [(0, 1), (1, 2)])], sets, blocks="regions")
    assert np.diff(blocks.offsets).tolist() == [5]
    assert np.hypot(*blocks.edge_vectors[blocks.boundaries["half"]].T).tolist() == [2]


def test_a_side_that_begins_in_its_middle_is_one_edge() -> None:
    """The first element of the mesh lies in the middle of the right side."""
    right = [(4, 9), (9, 14), (14, 19), (19, 24)]
    cells = [("quad", [QUADS[7], *QUADS[:7], *QUADS[8:]]), ("line", right)]
    sets = {"rock:gneiss": [list(range(16)), None], "boundary:right": [None, list(range(4))]}
    blocks, _ = convert_mesh(GRID, cells, sets, blocks="regions")
    (edge,) = blocks.boundaries["right"]
    assert blocks.vertices[edge].tolist() == [4, 0]
    assert blocks.edge_vectors[edge].tolist() == [0, 4]


def test_a_users_own_gmsh_script_gives_blocks(tmp_path: Path) -> None:
    with gmsh_session("own") as gmsh:
        occ = gmsh.model.occ
        rock = occ.addRectangle(0, 0, 0, 4, 2)
        line = occ.addLine(occ.addPoint(1, -1, 0), occ.addPoint(3, 3, 0))
        _, children = occ.fragment([(2, rock)], [(1, line)])
        occ.synchronize()
        inside = {
            tag for _, tag in gmsh.model.getBoundary([(2, t) for _, t in children[0]], combined=False, oriented=False)
        }
        joint = [tag for _, tag in children[1] if tag in inside]
        loose = [(1, tag) for _, tag in children[1] if tag not in inside]
        gmsh.model.removeEntities(loose)
        gmsh.model.mesh.setSize(gmsh.model.getEntities(0), 0.3)
        gmsh.model.mesh.generate(2)
        name_groups({"rock:granite": [tag for _, tag in children[0]], "joint:F": joint})
        write_mesh(tmp_path / "own.msh")
    blocks, _ = read_mesh(tmp_path / "own.msh", blocks="regions")
    np.testing.assert_allclose(blocks.moments.area, [4, 4])
    np.testing.assert_array_equal(np.diff(blocks.offsets), [4, 4])


def test_the_model_file_takes_regions(tmp_path: Path) -> None:
    regions = [Region(outline=box(0, 0, 2, 2), rock="gneiss")]
    joints = [JointSet(name="J1", dip=0, spacing=1, start=(0, 1))]
    write_blocks(cut_blocks(RockMass(regions=regions, joints=joints)), tmp_path / "rock.msh")
    text = '[mesh]\nfile = "rock.msh"\nblocks = "regions"\n[rock.gneiss]\nunit_weight = 26e3\n'
    text += "[joint.J1]\nnormal_stiffness = 1e9\nshear_stiffness = 1e9\nfriction = 30\n"
    text += '[[support]]\nboundary = "bottom"\nfix = "all"\n'
    (tmp_path / "model.toml").write_text(text)
    model = bsm.load(tmp_path / "model.toml")
    assert model.blocks.count == 2
    results = bsm.run(model)
    settlement = results.stages[-1].displacement[:, 1].min()
    assert settlement == pytest.approx(-(26e3 * 2) / (1e9 * 2))  # the upper block's weight over its joint's stiffness
    (tmp_path / "model.toml").write_text(text.replace("regions", "polygons"))
    with pytest.raises(ModelError, match="polygons"):
        bsm.load(tmp_path / "model.toml")
