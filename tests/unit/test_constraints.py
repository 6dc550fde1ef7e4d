"""Exact elimination of supports: ranks, repeated and inclined bars, prescribed displacements, contradictions."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.algebra.constraints import build_constraints
from tests.scenes.models import framed
from tests.scenes.reference import corner_row
from tests.scenes.shapes import grid, square, turned

ROCK = bsm.Rock("r", unit_weight=26e3, young=1e9, poisson=0.2)
ATOL = 1e-13


def constraints(supports, polygons=None):
    blocks = bsm.Blocks.from_polygons(grid(2, 2) if polygons is None else polygons, rock="r")
    if polygons is None:
        blocks = framed(blocks, 2, 2)
    return blocks, build_constraints(bsm.Model(blocks=blocks, rocks=[ROCK], supports=supports))


def held(supports, polygons=None):
    return constraints(supports, polygons)[1].constrained.tolist()


def test_no_supports():
    blocks, c = constraints([])
    assert len(c.block) == 0
    forces = np.arange(12.0).reshape(4, 3)
    assert_allclose(c.free_part(forces), forces)
    assert_allclose(c.expand(forces), forces)
    assert_allclose(c.reactions(forces), 0)
    assert c.number.tolist() == [-1] * blocks.count


@pytest.mark.parametrize(
    ("supports", "expected"),
    [
        ([bsm.Fixed(blocks=[0])], [3]),
        ([bsm.Fixed(blocks=[0, 0]), bsm.Fixed(blocks=[0])], [3]),
        ([bsm.Roller(blocks=[0], direction=30)], [1]),
        ([bsm.Roller(blocks=[0], direction=30), bsm.Roller(blocks=[0], direction=210)], [1]),
        ([bsm.Roller(blocks=[0], direction=30), bsm.Roller(blocks=[0], direction=31)], [2]),
        ([bsm.Fixed(point=(0, 0))], [2]),
        ([bsm.Fixed(point=(0, 0)), bsm.Roller(point=(0, 0.5), direction=90)], [2]),  # bar through the pin
        ([bsm.Fixed(point=(0, 0)), bsm.Roller(point=(0, 0.5), direction=0)], [3]),
        ([bsm.NormalRoller(boundary="bottom")], [2, 2]),
        ([bsm.Fixed(boundary="bottom")], [3, 3]),
        ([bsm.Roller(boundary="bottom", direction=0)], [1, 1]),  # two bars along one line
        ([bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="left")], [3, 2, 2]),
    ],
)
def test_rank(supports, expected):
    assert held(supports) == expected


@pytest.mark.parametrize("size", [1e-3, 0.05, 1.0, 1e3])
@pytest.mark.parametrize("offset", [0.0, 1e6, 5e6, 2e7])
def test_two_bars_along_a_turned_edge_hold_one_motion_anywhere(offset, size):
    if offset * 2e-16 > 1e-4 * size:
        pytest.skip("the coordinates themselves have no more than three digits of the block")
    polygon = turned(size * square(0, 0), 30, (offset, offset))
    ends = [bsm.Roller(point=tuple(polygon[i]), direction=30) for i in (0, 1)]
    assert held(ends, [polygon]) == [1]
    across = [bsm.Roller(point=tuple(polygon[i]), direction=120) for i in (0, 1)]
    assert held(across, [polygon]) == [2]


@pytest.mark.parametrize("degrees", [0, 30, 45, 137.3])
def test_given_displacements_satisfy_every_bar(degrees):
    supports = [
        bsm.PrescribedDisplacement(point=(0, 0), direction=degrees, displacement=3e-3),
        bsm.PrescribedDisplacement(point=(0.5, 0.25), direction=degrees + 50, displacement=-1e-3),
        bsm.PrescribedDisplacement(point=(0, 0.5), direction=degrees + 90, displacement=2e-3),
    ]
    blocks, c = constraints(supports)
    for bar in range(len(c.bars.block)):
        block = c.bars.block[bar]
        row = corner_row(blocks.moments.centroid[block], c.bars.point[bar], c.bars.direction[bar])
        assert_allclose(row @ c.prescribed[block], c.bars.value[bar], atol=1e-16)


def test_free_axes_do_not_move_the_bars():
    blocks, c = constraints([bsm.Roller(point=(0.3, 0.2), direction=25), bsm.Roller(point=(1.3, 0.2), direction=75)])
    rng = np.random.default_rng(1)
    solution = rng.normal(size=(blocks.count, 3))
    for row, block in enumerate(c.block):
        solution[block, : c.constrained[row]] = 0.0
    U = c.expand(solution)
    for bar in range(len(c.bars.block)):
        block = c.bars.block[bar]
        row = corner_row(blocks.moments.centroid[block], c.bars.point[bar], c.bars.direction[bar])
        assert_allclose(row @ U[block], 0, atol=ATOL)


def test_reactions_do_no_work_on_free_motions_and_balance_the_held_part():
    blocks, c = constraints([bsm.Roller(point=(0.3, 0.2), direction=25), bsm.Fixed(point=(2, 2))])
    forces = np.random.default_rng(2).normal(size=(blocks.count, 3))
    reactions = c.reactions(forces)
    assert_allclose(c.free_part(forces + reactions), c.free_part(forces), atol=ATOL)
    for row, block in enumerate(c.block):
        basis = c.basis[row]
        free = basis[:, c.constrained[row] :]
        assert_allclose(free.T @ reactions[block], 0, atol=ATOL)
        assert_allclose(basis[:, : c.constrained[row]].T @ (forces + reactions)[block], 0, atol=ATOL)


@pytest.mark.parametrize("fixed", [{"boundary": "bottom"}, {"blocks": [0]}, {"blocks": [0, 0]}])
def test_bar_forces_add_up_to_the_reaction(fixed):
    supports = [bsm.Fixed(**fixed), bsm.Roller(point=(0.3, 0.2), direction=25)]
    blocks, c = constraints(supports)
    reactions = c.reactions(np.random.default_rng(2).normal(size=(blocks.count, 3)))
    size = c.bar_forces(reactions)
    total = np.zeros_like(reactions)
    for bar, block in enumerate(c.bars.block):
        total[block] += size[bar] * corner_row(blocks.moments.centroid[block], c.bars.point[bar], c.bars.direction[bar])
        total[block, 2] += size[bar] * c.bars.holds_rotation[bar]
    assert_allclose(total, reactions, atol=ATOL)


def test_repeated_bars_share_evenly():
    supports = [bsm.Roller(blocks=[0], direction=90)] * 4
    blocks, c = constraints(supports)
    reactions = np.zeros((blocks.count, 3))
    reactions[0, 1] = 8.0
    assert_allclose(c.bar_forces(reactions), 2.0)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_units_do_not_weigh_the_bar_that_holds_a_rotation(scale):
    """A block held as a whole and at a corner: forces in the bars are the same in millimetres."""
    forces = np.array([[3.0, -5.0, 7.0]])
    found = []
    for size in (1.0, scale):
        supports = [bsm.Fixed(blocks=[0]), bsm.Fixed(point=(0, 0))]
        _, c = constraints(supports, [size * square(0, 0)])
        bar_forces = c.bar_forces(-forces * (1, 1, size))
        found.append(bar_forces / np.where(c.bars.holds_rotation, size, 1.0))
    assert_allclose(found[1], found[0], rtol=1e-12, atol=1e-12)
    assert np.abs(found[0]).min() > 0.1


@pytest.mark.parametrize(
    "supports",
    [
        [
            bsm.PrescribedDisplacement(blocks=[0], direction=30, displacement=0.01),
            bsm.PrescribedDisplacement(blocks=[0], direction=30, displacement=0.02),
        ],
        [bsm.Fixed(blocks=[0]), bsm.PrescribedDisplacement(point=(0.1, 0.9), direction=10, displacement=1e-6)],
        [
            bsm.PrescribedDisplacement(point=(0.0, 0.5), direction=0, displacement=0.01),
            bsm.PrescribedDisplacement(point=(1.0, 0.5), direction=0, displacement=0.02),  # would stretch the block
        ],
    ],
)
def test_contradictions_are_named(supports):
    blocks = bsm.Blocks.from_polygons([square(0, 0)], rock="r")
    message = r"block 0: support \d prescribes .* at \(.*\), which contradicts the block's other supports; remove one"
    with pytest.raises(bsm.ModelError, match=message):
        build_constraints(bsm.Model(blocks=blocks, rocks=[ROCK], supports=supports))


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 61.0])
def test_agreeing_repetitions_are_no_contradiction(degrees, offset):
    polygon = turned(square(0, 0), degrees, (offset, -offset))
    along = [bsm.PrescribedDisplacement(point=tuple(polygon[i]), direction=degrees, displacement=0.01) for i in (0, 1)]
    assert held([*along, *along], [polygon]) == [1]


def test_every_contradicting_block_is_listed():
    blocks = bsm.Blocks.from_polygons([square(0, 0), square(5, 0)], rock="r")
    supports = [bsm.PrescribedDisplacement(blocks=[0, 1], direction=0, displacement=w) for w in (0.1, 0.2)]
    with pytest.raises(bsm.ModelError) as caught:
        build_constraints(bsm.Model(blocks=blocks, rocks=[ROCK], supports=supports))
    assert len(caught.value.faults) == 2
    assert re.match("block 0: ", caught.value.faults[0])
    assert re.match("block 1: ", caught.value.faults[1])
