"""compare --with: results of other programs, by whatever reader, names, units and signs, averaged over the blocks."""

import json
from pathlib import Path

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.commands.comparing_with import field_names
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum import compare_stages
from bsm_mesh.converters.continuum.foreign_fields import FieldNames, length_factor, plane_fields
from bsm_mesh.converters.continuum.outside import compare_with, stages_of
from bsm_mesh.converters.continuum.sampled import block_averages_of
from bsm_mesh.converters.meshes.foreign_files import read_foreign
from bsm_mesh.converters.vtk_files import read_pvd, read_vtu, write_pvd
from bsm_mesh.errors import ModelError
from bsm_mesh.modelfile.build import load_model_file
from tests.scenes.continuum import HEAVY, slab
from tests.scenes.foreign_results import NONE, check, linear, theirs
from tests.scenes.models import LINEAR, model_of
from tests.scenes.small_case import Case

TUNNEL = Path(__file__).parents[2] / "examples/01_circular_tunnel/homogeneous.toml"
CONVENTIONS = {
    "SI, six components": (lambda u, s: {"U": u, "S": six(s)}, NONE),
    "Code_Aster": (lambda u, s: {"res__DEPL": u, "res__SIEF_NOEU": np.insert(s, 2, 0.0, axis=1)}, NONE),
    "single components": (
        lambda u, s: {"ux": u[:, 0], "uy": u[:, 1], "sigma_xx": s[:, 0], "sigma_yy": s[:, 1], "sigma_xy": s[:, 2]},
        NONE,
    ),
    "tensor": (lambda u, s: {"displacement": u, "Stress": tensor(s)}, NONE),
    "mm, kPa, compression positive": (
        lambda u, s: {"D": 1e3 * u, "T": -1e-3 * s},
        field_names(["displacement=D:mm", "stress=T:kPa"], None, True),
    ),
    "named components": (
        lambda u, s: {"a": u, "p": s[:, 0], "q": s[:, 1], "r": s[:, 2]},
        field_names(["displacement=a", "sxx=p", "syy=q", "sxy=r"], None, False),
    ),
    "named components, each in a unit of its own": (
        lambda u, s: {"a": 1e3 * u[:, 0], "b": 1e2 * u[:, 1], "p": 1e-3 * s[:, 0], "q": 1e-6 * s[:, 1], "r": s[:, 2]},
        field_names(["ux=a:mm", "uy=b:cm", "sxx=p:kPa", "syy=q:MPa", "sxy=r:Pa"], None, False),
    ),
    "named components, and a unit for those without one": (
        lambda u, s: {"a": u, "p": 1e-3 * s[:, 0], "q": 1e-6 * s[:, 1], "sxy": 1e-3 * s[:, 2]},
        FieldNames(arrays={"displacement": "a", "sxx": "p", "syy": "q"}, factors={"stress": 1e3, "syy": 1e6}),
    ),
}


def six(s):
    zero = np.zeros(len(s))
    return np.stack([s[:, 0], s[:, 1], zero, s[:, 2], zero, zero], axis=1)


def tensor(s):
    zero = np.zeros(len(s))
    return np.stack([s[:, 0], s[:, 2], zero, s[:, 2], s[:, 1], zero, zero, zero, zero], axis=1)


@pytest.mark.parametrize("name", CONVENTIONS)
def test_names_units_and_signs(name, tmp_path):
    arrays, names = CONVENTIONS[name]
    points, cells = theirs()
    path = tmp_path / "theirs.vtu"
    meshio.Mesh(points, [("triangle", cells)], point_data=arrays(*linear(points))).write(path)
    result = read_foreign(path)
    blocks = slab("wall in bond")
    check(block_averages_of(result, plane_fields(result, names), blocks, 1.0), blocks)


@pytest.mark.parametrize("ending", ["vtu", "vtk", "avs"])
@pytest.mark.parametrize("kind", ["triangle", "quad"])
def test_formats(ending, kind, tmp_path):
    points, cells = theirs(kind=kind)
    u, s = linear(points)
    fields = {"U": np.column_stack([u, np.zeros(len(u))]), "S": six(s)}
    path = tmp_path / f"theirs.{ending}"
    meshio.Mesh(points, [(kind, cells)], point_data=fields).write(path)
    result = read_foreign(path)
    blocks = slab("concave")
    check(block_averages_of(result, plane_fields(result, NONE), blocks, 1.0), blocks)


def test_fields_of_elements_are_averaged_by_area(tmp_path):
    """Two elements of constant stress; half of each block lies in either."""
    points = np.array([(0, 0), (4, 0), (4, 3), (0, 3), (2, 0), (2, 3)], dtype=float) * 1e3
    s = np.array([(-1.0, -2.0, 0.0), (-3.0, -6.0, 1.0)]) * 1e6
    path = tmp_path / "theirs.vtu"
    meshio.Mesh(
        np.column_stack([points, np.zeros(6)]), [("quad", [[0, 4, 5, 3], [4, 1, 2, 5]])], cell_data={"stress": [six(s)]}
    ).write(path)
    result = read_foreign(path)
    blocks = bsm.Blocks.from_polygons([[(0, 0), (4, 0), (4, 1), (0, 1)], [(0, 1), (4, 1), (4, 3), (0, 3)]], rock="r")
    averages = block_averages_of(result, plane_fields(result, NONE), blocks, 1e-3)
    for k, part in enumerate(("sxx", "syy", "sxy")):
        assert_allclose(averages.fields[part], s[:, k].mean(), rtol=1e-6)


@pytest.fixture(scope="module")
def solved():
    model = bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=[bsm.Fixed(boundary="bottom")])
    return model, bsm.run(model, LINEAR)


def written(tmp_path, points, cells, **point_data):
    path = tmp_path / "theirs.vtu"
    meshio.Mesh(points, [("triangle", cells)], point_data=point_data).write(path)
    return read_foreign(path)


def test_differences_are_those_of_the_averages(solved, tmp_path):
    model, results = solved
    points, cells = theirs()
    u, s = linear(points)
    found = compare_with(model, results, written(tmp_path, points, cells, U=u, S=six(s)), NONE)
    exact = linear(model.blocks.moments.centroid)[0]
    off = np.linalg.norm(results.stages[-1].displacement[:, :2] - exact) / np.linalg.norm(exact)
    by_name = {error.name: error for error in found.errors}
    assert_allclose(by_name["displacement"].l2, off, rtol=1e-9)
    assert set(by_name) == {"sigma_xx", "sigma_yy", "sigma_xy", "sigma_1", "stress", "displacement"}
    assert found.sentence.startswith("Blocks and theirs.vtu differ by ")
    taken, constants, why = found.notes
    assert taken == "taken from the other result: U, S"
    assert "most blocks are quads" in constants
    assert why.startswith("displacements can agree only with a continuum of these constants")


@pytest.mark.heavy
def test_our_own_elements_as_another_program_would_write_them(tmp_path):
    """In mm and kPa, compression positive, second-order elements of the rock that is left: the table of compare."""
    loaded = load_model_file(TUNNEL, lambda _: None)
    model, results = loaded.model, bsm.run(loaded.model, loaded.options)
    solved = solve_continuum(model)
    there = np.isin(solved.cell_block, np.flatnonzero(solved.present))
    xx, yy, xy = solved.cell_stress[there][:, (0, 1, 0), (0, 1, 1)].T
    meshio.Mesh(
        1e3 * np.column_stack([solved.points, np.zeros(len(solved.points))]),
        [("triangle6", solved.cells[there])],
        point_data={"U": 1e3 * solved.point_displacement},
        cell_data={"SIG": [-1e-3 * np.stack([xx, yy, xy], axis=1)]},
    ).write(tmp_path / "theirs.vtu")
    names = field_names(["displacement=U:mm", "stress=SIG:kPa"], "mm", True)
    found = compare_with(model, results, read_foreign(tmp_path / "theirs.vtu"), names)
    own = compare_stages(model, results)[-1].comparison
    named = {error.name: error for error in own.errors}
    named["displacement"] = named["displacement, nominal E"]
    for error in found.errors:
        assert_allclose(error.l2, named[error.name].l2, rtol=2e-3)
        assert_allclose(error.rms_fem, named[error.name].rms_fem, rtol=1e-3)
        assert error.worst_block == named[error.name].worst_block


def test_a_unit_for_some_components_alone_is_refused(tmp_path):
    """One that counted for all would make megapascals of kilopascals."""
    points, cells = theirs()
    fields = dict(zip(("A", "B", "C"), linear(points)[1].T, strict=True))
    meshio.Mesh(points, [("triangle", cells)], point_data=fields).write(tmp_path / "theirs.vtu")
    names = field_names(["sxx=A:kPa", "syy=B", "sxy=C:kPa"], None, False)
    with pytest.raises(ModelError, match=r"'B': sxx was given a unit and syy none; .*--field syy=\"B\":kPa"):
        plane_fields(read_foreign(tmp_path / "theirs.vtu"), names)


def test_half_a_mesh(solved, tmp_path):
    model, results = solved
    points, cells = theirs()
    left = points[cells, 0].max(axis=1) < 2.1
    found = compare_with(model, results, written(tmp_path, points, cells[left], U=linear(points)[0]), NONE)
    assert_allclose(found.compared, model.blocks.moments.centroid[:, 0] < 1.7)
    assert found.stress is None
    assert "not compared: 6 blocks, less than half of which the other mesh covers" in found.notes


def test_a_collapse_is_not_comparable(tmp_path):
    model = model_of(slab("squares"), gamma=26e3, friction=30.0)
    points, cells = theirs()
    result = written(tmp_path, points, cells, U=linear(points)[0])
    found = compare_with(model, bsm.run(model), result, NONE)
    assert found.sentence.startswith("Not comparable: the blocks' stage 'initial' is unstable")
    assert found.errors == ()


def refused(solved, result, names=NONE, **keys):
    with pytest.raises(ModelError) as caught:
        compare_with(*solved, result, names, **keys)
    return str(caught.value)


def test_what_cannot_be_taken(solved, tmp_path):
    points, cells = theirs()
    u, s = linear(points)
    nothing = written(tmp_path, points, cells, temperature=u[:, 0])
    assert "neither a displacement nor a stress" in refused(solved, nothing)
    assert "'temperature' at nodes" in refused(solved, nothing)
    good = written(tmp_path, points, cells, U=u, S=s, five=np.ones((len(u), 5)))
    assert "has no array 'V'" in refused(solved, good, FieldNames(arrays={"displacement": "V"}, factors={}))
    assert "has 5 components" in refused(solved, good, FieldNames(arrays={"stress": "five"}, factors={}))
    assert "covers no block" in refused(solved, written(tmp_path, points + np.array([50, 0, 0]), cells, U=u))
    upright = written(tmp_path, points[:, [0, 2, 1]], cells, U=u)
    assert "not in a plane of x and y" in refused(solved, upright)
    assert "there is no stage 'two'" in refused(solved, good, stage="two")
    with pytest.raises(ModelError, match=r"field 'strain' is none of displacement, stress"):
        field_names(["strain=E"], None, False)
    with pytest.raises(ModelError, match="unit 'furlongs squared'"):
        field_names(["stress=S:furlongs squared"], None, False)
    with pytest.raises(ModelError, match="there is no such file"):
        read_foreign(tmp_path / "nowhere.vtu")
    (tmp_path / "solid.vtu").unlink(missing_ok=True)
    meshio.Mesh(np.eye(4, 3), [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "solid.vtu")
    with pytest.raises(ModelError, match="holds solid elements; give a plane section"):
        read_foreign(tmp_path / "solid.vtu")


def test_command(case: Case) -> None:
    points, cells = theirs()
    u, s = linear(points)
    meshio.Mesh(points, [("triangle", cells)], point_data={"disp": 1e3 * u, "S": s}).write(case.folder / "theirs.vtu")
    asked = ("compare", "model.toml", "--with", "theirs.vtu", "--field", "displacement=disp:mm")
    outcome = case.run(*asked)
    assert outcome.code == 0
    assert "Blocks and theirs.vtu differ by" in outcome.out
    grid = read_vtu(case.folder / "out/model/compare_with.vtu")
    difference = grid.cell_data["displacement"] - grid.cell_data["displacement_fem"]
    assert_allclose(grid.cell_data["displacement_difference"], difference)
    told = json.loads(case.run(*asked, "--json").out)
    assert {row["name"] for row in told["differences"]} >= {"stress", "displacement"}
    assert case.run("compare", "model.toml", "--stage", "initial").code == 2
    assert case.run(*asked, "--refine", "1").code == 2


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_pictures_of_both_sides_and_the_difference(case: Case) -> None:
    points, cells = theirs()
    u, s = linear(points)
    meshio.Mesh(points, [("triangle", cells)], point_data={"U": u, "S": s}).write(case.folder / "theirs.vtu")
    case.run("compare", "model.toml", "--with", "theirs.vtu", "--pictures", "-q")
    own = case.run("compare", "model.toml", "--pictures", "-q")
    assert "written: out/model/pictures/compare_displacement.png" in own.out
    from PIL import Image

    for name in ("compare", "compare_with"):
        for quantity in ("displacement", "sigma_1"):
            with Image.open(case.folder / f"out/model/pictures/{name}_{quantity}.png") as image:
                colours = np.asarray(image.convert("RGB")).reshape(-1, 3)
                assert len(np.unique(colours, axis=0)) > 10  # blocks of several colours
                assert image.width == 1850  # three panels side by side


def test_units_in_names_count_whoever_read_the_file(tmp_path):
    """A name that tells kN/m2 is taken at its word in a VTU too; a unit that is not known is not taken for pascals."""
    points, cells = theirs()
    u, s = linear(points)
    blocks = slab("wall in bond")

    def read(unit):
        fields = {"u [cm]": 1e2 * u, f"Sigma XX ({unit})": 1e-3 * s[:, 0], f"Sigma YY ({unit})": 1e-3 * s[:, 1]}
        fields[f"Sigma XY ({unit})"] = 1e-3 * s[:, 2]
        meshio.Mesh(points, [("triangle", cells)], point_data=fields).write(tmp_path / "theirs.vtu")
        return read_foreign(tmp_path / "theirs.vtu")

    for unit in ("kN/m^2", "kN/m²", "kPa"):
        result = read(unit)
        check(block_averages_of(result, plane_fields(result, NONE), blocks, length_factor(result, NONE)), blocks)
    with pytest.raises(
        ModelError, match=r"'Sigma XX \(kip\)': unit 'kip' is none of Pa, kPa, .*--field sxx=\"Sigma XX"
    ):
        plane_fields(read("kip"), NONE)
    names = field_names([f"s{part}=Sigma {part.upper()} (kip):kPa" for part in ("xx", "yy", "xy")], None, False)
    result = read("kip")
    check(block_averages_of(result, plane_fields(result, names), blocks, 1.0), blocks)


def test_the_stages_of_a_series():
    """By order, by whole numbers as times, or as they are named."""
    model = bsm.Model(
        blocks=slab("squares"),
        rocks=[HEAVY],
        supports=[bsm.Fixed(boundary="bottom")],
        stages=[bsm.Stage(name="heading"), bsm.Stage(name="bench")],
    )
    assert stages_of(model, [7.5], ()) == ("bench",)
    assert stages_of(model, [0.1, 0.2, 0.3], ()) == ("initial", "heading", "bench")
    assert stages_of(model, [0.0, 2.0], ()) == ("initial", "bench")
    assert stages_of(model, [3.0, 4.0], ("heading", "bench")) == ("heading", "bench")
    for times, given, fault in (
        ([0.5, 1.0], (), "2 results of the other program, 0 stages named for them, and 3 in the model"),
        ([1.0, 2.0], ("bench", "bench"), "a stage is named twice"),
        ([1.0], ("benk",), "there is no stage 'benk'; did you mean 'bench'"),
    ):
        with pytest.raises(ModelError, match=fault):
            stages_of(model, times, given)


def test_a_series_of_files_and_a_pvd(case: Case) -> None:
    model = case.folder / "model.toml"
    model.write_text(model.read_text() + '[[stage]]\nname = "later"\n')
    points, cells = theirs()
    u, s = linear(points)
    for name, factor in (("a", 1.0), ("b", 2.0)):
        fields = {"U": factor * u, "S": s}
        meshio.Mesh(points, [("triangle", cells)], point_data=fields).write(case.folder / f"{name}.vtu")
    write_pvd(case.folder / "series.pvd", [(1.0, "b.vtu"), (0.0, "a.vtu")])
    by_files = case.run("compare", "model.toml", "--with", "a.vtu", "--with", "b.vtu", "--json")
    by_pvd = case.run("compare", "model.toml", "--with", "series.pvd", "--json")
    assert by_files.code == by_pvd.code == 0
    told, same = (json.loads(outcome.out) for outcome in (by_files, by_pvd))
    assert [one["stage"] for one in told["stages"]] == ["initial", "later"]
    assert [one["differences"] for one in told["stages"]] == [one["differences"] for one in same["stages"]]
    first, second = (read_vtu(case.folder / f"out/model/compare_with_000{k}.vtu").cell_data for k in (0, 1))
    assert_allclose(second["displacement_fem"], 2 * first["displacement_fem"], rtol=1e-9)
    assert [time for time, _ in read_pvd(case.folder / "out/model/compare_with.pvd")] == [0.0, 1.0]
    assert case.run("compare", "model.toml", "--with", "a.vtu", "--stage", "initial", "--stage", "later").code == 2
