"""The grammar of group names, and that the package needs no Gmsh to be imported."""

import subprocess
import sys

import pytest

from bsm_mesh.geometries import physical_groups
from bsm_mesh.geometries.physical_groups import GroupKind, GroupName, parse_group_name


@pytest.mark.parametrize("kind", list(GroupKind))
def test_a_written_name_is_parsed_back(kind):
    name = GroupName(kind, "J1: upper")
    assert parse_group_name(str(name)) == name


@pytest.mark.parametrize("text", ["Schist", "rock:", ":gneiss", "rok:gneiss", "", "rock :  "])
def test_other_texts_are_no_group(text):
    assert parse_group_name(text) is None


def test_spaces_and_capitals_do_not_count():
    assert parse_group_name(" Rock : gneiss ") == GroupName(GroupKind.ROCK, "gneiss")


def test_rocks_and_excavations_are_surfaces():
    surfaces = {kind for kind in GroupKind if kind.dimension == 2}
    assert surfaces == {GroupKind.ROCK, GroupKind.EXCAVATION}


def test_helpers_write_what_the_parser_reads():
    for kind in GroupKind:
        assert getattr(physical_groups, kind.value)("a") == f"{kind.value}:a"


@pytest.mark.heavy
def test_importing_geometries_imports_no_gmsh():
    script = (
        "import sys; from bsm_mesh import geometries; geometries.case_names(); "
        "geometries.case_parameters(geometries.find_case('circular_tunnel')); "
        "sys.exit(bool({'gmsh', 'meshio', 'bsm_mesh.model', 'bsm_mesh.converters'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
