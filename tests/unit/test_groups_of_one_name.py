"""Physical groups of one name, and without a name: a wedge of 40 degrees slides at a friction of 30.

Its plane consists of two curves, each in a physical group of its own; Gmsh saves the name of one of them only.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters import read_mesh
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries import gmsh_session

SLOPE = math.tan(math.radians(40.0))
TABLES = '[joint.plane]\nnormal_stiffness = 1e9\nshear_stiffness = 1e9\nlaw = "mohr_coulomb"\nfriction = 30\n'
MODEL = f"""\
[mesh]
file = "wedge.msh"
blocks = "regions"
[rock.granite]
unit_weight = 26e3
young = 20e9
poisson = 0.25
{TABLES}
[[support]]
boundary = "bottom"
fix = "all"
"""


def wedge(folder: Path, *, version: float, names: tuple[str, str]) -> Path:
    """Write the mesh of a wedge whose two parts of the plane are in groups of these names."""
    path = folder / "wedge.msh"
    with gmsh_session() as gmsh:
        occ, model = gmsh.model.occ, gmsh.model
        corners = [(0, 0), (10, 0), (10, 10 * SLOPE), (5, 5 * SLOPE), (10, 10 * SLOPE + 2), (0, 2)]
        a, b, c, d, e, f = (occ.addPoint(x, y, 0) for x, y in corners)
        bottom, right, upper, lower = (occ.addLine(*ends) for ends in ((a, b), (b, c), (c, d), (d, a)))
        rest = [occ.addLine(*ends) for ends in ((c, e), (e, f), (f, a))]
        below = occ.addPlaneSurface([occ.addCurveLoop([bottom, right, upper, lower])])
        above = occ.addPlaneSurface([occ.addCurveLoop([-lower, -upper, *rest])])
        occ.synchronize()
        model.addPhysicalGroup(2, [below, above], name="rock:granite")
        for curve, name in zip((lower, upper), names, strict=True):
            model.addPhysicalGroup(1, [curve], name=name)
        model.addPhysicalGroup(1, [bottom], name="boundary:bottom")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 3)
        model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(path))
    return path


@pytest.mark.parametrize("version", [4.1, 2.2])
def test_a_group_without_a_name_is_an_error_where_regions_are_asked_for(tmp_path: Path, version: float) -> None:
    path = wedge(tmp_path, version=version, names=("joint:plane", "joint:plane"))
    with pytest.raises(ModelError, match=r"curve groups without a name that are not used: 'gmsh:physical=\d'"):
        read_mesh(path, blocks="regions")
    _, report = read_mesh(path)
    (note,) = (note for note in report.notes if "without a name" in note.text)
    assert note.count == 5  # half of the plane, in elements of 1.3 m
    assert "one addPhysicalGroup" in note.text


@pytest.mark.heavy
@pytest.mark.parametrize("version", [4.1, 2.2])
def test_a_group_without_a_name_can_be_mapped(tmp_path: Path, version: float) -> None:
    path = wedge(tmp_path, version=version, names=("joint:plane", "joint:plane"))
    with pytest.raises(ModelError) as caught:
        read_mesh(path, blocks="regions")
    key = str(caught.value).split("'")[1]
    (tmp_path / "model.toml").write_text(f'{MODEL}[groups]\n"{key}" = "joint:plane"\n')
    assert bsm.run(tmp_path / "model.toml").status == "unstable"


@pytest.mark.heavy
@pytest.mark.parametrize("version", [4.1, 2.2])
def test_groups_of_one_name_are_added_up(tmp_path: Path, version: float) -> None:
    """As other programs write them: two numbers with one name in $PhysicalNames."""
    path = wedge(tmp_path, version=version, names=("joint:plane", "joint:other"))
    path.write_bytes(path.read_bytes().replace(b"joint:other", b"joint:plane"))
    blocks, report = read_mesh(path, blocks="regions")
    length = np.hypot(*blocks.edge_vectors[blocks.edge_joint >= 0].T).sum()
    assert length == pytest.approx(2 * 10 / math.cos(math.radians(40.0)))  # both sides
    assert blocks.count == 2
    assert not [note for note in report.notes if "without a name" in note.text]
    (tmp_path / "model.toml").write_text(MODEL)
    assert bsm.run(tmp_path / "model.toml").status == "unstable"


@pytest.mark.parametrize("version", [4.1, 2.2])
def test_a_curve_in_a_named_group_and_in_one_without_a_name_is_not_lost(tmp_path: Path, version: float) -> None:
    path = tmp_path / "shared.msh"
    with gmsh_session() as gmsh:
        occ, model = gmsh.model.occ, gmsh.model
        square = occ.addRectangle(0, 0, 0, 1, 1)
        occ.synchronize()
        model.addPhysicalGroup(2, [square], name="rock:granite")
        (bottom, *_) = (tag for _, tag in model.getBoundary([(2, square)], oriented=False))
        model.addPhysicalGroup(1, [bottom], name="boundary:bottom")
        model.addPhysicalGroup(1, [bottom], 7)
        model.addPhysicalGroup(1, [bottom], 8)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1)
        model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(path))
    with pytest.raises(ModelError, match=r"'gmsh:physical=7' \(8 elements\), 'gmsh:physical=8' \(8 elements\)"):
        read_mesh(path, blocks="regions")
    groups = {"gmsh:physical=7": "joint:J", "gmsh:physical=8": "boundary:base"}
    blocks, _ = read_mesh(path, blocks="regions", groups=groups)
    assert set(blocks.boundaries) == {"bottom", "base"}
