"""VTU and PVD files: whole or not at all, and what is not one of ours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from bsm_mesh.certificate.verify_certificate.model_file import mesh_arrays
from bsm_mesh.converters.vtk_files import Grid, read_pvd, read_vtu, vtk_of_grid, write_pvd, write_vtu
from bsm_mesh.converters.vtk_library import POLYGON, VERTEX
from bsm_mesh.errors import ModelError

NAMES = {"b:<\t\"&'>": 1, "b:ä b": 0, "b:": 2, "other:c:d": -1}


def square(**data: object) -> Grid:
    points = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    return Grid(points=points, offsets=np.array([0, 4]), connectivity=np.arange(4), cell_type=POLYGON, **data)  # type: ignore[arg-type]


def test_round_trip_keeps_types_names_and_digits(tmp_path: Path) -> None:
    cells = {"a": np.array([0.1 + 0.2]), "b": np.array([7], np.int32), "c": np.array([[1e-300, -0.0, np.nan]])}
    grid = square(cell_data=cells, point_data={"d": np.eye(4)[:, :3]}, names=NAMES)
    write_vtu(tmp_path / "a.vtu", grid)
    read = read_vtu(tmp_path / "a.vtu", needs=("a", "b"))
    np.testing.assert_array_equal(read.points, grid.points)
    assert (read.offsets.tolist(), read.connectivity.tolist(), read.cell_type) == ([0, 4], [0, 1, 2, 3], POLYGON)
    for name, values in cells.items():
        np.testing.assert_array_equal(read.cell_data[name], values)
        assert read.cell_data[name].dtype == values.dtype
    np.testing.assert_array_equal(read.point_data["d"], np.eye(4)[:, :3])
    assert read.names == NAMES
    assert read.names_of("b") == ("ä b", "<\t\"&'>", "")
    assert read.names_of("c") == ()


@pytest.mark.parametrize("compression", ["zlib", "lz4"])
def test_data_are_inline_and_in_base64(tmp_path: Path, compression: Literal["zlib", "lz4"]) -> None:
    """ParaView 5.11 with a patched expat reads no file with appended data (VTK issue 19258)."""
    grid = square(cell_data={"a": np.linspace(0, 1, 5000).reshape(1, -1)}, names=NAMES)
    write_vtu(tmp_path / "a.vtu", grid, compression=compression)
    content = (tmp_path / "a.vtu").read_text("utf-8")
    assert "AppendedData" not in content
    assert set(re.findall(r'format="(\w+)"', content)) == {"binary"}
    np.testing.assert_array_equal(read_vtu(tmp_path / "a.vtu").cell_data["a"], grid.cell_data["a"])


@pytest.mark.parametrize("mode", ["inline", "appended"])
def test_vtu_files_of_this_and_of_former_versions_are_read(tmp_path: Path, mode: str) -> None:
    """By VTK, and by the check of certificates, which does without it; arrays of several compressed blocks too."""
    path, count = tmp_path / "a.vtu", 9000
    points = np.random.default_rng(3).random((4 * count, 2))
    grid = Grid(
        points=points, offsets=np.arange(0, 4 * count + 1, 4), connectivity=np.arange(4 * count), cell_type=POLYGON
    )
    if mode == "inline":
        write_vtu(path, grid)
    else:
        writer = vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(path))
        writer.SetInputData(vtk_of_grid(grid))
        writer.SetCompressorTypeToZLib()
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOn()
        assert writer.Write() == 1
    np.testing.assert_array_equal(read_vtu(path).points, points)
    arrays = mesh_arrays(path.read_bytes())
    np.testing.assert_array_equal(arrays["Points"].reshape(-1, 3)[:, :2], points)
    assert arrays["connectivity"].tolist() == list(range(4 * count))
    assert arrays["offsets"].tolist() == list(range(4, 4 * count + 1, 4))
    assert set(arrays["types"]) == {POLYGON}


def test_names_that_xml_cannot_hold(tmp_path: Path) -> None:
    write_vtu(tmp_path / "a.vtu", square(names={"b:\x00\x1b[31m\ud800": 0}))
    assert read_vtu(tmp_path / "a.vtu").names_of("b") == ("\\x00\\x1b[31m\\ud800",)


def test_a_grid_of_nothing(tmp_path: Path) -> None:
    """A model without contacts has an empty contacts.vtu."""
    none = np.zeros(0, np.int64)
    empty = Grid(points=np.zeros((0, 2)), offsets=np.zeros(1, np.int64), connectivity=none, cell_type=VERTEX)
    write_vtu(tmp_path / "a.vtu", empty)
    assert read_vtu(tmp_path / "a.vtu").points.shape == (0, 2)


def test_an_array_that_is_needed(tmp_path: Path) -> None:
    write_vtu(tmp_path / "a.vtu", square())
    with pytest.raises(ModelError, match="not a complete VTU file"):
        read_vtu(tmp_path / "a.vtu", needs=("stress",))


@pytest.mark.parametrize("length", [0, 1, 200, -60])
def test_a_file_cut_off(tmp_path: Path, length: int, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.vtu"
    write_vtu(path, square(cell_data={"a": np.ones(1)}))
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(ModelError, match=r"a\.vtu: not a complete VTU file"):
        read_vtu(path)
    assert capfd.readouterr().err == ""  # VTK writes past Python


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="there is no such file"):
        read_vtu(tmp_path / "a.vtu")
    with pytest.raises(ModelError, match="is this the folder of a run"):
        read_pvd(tmp_path / "a.pvd")


def test_a_folder_that_is_not_there(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(OSError, match=r"a\.vtu|No such file"):
        write_vtu(tmp_path / "nowhere" / "a.vtu", square())
    assert list(tmp_path.iterdir()) == []


def test_pvd(tmp_path: Path) -> None:
    write_pvd(tmp_path / "a.pvd", [(0.0, "a_0.vtu"), (1.0, "a & b.vtu")])
    assert read_pvd(tmp_path / "a.pvd") == [(0.0, tmp_path / "a_0.vtu"), (1.0, tmp_path / "a & b.vtu")]
    (tmp_path / "b.pvd").write_text("<VTKFile/>")
    with pytest.raises(ModelError, match="lists no files"):
        read_pvd(tmp_path / "b.pvd")
    (tmp_path / "b.pvd").write_text("<VTKFile")
    with pytest.raises(ModelError, match="not a PVD file"):
        read_pvd(tmp_path / "b.pvd")
