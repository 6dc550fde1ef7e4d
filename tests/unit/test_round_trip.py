"""Every result file is read by meshio, PyVista and VTK with equal arrays; tables by csv, pyarrow and pandas."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import pyvista
from pyarrow import parquet
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

import bsm_mesh as bsm
from bsm_mesh.converters.continuum.compared_stages import compare_stages
from bsm_mesh.converters.continuum.files import write_comparison
from bsm_mesh.converters.meshes.block_files import write_polygons
from bsm_mesh.converters.result_files import BOLTS, SERIES, WATER, write_mechanism
from bsm_mesh.converters.vtk_files import Grid, write_vtu
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.result_tables import FLOW, ON_REQUEST
from bsm_mesh.results import Results
from bsm_mesh.results.tables import TABLES, result_table
from tests.unit.test_run_writer import staged

KINDS = (*SERIES, WATER, BOLTS)


@pytest.fixture(scope="module")
def results() -> Results:
    """Return two stages with bolts, water, an excavation and a block of five corners."""
    return bsm.run(staged(), bsm.Options(scheme="linear"))


@pytest.fixture(scope="module")
def folder(results: Results, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with every kind of VTU file that the package writes."""
    place = results.save(tmp_path_factory.mktemp("out"), tables=True)
    write_mechanism(results.blocks, results.stages[0].displacement, results.stages[0].present, place / "limit.vtu")
    write_polygons(results.blocks, place / "mended.vtu")
    return place


def by_vtk(path: Path) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return points, point arrays, cell arrays and field arrays."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    found = []
    for data in (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()):
        arrays = [data.GetAbstractArray(k) for k in range(data.GetNumberOfArrays())]
        assert all(array.IsA("vtkDataArray") for array in arrays)  # texts keep meshio, VisIt and others from reading
        found.append({array.GetName(): vtk_to_numpy(array) for array in arrays})
    return vtk_to_numpy(grid.GetPoints().GetData()), found[0], found[1], found[2]


def assert_equal(found: Any, expected: dict[str, np.ndarray]) -> None:
    assert set(found.keys()) == set(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(np.asarray(found[name]), values, err_msg=name)


@pytest.mark.heavy
def test_meshio_and_pyvista_read_what_vtk_reads(folder: Path) -> None:
    paths = sorted(folder.glob("*.vtu"))
    assert {path.name.partition("_")[0] for path in paths} == {*KINDS, "limit.vtu", "mended.vtu", "mesh.vtu"}
    for path in paths:
        points, *expected = by_vtk(path)
        mesh, grid = meshio.read(path), pyvista.read(path)
        np.testing.assert_array_equal(mesh.points, points)
        np.testing.assert_array_equal(grid.points, points)
        cells = {name: np.concatenate(parts) for name, parts in mesh.cell_data.items()}
        for found, arrays in zip((mesh.point_data, cells, mesh.field_data), expected, strict=True):
            assert_equal({name: np.reshape(v, arrays[name].shape) for name, v in found.items()}, arrays)
        for found, arrays in zip((grid.point_data, grid.cell_data, grid.field_data), expected, strict=True):
            assert_equal(found, arrays)
        assert [list(cell) for block in mesh.cells for cell in block.data] == [
            list(grid.get_cell(k).point_ids) for k in range(grid.n_cells)
        ]


def test_comparison_with_the_continuum_too(results: Results, tmp_path: Path) -> None:
    model = staged().replace(bolts=(), stages=(), water=None)
    compared = compare_stages(model, bsm.run(model, bsm.Options(scheme="linear")))
    write_comparison(compared[0].comparison, model.blocks, tmp_path / "compare.vtu")
    _, _, cells, _ = by_vtk(tmp_path / "compare.vtu")
    read = meshio.read(tmp_path / "compare.vtu")
    assert_equal({name: np.concatenate(parts) for name, parts in read.cell_data.items()}, cells)


@pytest.mark.parametrize("stage", [0, -1])
@pytest.mark.parametrize("kind", KINDS)
def test_objects_are_what_reading_the_file_gives(results: Results, folder: Path, kind: str, stage: int) -> None:
    path = folder / f"{kind}_{stage % len(results.stages):04d}.vtu"
    read, made = meshio.read(path), results.to_meshio(kind, stage)
    assert isinstance(made, meshio.Mesh)
    np.testing.assert_array_equal(made.points, read.points)
    assert [(c.type, c.data.tolist()) for c in made.cells] == [(c.type, c.data.tolist()) for c in read.cells]
    assert made.cell_data.keys() == read.cell_data.keys()
    for name, parts in read.cell_data.items():
        for ours, theirs in zip(made.cell_data[name], parts, strict=True):
            np.testing.assert_array_equal(ours, theirs, err_msg=name)
    assert_equal(made.point_data, read.point_data)
    assert_equal(made.field_data, read.field_data)
    grid = results.to_pyvista(kind, stage)
    _, points, cells, _ = by_vtk(path)
    assert_equal(grid.point_data, points)
    texts = {name for name in grid.cell_data if name.endswith("_name")}
    assert_equal({name: grid.cell_data[name] for name in grid.cell_data if name not in texts}, cells)
    for name in texts:
        numbers = grid.field_data
        for text, number in zip(grid.cell_data[name], cells[name.removesuffix("_name")], strict=True):
            assert numbers[f"{name.removesuffix('_name')}:{text}"] == [number]


def test_written_again_by_meshio_it_is_a_mesh_for_us(results: Results, tmp_path: Path) -> None:
    results.to_meshio("blocks", 0).write(tmp_path / "again.vtu")
    assert bsm.Results is Results
    assert len(meshio.read(tmp_path / "again.vtu").cells) == len(results.to_meshio("blocks", 0).cells)


def test_what_is_not_there(results: Results) -> None:
    with pytest.raises(ModelError, match="has no 'beams'; it has blocks, contacts, joints, supports"):
        results.to_pyvista("beams")
    with pytest.raises(ModelError, match=r"there is no stage 7; stages are numbered 0 to \d"):
        results.to_meshio("blocks", 7)
    with pytest.raises(ModelError, match="no table 'beams' of results; known: blocks, contacts"):
        results.to_pandas("beams")
    with pytest.raises(ModelError, match="compression = 'gzip' must be one of 'zlib', 'lz4'"):
        results.save("nowhere", compression="gzip")  # type: ignore[arg-type]


def test_without_pyvista(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ModelError, match="needs the Python package 'pyvista'; install it"):
        results.to_pyvista()


@pytest.mark.heavy
def test_tables_are_the_same_as_csv_parquet_and_pandas(results: Results, folder: Path, tmp_path: Path) -> None:
    results.save(tmp_path, tables="parquet")
    assert not list(tmp_path.glob("contacts.csv"))
    for name in (*ON_REQUEST, BOLTS):
        table, frame = result_table(results, name), results.to_pandas(name)
        read = parquet.read_table(tmp_path / f"{name}.parquet")
        assert [*table.columns] == read.column_names == [*frame.columns]
        units = {field.name: field.metadata[b"unit"].decode() for field in read.schema if field.metadata}
        assert units == table.units == frame.attrs["units"]
        with (folder / f"{name}.csv").open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        assert [h.partition(" [")[0] for h in header] == read.column_names
        assert len(rows) == len(frame) == read.num_rows > 0
        for column, cells in zip(read.column_names, zip(*rows, strict=True), strict=True):
            values = np.asarray(read[column].to_pylist())
            np.testing.assert_array_equal(frame[column].to_numpy(dtype=values.dtype), values)
            if values.dtype.kind in "fib":
                np.testing.assert_array_equal([float(cell or "nan") for cell in cells], values.astype(float))
            else:
                assert list(cells) == list(values)


def test_tables_hold_the_results(results: Results) -> None:
    blocks, last = results.to_pandas("blocks"), results.stages[-1]
    mine = blocks[blocks.stage_name == last.name]
    assert mine.block.tolist() == np.flatnonzero(last.present).tolist()
    np.testing.assert_array_equal(mine.displacement_y, last.displacement[last.present, 1])
    supports = results.to_pandas("supports")
    assert supports.groupby("stage").force_y.sum().tolist() == [s.supports.reaction[:, 1].sum() for s in results.stages]
    assert len(results.to_pandas("steps")) == sum(len(stage.steps) for stage in results.stages)
    assert set(TABLES) == {*ON_REQUEST, BOLTS, FLOW, "steps"}


def test_meshio_and_a_grid_of_nothing(tmp_path: Path) -> None:
    """No file without cells is read by meshio; the guide says so. When it is, the guide is to be corrected."""
    none = np.zeros(0, np.int64)
    write_vtu(tmp_path / "a.vtu", Grid(points=np.zeros((0, 2)), offsets=np.zeros(1), connectivity=none, cell_type=1))
    with pytest.raises((IndexError, ValueError, AssertionError)):
        meshio.read(tmp_path / "a.vtu")
    assert pyvista.read(tmp_path / "a.vtu").n_cells == 0
