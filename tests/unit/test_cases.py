"""Cases by name and by script: what they take, and the text when they fail."""

import math
import textwrap

import pytest

from bsm_mesh import geometries
from bsm_mesh.geometries.cases import case_names, case_parameters, find_case, parse_settings
from bsm_mesh.geometries.errors import GeometryError

SQUARE = """
    '''A square block.'''
    from __future__ import annotations

    from bsm_mesh.geometries import gmsh_session, name_groups, write_mesh


    def build(path, width: float = 1.0, pieces: int = 2, joints: list[float] | None = None):
        '''Write a square.

        Parameters
        ----------
        path : str
            The file.
        width : float
            Length of a side,
            in metres.
        pieces : int
            Elements along a side.
        '''
        with gmsh_session("square") as gmsh:
            square = gmsh.model.occ.addRectangle(0, 0, 0, width, width)
            gmsh.model.occ.synchronize()
            gmsh.model.mesh.setTransfiniteSurface(square)
            gmsh.model.mesh.generate(2)
            name_groups({"rock:granite": [square]})
            write_mesh(path)
"""


@pytest.fixture
def script(tmp_path):
    """Write the text of a script to a file and return its path."""

    def write(text, name="slope.py"):
        path = tmp_path / name
        path.write_text(textwrap.dedent(text).lstrip())
        return path

    return write


def line_of(path, text):
    return 1 + next(number for number, line in enumerate(path.read_text().splitlines()) if text in line)


def test_every_case_is_found_by_its_name():
    assert "circular_tunnel" in case_names()
    for name in case_names():
        case = find_case(name)
        assert case.function is getattr(geometries, name).build
        assert case.summary
        assert case.script is None


def test_a_hyphen_stands_for_an_underscore():
    assert find_case("circular-tunnel").name == "circular_tunnel"


def test_every_parameter_of_every_case_has_a_default_and_a_description():
    for name in case_names():
        for parameter in case_parameters(find_case(name)).values():
            assert not parameter.required
            assert parameter.summary.endswith((".", "]"))


def test_parameters_come_from_the_signature():
    parameters = case_parameters(find_case("circular_tunnel"))
    assert list(parameters)[:3] == ["radius", "depth", "below"]
    assert parameters["radius"].default == 2.0
    assert parameters["radius"].summary == "Radius of the tunnel [m]."
    assert parameters["below"].kind == "a number in SI units or none"
    assert parameters["mesh"].kind == "one of triangles, quads, radial"
    assert not {"path", "unknown"} & set(parameters)


def test_texts_become_values_of_the_parameters_types():
    texts = {
        "radius": "2.5",
        "below": "none",
        "width": "1e1",
        "half": "No",
        "order": "2",
        "mesh": "quads",
        "rock": "1",
    }
    values = parse_settings(find_case("circular_tunnel"), texts)
    assert values == dict(radius=2.5, below=None, width=10.0, half=False, order=2, mesh="quads", rock="1")
    assert values["half"] is False
    assert isinstance(values["order"], int)


def test_all_texts_that_do_not_fit_are_reported():
    texts = {"radius": "wide", "half": "maybe", "mesh": "hexagons", "order": "3", "sise": "1"}
    with pytest.raises(GeometryError) as caught:
        parse_settings(find_case("circular_tunnel"), texts)
    text = str(caught.value)
    assert len(caught.value.faults) == 5
    assert "circular_tunnel: radius = 'wide' does not fit; give a number in SI units" in text
    assert "half = 'maybe' does not fit; give true or false" in text
    assert "no parameter 'sise'; did you mean 'size'?" in text


@pytest.mark.parametrize("name", case_names())
def test_every_case_refuses_what_it_does_not_take_with_the_nearest_that_it_does(name, tmp_path):
    case, path = find_case(name), tmp_path / "x.msh"
    slips = {f"{parameter}_": parameter for parameter in case_parameters(case)}
    with pytest.raises(GeometryError) as caught:
        case.build(path, **dict.fromkeys(slips, 1.0))
    assert [fault.partition(" (")[0] for fault in caught.value.faults] == [
        f"{name}: there is no parameter '{slip}'; did you mean '{meant}'?" for slip, meant in slips.items()
    ]
    assert not path.exists()


def test_a_case_is_built_from_texts(tmp_path):
    case = find_case("circular_tunnel")
    path = case.build(tmp_path / "tunnel.msh", **parse_settings(case, {"size": "2", "radius": "3"}))
    assert path.stat().st_size > 0


def test_an_unknown_case_is_an_error_with_the_nearest_name():
    with pytest.raises(GeometryError, match=r"no case 'circular_tunel'; did you mean 'circular_tunnel'\?"):
        find_case("circular_tunel")


def test_a_helper_module_is_no_case():
    with pytest.raises(GeometryError, match="no case 'session'"):
        find_case("session")


def test_a_script_is_a_case(script, tmp_path):
    pytest.importorskip("gmsh")
    case = find_case(str(script(SQUARE)))
    assert case.name == "slope"
    assert case.summary == "A square block."
    parameters = case_parameters(case)
    assert list(parameters) == ["width", "pieces", "joints"]
    assert parameters["width"].summary == "Length of a side, in metres."
    values = parse_settings(case, {"pieces": "3", "joints": "[30, 60.5]"})
    assert values == {"pieces": 3, "joints": [30, 60.5]}
    assert case.build(tmp_path / "slope.msh", **values).is_file()


def test_a_script_may_import_its_neighbour(script):
    script("SIDE = 3.0\n", "sizes_of_slope.py")
    path = script("from sizes_of_slope import SIDE\n\n\ndef build(path, side=SIDE): ...\n")
    assert case_parameters(find_case(path))["side"].default == 3.0


def test_unknown_and_missing_parameters_of_a_script_are_named(script, tmp_path):
    case = find_case(script("def build(path, *, height, dip=60.0): ...\n"))
    assert case_parameters(case)["height"].required
    with pytest.raises(GeometryError) as caught:
        case.build(tmp_path / "slope.msh", dipp=3)
    assert "no parameter 'dipp'; did you mean 'dip'?" in caught.value.faults[0]
    assert caught.value.faults[1] == "slope: give the parameter 'height'"


def test_a_script_with_open_parameters_takes_any(script):
    case = find_case(script("def build(path, **parameters): ...\n"))
    assert parse_settings(case, {"dip": "60", "name": "north"}) == {"dip": 60, "name": "north"}


def test_what_a_script_raises_is_told_with_file_and_line(script, tmp_path):
    path = script("import math\n\n\ndef build(path, dip=-1.0):\n    return math.sqrt(dip)\n")
    with pytest.raises(GeometryError, match=r"slope.py, line 5: ValueError: math domain error") as caught:
        find_case(path).build(tmp_path / "slope.msh")
    assert type(caught.value.__cause__) is ValueError


def test_what_gmsh_raises_in_a_script_is_told_with_the_line_of_the_call(script, tmp_path):
    pytest.importorskip("gmsh")
    path = script(SQUARE.replace("setTransfiniteSurface(square)", "setTransfiniteSurface(99)"))
    line = line_of(path, "setTransfiniteSurface")
    with pytest.raises(GeometryError, match=f"slope.py, line {line}: square: Gmsh reports: ") as caught:
        find_case(path).build(tmp_path / "slope.msh")
    assert isinstance(caught.value.__cause__, GeometryError)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\ny = 1 +\n", r"line 2: SyntaxError"),
        ("x = 1\nimport no_such_module\n", r"line 2: ModuleNotFoundError"),
        ("x = 1\nraise SystemExit(3)\n", r"line 2: SystemExit: 3"),
        ("x = 1\n", r"has no function build; define build\(path, \*\*parameters\)"),
        ("def build(): ...\n", r"build takes no path"),
    ],
)
def test_a_script_that_cannot_be_loaded_is_told(text, message, script):
    with pytest.raises(GeometryError, match=rf"slope\.py.*{message}"):
        find_case(script(text))


def test_a_script_that_is_not_there_is_told_with_the_nearest(script, tmp_path):
    script("", "slope.py")
    with pytest.raises(GeometryError, match=r"no script .*slop\.py; did you mean 'slope\.py'\?"):
        find_case(tmp_path / "slop.py")


def test_a_script_that_writes_nothing_is_told(script, tmp_path):
    (tmp_path / "slope.msh").write_text("of yesterday")
    with pytest.raises(GeometryError, match=r"build wrote no file .*slope\.msh"):
        find_case(script("def build(path): ...\n")).build(tmp_path / "slope.msh")


def test_numbers_of_a_case_are_not_lost_in_text():
    parameter = case_parameters(find_case("circular_tunnel"))["radius"]
    assert parameter.parse(repr(math.pi)) == math.pi
