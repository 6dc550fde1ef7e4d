"""Slivers merged and corners snapped: nothing but what is reported changes."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes.block_files import write_polygons
from bsm_mesh.converters.meshes.conform import conforming
from bsm_mesh.converters.meshes.repair import repair_blocks, snap_corners
from bsm_mesh.geometries import cut_blocks, write_blocks
from bsm_mesh.text.quality import Thresholds, poor_blocks
from tests.scenes import shapes
from tests.scenes.networks import rock
from tests.scenes.small_case import Case


def slivers(blocks: bsm.Blocks) -> np.ndarray:
    return np.asarray(poor_blocks(blocks, Thresholds())["thin"])


def made(*polygons: np.ndarray) -> bsm.Blocks:
    return bsm.Blocks.from_polygons(polygons, rock="granite")


SQUARES = (
    shapes.SQUARE,
    shapes.rectangle(0, 1, 1, 1.01),
    shapes.rectangle(0, 1.01, 0.5, 2),
    shapes.rectangle(0.5, 1.01, 1, 2),
)


def test_a_sliver_goes_across_its_longest_edge() -> None:
    mended = repair_blocks(made(*SQUARES), slivers)
    np.testing.assert_allclose(mended.blocks.moments.area, [1.01, 0.495, 0.495])
    assert np.diff(mended.blocks.offsets).tolist() == [4, 4, 4]  # corners on straight sides are gone
    (change,) = mended.changes
    assert change == "block 1 (0.01 m2, near (0.5, 1.005)) is merged into block 0 across 1 m without a joint"


def test_a_joint_is_given_up_only_on_request() -> None:
    blocks = made(*SQUARES).with_joint("J1", lambda x, y: y > 0.9)
    kept = repair_blocks(blocks, slivers)
    assert kept.blocks.count == 4
    assert kept.changes == (
        "1 slivers are left: no neighbour of their rock across an edge without a joint; "
        "--across-joints gives up joints",
    )
    mended = repair_blocks(blocks, slivers, across_joints=True)
    assert mended.blocks.count == 3
    assert mended.changes[0].endswith("across 1 m of joint 'J1'")
    half = made(*SQUARES).with_joint("J1", lambda x, y: np.abs(y - 1) < 1e-3)  # below the sliver only
    mended = repair_blocks(half, slivers, across_joints=True)
    np.testing.assert_allclose(sorted(mended.blocks.moments.area), [0.495, 0.505, 1])


def test_rocks_and_excavations_are_never_mixed() -> None:
    blocks = bsm.Blocks.from_polygons(SQUARES[:2], rock=["granite", "schist"])
    assert repair_blocks(blocks, slivers, across_joints=True).blocks.count == 2


def test_a_sliver_keeps_to_its_excavation() -> None:
    blocks = dataclasses.replace(made(*SQUARES), excavations={"1": np.array([0])})
    mended = repair_blocks(blocks, slivers)
    np.testing.assert_allclose(sorted(mended.blocks.moments.area), [0.495, 0.505, 1])


def test_a_sliver_stays_where_a_hole_would_arise() -> None:
    around = np.array([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)])
    mended = repair_blocks(made(around, shapes.rectangle(1, 1, 2, 3), shapes.rectangle(0, 3, 3, 3.03)), slivers)
    assert mended.blocks.count == 3
    assert mended.changes[0].startswith("1 slivers are left")


def test_near_corners_become_one() -> None:
    blocks = made(shapes.SQUARE, np.array([(1.002, 0.0), (2, 0), (2, 1), (1, 1.001)]))
    snapped, changes = snap_corners(blocks, 0.01)
    assert len(changes) == 2
    assert "moved by 0.002 m at most" in changes[0]
    assert len(snapped.edge_table.pairs()[0]) == 1
    gone, changes = snap_corners(made(shapes.SQUARE, shapes.rectangle(1, 0, 1.001, 0.001)), 0.01)
    assert gone.count == 1
    assert any("block 1" in change and "vanishes" in change for change in changes)


def test_snapped_corners_go_to_the_boundary() -> None:
    blocks = made(np.array([(0, 0.003), (2, 0.003), (1, 2)]), shapes.rectangle(0, -1, 2, 0))
    blocks = blocks.with_boundary("ground", lambda x, y: y == 0)
    snapped, _ = snap_corners(blocks, 0.01)
    assert snapped.vertices[snapped.boundaries["ground"]].tolist() == [[2, 0]]
    assert snapped.moments.area.tolist() == [2, 2]


def test_corners_in_the_middle_of_edges_are_put_in() -> None:
    blocks = made(shapes.rectangle(0, 0, 2, 1), shapes.square(0, 1), shapes.square(1, 1))
    blocks = blocks.with_joint("bed", lambda x, y: y == 1).with_boundary("base", lambda x, y: y == 0)
    fine = conforming(blocks)
    assert np.diff(fine.offsets).tolist() == [5, 4, 4]
    assert not fine.edge_table.unpaired()[fine.edge_joint >= 0].any()
    np.testing.assert_allclose(fine.moments.area, blocks.moments.area)
    assert fine.vertices[fine.boundaries["base"]].tolist() == [[0, 0]]


def test_polygons_are_read_back_as_they_were_written(tmp_path: Path) -> None:
    lines = [[(-1, 2), (11, 5)], [(3, -1), (4, 11)], [(6, -1), (5, 11)]]
    blocks, _ = read_mesh(write_blocks(cut_blocks(rock(*lines)), tmp_path / "a.msh"), blocks="regions")
    back, report = read_mesh(write_polygons(blocks, tmp_path / "a.vtu"))
    assert report.notes == ()
    np.testing.assert_array_equal(back.vertices, blocks.vertices)
    np.testing.assert_array_equal(back.offsets, blocks.offsets)
    assert back.rock_names == blocks.rock_names
    names = [
        [joints[k] if k >= 0 else "" for k in of.edge_joint]
        for joints, of in ((back.joint_names, back), (blocks.joint_names, blocks))
    ]
    assert names[0] == names[1]
    for name, edges in blocks.boundaries.items():
        np.testing.assert_array_equal(back.boundaries[name], edges)
    with pytest.raises(bsm.ModelError, match=r"ends in \.vtu"):
        write_polygons(blocks, tmp_path / "a.msh")


def test_check_draws_and_mends(case: Case) -> None:
    model = (case.folder / "model.toml").read_text()
    outcome = case.run("check", "model.toml", "--picture", "q.png", "--repair", "fixed.vtu", "--threshold", "tiny=2")
    assert outcome.code == 0
    assert set(outcome.new) >= {"q.png", "fixed.vtu"}
    assert "is merged into block" in outcome.out
    assert "written: fixed.vtu: the repaired blocks as a mesh (VTU), a cell each" in outcome.out
    assert 'to use it: [mesh] file = "fixed.vtu", blocks = "elements"' in outcome.out
    case.write("model.toml", model.replace("mesh.msh", "fixed.vtu"))
    report = json.loads(case.run("check", "model.toml", "--json").out)
    assert report["blocks"] < 4
    assert report["total_area"] == pytest.approx(4)
