"""Foreign readers in a process of their own: what dies, never ends or takes all memory there is one message here."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes import apart
from bsm_mesh.converters.meshes.files import read_cells
from bsm_mesh.converters.meshes.from_meshio import read_by_meshio
from bsm_mesh.errors import ModelError
from tests.scenes.small_case import ROOT
from tests.scenes.square_mesh import CURVES, msh, msh22

pytestmark = pytest.mark.robust

READERS = """
import os
from bsm_mesh.errors import ModelError

LIBRARY = ()

def dies(path):
    os.abort()

def raises(path):
    raise KeyError("points")

def refuses(path):
    raise ModelError(["one", "two"])

def never_ends(path):
    while True:
        pass

def eats_memory(path):
    return bytearray(1 << 33)

def finds_much(path):
    raise ModelError(["a fault " * 10000])
"""
MANY_CELLS = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1900000000"><Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points><Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">9</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>
"""
SQUARE = """# vtk DataFile Version 3.0
square
ASCII
DATASET POLYDATA
POINTS 4 double
0 0 0 1 0 0 1 1 0 0 1 0
POLYGONS 1 5
4 0 1 2 3
"""


@pytest.fixture
def read_here() -> None:
    """Foreign meshes are read in a process of their own, as they are outside the tests."""


@pytest.fixture
def readers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a module of bad readers, which the other process finds too."""
    folder = tmp_path / "readers"
    folder.mkdir()
    (folder / "bad_readers.py").write_text(READERS)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), str(ROOT), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setattr(apart, "SECONDS", 1.0)
    monkeypatch.setattr(apart, "WAITING", 10.0)
    import bad_readers  # type: ignore[import-not-found]

    return bad_readers


@pytest.mark.parametrize(
    ("reader", "message"),
    [
        ("dies", r"a\.bad: the reader of this format died of signal 6; it is damaged"),
        ("raises", r"a\.bad: the reader of this format failed \(KeyError: 'points'\); it is damaged"),
        ("never_ends", r"a\.bad: the reader of this format did not end within 2 s; it is damaged"),
        ("eats_memory", r"a\.bad: the reader of this format failed \(MemoryError\)"),
        ("refuses", "2 faults:\n  - one\n  - two"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="the limits are those of POSIX")
def test_bad_readers(tmp_path: Path, readers: Any, reader: str, message: str) -> None:
    (tmp_path / "a.bad").write_text("a mesh")
    with pytest.raises(ModelError, match=message):
        apart.read_apart(getattr(readers, reader), tmp_path / "a.bad")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_an_answer_that_finds_no_room(tmp_path: Path, readers: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.bad").write_text("a mesh")
    places = [Path("/dev/full"), tmp_path / "said"]
    (tmp_path / "said").touch()
    monkeypatch.setattr(apart, "unnamed_file", lambda: places.pop(0).open("r+b", buffering=0))
    with pytest.raises(ModelError, match=r"its contents cannot be kept in .*make room there, or set TMPDIR"):
        apart.read_apart(readers.finds_much, tmp_path / "a.bad")


@pytest.mark.slow
def test_a_small_file_that_declares_many_cells(tmp_path: Path) -> None:
    (tmp_path / "a.vtu").write_text(MANY_CELLS)
    with pytest.raises(ModelError, match=r"a\.vtu: .*damaged"):
        read_cells(tmp_path / "a.vtu")


def test_what_is_read_apart_is_what_is_read_here(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text(msh22())
    here, apart_from_here = read_by_meshio(tmp_path / "a.msh"), read_cells(tmp_path / "a.msh")
    for name in ("points", "corners", "offsets", "numbers", "pieces"):
        mine, theirs = getattr(here, name), getattr(apart_from_here, name)
        assert mine.dtype == theirs.dtype
        np.testing.assert_array_equal(mine, theirs)
    assert [group.name for group in here.groups] == [group.name for group in apart_from_here.groups]
    for mine, theirs in zip(here.groups, apart_from_here.groups, strict=True):
        np.testing.assert_array_equal(mine.elements, theirs.elements)
        np.testing.assert_array_equal(mine.pieces, theirs.pieces)
    assert here.arrays.keys() == apart_from_here.arrays.keys()
    assert here.notes == apart_from_here.notes
    assert here.source == apart_from_here.source


def test_libraries_in_the_current_folder_are_not_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.msh").write_text(msh22())
    for name in ("meshio", "random", "numpy", "json"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a stranger was run')")
    monkeypatch.chdir(tmp_path)
    assert len(read_cells("a.msh").offsets) == 5


@pytest.mark.parametrize("library", ["vtkmodules", "meshio"])
def test_the_program_itself_needs_no_foreign_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, library: str
) -> None:
    """What dies there does not die here."""
    (tmp_path / "a.msh").write_text(msh22())
    (tmp_path / "a.vtk").write_text(SQUARE)
    monkeypatch.setitem(sys.modules, library, None)
    assert len(read_cells(tmp_path / ("a.msh" if library == "meshio" else "a.vtk")).offsets) > 1


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("1 9 1 9", "1000000000000 9 1 9"),  # blocks of nodes
        ("2 1 0 9", "2 1 0 1000000000000"),  # nodes
        ("2 1 0 9", "2 1 0 1e300"),
        ("2 1 3 4", "2 1 3 1000000000000000"),  # elements
        ("0 3 1 0", "0 3 1000000000000 0"),  # entities
    ],
)
def test_counts_that_the_file_does_not_hold(tmp_path: Path, old: str, new: str) -> None:
    assert old in msh()
    (tmp_path / "a.msh").write_text(msh().replace(old, new))
    with pytest.raises(ModelError, match="is cut off or damaged"):
        read_mesh(tmp_path / "a.msh")


def test_a_mesh_without_nodes(tmp_path: Path) -> None:
    whole = msh(curves=CURVES)
    nodes = whole[whole.index("$Nodes") : whole.index("$Elements")]
    (tmp_path / "a.msh").write_text(whole.replace(nodes, "$Nodes\n0 0 0 0\n$EndNodes\n"))
    with pytest.raises(ModelError, match="with nodes that are not in the file"):
        read_mesh(tmp_path / "a.msh")
