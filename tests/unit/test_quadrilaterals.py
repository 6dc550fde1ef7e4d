"""Geometries of quadrilateral blocks: areas, order of the blocks and groups, read back from the file."""

import math

import meshio
import numpy as np
import pytest

from bsm_mesh.converters import read_blocks
from bsm_mesh.geometries import brick_wall, column, dam_foundation, pushed_block, stratified_slope, voussoir_arch
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.quadrilaterals import rectangle, turn, write_quadrilaterals

gmsh = pytest.importorskip("gmsh")


def read(path):
    """Return the corners (n, 4, 2) of the blocks, and the number of elements in each group."""
    mesh = meshio.read(path)
    quads = np.concatenate([block.data for block in mesh.cells if block.type == "quad"])
    sizes = {name: sum(map(len, rows)) for name, rows in mesh.cell_sets.items() if ":" in name and "gmsh:" not in name}
    return mesh.points[quads, :2], sizes


def areas(corners):
    x, y = corners[..., 0], corners[..., 1]
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)


def test_blocks_keep_their_order_and_rocks(tmp_path):
    blocks = [rectangle(k, 0.0, k + 1.0, 1.0 + k) for k in range(4)]
    path = tmp_path / "four.msh"
    write_quadrilaterals(
        path, blocks, ["a", "b", "b", "a"], joints={"j": [(0, 1), (1, 3)]}, boundaries={"bottom": [(0, 0), (1, 0)]}
    )
    corners, groups = read(path)
    np.testing.assert_allclose(corners, blocks, atol=1e-12)
    # sides 1 of block 0 and 3 of block 1 differ in height: two lines
    assert groups == {"rock:a": 2, "rock:b": 2, "joint:j": 2, "boundary:bottom": 2}


def test_a_shared_side_is_one_line(tmp_path):
    blocks = [rectangle(0.0, 0.0, 1.0, 1.0), rectangle(1.0, 0.0, 2.0, 1.0)]
    write_quadrilaterals(tmp_path / "two.msh", blocks, ["a"], joints={"j": [(0, 1), (1, 3)]})
    assert read(tmp_path / "two.msh")[1] == {"rock:a": 2, "joint:j": 1}


def test_faults_are_collected(tmp_path):
    clockwise = ((0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0))
    with pytest.raises(GeometryError) as caught:
        write_quadrilaterals(tmp_path / "x.msh", [clockwise], ["a", "b"], joints={"j": [(0, 4)]})
    text = str(caught.value)
    assert "block 0 is not convex" in text
    assert "1 blocks and 2 rocks" in text
    assert "no side 4" in text
    assert not (tmp_path / "x.msh").exists()


def test_turned_blocks_dip_to_the_right():
    ((left, right, *_),) = turn([rectangle(0.0, 0.0, 1.0, 1.0)], 30.0)
    assert left == (0.0, 0.0)
    assert right == pytest.approx((math.cos(math.pi / 6), -0.5))


def test_pushed_block(tmp_path):
    corners, groups = read(pushed_block.build(tmp_path / "on.msh", size=1.0, gap=0.5))
    np.testing.assert_allclose(areas(corners), [3.5, 1.0, 2.0])
    assert corners[2, :, 0].min() - corners[1, :, 0].max() == pytest.approx(0.5)
    assert groups == {"rock:rock": 3, "joint:joint": 12, "boundary:base": 1}
    apart, _ = read(pushed_block.build(tmp_path / "off.msh", gap=2.5, separation=2.0))
    assert apart[2, :, 0].min() - apart[0, :, 0].max() == pytest.approx(2.0)


def test_brick_wall(tmp_path):
    corners, groups = read(brick_wall.build(tmp_path / "wall.msh", courses=3, bricks=4))
    assert len(corners) == 1 + 4 + 5 + 4
    np.testing.assert_allclose(areas(corners)[1:].sum(), 3 * 4 * 0.5)
    np.testing.assert_allclose(areas(corners)[5:10], [0.25, 0.5, 0.5, 0.5, 0.25])
    assert set(groups) == {"rock:rock", "joint:bed", "joint:head", "boundary:base"}


@pytest.mark.parametrize("count", [2, 7, 16])
def test_arch(tmp_path, count):
    corners, groups = read(voussoir_arch.build(tmp_path / "arch.msh", count=count, radius=2.0, thickness=0.3))
    expected = 0.5 * math.sin(math.pi / count) * (2.15**2 - 1.85**2)
    np.testing.assert_allclose(areas(corners)[2:], expected)
    assert groups["boundary:base"] == 2


@pytest.mark.parametrize("dip", [0.0, 25.0])
def test_column(tmp_path, dip):
    corners, _ = read(column.build(tmp_path / "column.msh", count=3, width=1.0, height=2.0, dip=dip))
    np.testing.assert_allclose(areas(corners)[1:], 2.0)
    np.testing.assert_allclose(corners[1, 1], 0.0, atol=1e-12)
    base = corners[0, 2] - corners[0, 3]
    assert math.degrees(math.atan2(-base[1], base[0])) == pytest.approx(dip)


def test_stratified_slope(tmp_path):
    path = stratified_slope.build(tmp_path / "slope.msh", dip=30.0, layers=3, blocks=4, gap=2.0, step=0.5)
    corners, groups = read(path)
    assert len(corners) == 1 + 3 + 12
    np.testing.assert_allclose(areas(corners)[4:], 2.0)
    lower, upper = corners[[7, 15]], corners[[1, 3]]  # the last block of the lowest and highest layer, and their toes
    gaps = np.linalg.norm(upper[:, 0] - lower[:, 1], axis=1)
    np.testing.assert_allclose(gaps, [2.0, 3.0])
    assert groups["boundary:right"] == 4
    assert set(groups) >= {"joint:set1", "joint:set2", "boundary:base", "boundary:left"}


def test_stratified_slope_down_to_a_floor(tmp_path):
    corners, groups = read(stratified_slope.build(tmp_path / "slope.msh", dip=30.0, gap=2.0, floor=10.0))
    assert len(corners) == 2 + 12
    foot = [2.0 * math.cos(math.pi / 6), -1.0]  # 2 m down the face
    np.testing.assert_allclose(corners[0, 2], foot)
    np.testing.assert_allclose(corners[1, 2:], [[foot[0] + 10.0, -1.0], foot])
    np.testing.assert_allclose(areas(corners)[2:], 2.0)
    assert groups["boundary:base"] == 2


def test_stratified_slope_of_layers_throughout(tmp_path):
    """Both sets run through all rock; the outline, and the layers over the face, are those of the slope on a floor."""
    sizes = {"dip": 30.0, "layers": 2, "blocks": 4, "length": 3.0, "gap": 3.0, "floor": 10.0}
    path = stratified_slope.build(tmp_path / "slope.msh", **sizes, layered=True)
    blocks = read_blocks(path, blocks="regions")
    corners, _ = read(stratified_slope.build(tmp_path / "floor.msh", **sizes))
    assert blocks.moments.area.sum() == pytest.approx(areas(corners).sum())
    np.testing.assert_allclose(blocks.vertices.min(axis=0), corners.min(axis=(0, 1)))
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    x, y = blocks.moments.centroid.T
    over = (s * x + c * y > 0) & (c * x - s * y < 0)
    assert over.sum() == 8
    np.testing.assert_allclose(blocks.moments.area[over], 3.0)
    assert blocks.count > 60
    assert set(blocks.boundaries) == {"base", "left", "right", "ground"}
    lengths = np.hypot(*blocks.edge_vectors.T)
    assert lengths.min() > 0.4


def test_dam_foundation(tmp_path):
    path = dam_foundation.build(
        tmp_path / "dam.msh", upstream=2, downstream=3, under=2, beds=2, thickness=5.0, dip=60.0
    )
    corners, groups = read(path)
    assert len(corners) == 1 + 7 + 5
    foot, rock = 32.0 + 26.0 / 40.0 * 5.0, corners[1:]  # the downstream face continues through the upper bed
    np.testing.assert_allclose(areas(corners)[0], 45.0 * (foot + 6.0) / 2)
    width = np.ptp(rock[:, :, 0])
    np.testing.assert_allclose(areas(rock).sum(), width * 10.0 - 5.0 * (foot + 32.0) / 2)
    np.testing.assert_allclose(areas(corners)[2:7], 16.0 * 5.0)  # the inner blocks of the lower bed
    assert groups["boundary:bottom"] == 7
    assert groups["boundary:left"] == groups["boundary:right"] == 2
    assert {"joint:contact", "joint:bedding", "joint:cross", "rock:concrete", "rock:rock"} <= set(groups)
    assert groups["joint:contact"] == 3
    np.testing.assert_allclose(corners[8, 1, 0] - corners[8, 2, 0], 5.0 / math.tan(math.radians(60)))
    toe = corners[10]  # a wedge: wider above than below
    np.testing.assert_allclose(toe[[0, 3], 0], [foot, 32.0])
    np.testing.assert_allclose(toe[[1, 2], 0], [foot + 3.0, foot + 3.0 + 5.0])


@pytest.mark.parametrize(
    ("case", "parameters", "words"),
    [
        (pushed_block, {"separation": 1.0}, "exceeds gap"),
        (column, {"count": 0, "dip": 90.0}, "count = 0"),
        (brick_wall, {"bricks": 2.5, "colour": 1}, "no parameter 'colour'"),
        (voussoir_arch, {"thickness": 3.0}, "twice radius"),
        (stratified_slope, {"step": -1.0}, "step = -1.0"),
        (stratified_slope, {"dip": 90.0, "floor": 5.0}, "below 90 degrees"),
        (stratified_slope, {"layered": True}, "layered = true without a floor"),
        (dam_foundation, {"dip": 10.0, "beds": 0}, "beds = 0"),
    ],
)
def test_bad_parameters(tmp_path, case, parameters, words):
    with pytest.raises(GeometryError, match=words):
        case.build(tmp_path / "x.msh", **parameters)
