"""Geometries of jointed rock, scripted with Gmsh, one module a case.

Importing the package needs no Gmsh; building a case does.
"""

from geometries import circular_tunnel
from geometries.cases import Case, case_names, case_parameters, find_case, parse_settings
from geometries.errors import GeometryError
from geometries.physical_groups import GroupKind, GroupName, parse_group_name
from geometries.session import gmsh_session, name_groups, write_mesh
from geometries.settings import Parameter

__all__ = [
    "Case",
    "GeometryError",
    "GroupKind",
    "GroupName",
    "Parameter",
    "case_names",
    "case_parameters",
    "circular_tunnel",
    "find_case",
    "gmsh_session",
    "name_groups",
    "parse_group_name",
    "parse_settings",
    "write_mesh",
]
