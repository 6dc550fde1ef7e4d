"""Snapshots of a movement: what is written, how many, and what pictures make of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.result_files import SERIES, corner_displacement
from bsm_mesh.converters.vtk_files import read_pvd, read_vtu
from bsm_mesh.folder.frames import frames_in
from bsm_mesh.folder.run_writer import RunWriter
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.pictures.animation import draw_step
from bsm_mesh.results import Results
from bsm_mesh.results.check import block_residuals
from bsm_mesh.results.records import StepRecord
from tests.file_operations import watched
from tests.scenes.models import model_of
from tests.scenes.shaken import block_on_plane, quake
from tests.scenes.shapes import rectangle

pytestmark = pytest.mark.robust

MOVING = bsm.Options(scheme="continuation")


def pushed() -> bsm.Model:
    """Return a block that is pushed over 0.5 m to a wall."""
    polygons = [rectangle(0, -1, 4, 0), rectangle(0.5, 0, 1.5, 1), rectangle(2, 0, 3, 1)]
    return model_of(
        polygons, friction=30, fixed=(0, 2), loads=[bsm.PointLoad(block=1, point=(0.5, 0.3), force=(30e3, 0))]
    )


def run_with_snapshots(folder: Path, model: bsm.Model | None = None) -> Results:
    with RunWriter(folder, steps=True) as writer:
        results = bsm.run(model or pushed(), MOVING, snapshot=writer.step, finished=writer.stage)
        writer.finish(results)
    return results


def test_times_of_a_shaken_stage_are_seconds(tmp_path: Path) -> None:
    """Before it the steps run up to 0, after it each adds 1."""
    shaking = bsm.Shaking(record=quake(4.0, 1.0), every=0.1)
    results = run_with_snapshots(tmp_path, block_on_plane(shaking, friction=0.2))
    first, last = results.stages
    rest = [step for step in last.steps if step.time is None]
    before, after = len(first.steps), len(rest)
    exact = [*range(1 - before, 1), *(0.1 * np.arange(1, 11)), *(1.0 + np.arange(1, after + 1))]
    for kind in SERIES:
        np.testing.assert_allclose([time for time, _ in read_pvd(tmp_path / f"{kind}.pvd")], exact, atol=1e-12)
    frames = frames_in(SavedResults(tmp_path))
    assert [frame.steps for frame in frames] == list(range(1, before + len(last.steps) + 1))
    assert draw_step(tmp_path, before + 3).name == f"position_{before + 3:05d}.png"


def test_every_step_is_in_the_series(tmp_path: Path) -> None:
    results = run_with_snapshots(tmp_path)
    steps = results.stages[0].steps
    for kind in SERIES:
        entries = read_pvd(tmp_path / f"{kind}.pvd")
        assert [time for time, _ in entries] == list(range(1, len(steps) + 1))
        assert sorted(tmp_path.glob(f"{kind}_*.vtu")) == sorted(path for _, path in entries)
        arrays = [set(read_vtu(path).cell_data) for _, path in entries]
        assert arrays.count(arrays[0]) == len(arrays)
    for (_, file), step in zip(read_pvd(tmp_path / "blocks.pvd"), steps, strict=True):
        moved = np.linalg.norm(read_vtu(file).cell_data["displacement"], axis=1).max()
        assert moved == pytest.approx(step.max_displacement, abs=1e-12)
    assert steps[-1].max_displacement == pytest.approx(0.5, abs=1e-3)


def test_results_come_back_from_among_snapshots(tmp_path: Path) -> None:
    results = run_with_snapshots(tmp_path)
    back = Results.load(tmp_path)
    np.testing.assert_array_equal(back.stages[0].displacement, results.stages[0].displacement)
    np.testing.assert_array_equal(back.stages[0].contacts.normal_force, results.stages[0].contacts.normal_force)
    assert back.status == "stable"


def test_a_snapshot_is_the_state_of_its_step() -> None:
    """Its forces have the residual of the record."""
    model, seen = pushed(), []

    def look(record: StepRecord, results: object) -> None:
        now = results()  # type: ignore[operator]
        (stage,) = now.stages
        seen.append(record.step)
        assert stage.status == "not_converged"
        assert len(stage.steps) == record.step + 1
        out = np.abs(block_residuals(now, stage)).max() / stage.reference_weight
        assert out == pytest.approx(record.residual, rel=1e-6, abs=1e-9)

    results = bsm.run(model, MOVING, snapshot=look)
    assert seen == [step.step for step in results.stages[0].steps]


def test_looking_changes_nothing() -> None:
    plain = bsm.run(pushed(), MOVING).stages[0]
    watched = bsm.run(pushed(), MOVING, snapshot=lambda record, results: results()).stages[0]
    np.testing.assert_array_equal(plain.displacement, watched.displacement)


@pytest.mark.parametrize("most", [4, 5, 8])
def test_their_number_is_bounded_and_they_stay_evenly_spread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    monkeypatch.setattr("bsm_mesh.folder.snapshots.MOST_SNAPSHOTS", most)
    results = run_with_snapshots(tmp_path)
    count = len(results.stages[0].steps)
    assert count > most
    times = [time for time, _ in read_pvd(tmp_path / "blocks.pvd")]
    assert times[-1] == count
    assert most // 2 <= len(times) <= most
    assert len(set(np.diff(times[:-1]))) == 1
    assert len(list(tmp_path.glob("contacts_*.vtu"))) == len(times)


def test_a_run_without_snapshots_removes_those_of_an_earlier_one(tmp_path: Path) -> None:
    run_with_snapshots(tmp_path)
    bsm.run(pushed(), MOVING).save(tmp_path)
    assert [(time, path.name) for time, path in read_pvd(tmp_path / "blocks.pvd")] == [(0, "blocks_0000.vtu")]
    assert len(list(tmp_path.glob("*_0000*.vtu"))) == len(SERIES)


def test_an_interrupted_run_leaves_its_movement_beside_the_former_results(tmp_path: Path) -> None:
    run_with_snapshots(tmp_path / "out")

    def stop(record: StepRecord) -> None:
        if record.step == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught, RunWriter(tmp_path / "out", steps=True) as writer:
        bsm.run(pushed(), MOVING, stop, snapshot=writer.step, finished=writer.stage)
    (note,) = caught.value.__notes__
    left = tmp_path / "out.interrupted"
    assert note.startswith(f"no stage was finished; the movement up to step 3 is in {left}; {tmp_path / 'out'} holds")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "out.interrupted"]
    assert Results.load(tmp_path / "out").status == "stable"
    entries = read_pvd(left / "blocks.pvd")
    assert [time for time, _ in entries] == [1, 2, 3]
    for _, path in entries:
        grid = read_vtu(path)
        moved = np.column_stack([grid.cell_data["displacement"][:, :2], grid.cell_data["rotation"]])
        corners = grid.point_data["displacement"][:, :2]
        np.testing.assert_allclose(corners, corner_displacement(pushed().blocks, moved), atol=1e-15)


def test_a_run_can_be_followed_beside_its_folder(tmp_path: Path) -> None:
    """What ParaView has open while it runs: whole files, the steps so far."""
    seen: list[int] = []

    def look(record: StepRecord) -> None:
        if record.step:
            seen.append(len(read_pvd(tmp_path / "out.running/blocks.pvd")))

    with RunWriter(tmp_path / "out", steps=True) as writer:
        results = bsm.run(pushed(), MOVING, look, snapshot=writer.step, finished=writer.stage)
        writer.finish(results)
    assert seen == list(range(1, len(results.stages[0].steps)))
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.slow
def test_finished_stages_can_be_read_at_every_operation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also while snapshots go that the summary on disk still lists: to bound their number, and at the end."""
    monkeypatch.setattr("bsm_mesh.folder.snapshots.MOST_SNAPSHOTS", 4)
    wall = replace(pushed().blocks, excavations={"wall": np.array([2], np.int32)})
    model = pushed().replace(blocks=wall, stages=(bsm.Stage(name="taken away", excavate=("wall",)),))
    place, finished, gone = tmp_path / "out.running", 0, 0

    def look(operation: str, path: str, *_: str) -> None:
        nonlocal gone
        if finished and place.is_dir():
            gone += operation == "remove" and Path(path).name.startswith("blocks_0000_")
            assert len(Results.load(place).stages) >= finished

    def finish(results: Results) -> None:
        nonlocal finished
        writer.stage(results)
        finished = len(results.stages)

    with watched(look), RunWriter(tmp_path / "out", steps=True) as writer:
        writer.finish(bsm.run(model, MOVING, snapshot=writer.step, finished=finish))
    assert finished == 2
    assert gone >= 2
    assert len(Results.load(tmp_path / "out").stages) == 2


@pytest.mark.slow
def test_stages_follow_each_other_in_time(tmp_path: Path) -> None:
    """Block 2 is taken away: the block that leant on it slides on and off the base."""
    wall = replace(pushed().blocks, excavations={"wall": np.array([2], np.int32)})
    model = pushed().replace(blocks=wall, stages=(bsm.Stage(name="taken away", excavate=("wall",)),))
    results = run_with_snapshots(tmp_path, model)
    first, second = (len(stage.steps) for stage in results.stages)
    entries = dict(read_pvd(tmp_path / "blocks.pvd"))
    assert max(entries) == first + second
    assert entries[first].name == "blocks_0000.vtu"
    assert entries[first + second].name == "blocks_0001.vtu"
    assert entries[first + 1].name == "blocks_0001_00000.vtu"
    x = [read_vtu(path).cell_data["displacement"][1, 0] for _, path in sorted(entries.items())]
    assert (np.diff(x) > -1e-3).all()
    assert list(Results.load(tmp_path).stages[1].displacement[1]) == list(results.stages[1].displacement[1])
