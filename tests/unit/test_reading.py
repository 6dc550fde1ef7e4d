"""What is read is a regular file: a pipe or a device is refused at once, wherever a file may be named."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters import read_mesh
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries import GeometryError, read_scan_line, read_traces
from bsm_mesh.model.bolt_patterns import bolts_from_table
from bsm_mesh.reading import refuse_special
from tests.scenes.small_case import FILE, MODEL, Case

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system knows no pipes with a name")
BOLTS = '[[bolt]]\ntable = "bolts.csv"\ndiameter = "25 mm"\nyield_strength = "500 MPa"\n'


@pytest.fixture(autouse=True)
def _alarm() -> Iterator[None]:
    """End a test that waits for a pipe."""

    def end(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, end)
    signal.alarm(30)
    yield
    signal.alarm(0)


def pipe(folder: Path, name: str) -> Path:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.unlink(missing_ok=True)
    os.mkfifo(path)
    return path


@pytest.mark.parametrize(
    ("name", "model", "arguments"),
    [
        ("model.toml", MODEL, ("check", "model.toml")),
        ("mesh.msh", MODEL, ("check", "model.toml")),
        ("mesh.vtu", MODEL.replace("mesh.msh", "mesh.vtu"), ("check", "model.toml")),
        ("mesh.inp", MODEL.replace("mesh.msh", "mesh.inp"), ("check", "model.toml", "--no-scripts")),
        ("bolts.csv", MODEL + BOLTS, ("check", "model.toml")),
        ("ours.py", MODEL.replace(FILE, 'geometry = "ours.py"\n'), ("check", "model.toml")),
        ("ours.py", MODEL, ("mesh", "ours.py")),
        ("out/summary.json", MODEL, ("plot", "out")),
    ],
)
def test_pipes_are_refused(case: Case, name: str, model: str, arguments: tuple[str, ...]) -> None:
    case.write("model.toml", model)
    pipe(case.folder, name)
    outcome = case.run(*arguments)
    assert outcome.code == 2, outcome
    assert f"{name}: is a pipe, which may never end" in outcome.err


@pytest.mark.parametrize(
    ("name", "read", "error"),
    [
        ("a.msh", read_mesh, ModelError),
        ("a.csv", read_traces, GeometryError),
        ("a.geojson", read_traces, GeometryError),
        ("a.dxf", read_traces, GeometryError),
        ("a.csv", read_scan_line, GeometryError),
    ],
)
def test_pipes_are_refused_from_python(
    tmp_path: Path, name: str, read: Callable[[Path], object], error: type[Exception]
) -> None:
    with pytest.raises(error, match="is a pipe"):
        read(pipe(tmp_path, name))


class Odd:
    """What says that it is a path, of bytes."""

    def __fspath__(self) -> bytes:
        return b"a"


@pytest.mark.parametrize("given", [5, None, b"a.csv", np.array([]), Odd()])
@pytest.mark.parametrize(
    ("read", "error"),
    [
        (bsm.load, ModelError),
        (bsm.Results.load, ModelError),
        (read_mesh, ModelError),
        (bolts_from_table, ModelError),
        (read_traces, GeometryError),
        (read_scan_line, GeometryError),
    ],
)
def test_what_is_no_path(given: object, read: Callable[[Any], object], error: type[Exception]) -> None:
    with pytest.raises(error, match="must be a path"):
        read(given)


def test_pipes_among_results_are_refused(tmp_path: Path) -> None:
    pipe(tmp_path, "summary.json")
    with pytest.raises(ModelError, match="is a pipe"):
        bsm.Results.load(tmp_path)


def test_devices_are_refused(case: Case) -> None:
    case.change(FILE, 'file = "/dev/zero"\n')
    case.refuses("check", "model.toml", says=["/dev/zero: is a device, which may never end"])


def test_a_link_to_a_regular_file_is_one(tmp_path: Path) -> None:
    (tmp_path / "a").touch()
    (tmp_path / "b").symlink_to("a")
    for name in ("a", "b", ".", "missing", "\0"):
        refuse_special(tmp_path / name)
