"""Pictures of blocks with zones and of few blocks: where nodes moved to, how far arrows reach, and colours."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.quiver import Quiver

import bsm_mesh as bsm
from bsm_mesh.pictures.canvas import BOLTS, SETS, WATER
from tests.scenes.shapes import rectangle

SPAN, DEPTH = 6.0, 0.5  # m


def slab(order: int) -> bsm.Results:
    """Return a slab of zones that rests on its two lower corners, under its own weight."""
    corners = [bsm.PrescribedDisplacement(point=(x, 0), direction=90, displacement=0.0) for x in (0.0, SPAN)]
    return bsm.run(
        bsm.Model(
            blocks=bsm.Blocks.from_polygons([rectangle(0, 0, SPAN, DEPTH)], rock="rock"),
            rocks=[bsm.Rock("rock", unit_weight=26e3, young=1e9, poisson=0.2, zones=bsm.Zones(size=0.5, order=order))],
            supports=[*corners, bsm.PrescribedDisplacement(point=(0, 0), direction=0, displacement=0.0)],
        )
    )


@pytest.mark.parametrize("order", [1, 2])
def test_deformation_is_that_of_the_nodes(order: int) -> None:
    """The corners on supports stay where they are, and the slab sags between them; its mean moved off them."""
    results = slab(order)
    figure = results.plot("deformation")
    (caption,) = [text for axes in figure.axes for text in [axes.get_title(loc="left")] if "exaggerated" in text]
    factor = float(re.findall(r"exaggerated (\d+) times", caption)[0])
    drawn = [each for each in figure.axes[0].collections if isinstance(each, LineCollection)]
    points = np.concatenate([np.concatenate(each.get_segments()) for each in drawn])
    zones = results.stages[-1].zones
    assert zones is not None
    lowest = (zones.points + factor * zones.displacement)[:, 1].min()
    assert points[:, 1].min() == pytest.approx(lowest, rel=1e-9)
    assert lowest < factor * results.stages[-1].displacement[0, 1]
    for corner in ((0.0, 0.0), (SPAN, 0.0)):
        assert abs((points - corner)[np.isclose(points[:, 0], corner[0], atol=0.1), 1]).min() < 1e-9


def test_the_arrow_of_a_single_block_stays_in_the_frame() -> None:
    """It was as long as the block is large."""
    axes = slab(1).plot("displacement_arrows").axes[0]
    drawn = next(each for each in axes.collections if isinstance(each, Quiver) and each.N == 1 and each.get_cmap())
    tip = drawn.get_offsets()[0] + (drawn.U[0], drawn.V[0])
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert left < tip[0] < right
    assert low < tip[1] < high


def test_no_joint_set_has_the_colour_of_water_or_bolts() -> None:
    """The sixth set was drawn as the water table."""
    assert not set(SETS) & {WATER, BOLTS}
