"""Gmsh is given meshes only: it runs as a script what it does not recognise, and options that lie beside a mesh."""

from __future__ import annotations

from pathlib import Path

import gmsh
import pytest

from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes.content import MSH, UNV, format_of
from bsm_mesh.converters.meshes.from_gmsh import read_by_gmsh
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries import gmsh_session
from tests.scenes.square_mesh import msh, msh22

SCRIPT = """\
SystemCall "touch WAS_RUN";
Point(1)={0,0,0};Point(2)={1,0,0};Point(3)={1,1,0};Point(4)={0,1,0};
Line(1)={1,2};Line(2)={2,3};Line(3)={3,4};Line(4)={4,1};
Curve Loop(1)={1,2,3,4};Plane Surface(1)={1};Physical Surface("rock:rock")={1};
Mesh 2;
"""


@pytest.fixture
def unv(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a universal file of a unit square; its folder is the current one."""
    monkeypatch.chdir(tmp_path)
    with gmsh_session("unv") as session:
        square = session.model.occ.addRectangle(0, 0, 0, 1, 1)
        session.model.occ.synchronize()
        session.model.addPhysicalGroup(2, [square], 1, "rock:rock")
        session.model.mesh.generate(2)
        session.option.setNumber("Mesh.SaveGroupsOfElements", 1)
        session.write(str(tmp_path / "mesh.unv"))
    return tmp_path / "mesh.unv"


@pytest.mark.parametrize("name", ["rock.Unv", "rock.UNV", "rock.unv"])
@pytest.mark.parametrize("before", ["", "// -1\n", "-1\n", "$\n", "\ufeff"])
def test_a_script_named_as_a_mesh_is_not_run(unv: Path, name: str, before: str) -> None:
    path = unv.with_name(name)
    path.write_text(before + SCRIPT)
    with pytest.raises(ModelError, match=rf"{name}: its content is no mesh in a format that Gmsh is given"):
        read_mesh(path)
    assert not unv.with_name("WAS_RUN").exists()


@pytest.mark.parametrize("before", ["    -1\n  2411\n", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"])
def test_a_script_behind_the_head_of_a_mesh_is_not_run(unv: Path, before: str) -> None:
    path = unv.with_name("rock.Unv")
    path.write_text(before + SCRIPT)
    with pytest.raises(ModelError, match=r"rock\.Unv: Gmsh"):
        read_mesh(path)
    assert not unv.with_name("WAS_RUN").exists()


def test_options_beside_a_mesh_are_not_run(unv: Path) -> None:
    unv.with_name("mesh.unv.opt").write_text('SystemCall "touch WAS_RUN";\n')
    blocks, _ = read_mesh(unv)
    assert blocks.moments.area.sum() == pytest.approx(1)
    assert not unv.with_name("WAS_RUN").exists()


@pytest.mark.parametrize("name", ["a.UNV", "a.Unv"])
def test_an_ending_in_capitals_is_the_same_format(unv: Path, name: str) -> None:
    unv.rename(unv.with_name(name))
    blocks, _ = read_mesh(unv.with_name(name))
    assert blocks.moments.area.sum() == pytest.approx(1)


def test_a_mesh_reached_by_a_link_is_read(unv: Path) -> None:
    unv.with_name("link.unv").symlink_to("mesh.unv")
    assert read_mesh(unv.with_name("link.unv"))[0].moments.area.sum() == pytest.approx(1)


def test_the_content_tells_the_format(unv: Path, tmp_path: Path) -> None:
    for name, content in (("a", msh()), ("b", msh22())):
        (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
        assert format_of(tmp_path / name) is MSH
    assert format_of(unv) is UNV
    (tmp_path / "c").write_text(SCRIPT)
    assert format_of(tmp_path / "c") is None
    (tmp_path / "d.unv").write_bytes((tmp_path / "a").read_bytes())  # of the wrong ending: read as what it is
    assert read_by_gmsh(tmp_path / "d.unv").points.shape[0] > 0
    assert not gmsh.isInitialized()
