"""A run on its way to disk: stage by stage, killed anywhere, out of room, refused; the former results stay whole."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.arrays import content_hash
from bsm_mesh.errors import ModelError
from bsm_mesh.files import write_text
from bsm_mesh.folder.own_files import MARKER
from bsm_mesh.folder.results_folder import State
from bsm_mesh.folder.run_writer import RunWriter
from bsm_mesh.folder.storage import save_results
from bsm_mesh.modelfile.reach import BESIDE
from bsm_mesh.results import Results
from tests.file_operations import count_operations, drafts, full_disk, killed_at, names, watched
from tests.scenes.two_stages import staged

pytestmark = pytest.mark.robust

LINEAR = bsm.Options(scheme="linear")


def test_names_kept_for_runs_are_those_of_states() -> None:
    assert set(BESIDE) == {state for state in State if state}


@pytest.fixture(scope="module")
def old() -> Results:
    return bsm.run(staged(), LINEAR)


@pytest.fixture(scope="module")
def new() -> Results:
    return bsm.run(staged(2e5), LINEAR)


@pytest.fixture(scope="module")
def plain() -> Results:
    """Return new results of as few files as may be: two stages."""
    model = staged(2e5)
    return bsm.run(model.replace(bolts=(), water=None, stages=model.stages[:1]), LINEAR)


@pytest.fixture
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing waits for the disk itself: a process that dies does not take the system's memory along."""
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)


@pytest.fixture
def out(tmp_path: Path, old: Results) -> Path:
    """Return a folder with the old results, a picture of them, and a file of its user's."""
    folder = old.save(tmp_path / "out")
    (folder / "pictures").mkdir()
    (folder / "pictures/sigma_1.png").write_text("of the old")
    with (folder / MARKER).open("a") as marker:
        marker.write("pictures/sigma_1.png\n")
    (folder / "view.pvsm").write_text("mine")
    return folder


def stages_of(results: Results, number: int) -> Results:
    """Return the results as they were at the end of a stage."""
    return replace(results, stages=results.stages[:number], finished=False)


def write(folder: Path, results: Results) -> None:
    """Write results as a run does."""
    with RunWriter(folder, {"model.toml": lambda path: write_text(path, "")}) as writer:
        for number in range(1, len(results.stages) + 1):
            writer.stage(stages_of(results, number))
        writer.finish(results)


def which(folder: Path, old: Results, new: Results) -> str:
    """Return which results a reader finds, and assert that they are whole."""
    read = Results.load(folder)
    for name, results in (("old", old), ("new", new)):
        if read.model_digest == results.model_digest:
            assert [content_hash(stage) for stage in read.stages] == [content_hash(stage) for stage in results.stages]
            assert read.status == results.status == "no_verdict"
            return name
    raise AssertionError("neither the old nor the new")


EVERY = pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])  # operation of a run


def operations_of(out: Path, results: Results, swap: str, every: int) -> list[int]:
    """Return the numbers of operations of a run, the last being none; of the renaming way of those at its end.

    The last eight are all there: folders take each other's place then.
    """
    shutil.copytree(out, out.with_name("kept"))
    count = count_operations(lambda: write(out, results))
    assert count > 60
    numbers = range(1 if swap == "exchanged" else count - 15, count + 2)
    return sorted({*numbers[::every], *numbers[-8:]})


@pytest.fixture(params=["exchanged", "renamed"])
def swap(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, no_waiting: None) -> Iterator[str]:
    """Both ways to let a folder take the place of another."""
    if request.param == "renamed":
        monkeypatch.setattr("bsm_mesh.folder.results_folder.exchange", lambda one, other: False)
    elif sys.platform != "linux":
        pytest.skip("names cannot be exchanged")
    return request.param


@pytest.mark.slow
@EVERY
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes that are killed are forked")
def test_killed_at_operations(tmp_path: Path, out: Path, old: Results, plain: Results, swap: str, every: int) -> None:
    """The reader finds the old results or the new ones, finished stages are there, and the next run clears up."""
    new, numbers = plain, operations_of(out, plain, swap, every)
    found, left = [], []
    for number in numbers:
        shutil.rmtree(out)
        shutil.copytree(tmp_path / "kept", out)
        killed_at(number, lambda: write(out, new))
        found.append(which(out, old, new))
        assert (out / "view.pvsm").read_text() == "mine"
        assert (out / "pictures").exists() == (found[-1] == "old")
        assert drafts(out) == []
        left.append(0)
        if (tmp_path / "out.running/summary.json").exists() and found[-1] == "old":
            unfinished = Results.load(tmp_path / "out.running")
            left[-1] = len(unfinished.stages)
            for stage, again in zip(new.stages, unfinished.stages, strict=False):
                assert content_hash(stage) == content_hash(again)
            assert unfinished.finished or unfinished.status == "unfinished"
        write(out, new)
        assert names(tmp_path) == ["kept", "out"]
        assert (out / "view.pvsm").read_text() == "mine"
        assert which(out, old, new) == "new"
    assert found == sorted(found, reverse=True)  # the old, from some operation on the new
    assert found[-1] == "new"
    while_old = left[: found.index("new")]
    assert while_old == sorted(while_old)
    assert set(while_old) == ({0, 1, 2} if swap == "exchanged" else {2})  # every stage was there before the next


@pytest.mark.slow
@EVERY
@pytest.mark.parametrize("stays", [True, False], ids=["full from then on", "full once"])
def test_out_of_room_at_operations(
    tmp_path: Path, out: Path, old: Results, plain: Results, swap: str, stays: bool, every: int
) -> None:
    new, numbers = plain, operations_of(out, plain, swap, every)
    refused = 0
    for number in numbers[:-1]:
        shutil.rmtree(out)
        shutil.copytree(tmp_path / "kept", out)
        said = ""
        try:
            with watched(full_disk(number, stays)):
                write(out, new)
        except ModelError as error:
            said, refused = str(error), refused + 1
        if said:
            assert "No space left on device" in said
            assert "free space there" in said or "the next run into it completes this" in said
            which(out, old, new)
        else:
            assert which(out, old, new) == "new"
        assert (out / "view.pvsm").read_text() == "mine"
        assert drafts(out) == []
        for name in names(tmp_path):
            assert name in ("kept", "out", "out.interrupted", "out.running", "out.former", ".out.lock")
        write(out, new)
        assert names(tmp_path) == ["kept", "out"]
        assert drafts(tmp_path) == []
    assert refused > 30 / every or swap == "renamed"


def test_every_stage_is_on_disk_when_the_next_begins(tmp_path: Path) -> None:
    """As `bsm_mesh.run` tells of it: the folder beside is a results folder, without a verdict."""
    seen: list[tuple[int, int]] = []

    def look(record: bsm.results.StepRecord) -> None:
        there = tmp_path / "out.running"
        count = len(Results.load(there).stages) if (there / "summary.json").exists() else 0
        seen.append((record.stage, count))

    with RunWriter(tmp_path / "out") as writer:
        results = bsm.run(staged(), LINEAR, look, finished=writer.stage)
        unfinished = Results.load(tmp_path / "out.running")
        writer.finish(results)
    assert seen == [(0, 0), (1, 1), (2, 2)]
    assert unfinished.status == "unfinished"
    assert [stage.status for stage in unfinished.stages] == ["no_verdict"] * 3
    assert Results.load(tmp_path / "out").status == "no_verdict"


def test_an_interrupted_run_says_what_is_where(out: Path, old: Results, new: Results) -> None:
    def stop(record: bsm.results.StepRecord) -> None:
        if record.stage == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught, RunWriter(out) as writer:
        bsm.run(staged(2e5), LINEAR, stop, finished=writer.stage)
    left = out.with_name("out.interrupted")
    assert caught.value.__notes__ == [
        f"finished and in {left}: 2 stages (initial, first); {out} holds the former results"
    ]
    assert names(out.parent) == ["out", "out.interrupted"]
    assert which(out, old, new) == "old"
    assert (out / "pictures/sigma_1.png").exists()
    unfinished = Results.load(left)
    assert (unfinished.status, [stage.name for stage in unfinished.stages]) == ("unfinished", ["initial", "first"])
    assert json.loads((left / "summary.json").read_text())["status"] == "unfinished"
    with pytest.raises(KeyboardInterrupt), RunWriter(out):  # before its first stage: what there was stays
        raise KeyboardInterrupt
    assert len(Results.load(left).stages) == 2
    write(out, new)
    assert names(out.parent) == ["out"]


def test_a_run_that_fails_keeps_its_finished_stages(tmp_path: Path, old: Results) -> None:
    def run() -> None:
        with RunWriter(tmp_path / "out") as writer:
            writer.stage(stages_of(old, 1))
            raise ModelError("stage 'first' cannot be analysed")

    with pytest.raises(ModelError, match="cannot be analysed") as caught:
        run()
    (note,) = caught.value.__notes__
    assert note == f"finished and in {tmp_path / 'out.interrupted'}: 1 stage (initial)"
    assert names(tmp_path) == ["out.interrupted"]
    with pytest.raises(ModelError, match=r"does not exist.* that was interrupted are in .*out\.interrupted"):
        Results.load(tmp_path / "out")


def test_nothing_is_left_of_a_run_without_a_finished_stage(tmp_path: Path) -> None:
    for reason in (KeyboardInterrupt(), ModelError("no")):
        with pytest.raises(type(reason)), RunWriter(tmp_path / "deep/out"):
            raise reason
        assert names(tmp_path) == []


def test_a_second_run_into_a_folder_is_refused(tmp_path: Path, old: Results) -> None:
    with RunWriter(tmp_path / "out") as writer:
        with pytest.raises(ModelError, match=rf"out: another run .*process {os.getpid()} on .* since 20\d\d-"):
            old.save(tmp_path / "out")
        old.save(tmp_path / "other")
        writer.finish(old)
    old.save(tmp_path / "out")
    assert names(tmp_path) == ["other", "out"]


def test_another_process_is_refused_and_takes_over_from_a_dead_one(tmp_path: Path, old: Results) -> None:
    code = f"""
import os, pathlib, sys
from bsm_mesh.folder.run_writer import RunWriter
with RunWriter(pathlib.Path({str(tmp_path / "out")!r})):
    print("held", flush=True)
    sys.stdin.read()
    os._exit(9)
"""
    root = str(Path(bsm.__file__).parents[1])
    holder = subprocess.Popen(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": root}, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    with pytest.raises(ModelError, match=rf"another run writes there \(process {holder.pid} on"):
        old.save(tmp_path / "out")
    holder.communicate()
    assert names(tmp_path) == [".out.lock"]
    old.save(tmp_path / "out")
    assert names(tmp_path) == ["out"]


def test_saving_again_replaces_everything_that_was_written(out: Path, new: Results) -> None:
    assert new.save(out) == out
    assert not (out / "pictures").exists()
    assert (out / "view.pvsm").read_text() == "mine"
    bare = staged().replace(bolts=(), water=None, stages=())
    bsm.run(bare, LINEAR).save(out)
    assert not [name for name in names(out) if name.startswith(("bolts", "water")) or "_0001" in name]


def test_what_its_user_put_there_goes_along(tmp_path: Path, old: Results, new: Results, swap: str) -> None:
    folder = old.save(tmp_path / "out")
    mine = {"notes.txt": "a", "states/one.pvsm": "b", "pictures/photo.png": "c"}
    for name, text in mine.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    (folder / "link").symlink_to("notes.txt")
    (folder / "empty").mkdir()
    with RunWriter(folder) as writer:
        writer.stage(stages_of(new, 1))
        (tmp_path / "out.running/watching.pvsm").write_text("d")
        writer.finish(new)
    for name, text in {**mine, "watching.pvsm": "d"}.items():
        assert (folder / name).read_text() == text
    assert os.readlink(folder / "link") == "notes.txt"
    assert (folder / "empty").is_dir()
    assert names(tmp_path) == ["out"]


def test_a_file_of_a_results_name_that_its_user_put_there(tmp_path: Path, old: Results) -> None:
    """Told before the run, or where it came during the run with the results left beside."""
    bare = bsm.run(staged().replace(bolts=()), LINEAR)
    folder = bare.save(tmp_path / "out")
    with RunWriter(folder) as writer:
        writer.stage(stages_of(old, 1))
        (folder / "bolts.csv").write_text("mine")
        with pytest.raises(ModelError, match=r"bolts\.csv is not from a run .* new results are in .*out\.running"):
            writer.finish(old)
    assert (folder / "bolts.csv").read_text() == "mine"
    assert Results.load(tmp_path / "out.running").status == "no_verdict"
    with pytest.raises(ModelError, match=r"bolts\.csv is not from a run and would be replaced"):
        old.save(folder)
    (folder / "bolts.csv").rename(tmp_path / "bolts.csv")
    assert Results.load(folder).model_digest == bare.model_digest
    bare.save(folder)
    assert names(tmp_path) == ["bolts.csv", "out"]


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_a_folder_that_is_none_of_ours(tmp_path: Path, old: Results, kind: str) -> None:
    (tmp_path / "out").mkdir()
    if kind == "file":
        (tmp_path / "out/bolts.csv").write_text("mine")
    else:
        (tmp_path / "out/sub").mkdir()
    with pytest.raises(ModelError, match=r"out holds files and is no results folder .*\.bsm-mesh-results.*new or an"):
        old.save(tmp_path / "out")
    assert len(list(tmp_path.rglob("*"))) == 2


def test_folders_that_cannot_be_replaced(tmp_path: Path, old: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    old.save(tmp_path / "out")
    for name in ("a.running", "a.interrupted", "a.former"):
        with pytest.raises(ModelError, match="kept for runs on their way"):
            old.save(tmp_path / name)
    with pytest.raises(ModelError, match=r"a disk is mounted there"):
        old.save("/")
    monkeypatch.chdir(tmp_path / "out")
    with pytest.raises(ModelError, match="the current folder is in it; run from the folder above"):
        old.save(".")
    assert Results.load(".").status == "no_verdict"


def test_an_empty_folder_and_one_behind_a_link_are_taken(tmp_path: Path, old: Results, new: Results) -> None:
    (tmp_path / "out").mkdir(mode=0o750)
    old.save(tmp_path / "out")
    assert (tmp_path / "out").stat().st_mode & 0o777 == 0o750
    (tmp_path / "here").symlink_to("out", target_is_directory=True)
    new.save(tmp_path / "here")
    assert (tmp_path / "here").is_symlink()
    assert which(tmp_path / "out", old, new) == "new"


def test_a_reader_while_results_are_replaced_again_and_again(tmp_path: Path, old: Results, new: Results) -> None:
    """In another process: it never finds a mixture, and never nothing; at worst it says that they changed too often."""
    folder = old.save(tmp_path / "out")
    root = str(Path(bsm.__file__).parents[1])
    code = f"""
from bsm_mesh import ModelError, Results
known = {[[r.model_digest, float(r.stages[-1].displacement.sum())] for r in (old, new)]!r}
Results.load({str(folder)!r})  # imports what reading takes
print("ready", flush=True)
seen = []
while len(set(seen)) < 2 or len(seen) < 6:
    try:
        read = Results.load({str(folder)!r})
    except ModelError as error:
        assert "read them later" in str(error), error
    else:
        assert [read.model_digest, float(read.stages[-1].displacement.sum())] in known
        seen.append(read.model_digest)
"""
    reader = subprocess.Popen(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": root}, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert reader.stdout is not None
    assert reader.stdout.readline() == "ready\n"
    results = itertools.cycle((new, old))
    while reader.poll() is None:
        save_results(next(results), folder)
        time.sleep(0.05)
    assert (reader.communicate()[1], reader.returncode) == ("", 0)
