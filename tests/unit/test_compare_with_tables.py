"""Another program's nodes as a table: separators, decimal commas, units; faults."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.commands.comparing_with import field_names
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum.foreign_fields import length_factor, plane_fields
from bsm_mesh.converters.continuum.sampled import block_averages_of, grid_of
from bsm_mesh.converters.meshes.foreign_files import read_foreign
from bsm_mesh.converters.vtk_files import sample
from bsm_mesh.errors import ModelError
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.named_units import LENGTHS, STRESSES, factor_of, unit_in
from tests.scenes.continuum import slab
from tests.scenes.foreign_results import EXACT, NONE, check, linear, theirs

TUNNEL = Path(__file__).parents[2] / "examples/01_circular_tunnel/homogeneous.toml"


def table(path, points, u, s, header, parting=",", point="."):
    values = np.column_stack([points, u, s]).tolist()
    rows = [parting.join(repr(value).replace(".", point) for value in row) for row in values]
    path.write_text("\n".join([parting.join(header), *rows]), encoding="utf-8-sig")
    return read_foreign(path)


RS2 = ["x_coord (m)", "y_coord (m)", "Horizontal Displacement (mm)", "Vertical Displacement (mm)"]
RS2 += ["Sigma XX (MPa)", "Sigma YY (MPa)", "Sigma XY (MPa)"]


@pytest.mark.parametrize(("parting", "point"), [(",", "."), (";", ","), ("\t", ".")])
def test_a_table_of_nodes(tmp_path, parting, point):
    """As RS2's nodes: in mm and MPa by the names of the columns, compression positive, a node of a joint twice."""
    points = theirs()[0][:, :2]
    points = np.vstack([points, points[9:12]])
    u, s = linear(points)
    u[9:12] -= 1e-4
    u[-3:] += 1e-4
    result = table(tmp_path / "rs2.csv", points, 1e3 * u, -1e-6 * s, RS2, parting, point)
    assert len(result.points) == len(points) - 3
    names = field_names([], None, True)
    check(block_averages_of(result, plane_fields(result, names), slab("wall in bond"), 1.0), slab("wall in bond"))


def test_units_of_columns(tmp_path):
    """By definition: an inch is 25.4 mm, a pound-force 4.4482216152605 N; a kip is 1000 of these, a ton 2000."""
    (tmp_path / "a.csv").write_text("X (ft),Y (FT),ux (in)\n0,0,1\n1,0,1\n0,1,1\n")
    foot = factor_of(read_foreign(tmp_path / "a.csv").length_unit, LENGTHS, "x", "")
    assert_allclose(foot, 12 * 0.0254, rtol=1e-15)
    pound = 4.4482216152605
    for name, known, expected in (
        ("ux (in)", LENGTHS, 0.0254),
        ("uy (mm)", LENGTHS, 1e-3),
        ("sxx (psi)", STRESSES, pound / 0.0254**2),
        ("syy (ksf)", STRESSES, 1e3 * pound / 0.3048**2),
        ("syy (tsf)", STRESSES, 2e3 * pound / 0.3048**2),
        ("sxy (mpa)", STRESSES, 1e6),
    ):
        assert_allclose(factor_of(unit_in(name), known, name, ""), expected, rtol=1e-15)
    with pytest.raises(ModelError, match="unit 'total' is none of"):
        factor_of(unit_in("other (total)"), STRESSES, "other", "")


def test_our_own_elements_as_a_table_of_nodes(tmp_path):
    """Sampled back at the nodes, where no triangle between them matters: the same to rounding."""
    model = load_model_file(TUNNEL, lambda _: None).model
    own = solve_continuum(model, order=1)
    stress = np.zeros((len(own.points), 3))
    result = table(tmp_path / "own.csv", own.points, 1e3 * own.point_displacement, stress, RS2)
    fields = plane_fields(result, NONE)
    back, values = sample(grid_of(result, fields), own.points)
    assert back.all()
    for part, exact in zip(("ux", "uy"), own.point_displacement.T, strict=True):
        assert_allclose(values[part], exact, atol=EXACT * np.abs(exact).max())


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("x,y,ux\n0,0,1\n1,0\n", "line 3: has more or fewer cells than the header .2, not 3"),
        ("node,ux\n1,2\n", r"no column is called x \(or x_coord\); it has node, ux"),
        ("x,y,ux\n0,0,1\n1,up,1\n", "column 'y' is not all numbers: line 3 has 'up'"),
        ("x,y\n0,up\n1,down\n", "column 'y' is not all numbers"),
        ("x,y,ux\n\n0,0,1\n1,0,\n", "column 'ux' is not all numbers: line 4 has ''; leave out that row"),
        (
            '"x","y"\n"0","0"\n"1","1,500"\n',
            "line 3 has '1,500'; where commas are decimal points part columns by semicolons",
        ),
        (
            "x,y\n0,0\n1,0,5\n",
            "line 3: has more or fewer cells than the header .3, not 2.; where commas are decimal points",
        ),
        ("x (m),y (mm),ux\n0,0,1\n1,0,1\n", r"columns 'x \(m\)' and 'y \(mm\)' name different units"),
        ("x,y,ux\n0,0,1\n1,1,1\n2,2,1\n", "its 3 nodes span no area"),
        ("\n", "has no rows"),
        ("x,y,ux\n", "has no rows"),
        ("x,y,ux\n0,0,1\n\n1,0\n", "line 4: has more or fewer cells"),
        ("x,y,ux,ux\n0,0,1,2\n1,0,1,2\n0,1,1,2\n", "two columns are called 'ux'"),
        ("x (mm),y (m),ux\n0,0,1\n1,0,1\n0,1,1\n", r"columns 'x \(mm\)' and 'y \(m\)' name different units"),
    ],
)
def test_tables_that_cannot_be_read(text, fault, tmp_path):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(ModelError, match=fault):
        read_foreign(tmp_path / "bad.csv")


def test_units_of_the_nodes_of_a_table(tmp_path):
    points = theirs()[0][:, :2]
    u, s = linear(points)
    blocks = slab("wall in bond")
    for unit, size in (("ft", 0.3048), ("mm", 1e-3)):
        header = [f"x ({unit})", f"y ({unit})", *RS2[2:]]
        result = table(tmp_path / "rs2.csv", points / size, 1e3 * u, 1e-6 * s, header)
        check(block_averages_of(result, plane_fields(result, NONE), blocks, length_factor(result, NONE)), blocks)
    result = table(tmp_path / "rs2.csv", points, 1e3 * u, 1e-6 * s, ["x (yd)", "y (yd)", *RS2[2:]])
    with pytest.raises(ModelError, match="coordinates: unit 'yd' is none of m, cm, mm, ft, in, km; give one"):
        length_factor(result, NONE)
