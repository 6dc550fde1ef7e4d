"""A run that is resumed ends as the one that was not interrupted, bit for bit, however often it is killed."""

from __future__ import annotations

import os
import shutil
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.folder import checkpoints, snapshots
from bsm_mesh.folder.checkpoint_file import write_checkpoint
from bsm_mesh.folder.own_files import CHECKPOINT
from bsm_mesh.modelfile.model_text import files_of_model
from bsm_mesh.solve.algebra import pardiso
from bsm_mesh.solve.algebra.pardiso import Pardiso, is_available
from bsm_mesh.solve.step.factorization import Factors
from tests.file_operations import count_operations, full_disk, killed_at, names
from tests.scenes.interrupted import copies_of, fails, interrupted, stop, whole_run
from tests.scenes.large import tilted_courses
from tests.scenes.large_zones import pushed
from tests.scenes.meeting_zones import beside
from tests.scenes.model_folders import content, put_model
from tests.scenes.models import model_of
from tests.scenes.quiet import on_quiet_base
from tests.scenes.shaken import block_on_plane, quake
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import tree
from tests.scenes.steps import begun
from tests.unit.test_zones import BOLT, CASES, GNEISS, RIGID, wall

pytestmark = [pytest.mark.robust, pytest.mark.filterwarnings("ignore::bsm_mesh.errors.MeshWarning")]

SCHEMES = {"staged": ("continuation", "wang", "linear"), "bolted": ("continuation",), "collapsing": ("continuation",)}
RUNS = [(name, scheme) for name, schemes in SCHEMES.items() for scheme in schemes]


@pytest.fixture
def left_late(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """Copy the folder of a run before each checkpoint but the first, as a run that is killed there leaves it."""
    return copies_of(monkeypatch, tmp_path / "left", before=True)


@pytest.mark.heavy
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("most", [6, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("name", "scheme"), RUNS)
def test_resumed_from_checkpoints(tmp_path: Path, left: list[Path], name: str, scheme: str, most: int) -> None:
    """From so many of them, or a few more, spread over the run."""
    model = put_model(tmp_path / "case", name, tables={"solver": {"scheme": scheme, "max_steps": 40}})
    out = model.parent / "out"
    whole = bsm.run(model, output=out)
    wanted, copies = content(out), list(left)
    steps = sum(len(stage.steps) for stage in whole.stages)
    assert len(copies) >= (len(whole.stages) if scheme == "linear" else steps)
    for copy in copies[:: 1 + len(copies) // (most + 1)]:
        interrupted(model.parent, copy)
        seen: list[bsm.results.StepRecord] = []
        results = bsm.run(model, output=out, resume=True, observer=seen.append)
        assert results.status == whole.status
        assert len(seen) < steps
        assert content(out) == wanted
        assert names(model.parent) == ["bolts.csv", "mesh.msh", "model.toml", "out"]


SHAKEN = {
    "base": lambda: block_on_plane(
        bsm.Shaking(record=quake(4.0, 3.0), every=0.25), friction=0.2, histories=[bsm.History(name="b", block=1)]
    ),
    "quiet": lambda: on_quiet_base(20.0, 0.5, duration=3.0, every=0.25),
}


def shaken_case(folder: Path, name: str) -> tuple[Path, Path]:
    """Write the model file of a shaken model with frames of all steps; return it and the folder of its results."""
    model = folder / "case" / "model.toml"
    model.parent.mkdir()
    for file, write in files_of_model(SHAKEN[name](), bsm.Options()).items():
        write(model.parent / file)
    text = model.read_text(encoding="utf-8")
    model.write_text(text.replace("[output]", '[output]\nsnapshots = "steps"'), encoding="utf-8")
    return model, model.parent / "out"


def frames(folder: Path) -> int:
    """Return how many frames of the shaken stage a folder has."""
    return len(list(folder.glob("**/blocks_0001_*.vtu")))


@pytest.mark.heavy
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("name", SHAKEN)
def test_within_a_record(tmp_path: Path, left: list[Path], name: str) -> None:
    """Histories, energies, and the times of frames are those of a run that was not interrupted."""
    model, out = shaken_case(tmp_path, name)
    bsm.run(model, output=out)
    wanted, copies = content(out), list(left)
    within = [copy for copy in copies if 0 < frames(copy) < 12]
    assert within
    for copy in within[::2]:
        interrupted(model.parent, copy)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted


@pytest.mark.usefixtures("at_every_step")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a process that is killed is forked")
def test_a_kill_within_a_record(tmp_path: Path) -> None:
    model, out = shaken_case(tmp_path, "base")
    bsm.run(model, output=out)
    wanted = content(out)
    shutil.rmtree(out)
    process = os.fork()
    if process == 0:
        try:
            bsm.run(model, output=out)
        finally:
            os._exit(0)
    running, end = out.with_name("out.running"), time.monotonic() + 60
    while frames(running) < 3 and time.monotonic() < end:
        time.sleep(1e-3)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    assert 3 <= frames(running) < 12
    said: list[str] = []
    bsm.run(model, output=out, resume=True, report=said.append)
    assert content(out) == wanted
    assert "no interrupted run to continue with: it begins at the start" not in said


@pytest.mark.usefixtures("at_every_step")
def test_a_block_that_falls_from_where_it_slid_to(tmp_path: Path, left: list[Path]) -> None:
    """It is unstable when it has fallen by a tenth of its size since it last lay on something, not since the start."""
    polygons = [rectangle(-4, -1, 0, 0), rectangle(-8, -9, 8, -8), rectangle(-1.3, 0, -0.3, 1)]
    push = bsm.PointLoad(block=2, point=(-0.8, 0.4), force=(20e3, 0))
    model, out = tmp_path / "case" / "model.toml", tmp_path / "case" / "out"
    model.parent.mkdir()
    for name, write in files_of_model(model_of(polygons, fixed=(0, 1), loads=[push]), bsm.Options()).items():
        write(model.parent / name)
    whole = bsm.run(model, output=out)
    assert whole.stages[0].reason == "a block has lost all contact and moves freely"
    wanted, copies = content(out), list(left)
    for copy in copies[-8::2]:
        interrupted(model.parent, copy)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted


@pytest.mark.slow
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("scheme", ["continuation", "wang", "linear"])
def test_stages_that_change_strength_and_shake(tmp_path: Path, left: list[Path], scheme: str) -> None:
    """At a checkpoint strength and gravity are those of the last stages: joints slip in every one of these."""
    polygons = [rectangle(-4, -1, 6, 0), rectangle(-2, 0, 0, 1), rectangle(0, 0, 2, 1), rectangle(2, 0, 3, 2)]
    stages = [
        bsm.Stage(name="shakes", gravity=(0.5, 0.05), strength={"J": 0.5}),
        bsm.Stage(name="rain", strength={"*": 0.4}),
        bsm.Stage(name="back", gravity=(-0.1, 0.0)),
        bsm.Stage(name="mended", strength={"J": 2.0}),
    ]
    built = model_of(polygons, fixed=(0, 3), friction=30.0, kn=1e8, stages=stages)
    model, out = tmp_path / "case" / "model.toml", tmp_path / "case" / "out"
    model.parent.mkdir()
    for name, write in files_of_model(built, bsm.Options(scheme=scheme)).items():
        write(model.parent / name)
    whole = bsm.run(model, output=out)
    assert {stage.status for stage in whole.stages} == {"no_verdict" if scheme == "linear" else "stable"}
    if scheme == "continuation":
        slips = [bool((stage.contacts.status == 1).any()) for stage in whole.stages]
        assert slips == [False, True, True, True, False]
    wanted, copies = content(out), list(left)
    assert len(copies) >= 5
    for copy in copies[:: 1 + len(copies) // 8]:
        interrupted(model.parent, copy)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted


@pytest.mark.usefixtures("at_every_step")
def test_joints_that_in_situ_stress_closed_and_that_are_open_at_a_checkpoint(tmp_path: Path, left: list[Path]) -> None:
    """The offset that an open contact remembers is in the checkpoint: the block ends where it was."""
    p0, stiffness = 1e5, 1e9
    loads = [bsm.PointLoad(block=1, point=(0.5, 1.5), force=(0.0, force)) for force in (3 * p0, -3 * p0)]
    built = model_of([rectangle(0, k, 1, k + 1) for k in range(3)], kn=stiffness, fixed=(0, 2), gamma=0.0)
    built = built.replace(
        in_situ=bsm.InSitu(stress={"yy": -p0}),
        stages=[bsm.Stage(name=f"{k}", loads=[load]) for k, load in enumerate(loads)],
    )
    model, out = tmp_path / "case" / "model.toml", tmp_path / "case" / "out"
    model.parent.mkdir()
    for name, write in files_of_model(built, bsm.Options()).items():
        write(model.parent / name)
    whole = bsm.run(model, output=out)
    assert abs(whole.stages[-1].displacement[1, 1]) < 1e-9 * p0 / stiffness
    wanted, copies = content(out), list(left)
    for copy in copies:
        interrupted(model.parent, copy)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted


@pytest.mark.slow
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("case", ["stages", "in situ"])
def test_stages_of_blocks_with_zones(tmp_path: Path, left: list[Path], case: str) -> None:
    """Rock that yields, joints, bolts, held excavation forces, water and rock put back are in the checkpoint."""
    zones = bsm.Zones(size=0.5, law="mohr_coulomb", dilation=10.0)
    soft = replace(GNEISS, cohesion=6e4, friction=30.0, tensile_strength=3e4, zones=zones)
    part, away, back = CASES["stages"]["stages"]
    stages = [part, bsm.Stage(name="weak", strength={"J1": 0.9, "rock:gneiss": 0.9}), away, replace(back, loads=())]
    bolts = [BOLT, replace(BOLT, start=(0.2, 1.9), end=(0.8, 0.1), stage="part")]
    built = wall(rocks=[soft, RIGID], **{**CASES[case], "stages": stages, "bolts": bolts})
    _resumed_after_every_stage(tmp_path, left, built)


@pytest.mark.usefixtures("at_every_step")
def test_stages_of_zones_that_slid(tmp_path: Path, left: list[Path]) -> None:
    """Places on other zones are in the checkpoint: the second stage presses on them."""
    press = bsm.PointLoad(block=1, point=(1.8, 0.5), force=(0, -1e4))
    built = pushed(0.3).replace(stages=[bsm.Stage(name="press", loads=[press])])
    _resumed_after_every_stage(tmp_path, left, built)


@pytest.mark.usefixtures("at_every_step")
def test_stages_of_zones_without_a_block_that_fell(tmp_path: Path, left: list[Path]) -> None:
    """It is gone in the second stage too."""
    press = bsm.PointLoad(block=1, point=(0.5, 1.0), force=(0, -1e3))
    options = bsm.Options(falls=bsm.Falls(on_fall="remove"))
    _resumed_after_every_stage(tmp_path, left, beside(stages=[bsm.Stage(name="press", loads=[press])]), options)


def _resumed_after_every_stage(
    tmp_path: Path, left: list[Path], built: bsm.Model, options: bsm.Options | None = None
) -> None:
    model, out = tmp_path / "case" / "model.toml", tmp_path / "case" / "out"
    model.parent.mkdir()
    for name, write in files_of_model(built, options or bsm.Options()).items():
        write(model.parent / name)
    whole = bsm.run(model, output=out)
    count = len(built.stages) + 1
    assert (whole.status, len(whole.stages)) == ("stable", count)
    wanted, copies = content(out), list(left)
    assert len(copies) >= count
    for number, copy in enumerate(copies):
        interrupted(model.parent, copy)
        seen: list[bsm.results.StepRecord] = []
        bsm.run(model, output=out, resume=True, observer=seen.append)
        assert [step.stage for step in seen] == list(range(number + 1, count))
        assert content(out) == wanted


@pytest.mark.slow
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])  # checkpoint
def test_blocks_that_were_taken_away_and_snapshots_that_were_thinned_out(
    tmp_path: Path, left_late: list[Path], monkeypatch: pytest.MonkeyPatch, every: int
) -> None:
    """What falls is removed and the others continue; of more than ten snapshots every second goes, again and again.

    Also after another run that was begun anew and ended at once.
    """
    monkeypatch.setattr(snapshots, "MOST_SNAPSHOTS", 10)
    solver = {"falls": {"on_fall": "remove"}}
    model = put_model(tmp_path / "case", "collapsing", tables=solver)
    out = model.parent / "out"
    whole = bsm.run(model, output=out)
    assert whole.status == "stable_after_falls"
    assert len(whole.stages[0].falls) == 1
    wanted, copies = content(out), list(left_late)
    assert len(copies) > 25
    for number, copy in enumerate(copies[::every]):
        interrupted(model.parent, copy)
        if number % 2 == 0:
            with pytest.raises(KeyboardInterrupt):
                bsm.run(model, output=out, observer=stop)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted


def test_a_run_that_begins_anew_keeps_what_there_is_to_go_on_with(killed: tuple[Path, Path]) -> None:
    """Who forgets --resume, and ends that run at once, can still continue."""
    model, out = killed
    before = tree(out.with_name("out.running"))
    with pytest.raises(KeyboardInterrupt):
        bsm.run(model, output=out, observer=stop)
    after = tree(out.with_name("out.interrupted"))
    assert {name.replace("running", "interrupted") for name in before} >= set(after)
    seen: list[bsm.results.StepRecord] = []
    bsm.run(model, output=out, resume=True, observer=seen.append)
    assert (seen[0].stage, seen[0].step) == (1, 3)
    assert names(out.parent) == ["bolts.csv", "mesh.msh", "model.toml", "out"]


def test_when_a_checkpoint_is_due(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every two minutes, and before a step after which it would be later than that; at the end of each stage."""
    now = 1000.0
    monkeypatch.setattr(checkpoints.time, "monotonic", lambda: now)
    monkeypatch.setattr(checkpoints, "write_checkpoint", lambda *_: None)
    due = checkpoints.Checkpoints()
    written = []
    for step in range(1, 31):
        now += 10.0
        if due.is_due(ended=step == 25):
            due.write(Path(), None, {})  # type: ignore[arg-type]
            written.append(step)
    assert written == [11, 22, 25]
    now += 119.0
    assert due.is_due(ended=False)


def test_what_no_checkpoint_may_hold(tmp_path: Path) -> None:
    for thing in (np.array([None]), object(), {1: 2}, [1], Path()):
        with pytest.raises(TypeError, match="cannot be kept"):
            write_checkpoint(tmp_path / "a.npz", {}, thing)  # type: ignore[arg-type]
    assert names(tmp_path) == []


@pytest.mark.skipif(not is_available(), reason="needs Pardiso")
@pytest.mark.parametrize("same", [True, False])
def test_a_pattern_that_needed_double_precision_still_does(monkeypatch: pytest.MonkeyPatch, same: bool) -> None:
    """A matrix that single precision finds singular; of the same pattern the next would be tried so again."""
    factorize = Pardiso.factorize

    def poor(self: Pardiso, data: np.ndarray) -> None:
        if self._precision is np.float32:
            raise SingularMatrixError("no pivot")
        factorize(self, data)

    monkeypatch.setattr(pardiso, "LARGE", 1)
    step = begun(tilted_courses(3, 4).model())
    assert step.factors.double_precision == ""
    with monkeypatch.context() as changed:
        changed.setattr(Pardiso, "factorize", poor)
        _ = step.elastic_position  # factorizes
    digest = step.factors.double_precision
    assert len(digest) == 64
    again = Factors(step.system, bsm.Options())
    again.recall(digest if same else digest[::-1])
    again.pattern_of(step.contacts)
    assert again.double_precision == (digest if same else "")


@pytest.mark.slow
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("stays", [True, False], ids=["full from then on", "full once"])
def test_a_disk_that_is_full(tmp_path: Path, stays: bool) -> None:
    """At whatever operation: the message says how to continue, if there is anything to continue with, and that does."""
    model, out = put_model(tmp_path / "case", "staged"), tmp_path / "case" / "out"
    wanted = whole_run(model, out)
    last = count_operations(lambda: bsm.run(model, output=out))
    went_on = 0
    for number in range(3, last, 47):
        for left_over in out.parent.glob("out*"):
            shutil.rmtree(left_over)
        if said := fails(lambda: bsm.run(model, output=out), full_disk(number, stays)):
            assert "No space left on device" in said
            can = "continue with: bsm-mesh run" in said
            assert can == any((out.parent / name / CHECKPOINT).exists() for name in ("out.interrupted", "out.running"))
            why = fails(lambda: bsm.run(model, output=out, resume=True), lambda *told: None)
            assert not why or (not can and "holds the finished results of this model" in why)
            went_on += can
        assert content(out) == wanted
        assert names(out.parent) == ["bolts.csv", "mesh.msh", "model.toml", "out"]
    assert went_on > 4


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes that are killed are forked")
def test_a_resumed_run_that_is_killed_in_its_turn(killed: tuple[Path, Path]) -> None:
    """At whatever operation; what was left before is there still, or what it came to."""
    model, out = killed
    shutil.copytree(out.with_name("out.running"), out.with_name("kept"))
    bsm.run(model, output=out, resume=True)
    wanted, said = content(out), []
    shutil.rmtree(out)
    shutil.copytree(out.with_name("kept"), out.with_name("out.running"))
    last = count_operations(lambda: bsm.run(model, output=out, resume=True))
    for number in range(1, last + 1, 29):
        for left_over in out.parent.glob("out*"):
            shutil.rmtree(left_over)
        shutil.copytree(out.with_name("kept"), out.with_name("out.interrupted"))
        killed_at(number, lambda: bsm.run(model, output=out, resume=True))
        why = fails(lambda: bsm.run(model, output=out, resume=True, report=said.append), lambda *told: None)
        assert not why or "holds the finished results of this model" in why
        assert content(out) == wanted
        assert names(out.parent) == ["bolts.csv", "kept", "mesh.msh", "model.toml", "out"]
    assert "no interrupted run to continue with: it begins at the start" not in said
