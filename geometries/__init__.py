"""Geometries of jointed rock, scripted with Gmsh, one module a case.

Importing the package needs no Gmsh; building a case does.
"""

from geometries.physical_groups import GroupKind, GroupName, parse_group_name

__all__ = ["GroupKind", "GroupName", "parse_group_name"]
