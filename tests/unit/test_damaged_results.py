"""A results folder of which something is gone, cut off, changed or exchanged: one `ModelError`, whatever it is."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.vtk_files import read_pvd
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.own_files import CHECKPOINT, MARKER, own_files
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.results import Results
from tests.file_operations import names
from tests.scenes import models, shapes
from tests.unit.test_forged_results import forge_summary

CHANGED_BYTES = 12  # of each file


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return results of two stages with bolts and water, so of every kind of file."""
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(2, 2), rock="gneiss"), 2, 2)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("gneiss", unit_weight=25e3, young=1e9, poisson=0.2)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=2e8, law=bsm.Patton(friction=30))],
        default_joint="J1",
        supports=[bsm.Fixed(boundary="bottom")],
        bolts=[bsm.Bolt(start=(0.2, 0.4), end=(1.8, 0.6), diameter=0.02)],
        water=bsm.Water(table=[(0, 0.5)]),
        stages=[bsm.Stage(name="dug", excavate=[3])],
    )
    folder = bsm.run(model, bsm.Options(scheme="linear")).save(tmp_path_factory.mktemp("whole") / "out")
    assert {path.suffix for path in folder.iterdir()} == {"", ".vtu", ".pvd", ".csv", ".json", ".toml", ".npz"}
    assert Results.load(folder).status == "no_verdict"
    return folder


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "out"))


def damages(content: bytes, chance: random.Random) -> Iterator[bytes]:
    """Yield a file's content cut off, longer, and with one byte changed."""
    yield from (b"", content[:1], content[: len(content) // 2], content[:-1], content + b"0")
    for _ in range(CHANGED_BYTES):
        where = chance.randrange(len(content))
        yield content[:where] + bytes([content[where] ^ 1 << chance.randrange(7)]) + content[where + 1 :]


def same_summary(content: bytes, whole: bytes) -> bool:
    """Return whether a changed summary says the same: a blank is a blank."""
    try:
        return bool(json.loads(content) == json.loads(whole))
    except ValueError:
        return False


@pytest.mark.heavy
def test_every_file_damaged(folder: Path) -> None:
    """Also in files that are not read back, such as the table of bolts: a reader trusts the folder."""
    chance = random.Random(34)
    for name in names(folder):
        if name == MARKER:  # tells whose the folder is, not the result
            continue
        path, content = folder / name, (folder / name).read_bytes()
        for damaged in damages(content, chance):
            if name == "summary.json" and same_summary(damaged, content):
                continue
            path.write_bytes(damaged)
            with pytest.raises(ModelError, match=name.replace(".", r"\.")):
                Results.load(folder)
        path.unlink()
        with pytest.raises(ModelError, match=name.replace(".", r"\.")):
            Results.load(folder)
        path.mkdir()
        with pytest.raises(ModelError, match=name.replace(".", r"\.")):
            Results.load(folder)
        path.rmdir()
        path.write_bytes(content)
    assert Results.load(folder).status == "no_verdict"


def test_all_damaged_files_are_told_at_once(folder: Path) -> None:
    (folder / "blocks_0001.vtu").unlink()
    (folder / "history.csv").write_text("step\n")
    (folder / "contacts_0000.vtu").write_bytes(b"")
    with pytest.raises(ModelError) as caught:
        Results.load(folder)
    assert len(caught.value.faults) == 3


def test_files_that_changed_places(folder: Path) -> None:
    """Each is whole, and none is what it was."""
    for one, other in (("blocks_0000.vtu", "blocks_0001.vtu"), ("blocks.pvd", "contacts.pvd")):
        (folder / one).rename(folder / "between")
        (folder / other).rename(folder / one)
        (folder / "between").rename(folder / other)
    with pytest.raises(ModelError, match=r"blocks_0000\.vtu is damaged, or was changed after the run"):
        Results.load(folder)


def test_a_number_that_was_changed_is_noticed(folder: Path) -> None:
    told = json.loads((folder / "summary.json").read_text())
    told["stages"][-1]["status"] = told["status"] = "unstable"
    (folder / "summary.json").write_text(json.dumps(told, indent=2) + "\n")
    with pytest.raises(ModelError, match=r"summary\.json was changed after the run"):
        Results.load(folder)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
@pytest.mark.parametrize("name", ["summary.json", "history.csv", "blocks_0000.vtu"])
def test_a_pipe_blocks_nobody(folder: Path, name: str) -> None:
    (folder / name).unlink()
    os.mkfifo(folder / name)
    with pytest.raises(ModelError, match=re.escape(f"{name}: is a pipe, which may never end")):
        Results.load(folder)


@pytest.mark.parametrize(
    "told",
    [
        {"files": []},
        {"files": {"summary.json": None}},
        {"stages": [{}]},
        {"stages": 5},
        {"stages": "ab"},
        {"stages": [None]},
        {"joint_names": 1},
    ],
)
def test_a_summary_that_was_made_up(folder: Path, told: dict[str, object]) -> None:
    forge_summary(folder, lambda summary: summary.update(told))
    with pytest.raises(ModelError):
        Results.load(folder)


def test_a_list_of_files_names_none_outside_the_folder(folder: Path) -> None:
    """It says what may be removed: `..` and whole paths are nobody's."""
    names = ["../mine", "/etc/passwd", "a/../../mine", "", "a\0b"]
    forge_summary(folder, lambda summary: summary.update(files=dict.fromkeys([*names, "pictures/a.png"])))
    (folder / MARKER).write_text("../mine\n/tmp/mine\n")
    assert own_files(folder) == {"pictures/a.png", MARKER, CHECKPOINT, "summary.json"}


@pytest.mark.parametrize(
    "content",
    [
        b'<?xml version="1.0" encoding="of-nobody"?><VTKFile><DataSet file="a"/></VTKFile>',
        b'<VTKFile><DataSet timestep="noon" file="a"/></VTKFile>',
        b"<VTKFile>",
        b"\xff\xfe\0",
        b"",
    ],
)
def test_a_series_that_is_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "blocks.pvd").write_bytes(content)
    with pytest.raises(ModelError, match=r"blocks\.pvd: (not a PVD file|lists no files)"):
        read_pvd(tmp_path / "blocks.pvd")


@pytest.mark.parametrize("name", ["\0", "x" * 3000, "", "no/such/folder"])
def test_names_of_no_folder(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError):
        Results.load(name)


@pytest.mark.parametrize("name", ["\0", "x" * 3000])
def test_names_of_no_folder_to_write_to(name: str, whole: Path, tmp_path: Path) -> None:
    results = Results.load(whole)
    with pytest.warns(bsm.ResultsWarning), pytest.raises(ModelError):
        results.save(tmp_path / name)


def test_results_of_an_interrupted_run_that_were_damaged(folder: Path) -> None:
    """A step's file, which no summary lists, may be cut off; the series may be gone: no crash."""
    saved = SavedResults(folder)
    saved.finished = False
    (folder / "blocks_0001_00007.vtu").write_bytes((folder / "blocks_0001.vtu").read_bytes()[:300])
    with pytest.raises(ModelError, match=r"blocks_0001_00007\.vtu: not a complete VTU file"):
        saved.grid("blocks_0001_00007.vtu")
    (folder / "blocks.pvd").unlink()
    with pytest.raises(ModelError, match=r"blocks\.pvd: there is no such file"):
        saved.series("blocks")
