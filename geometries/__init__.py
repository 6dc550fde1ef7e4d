"""Geometries of jointed rock, scripted with Gmsh, one module a case.

Importing the package needs neither Gmsh nor NumPy; the names that do are loaded when they are first used.
"""

from __future__ import annotations

if __name__ == "geometries":  # imported by the folder's own name
    from bsm_mesh.checkout import hand_over

    hand_over(__name__)

from importlib import import_module
from typing import TYPE_CHECKING, Any

from geometries import circular_tunnel
from geometries.cases import Case, case_names, case_parameters, find_case, parse_settings
from geometries.errors import GeometryError
from geometries.physical_groups import GroupKind, GroupName, parse_group_name
from geometries.session import gmsh_session, name_groups, write_mesh
from geometries.settings import Parameter

if TYPE_CHECKING:
    from geometries.block_files import mesh_blocks, write_blocks
    from geometries.cutting.block_cut import BlockCut, JointAccount
    from geometries.cutting.cut import cut_blocks
    from geometries.joint_sets import Fault, JointSet, bedding
    from geometries.orientations import (
        apparent_dip,
        apparent_spacing,
        draw_stereonet,
        joint_set_in_section,
        joint_sets_of_scan_line,
    )
    from geometries.patterns import Heads, Voronoi, bricks
    from geometries.quarters import quarter_blocks
    from geometries.rock_mass import Excavation, Opening, Region, RockMass
    from geometries.shapes import band, circle, dam, horseshoe, rectangle, slope, stope, vaulted_box
    from geometries.short_sides import close_short_sides
    from geometries.spacings import Constant, Exponential, Lognormal, Normal
    from geometries.traces import read_scan_line, read_traces

__all__ = [
    "BlockCut",
    "Case",
    "Constant",
    "Excavation",
    "Exponential",
    "Fault",
    "GeometryError",
    "GroupKind",
    "GroupName",
    "Heads",
    "JointAccount",
    "JointSet",
    "Lognormal",
    "Normal",
    "Opening",
    "Parameter",
    "Region",
    "RockMass",
    "Voronoi",
    "apparent_dip",
    "apparent_spacing",
    "band",
    "bedding",
    "bricks",
    "case_names",
    "case_parameters",
    "circle",
    "circular_tunnel",
    "close_short_sides",
    "cut_blocks",
    "dam",
    "draw_stereonet",
    "find_case",
    "gmsh_session",
    "horseshoe",
    "joint_set_in_section",
    "joint_sets_of_scan_line",
    "mesh_blocks",
    "name_groups",
    "parse_group_name",
    "parse_settings",
    "quarter_blocks",
    "read_scan_line",
    "read_traces",
    "rectangle",
    "slope",
    "stope",
    "vaulted_box",
    "write_blocks",
    "write_mesh",
]

_HOME = {
    "apparent_dip": "geometries.orientations",
    "apparent_spacing": "geometries.orientations",
    "draw_stereonet": "geometries.orientations",
    "joint_set_in_section": "geometries.orientations",
    "joint_sets_of_scan_line": "geometries.orientations",
    "read_scan_line": "geometries.traces",
    "read_traces": "geometries.traces",
    "Heads": "geometries.patterns",
    "Voronoi": "geometries.patterns",
    "bricks": "geometries.patterns",
    "band": "geometries.shapes",
    "circle": "geometries.shapes",
    "dam": "geometries.shapes",
    "horseshoe": "geometries.shapes",
    "rectangle": "geometries.shapes",
    "slope": "geometries.shapes",
    "stope": "geometries.shapes",
    "vaulted_box": "geometries.shapes",
    "BlockCut": "geometries.cutting.block_cut",
    "Constant": "geometries.spacings",
    "Excavation": "geometries.rock_mass",
    "Exponential": "geometries.spacings",
    "Fault": "geometries.joint_sets",
    "JointAccount": "geometries.cutting.block_cut",
    "JointSet": "geometries.joint_sets",
    "Lognormal": "geometries.spacings",
    "Normal": "geometries.spacings",
    "Opening": "geometries.rock_mass",
    "Region": "geometries.rock_mass",
    "RockMass": "geometries.rock_mass",
    "bedding": "geometries.joint_sets",
    "cut_blocks": "geometries.cutting.cut",
    "mesh_blocks": "geometries.block_files",
    "quarter_blocks": "geometries.quarters",
    "close_short_sides": "geometries.short_sides",
    "write_blocks": "geometries.block_files",
}


def __getattr__(name: str) -> Any:
    """Return a public name from the module that defines it."""
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
