"""Blocks that fall while the others stay: too small to count, or taken away as a roof is scaled."""

import dataclasses

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.commands.cli import main
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.folder.verify import grounds_in, print_grounds
from bsm_mesh.pages.view_data import read_view
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.results.joint_sets import joint_sets
from bsm_mesh.results.movement import verdict_in_words
from bsm_mesh.text.tables import fall_rows
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

PUSH = bsm.PointLoad(block=0, point=(-1, -0.5), force=(0, -1))
LEDGE, SHELF = rectangle(-4, -1, 0, 0), rectangle(-4, -6, 8, -5)


def overhanging(width, **given):
    """Return a ledge with a block on it, and beside it one of a width that nothing carries, far above a shelf."""
    polygons = [LEDGE, SHELF, rectangle(-2, 0, -1, 1), rectangle(0, -1, width, -1 + width)]
    return model_of(polygons, fixed=(0, 1), **given)


def test_a_sliver_that_comes_loose_does_not_decide():
    results = bsm.run(overhanging(0.05))
    (stage,) = results.stages
    assert (results.status, list(stage.unstable_blocks)) == ("stable", [])
    (fall,) = stage.falls
    assert (fall.block, fall.ignored) == (3, True)
    assert (fall.area, fall.weight) == pytest.approx((0.05**2, 0.05**2 * 25e3))
    assert 0.005 < fall.moved < 1.0
    assert fall.place[1] < -1 + 0.025
    assert list(stage.present) == [True, True, True, False]
    assert "too small to count: 1 block of 0.0025 m2 in all (falls.ignore_below): block 3" in stage.notes[-1]


def test_the_log_of_a_sliver_that_falls_names_no_instability():
    said: list[str] = []
    bsm.run(overhanging(0.05), report=said.append)
    assert "small blocks fall: 1 block taken away, the run continues" in said
    assert not [line for line in said if line.startswith("unstable")]


@pytest.mark.parametrize(("width", "share"), [(0.05, 0.0), (0.2, 0.01)])
def test_a_block_that_counts_makes_the_stage_unstable(width, share):
    results = bsm.run(overhanging(width), bsm.Options(falls=bsm.Falls(ignore_below=share)))
    assert (results.status, list(results.unstable_blocks)) == ("unstable", [3])
    assert results.stages[0].falls == ()
    area = results.blocks.moments.area
    verdict = f"unstable, 1 block falls: {100 * area[3] / area.sum():.2g} % of the area"
    assert verdict_in_words(results.blocks, results.stages[0]) == verdict


@pytest.mark.parametrize(("width", "ignored"), [(0.05, 0.01), (0.2, 0.08), (0.5, None)])
def test_a_fall_that_ends_a_run_has_the_keys_that_give_the_verdict_on_the_others(width, ignored):
    model = overhanging(width)
    (note,) = bsm.run(model, bsm.Options(falls=bsm.Falls(ignore_below=0.0))).stages[0].notes
    assert note.startswith("the fall of block 3 ended the run, and the other blocks have no verdict; with on_fall = ")
    assert (f"with ignore_below = {ignored} chips of this size do not count" in note) == (ignored is not None)
    others = {"on_fall": "remove"} if ignored is None else {"ignore_below": ignored}
    followed = bsm.run(model, bsm.Options(falls=bsm.Falls(**others))).stages[0]
    assert followed.status.is_stable
    assert not [text for text in followed.notes if "no verdict" in text]


@pytest.mark.heavy
def test_what_comes_down_is_taken_away_and_stage_after_stage_goes_on(tmp_path):
    dug = [
        bsm.Stage(name="dug", excavate=(2,)),
        bsm.Stage(name="left", loads=[PUSH]),
    ]
    results = bsm.run(overhanging(0.5, stages=dug), bsm.Options(falls=bsm.Falls(on_fall="remove")))
    assert [stage.status for stage in results.stages] == ["stable_after_falls", "stable", "stable"]
    assert results.status == "stable"
    verdicts = [verdict_in_words(results.blocks, stage) for stage in results.stages]
    assert verdicts == ["stable, after 1 block fell", "stable", "stable"]
    (fall,) = results.stages[0].falls
    assert (fall.block, fall.ignored, fall.reason) == (3, False, "a block has lost all contact and moves freely")
    assert fall.origin == pytest.approx((0.25, -0.75))
    assert np.hypot(*np.subtract(fall.place, fall.origin)) == pytest.approx(fall.moved)
    assert fall_rows(results)[0][2] == "(0.25, -0.75) m"
    assert [list(np.flatnonzero(~stage.present)) for stage in results.stages] == [[3], [2, 3], [2, 3]]
    results.save(tmp_path / "out")
    again = bsm.Results.load(tmp_path / "out")
    assert again.stages[0].falls == results.stages[0].falls
    assert [stage.status for stage in again.stages] == [stage.status for stage in results.stages]
    assert bsm.run(tmp_path / "out" / "model.toml", output=tmp_path / "again").stages[0].falls[0].block == 3


@pytest.mark.slow
def test_results_are_read_after_a_block_was_removed_in_the_first_stage(tmp_path, drawn_here):
    """The numbers of blocks are permanent; the last one keeps its own after block 1 was removed."""
    polygons = [LEDGE, rectangle(0, -1, 0.5, -0.5), SHELF, rectangle(-2, 0, -1, 1)]
    model = model_of(polygons, fixed=(0, 2))
    results = bsm.run(model, bsm.Options(falls=bsm.Falls(on_fall="remove")))
    assert [fall.block for fall in results.stages[0].falls] == [1]
    again = bsm.Results.load(results.save(tmp_path / "out"))
    np.testing.assert_array_equal(again.blocks.vertices, model.blocks.vertices)
    np.testing.assert_array_equal(again.stages[0].displacement, results.stages[0].displacement)
    assert list(again.stages[0].present) == [True, False, True, True]
    for command in ("report", "view", "paraview"):
        main([command, str(tmp_path / "out")])
    assert print_grounds(grounds_in(tmp_path / "out"), as_json=False) == 0


@pytest.mark.heavy
def test_blocks_slide_on_when_one_beside_them_is_taken_away():
    """A square on a plane steeper than its friction, with a sliver that it carries and loses on its way."""
    sliver = rectangle(0.5, 0.9, 0.55, 0.95)
    polygons = [turned(p, 40.0) for p in (rectangle(-60, -5, 5, 0), rectangle(-0.5, 0, 0.5, 1), sliver)]
    results = bsm.run(model_of(polygons, friction=20.0))
    (stage,) = results.stages
    assert (results.status, list(results.unstable_blocks)) == ("unstable", [1])
    assert [fall.block for fall in stage.falls] == [2]
    start = [step.max_displacement for step in stage.steps]
    assert min(np.diff(start)) > -1e-3, "what moved before moves on"


def test_a_chip_that_slides_to_a_stop_is_in_a_note_and_in_no_headline(tmp_path):
    """Beside a block at rest a chip slides .1 m down a plane to a wall: five times its own size."""
    ramp = rectangle(-4, -1, 8, 0)
    polygons = [ramp, rectangle(-3, 0, -2, 1), rectangle(3, 0, 4, 1), rectangle(4.1, 0, 4.12, 0.02)]
    law = [bsm.MohrCoulomb(friction=friction) for friction in (60.0, 10.0)]
    model = model_of([turned(polygon, 30.0) for polygon in polygons], fixed=(0, 2), law=law[0])
    slippery = bsm.Joint("slippery", 1e9, 1e9, law=law[1])
    joint = np.full(16, -1)
    joint[12:] = 0
    blocks = dataclasses.replace(model.blocks, edge_joint=joint, joint_names=("slippery",))
    results = bsm.run(model.replace(blocks=blocks, joints=(*model.joints, slippery)))
    (stage,) = results.stages
    moved = np.hypot(*stage.stage_displacement[:, :2].T)
    assert moved[3] == pytest.approx(0.1, rel=0.01)
    assert (list(stage.small_blocks), verdict_in_words(results.blocks, stage)) == ([3], "stable")
    assert stage.max_displacement == pytest.approx(moved[1])
    assert moved[1] < 1e-3
    assert "1 block too small to count (falls.ignore_below) moved by up to 0.1 m: block 3" in stage.notes
    by_name = {one.name: one for one in joint_sets(results, stage)}
    assert by_name["slippery"].greatest_slip == 0  # no face but the chip's
    assert by_name["slippery"].slip > 0.01  # its mean has it
    assert list(Scene(results=results, number=0, title="").strays) == [False, False, False, True]
    again = bsm.Results.load(results.save(tmp_path / "out"))
    assert again.stages[0].max_displacement == stage.max_displacement
    assert stage.steps[-1].max_displacement == pytest.approx(stage.max_displacement)  # of the progress lines
    everything = bsm.run(results.model, bsm.Options(falls=bsm.Falls(ignore_below=0.0)))
    assert verdict_in_words(everything.blocks, everything.stages[0]).startswith("stable, after 1 block moved by 0.1 m")


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"ignore_below": -0.1}, "ignore_below"),
        ({"ignore_below": 0.5}, "ignore_below"),
        ({"on_fall": "continue"}, "on_fall"),
    ],
)
def test_what_cannot_be_meant_is_refused(given, fault):
    with pytest.raises(bsm.ModelError, match=fault):
        bsm.Falls(**given)


@pytest.mark.heavy
@pytest.mark.parametrize("on_fall", ["stop", "remove"])
def test_where_every_block_that_is_left_falls_the_stage_is_unstable(tmp_path, on_fall):
    """A stage takes the only block that is held: nothing would be left without the other one. The page knows it too."""
    stages = [bsm.Stage(name="dig", excavate=[0])]
    model = model_of([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)], stages=stages)
    results = bsm.run(model, bsm.Options(falls=bsm.Falls(on_fall=on_fall)))
    assert (results.status, results.unstable_blocks.tolist()) == ("unstable", [1])
    results.save(tmp_path / "out")
    last = read_view(SavedResults(tmp_path / "out")).states[-1]
    assert last.frame.label == "stage dig: unstable, 1 block falls: 100 % of the area"
