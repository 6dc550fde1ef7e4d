"""Pictures in Python: figures of Matplotlib, of results and of a model that was not run."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.pictures.pictures import NAMES
from bsm_mesh.pictures.plotting import as_given
from tests.scenes.openings import OPENED, opening


@pytest.fixture(scope="module")
def results():
    return bsm.run(opening(bolted=True))


def texts(figure):
    legends = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    return [figure.get_suptitle(), *(axes.get_title(loc="left") for axes in figure.axes), *legends]


def test_joints_of_a_stage(results):
    """The key has the share of the joints' length in each state."""
    told = texts(results.plot("joints", stage="dig"))
    faces = {name: share for name, share in (text.split(", ") for text in told if "of the length" in text)}
    assert set(faces) == {"sticking", "slipping", "open"}
    assert "stage dig, stable" in told[0]
    assert "initial" in texts(results.plot("joints", stage=0))[0]


def test_it_is_drawn_on_a_figure_that_is_given(results):
    figure = Figure()
    assert results.plot(figure=figure) is figure
    assert figure.axes[0].get_xlabel() == "x, m"


def test_a_window(results):
    axes = results.plot("model", window=(1, 1, 3, 2)).axes[0]
    assert (axes.get_xlim(), axes.get_ylim()) == ((1, 3), (1, 2))


@pytest.mark.parametrize(
    ("picture", "stage", "says"),
    [
        ("joint", 5, "there is no stage 5; stages are numbered 0 to 1"),
        ("joints", "digg", "there is no stage 'digg'; did you mean 'dig'"),
        ("jonts_slip", 0, "there is no picture 'jonts_slip'; did you mean 'joints_slip'"),
        ("histories", 0, "there is nothing to show in 'histories'"),
        ("history", 0, "there is no picture 'history'; did you mean 'histories'"),
        ("joints", 0.5, "there is no stage 0.5"),
        ("displacement", 0, "there is nothing to show in 'displacement' of that stage"),
    ],
)
def test_what_is_not_there(picture, stage, says):
    still = bsm.run(opening(bolted=False).replace(supports=[bsm.Fixed(blocks=range(24))]))
    with pytest.raises(ModelError, match=says):
        still.plot(picture, stage=stage)


@pytest.mark.parametrize("window", [(0, 1, 2), (3, 1, 2, 2), (0, 0, float("inf"), 1)])
def test_a_window_that_is_none(results, window):
    with pytest.raises(ModelError, match="must be X0 Y0 X1 Y1"):
        results.plot("model", window=window)


@pytest.mark.heavy
def test_every_picture_of_the_command_is_one_of_a_script(results):
    """One list for both; the charts of the bolts are of a stage, and of no part of the model."""
    nothing = {
        "histories",
        "extensometers",
        "profiles",
        "points",
        "bolts_utilisation",
    }  # none recorded; no strength used
    nothing |= {"flow_head", "flow_discharge"}  # its water has a table
    nothing |= {"zones_displacement", "zones_sigma_1", "zones_sigma_3", "zones_yielding"}  # its blocks are rigid
    nothing |= {"stereonet"}  # its blocks lie in the plane
    nothing |= {name for name in NAMES if name.startswith("shaking")}  # its stages are at rest
    assert all(results.plot(name).axes for name in NAMES if name not in nothing)
    assert [axes.get_title() for axes in results.plot("bolt_forces").axes if "B" in axes.get_title()]
    with pytest.raises(ModelError, match="bolt_forces show no part of the model"):
        results.plot("bolt_forces", window=(0, 0, 1, 1))


def test_a_stage_by_its_number_as_text(results):
    assert "stage initial" in texts(results.plot("joints", stage="0"))[0]


def test_a_model_that_was_not_run(results):
    model = opening(bolted=True)
    told = texts(model.plot())
    assert told[0] == "Opening with bolts: as given"
    assert told[1].startswith("24 blocks in the initial position")
    assert {"rock", "joint J", "fixed", "water table", "bolt with head"} <= set(told)
    histories = [bsm.History(name="roof", point=(0.5, 0.5)), bsm.History(name="rod", line=[(0.5, 0.5), (1.5, 1.5)])]
    figure = model.replace(histories=histories).plot()
    assert {"points of histories", "lines of histories"} <= set(texts(figure))
    assert {"roof", "rod"} <= {text.get_text() for text in figure.axes[0].texts}


def test_bolts_stand_in_the_pictures_of_displacement(results):
    for name in ("displacement", "displacement_arrows"):
        assert "bolt with head" in texts(results.plot(name))


def test_what_is_known_of_a_model_is_what_its_run_begins_with(results):
    given, first = as_given(results.model).stages[0], results.stages[0]
    np.testing.assert_allclose(given.loads, first.loads, atol=1e-6)
    np.testing.assert_allclose(given.water, first.water, atol=1e-6)
    np.testing.assert_array_equal(given.water_table, first.water_table)
    np.testing.assert_array_equal(given.present, first.present)
    np.testing.assert_array_equal(given.evidence.weight, first.evidence.weight)
    np.testing.assert_array_equal(given.evidence.bar_block, first.evidence.bar_block)
    np.testing.assert_array_equal(given.bolts.original, first.bolts.original)
    assert given.bolts.alive.all()


def test_blocks_that_a_stage_fills_in_are_not_there_at_first():
    model = opening(bolted=False)
    stages = (*model.stages, bsm.Stage(name="fill", fill=OPENED))
    assert as_given(model.replace(stages=stages)).stages[0].present.all()


@pytest.mark.heavy
def test_a_notebook_shows_the_figure(results):
    assert results.plot("joints")._repr_png_().startswith(b"\x89PNG")
