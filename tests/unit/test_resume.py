"""A run that is resumed ends as the one that was not interrupted, file by file and bit for bit, or is refused."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.app import checkpoints, snapshots
from bsm_mesh.app.checkpoint_file import write_checkpoint
from bsm_mesh.app.model_text import files_of_model
from bsm_mesh.app.own_files import CHECKPOINT
from bsm_mesh.errors import ModelError, SingularMatrixError
from bsm_mesh.solve.algebra import linear_solvers
from bsm_mesh.solve.algebra.pardiso import Pardiso, is_available
from bsm_mesh.solve.step.elastic import elastic_position
from bsm_mesh.solve.step.factorization import Factors
from tests.campaigns.scenes import content, put_model
from tests.file_operations import count_operations, full_disk, killed_at, names, watched
from tests.scenes.large import tilted_courses
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import Case, environment
from tests.scenes.steps import begun

pytestmark = pytest.mark.filterwarnings("ignore::bsm_mesh.errors.MeshWarning")

SCHEMES = {"staged": ("continuation", "wang", "linear"), "bolted": ("continuation",), "collapsing": ("continuation",)}
RUNS = [(name, scheme) for name, schemes in SCHEMES.items() for scheme in schemes]


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing waits for the disk itself."""
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)


@pytest.fixture
def at_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints are written after every step."""
    monkeypatch.setattr(checkpoints.SETTINGS, "interval", 0.0)


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """Copy the folder of a run after each checkpoint, as a run that is killed there leaves it."""
    return copies_of(monkeypatch, tmp_path / "left", before=False)


@pytest.fixture
def left_late(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """Copy the folder of a run before each checkpoint but the first, as a run that is killed there leaves it."""
    return copies_of(monkeypatch, tmp_path / "left", before=True)


def copies_of(monkeypatch: pytest.MonkeyPatch, folder: Path, *, before: bool) -> list[Path]:
    copies: list[Path] = []
    write = checkpoints.Checkpoints.write

    def copy(place: Path) -> None:
        copies.append(folder / f"{os.getpid()}-{len(copies)}")
        shutil.copytree(place, copies[-1])

    def and_copy(self: Any, place: Path, *rest: Any) -> None:
        if before and (place / CHECKPOINT).exists():
            copy(place)
        write(self, place, *rest)
        if not before:
            copy(place)

    monkeypatch.setattr(checkpoints.Checkpoints, "write", and_copy)
    return copies


def interrupted(case: Path, copy: Path) -> None:
    """Bring the results of a model to where a run was killed, and nothing else is."""
    for name in ("out", "out.running", "out.interrupted"):
        shutil.rmtree(case / name, ignore_errors=True)
    shutil.copytree(copy, case / "out.running")


def stop(record: bsm.results.StepRecord) -> None:
    raise KeyboardInterrupt


@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize(("name", "scheme"), RUNS)
def test_resumed_from_every_checkpoint(tmp_path: Path, left: list[Path], name: str, scheme: str) -> None:
    model = put_model(tmp_path / "case", name, tables={"solver": {"scheme": scheme, "max_steps": 40}})
    out = model.parent / "out"
    whole = bsm.run(model, output=out)
    wanted, copies = content(out), list(left)
    steps = sum(len(stage.steps) for stage in whole.stages)
    assert len(copies) >= (len(whole.stages) if scheme == "linear" else steps)
    for copy in copies:
        interrupted(model.parent, copy)
        seen: list[bsm.results.StepRecord] = []
        results = bsm.run(model, output=out, resume=True, observer=seen.append)
        assert results.status == whole.status
        assert len(seen) < steps
        assert content(out) == wanted
        assert names(model.parent) == ["bolts.csv", "mesh.msh", "model.toml", "out"]


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


@pytest.mark.usefixtures("at_every_step")
def test_blocks_that_were_taken_away_and_snapshots_that_were_thinned_out(
    tmp_path: Path, left_late: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What falls is removed and the others go on; of more than ten snapshots every second goes, again and again.

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
    for number, copy in enumerate(copies):
        interrupted(model.parent, copy)
        if number % 2 == 0:
            with pytest.raises(KeyboardInterrupt):
                bsm.run(model, output=out, observer=stop)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted


@pytest.fixture
def killed(tmp_path: Path, left: list[Path], at_every_step: None) -> tuple[Path, Path]:
    """Return a staged model and its folder, in which a run was killed amid its second stage."""
    model = put_model(tmp_path / "case", "staged")
    out = model.parent / "out"
    bsm.run(model, output=out)
    interrupted(model.parent, left[4])
    return model, out


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def refused(model: Path, out: Path, says: str) -> None:
    """Assert that a run is refused in one sentence with the cure, and that nothing is changed."""
    before = tree(out.parent)
    with pytest.raises(ModelError, match=says) as caught:
        bsm.run(model, output=out, resume=True)
    assert len(caught.value.faults) == 1
    assert str(caught.value).endswith("run without --resume")
    assert tree(out.parent) == before


def cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def flipped(content: bytes) -> bytes:
    return content[:5000] + bytes([content[5000] ^ 1]) + content[5001:]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": cut,
    "a byte less": lambda content: content[:-1],
    "a byte more": lambda content: content + b"\n",
    "a bit changed": flipped,
    "empty": lambda content: b"",
    "foreign": lambda content: b"PK\x03\x04 of another program",
    "a line": lambda content: b"\n",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_checkpoint_that_is_not_as_it_was_written(killed: tuple[Path, Path], damage: str) -> None:
    model, out = killed
    file = out.with_name("out.running") / CHECKPOINT
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    refused(model, out, "truncated, was changed, or is no checkpoint of bsm-mesh")


def sealed(file: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Change what is told in a checkpoint, and seal it again."""
    with np.load(file) as members:
        arrays = dict(members)
    told = json.loads(arrays["content"].tobytes())
    change(told)
    arrays["content"] = np.frombuffer(json.dumps(told).encode(), np.uint8)
    np.savez(file, **arrays)
    content = file.read_bytes()
    file.write_bytes(content + f"{hashlib.sha256(content).hexdigest()}\n".encode())


CHANGES: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "format": (lambda told: told.update(format=2), "has format 2, and this bsm-mesh reads 1"),
    "kind": (lambda told: told["checkpoint"].update(kind="Path"), "is no checkpoint of this program"),
    "field": (lambda told: told["checkpoint"].update(more=1), "is no checkpoint of this program"),
    "less": (lambda told: told.pop("files"), "is no checkpoint of this program"),
    "another state": (lambda told: told.update(checkpoint=[]), "holds no state of a run"),
    "versions": (lambda told: told["identity"].update(versions="bsm-mesh 0.0"), "other versions .bsm-mesh 0.0; here"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_checkpoint_of_another_program(killed: tuple[Path, Path], change: str) -> None:
    model, out = killed
    sealed(out.with_name("out.running") / CHECKPOINT, CHANGES[change][0])
    refused(model, out, CHANGES[change][1])


OTHERS: dict[str, tuple[dict[str, Any], str]] = {
    "model": ({"water": {"unit_weight": "9.8 kN/m^3"}}, "of another model"),
    "options": ({"solver": {"tolerance": 1e-7}}, "of another way to solve"),
    "falls": ({"falls": {"on_fall": "remove"}}, "of another way to solve"),
    "snapshots": ({"output": {"snapshots": "stages"}}, r"snapshots = 'steps' in .output., and now it is 'stages'"),
}


@pytest.mark.parametrize("other", OTHERS)
def test_a_model_that_was_changed_since(killed: tuple[Path, Path], other: str) -> None:
    model, out = killed
    put_model(model.parent, "staged", tables=OTHERS[other][0])
    refused(model, out, OTHERS[other][1])


@pytest.mark.parametrize("name", ["blocks_0000.vtu", "blocks_0001_00001.vtu"])
@pytest.mark.parametrize("how", ["gone", "changed"])
def test_a_grid_that_was_changed_since(killed: tuple[Path, Path], name: str, how: str) -> None:
    model, out = killed
    file = out.with_name("out.running") / name
    if how == "gone":
        file.unlink()
    else:
        file.write_bytes(file.read_bytes().replace(b"gneiss", b"gneisS"))
        file.write_bytes(flipped(file.read_bytes()) if len(file.read_bytes()) > 5000 else b"")
    refused(model, out, f"{name} is missing, or was changed after it was written")


def test_finished_stages_that_cannot_be_read(killed: tuple[Path, Path]) -> None:
    model, out = killed
    (out.with_name("out.running") / "summary.json").write_text("{}")
    refused(model, out, "the finished stages of what was interrupted: .*summary.json is not from a run")


def test_a_run_that_begins_anew_keeps_what_there_is_to_go_on_with(killed: tuple[Path, Path]) -> None:
    """Who forgets --resume, and ends that run at once, can still go on."""
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


def test_nothing_to_go_on_with(tmp_path: Path) -> None:
    model = put_model(tmp_path, "bolted")
    said: list[str] = []
    bsm.run(model, output=tmp_path / "out", resume=True, report=said.append)
    assert "no interrupted run to go on with: it begins at the start" in said
    assert not (tmp_path / "out" / CHECKPOINT).exists()
    refused(model, tmp_path / "out", "holds the finished results of this model, .* nothing to go on with")
    put_model(tmp_path, "bolted", unit_weight="25 kN/m^3")
    bsm.run(model, output=tmp_path / "out", resume=True)
    with pytest.raises(ModelError, match="output = False leaves nothing to go on with"):
        bsm.run(model, output=False, resume=True)
    with pytest.raises(ModelError, match="resume goes with a model file"):
        bsm.run(bsm.load(model), resume=True)


def test_the_command(case: Case) -> None:
    """A run that is interrupted says how to go on; that command comes to the end."""
    case.write("model.toml", (case.folder / "model.toml").read_text() + '[[stage]]\nname = "one"\nexcavate = [3]\n')
    script = WAIT + "from bsm_mesh.__main__ import main; import sys; sys.argv[1:] = ['run', 'model.toml', '-q']; main()"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=case.folder, env=environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 130
    told = "finished and in out/model.interrupted: 1 stage (initial); go on with: bsm-mesh run model.toml --resume"
    assert done.stderr.strip() == f"interrupted (SIGTERM): {told}"
    outcome = case.run("run", "model.toml", "--resume")
    assert outcome.code == 0
    assert "stage one" in outcome.err
    assert "stage initial" not in outcome.err
    assert len(bsm.Results.load("out/model").stages) == 2
    case.refuses("run", "model.toml", "--resume", says=["nothing to go on with", "run without --resume"])


WAIT = """
import os, signal
from bsm_mesh.app.progress import Progress
step = Progress.step
def strike(self, record):
    if record.stage:
        os.kill(os.getpid(), signal.SIGTERM)
    step(self, record)
Progress.step = strike
"""


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

    monkeypatch.setattr(linear_solvers, "WORTH_SINGLE", 1)
    step = begun(tilted_courses(3, 4).model())
    assert step.factors.double_precision == ""
    with monkeypatch.context() as changed:
        changed.setattr(Pardiso, "factorize", poor)
        elastic_position(step)
    digest = step.factors.double_precision
    assert len(digest) == 64
    again = Factors(step.system, bsm.Options())
    again.recall(digest if same else digest[::-1])
    again.pattern_of(step.contacts)
    assert again.double_precision == (digest if same else "")


def whole_run(model: Path, out: Path) -> dict[str, Any]:
    """Return what a run that nothing interrupts leaves, and take it away again."""
    shutil.rmtree(out, ignore_errors=True)
    bsm.run(model, output=out)
    wanted = content(out)
    shutil.rmtree(out)
    return wanted


def fails(action: Callable[[], object], hook: Callable[..., None]) -> str:
    """Return with which words an action is refused while a hook watches the operations on files; empty: it is not."""
    try:
        with watched(hook):
            action()
    except ModelError as error:
        return "; ".join([str(error), *getattr(error, "__notes__", [])])
    return ""


@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize("stays", [True, False], ids=["full from then on", "full once"])
def test_a_disk_that_is_full(tmp_path: Path, stays: bool) -> None:
    """At whatever operation: the message says how to go on, if there is anything to go on with, and that does."""
    model, out = put_model(tmp_path / "case", "staged"), tmp_path / "case" / "out"
    wanted = whole_run(model, out)
    last = count_operations(lambda: bsm.run(model, output=out))
    went_on = 0
    for number in range(3, last, 23):
        for left_over in out.parent.glob("out*"):
            shutil.rmtree(left_over)
        if said := fails(lambda: bsm.run(model, output=out), full_disk(number, stays)):
            assert "No space left on device" in said
            can = "go on with: bsm-mesh run" in said
            assert can == any((out.parent / name / CHECKPOINT).exists() for name in ("out.interrupted", "out.running"))
            why = fails(lambda: bsm.run(model, output=out, resume=True), lambda *told: None)
            assert not why or (not can and "holds the finished results of this model" in why)
            went_on += can
        assert content(out) == wanted
        assert names(out.parent) == ["bolts.csv", "mesh.msh", "model.toml", "out"]
    assert went_on > 4


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
    for number in range(1, last + 1, 13):
        for left_over in out.parent.glob("out*"):
            shutil.rmtree(left_over)
        shutil.copytree(out.with_name("kept"), out.with_name("out.interrupted"))
        killed_at(number, lambda: bsm.run(model, output=out, resume=True))
        why = fails(lambda: bsm.run(model, output=out, resume=True, report=said.append), lambda *told: None)
        assert not why or "holds the finished results of this model" in why
        assert content(out) == wanted
        assert names(out.parent) == ["bolts.csv", "kept", "mesh.msh", "model.toml", "out"]
    assert "no interrupted run to go on with: it begins at the start" not in said
