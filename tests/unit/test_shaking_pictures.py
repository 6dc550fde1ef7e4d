"""Pictures of shaken stages: which there are, and that their curves are the results'."""

import numpy as np
import pytest
from matplotlib.text import Text
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.pictures.pictures import figure_of
from bsm_mesh.pictures.shaking_pictures import NAMES
from bsm_mesh.results.shaking import ENERGIES
from tests.scenes.shaken import block_on_plane, quake, wall

NEW = ("shaking_acceleration", "shaking_displacement", "shaking_histories", "shaking_energy")


def texts_of(figure):
    return [text.get_text() for text in figure.findobj(Text)]


@pytest.fixture(scope="module")
def results():
    watched = [
        bsm.History(name="b", block=1),
        bsm.History(name="p", point=(0.5, 0.5)),
        bsm.History(name="J", joint="J"),
    ]
    return bsm.run(wall(bsm.Shaking(record=quake(4.0, 1.0), every=0.05), courses=3, bricks=2, histories=watched))


@pytest.mark.parametrize("name", NEW)
def test_only_a_shaken_stage_has_them(results, name):
    assert figure_of(results, name, stage=0) is None
    assert figure_of(results, name, stage=-1) is not None


def test_maps_show_what_the_results_say(results):
    stage = results.stages[-1]
    drawn = [each.get_array() for each in figure_of(results, "shaking_acceleration").axes[0].collections]
    (shown,) = [each for each in drawn if each is not None]
    assert_allclose(shown, stage.shaking.peak_acceleration[1:] / GRAVITY)  # the first block is the base
    assert "impacts" in " ".join(texts_of(figure_of(results, "shaking_acceleration")))
    left = figure_of(results, "shaking_displacement").axes[0].collections[0].get_array()
    moved = np.hypot(*stage.stage_displacement[:, :2].T)
    assert_allclose(left / left.max(), moved / moved.max())


def test_a_block_at_rest_after_a_long_way_is_on_the_map():
    pulse = bsm.Shaking(waveform="pulse", frequency=1, cycles=0.3, amplitude=5.0, duration=1.0, every=0.1)
    results = bsm.run(block_on_plane(pulse, friction=0.2))
    assert results.stages[-1].stage_displacement[1, 0] < -0.2  # of a block of 1 m by 0.5 m
    shown = figure_of(results, "shaking_displacement").axes[0].collections[0].get_array()
    assert_allclose(shown[1] / shown.max(), 1.0)


def test_histories_are_drawn_over_time(results):
    base, block, point, joint, *_ = figure_of(results, "shaking_histories").axes
    assert_allclose(base.lines[0].get_xdata(), results.stages[-1].shaking.time)
    timed = [step for step in results.stages[-1].steps if step.time is not None]
    for axes in (block, point, joint):
        assert_allclose(axes.lines[0].get_xdata(), [step.time for step in timed])
    drawn = block.lines[0].get_ydata()
    exact = np.array([step.recorded[0] for step in timed])
    assert_allclose(drawn / np.abs(drawn).max(), exact / np.abs(exact).max(), atol=1e-12)


def test_energies_that_there_are_have_a_curve_each(results):
    (axes,) = figure_of(results, "shaking_energy").axes
    labels = {line.get_label() for line in axes.lines}
    assert {NAMES["kinetic"], NAMES["springs"], NAMES["slip"], NAMES["error"]} <= labels
    assert NAMES["bolts"] not in labels
    curves = {line.get_label(): line.get_ydata() for line in axes.lines}
    slip = results.stages[-1].shaking.energy[:, ENERGIES.index("slip")]
    assert_allclose(curves["slip"] / curves["slip"][-1], slip / slip[-1])
