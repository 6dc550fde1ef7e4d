"""Gmsh is opened, closed and given back as it was; a mesh file is written whole or not at all."""

import os
import subprocess
import sys
import threading

import meshio
import numpy as np
import pytest

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.session import SYSTEM_LIBRARIES, gmsh_session, name_groups, write_mesh

gmsh = pytest.importorskip("gmsh")


@pytest.fixture
def callers_gmsh():
    """Gmsh as a caller has it who uses it too, with a model and options of their own."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("mine")
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    yield
    gmsh.finalize()


def write_square(path, size=0.5, groups=None):
    """Write a unit square."""
    with gmsh_session("square") as gmsh:
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        name_groups(groups or {"rock:granite": [square], "boundary:bottom": [1]})
        return write_mesh(path)


def write_crossing(path, name_first, outside):
    """Cut a unit square by two joints, with a third outside; name groups before or after the cut."""
    corners = [(0.5, 0), (0.5, 1), (0, 0.5), (1, 0.5), (2, 0), (2, 1)]
    with gmsh_session("crossing") as gmsh:
        occ = gmsh.model.occ
        square = occ.addRectangle(0, 0, 0, 1, 1)
        ends = [occ.addPoint(x, y, 0) for x, y in corners[: 6 if outside else 4]]
        joints = [occ.addLine(*pair) for pair in zip(ends[::2], ends[1::2], strict=True)]
        occ.synchronize()
        if name_first:
            name_groups({"joint:J1": joints})
        _, pieces = occ.fragment([(2, square)], [(1, joint) for joint in joints])
        occ.synchronize()
        if not name_first:
            name_groups({"joint:J1": [tag for piece in pieces[1:] for _, tag in piece]})
        name_groups({"rock:granite": [tag for _, tag in pieces[0]]})
        gmsh.model.mesh.generate(2)
        return write_mesh(path)


def test_session_closes():
    with gmsh_session():
        assert gmsh.isInitialized()
    assert not gmsh.isInitialized()


def test_session_closes_after_an_exception():
    with pytest.raises(ZeroDivisionError), gmsh_session():
        raise ZeroDivisionError
    assert not gmsh.isInitialized()


def test_session_bears_a_script_that_closes_gmsh_itself():
    with gmsh_session():
        gmsh.finalize()
    assert not gmsh.isInitialized()


def test_errors_of_gmsh_are_translated_with_their_cause():
    with (
        pytest.raises(GeometryError, match=r"^slope: Gmsh reports: .*control point 9") as caught,
        gmsh_session("slope") as opened,
    ):
        opened.model.geo.addLine(opened.model.geo.addPoint(0, 0, 0), 9)
    assert type(caught.value.__cause__) is Exception
    assert not gmsh.isInitialized()


@pytest.mark.usefixtures("callers_gmsh")
@pytest.mark.parametrize("fails", [False, True])
def test_session_in_a_callers_gmsh_leaves_it_as_it_was(fails, tmp_path):
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.option.setNumber("Mesh.Smoothing", 7)
    gmsh.option.setNumber("General.AbortOnError", 0)
    try:
        with gmsh_session("inner", {"Mesh.Algorithm": 5}):
            assert gmsh.model.getEntities() == []
            assert gmsh.option.getNumber("Mesh.Algorithm") == 5
            assert gmsh.option.getNumber("Mesh.Smoothing") == 1
            assert gmsh.option.getNumber("General.AbortOnError") == 2
            if fails:
                raise ZeroDivisionError
    except ZeroDivisionError:
        pass
    assert gmsh.isInitialized()
    assert gmsh.model.getCurrent() == "mine"
    assert "inner" not in " ".join(gmsh.model.list())
    assert len(gmsh.model.getEntities(1)) == 4
    assert gmsh.option.getNumber("Mesh.MshFileVersion") == 2.2
    assert gmsh.option.getNumber("Mesh.Smoothing") == 7
    assert gmsh.option.getNumber("Mesh.Algorithm") == 6


def test_sessions_nest():
    with gmsh_session("outer") as outer:
        outer.model.geo.addPoint(0, 0, 0, tag=1)
        outer.model.geo.synchronize()
        with gmsh_session("inner") as inner:
            assert inner.model.getEntities() == []
        assert outer.model.getEntities() == [(0, 1)]
    assert not gmsh.isInitialized()


@pytest.mark.usefixtures("callers_gmsh")
def test_a_callers_options_do_not_change_the_mesh(tmp_path):
    gmsh.finalize()
    alone = write_square(tmp_path / "alone.msh").read_bytes()
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    for option, value in {
        "General.Terminal": 0,
        "Mesh.MeshSizeFactor": 3,
        "Mesh.Binary": 0,
        "Mesh.SaveAll": 1,
    }.items():
        gmsh.option.setNumber(option, value)
    assert write_square(tmp_path / "nested.msh").read_bytes() == alone


def test_threads_wait_for_each_other(tmp_path):
    paths = [tmp_path / f"{number}.msh" for number in range(4)]
    threads = [threading.Thread(target=write_square, args=(path,)) for path in paths]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({path.read_bytes() for path in paths}) == 1


def test_a_missing_system_library_is_one_clear_message(tmp_path):
    (tmp_path / "gmsh.py").write_text("raise OSError('libGLU.so.1: cannot open shared object file')\n")
    script = "from bsm_mesh import geometries\nwith geometries.gmsh_session(): pass"
    path = os.pathsep.join([str(tmp_path), *sys.path])
    run = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    last = run.stderr.strip().splitlines()[-1]
    assert "GeometryError: Gmsh cannot start: libGLU.so.1" in last
    assert last.endswith("apt-get install " + " ".join(SYSTEM_LIBRARIES))


def test_a_mesh_is_binary_msh_4_1_with_its_groups(tmp_path):
    path = write_square(tmp_path / "new" / "folder" / "square.msh")
    assert path.read_bytes().startswith(b"$MeshFormat\n4.1 1 8\n")
    mesh = meshio.read(path)
    assert {"rock:granite", "boundary:bottom"} <= set(mesh.cell_sets)
    triangles = mesh.points[mesh.cells_dict["triangle"]][:, :, :2]
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    np.testing.assert_allclose(0.5 * np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 1.0)


def test_an_older_file_stays_whole_when_writing_fails(tmp_path, monkeypatch):
    path = write_square(tmp_path / "square.msh")
    before = path.read_bytes()

    def write_half(draft):
        with open(draft, "wb") as file:
            file.write(b"$MeshFormat")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(gmsh, "write", write_half)
    with pytest.raises(GeometryError, match="No space left on device"):
        write_square(path, size=0.2)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["square.msh"]


def test_a_mesh_that_gmsh_cut_off_without_a_word_is_refused(tmp_path, monkeypatch):
    write = gmsh.write

    def write_and_lose_the_end(draft):
        write(draft)
        with open(draft, "r+b") as file:
            file.truncate(500)

    monkeypatch.setattr(gmsh, "write", write_and_lose_the_end)
    with pytest.raises(GeometryError, match="No space left on device; choose another folder"):
        write_square(tmp_path / "square.msh")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["square.vtk", "square", "a_file/square.msh", "a_folder.msh"])
def test_a_path_that_cannot_be_written_is_named(name, tmp_path):
    (tmp_path / "a_file").touch()
    (tmp_path / "a_folder.msh").mkdir()
    with pytest.raises(GeometryError, match=name):
        write_square(tmp_path / name)
    assert not gmsh.isInitialized()


def test_groups_named_after_fragmenting_hold_every_piece(tmp_path):
    mesh = meshio.read(write_crossing(tmp_path / "crossing.msh", name_first=False, outside=True))
    lines = [
        block.data[cells] for block, cells in zip(mesh.cells, mesh.cell_sets["joint:J1"], strict=True) if len(cells)
    ]
    ends = mesh.points[np.concatenate(lines)]
    np.testing.assert_allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum(), 3.0)


@pytest.mark.parametrize(("outside", "lost"), [(True, "some"), (False, "all")])
def test_groups_named_before_fragmenting_are_refused(outside, lost, tmp_path):
    rule = f"group 'joint:J1' lost {lost} of its curves or surfaces; name groups last"
    with pytest.raises(GeometryError, match=rule):
        write_crossing(tmp_path / "crossing.msh", name_first=True, outside=outside)
    assert list(tmp_path.iterdir()) == []


def test_a_surface_in_no_group_is_refused(tmp_path):
    with pytest.raises(GeometryError, match=r"1 surface\(s\) with elements are in no group, the first is 1"):
        write_square(tmp_path / "square.msh", groups={"boundary:bottom": [1]})


def test_a_mesh_without_elements_is_refused(tmp_path):
    with pytest.raises(GeometryError, match="no elements to write"), gmsh_session():
        write_mesh(tmp_path / "square.msh")


def test_all_bad_groups_are_reported_together(tmp_path):
    groups = {"granite": [1], "joint:J1": [99], "rock:empty": []}
    with pytest.raises(GeometryError) as caught:
        write_square(tmp_path / "square.msh", groups=groups)
    assert len(caught.value.faults) == 3
    assert "no curve 99" in caught.value.faults[1]
