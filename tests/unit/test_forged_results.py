"""Results folders made up by somebody, with right checksums: one `ModelError`, no crash, and nothing read elsewhere."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.certificate.verify_certificate import arrays_file, read_arrays
from bsm_mesh.converters import grid_reader
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.checkpoint_file import read_checkpoint
from bsm_mesh.folder.summary import _checksum
from bsm_mesh.folder.verify import grounds_in
from bsm_mesh.pages.paraview import write_paraview
from bsm_mesh.pages.report import write_report
from bsm_mesh.pages.view import write_view
from bsm_mesh.pictures.pictures import PictureChoice, draw_pictures
from bsm_mesh.results.results import Results
from tests.scenes import models, shapes

Change = Callable[[bytes], bytes]
ARRAYS, GRID, CERTIFICATE = "certificate_0000.npz", "blocks_0000.vtu", "certificate.json"
ENTITIES = "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefghi", "bcdefghij", strict=True))
DOCTYPE = f'<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa">{ENTITIES}]>'


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return results of two stages, the second of which takes a block away."""
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(2, 2), rock="gneiss"), 2, 2)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("gneiss", unit_weight=25e3)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=2e8, law=bsm.Patton(friction=30))],
        default_joint="J1",
        supports=[bsm.Fixed(boundary="bottom")],
        stages=[bsm.Stage(name="dug", excavate=[3])],
    )
    return bsm.run(model).save(tmp_path_factory.mktemp("whole") / "out")


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "out"))


def forge(folder: Path, name: str, change: Change) -> None:
    """Change a file, and all checksums with it."""
    content = change((folder / name).read_bytes())
    (folder / name).write_bytes(content)
    listed = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    forge_summary(folder, lambda told: told["files"].update({name: listed}))


def forge_summary(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    told = json.loads((folder / "summary.json").read_text())
    del told["checksum"]
    change(told)
    (folder / "summary.json").write_text(json.dumps({**told, "checksum": _checksum(told)}))


def refused(folder: Path, says: str = "") -> None:
    """Everything that reads results refuses them."""
    readers = (Results.load, grounds_in, lambda out: list(draw_pictures(out, PictureChoice())))
    for read in readers:
        with pytest.raises(ModelError, match=re.escape(says)):
            read(folder)


def larger(content: bytes) -> bytes:
    """Return an archive with an array that says of itself that it fills 8 GB."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive, archive.open("a.npy", "w") as a:
        np.lib.format.write_array_header_1_0(a, {"descr": "<f8", "fortran_order": False, "shape": (10**9,)})
    return file.getvalue()


def pickled(content: bytes) -> bytes:
    file = io.BytesIO()
    np.savez(file, told=np.array([{"a": 1}], dtype=object))
    return file.getvalue()


def packed_otherwise(content: bytes) -> bytes:
    """Return an archive packed by a method that NumPy does not write, with properties that this method refuses."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("a.npy", bytes(99))
    whole = bytearray(file.getvalue())
    whole[whole.index(b"a.npy") + len(b"a.npy") + 4] = 255
    return bytes(whole)


NO_ARRAYS: list[Change] = [
    lambda content: b"",
    lambda content: b"PK\x03\x04junkjunk",
    lambda content: content[: len(content) // 2],
    lambda content: content[:999] + bytes(255 - byte for byte in content[999:1040]) + content[1040:],
    lambda content: b"\x80\x04N.",  # a pickle
    larger,
    pickled,
    packed_otherwise,
]


@pytest.mark.parametrize("number", range(len(NO_ARRAYS)))
def test_arrays_that_are_none(folder: Path, number: int) -> None:
    forge(folder, ARRAYS, NO_ARRAYS[number])
    refused(folder, "is damaged")
    assert verify_certificate.main(folder) == 1  # the check without a partner


def test_arrays_that_swell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An archive that says, truly, that it holds a thousand times its size."""
    monkeypatch.setattr(arrays_file, "ROOM", 0)
    np.savez_compressed(tmp_path / "a.npz", a=np.zeros(10**6))
    with pytest.raises(ValueError, match="fill more than such a file can hold"):
        read_arrays(tmp_path / "a.npz")


def test_arrays_are_those_that_numpy_reads(tmp_path: Path) -> None:
    given = {
        "a": np.arange(6.0).reshape(2, 3),
        "b": np.asfortranarray(np.arange(6).reshape(2, 3)),
        "c": np.array("text"),
        "d": np.zeros((0, 2)),
        "e": np.array([True, False]),
        "f": np.arange(3, dtype=">i4"),
    }
    np.savez(tmp_path / "a.npz", **given)
    np.savez_compressed(tmp_path / "b.npz", **given)
    for name in ("a.npz", "b.npz"):
        read = read_arrays(tmp_path / name)
        assert list(read) == list(given)
        for key, values in given.items():
            assert read[key].dtype == values.dtype
            np.testing.assert_array_equal(read[key], values)
        assert list(read_arrays(tmp_path / name, ("c",))) == ["c"]


def test_a_checkpoint_that_is_none(tmp_path: Path) -> None:
    for change in NO_ARRAYS:
        content = change(b"0" * 3000)
        seal = f"{hashlib.sha256(content).hexdigest()}\n".encode()
        (tmp_path / "a.npz").write_bytes(content + seal)
        with pytest.raises(ModelError, match=r"a\.npz is no checkpoint of bsm-mesh"):
            read_checkpoint(tmp_path / "a.npz")


def attribute(name: bytes, value: bytes) -> Change:
    return lambda content: re.sub(rb"\b" + name + rb'="[^"]*"', name + b'="' + value + b'"', content)


GRIDS: list[Change] = [
    attribute(b"NumberOfPoints", b"1900000000"),
    attribute(b"NumberOfCells", b"1900000000"),
    attribute(b"NumberOfPoints", b"-5"),
    attribute(b"NumberOfCells", b"-5"),
    attribute(b"NumberOfComponents", b"1000000000"),
    attribute(b"NumberOfTuples", b"1900000000"),
    attribute(b"header_type", b"UInt8"),
    lambda content: content.replace(b"<VTKFile", DOCTYPE.encode() + b'<VTKFile a="&j;"', 1),
    lambda content: content[: len(content) // 2],
    lambda content: b"",
]


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(GRIDS)))
def test_grids_that_kill_their_reader(folder: Path, whole: Path, number: int) -> None:
    """It runs in a process of its own: this one lives, and the next file is read."""
    before = (folder / GRID).read_bytes()
    forge(folder, GRID, GRIDS[number])
    if (folder / GRID).read_bytes() == before:
        pytest.skip("no such attribute")
    refused(folder, f"{GRID}: not a complete VTU file of a run")
    assert Results.load(whole).status == "stable"


def test_arrays_of_fewer_components(folder: Path) -> None:
    forge(folder, GRID, lambda content: re.sub(rb'(Name="reaction" NumberOfComponents=)"3"', rb'\1"1"', content))
    refused(folder, f"{GRID} is damaged")


def test_cells_of_points_that_are_not_there() -> None:
    arrays = {"points": np.zeros((3, 2)), "offsets": np.array([0, 3]), "connectivity": np.array([0, 1, 2])}
    assert grid_reader._misfit(arrays) == ""
    for changed in (
        {"connectivity": np.array([0, 1, 3])},
        {"connectivity": np.array([0, 1, -1])},
        {"offsets": np.array([0, 4])},
        {"offsets": np.array([1, 3])},
        {"offsets": np.array([0, 4, 3])},
        {"cell:rock": np.zeros(2)},
        {"point:x": np.zeros(4)},
    ):
        assert grid_reader._misfit({**arrays, **changed}) != ""


@pytest.mark.heavy
def test_an_interruption_leaves_no_answer_to_another_question(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(stream: Any) -> Any:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(grid_reader, "_received", interrupted)
        with pytest.raises(KeyboardInterrupt):
            Results.load(whole)
    assert Results.load(whole).status == "stable"


@pytest.mark.heavy
@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
def test_a_process_that_forked_has_a_reader_of_its_own(whole: Path) -> None:
    Results.load(whole)
    child = os.fork()
    if child == 0:
        os._exit(0 if Results.load(whole).status == "stable" else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert Results.load(whole).status == "stable"


def test_a_reader_that_does_not_come_to_an_end(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grid_reader, "_process", grid_reader._Process())
    monkeypatch.setattr(grid_reader, "WAITING", 0.2)
    monkeypatch.setattr(grid_reader, "_seconds", lambda size: 0)
    monkeypatch.setattr(
        grid_reader, "python_command", lambda module: ["sleep", "60"] if shutil.which("sleep") else pytest.skip("sleep")
    )
    with pytest.raises(ModelError, match=r"its reader died of signal 9"):
        Results.load(whole)


CERTIFICATES: list[Change] = [
    lambda content: b"[" * 200_000,
    lambda content: b"[]",
    lambda content: b"{}",
    lambda content: b'{"schema_version": 2}',
    lambda content: content.replace(b'"arrays": "', b'"arrays": "../'),
    lambda content: content.replace(b'"arrays"', b'"arrows"'),
    lambda content: content.replace(b'"stages": [', b'"stages": [5, '),
]


@pytest.mark.parametrize("number", range(len(CERTIFICATES)))
def test_certificates_that_are_none(folder: Path, number: int) -> None:
    forge(folder, CERTIFICATE, CERTIFICATES[number])
    with pytest.raises(ModelError):
        grounds_in(folder)
    assert verify_certificate.main(folder) == (0 if b'"../' in (folder / CERTIFICATE).read_bytes() else 1)


STRANGE: dict[str, Callable[[dict[str, Any]], object]] = {
    "a title of half a character": lambda told: told.update(title="\ud800"),
    "a title that is a number": lambda told: told.update(title=5),
    "blocks before the first": lambda told: told["stages"][0].update(unstable_blocks=[-1]),
    "blocks after the last": lambda told: told["stages"][0].update(unstable_blocks=[99_999]),
    "fewer steps than none": lambda told: told["stages"][0].update(steps=-3),
    "steps without end": lambda told: told["stages"][0].update(steps=10**18),
    "an unknown verdict": lambda told: told["stages"][0].update(status="fine"),
    "notes that are a text": lambda told: told["stages"][0].update(notes="none"),
    "a verdict in numbers": lambda told: told["stages"][0].update(verdict=3),
    "sizes below nothing": lambda told: told["files"][ARRAYS].update(bytes=-1),
    "sizes in words": lambda told: told["files"][ARRAYS].update(bytes="many"),
    "files above": lambda told: told["files"].update({"../secret": {"bytes": 1, "sha256": "x"}}),
    "files elsewhere": lambda told: told["files"].update({"/etc/hostname": {"bytes": 1, "sha256": "x"}}),
    "histories that are none": lambda told: told.update(histories=[{"name": "../../x"}]),
}


@pytest.mark.parametrize("case", STRANGE)
def test_summaries_that_are_none(folder: Path, case: str) -> None:
    forge_summary(folder, STRANGE[case])
    refused(folder, "is damaged")
    for write in (write_report, write_view, write_paraview):
        if case not in ("steps without end", "blocks after the last", "histories that are none"):
            with pytest.raises(ModelError):
                write(folder)


def test_a_listed_file_behind_a_link_is_not_read(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/a.txt").write_text("secret")
    (folder / "pictures").symlink_to("../elsewhere")
    listed = {"bytes": 6, "sha256": hashlib.sha256(b"secret").hexdigest()}
    forge_summary(folder, lambda told: told["files"].update({"pictures/a.txt": listed}))
    refused(folder, "pictures is a link, and pictures/a.txt would lie elsewhere")


def test_a_series_of_other_files(folder: Path) -> None:
    forge(folder, "blocks.pvd", lambda content: content.replace(b"blocks_0000.vtu", b"../../x.vtu"))
    for write in (write_view, write_paraview):
        with pytest.raises(ModelError):
            write(folder)
    forge(folder, "blocks.pvd", lambda content: content.replace(b"<VTKFile", DOCTYPE.encode() + b"<VTKFile", 1))
    with pytest.raises(ModelError, match="a document type is in it"):
        write_view(folder)


@pytest.mark.heavy
def test_the_reader_ends_with_the_program(whole: Path) -> None:
    code = (
        "from bsm_mesh.results import Results; from bsm_mesh.converters import grid_reader; "
        f"Results.load({str(whole)!r}); print(grid_reader._process._running.pid)"
    )
    root = str(Path(bsm.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": root},
    )
    with pytest.raises(ProcessLookupError):
        os.kill(int(done.stdout), 0)
