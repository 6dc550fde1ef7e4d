"""Geometries of jointed rock, scripted with Gmsh, one module a case.

Importing the package needs neither Gmsh nor NumPy; the names that do are loaded when they are first used.
"""

from __future__ import annotations

if __name__ == "geometries":  # imported by the folder's own name
    from bsm_mesh.checkout import hand_over

    hand_over(__name__)

from typing import TYPE_CHECKING

from bsm_mesh.geometries import circular_tunnel
from bsm_mesh.geometries.cases import Case, case_names, case_parameters, find_case, parse_settings
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.physical_groups import GroupKind, GroupName, parse_group_name
from bsm_mesh.geometries.session import gmsh_session, name_groups, write_mesh
from bsm_mesh.geometries.settings import Parameter
from bsm_mesh.lazy import names_from

if TYPE_CHECKING:
    from bsm_mesh.geometries.abutting import abutting_sets
    from bsm_mesh.geometries.block_files import mesh_blocks, write_blocks
    from bsm_mesh.geometries.cutting.block_cut import BlockCut, JointAccount
    from bsm_mesh.geometries.cutting.cut import cut_blocks
    from bsm_mesh.geometries.fractures import read_fractures
    from bsm_mesh.geometries.gmsh_joints import find_curves, fragment_by_joints
    from bsm_mesh.geometries.joint_sets import Fault, JointSet, bedding
    from bsm_mesh.geometries.kinematic_net import draw_kinematics
    from bsm_mesh.geometries.kinematics import Kinematics, kinematic_screening
    from bsm_mesh.geometries.orientations import (
        apparent_dip,
        apparent_spacing,
        joint_set_in_section,
        joint_sets_of_scan_line,
    )
    from bsm_mesh.geometries.outline_mesh import OutlineMesher
    from bsm_mesh.geometries.patterns import Heads, Voronoi, bricks
    from bsm_mesh.geometries.quarters import quarter_blocks
    from bsm_mesh.geometries.rock_mass import Excavation, Opening, Region, RockMass
    from bsm_mesh.geometries.sections import read_section
    from bsm_mesh.geometries.shapes import band, circle, dam, horseshoe, rectangle, slope, stope, vaulted_box
    from bsm_mesh.geometries.short_sides import close_short_sides
    from bsm_mesh.geometries.spacings import Constant, Exponential, Lognormal, Normal, PowerLaw
    from bsm_mesh.geometries.stereonet import draw_stereonet
    from bsm_mesh.geometries.trace_tables import read_orientations, read_scan_line
    from bsm_mesh.geometries.traces import read_traces

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
    "Kinematics",
    "Lognormal",
    "Normal",
    "Opening",
    "OutlineMesher",
    "Parameter",
    "PowerLaw",
    "Region",
    "RockMass",
    "Voronoi",
    "abutting_sets",
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
    "draw_kinematics",
    "draw_stereonet",
    "find_case",
    "find_curves",
    "fragment_by_joints",
    "gmsh_session",
    "horseshoe",
    "joint_set_in_section",
    "joint_sets_of_scan_line",
    "kinematic_screening",
    "mesh_blocks",
    "name_groups",
    "parse_group_name",
    "parse_settings",
    "quarter_blocks",
    "read_fractures",
    "read_orientations",
    "read_scan_line",
    "read_section",
    "read_traces",
    "rectangle",
    "slope",
    "stope",
    "vaulted_box",
    "write_blocks",
    "write_mesh",
]

_HOME = {
    "abutting_sets": "bsm_mesh.geometries.abutting",
    "apparent_dip": "bsm_mesh.geometries.orientations",
    "apparent_spacing": "bsm_mesh.geometries.orientations",
    "draw_stereonet": "bsm_mesh.geometries.stereonet",
    "joint_set_in_section": "bsm_mesh.geometries.orientations",
    "joint_sets_of_scan_line": "bsm_mesh.geometries.orientations",
    "Kinematics": "bsm_mesh.geometries.kinematics",
    "kinematic_screening": "bsm_mesh.geometries.kinematics",
    "draw_kinematics": "bsm_mesh.geometries.kinematic_net",
    "read_orientations": "bsm_mesh.geometries.trace_tables",
    "read_section": "bsm_mesh.geometries.sections",
    "read_fractures": "bsm_mesh.geometries.fractures",
    "read_scan_line": "bsm_mesh.geometries.trace_tables",
    "read_traces": "bsm_mesh.geometries.traces",
    "Heads": "bsm_mesh.geometries.patterns",
    "Voronoi": "bsm_mesh.geometries.patterns",
    "bricks": "bsm_mesh.geometries.patterns",
    "band": "bsm_mesh.geometries.shapes",
    "circle": "bsm_mesh.geometries.shapes",
    "dam": "bsm_mesh.geometries.shapes",
    "find_curves": "bsm_mesh.geometries.gmsh_joints",
    "fragment_by_joints": "bsm_mesh.geometries.gmsh_joints",
    "horseshoe": "bsm_mesh.geometries.shapes",
    "rectangle": "bsm_mesh.geometries.shapes",
    "slope": "bsm_mesh.geometries.shapes",
    "stope": "bsm_mesh.geometries.shapes",
    "vaulted_box": "bsm_mesh.geometries.shapes",
    "BlockCut": "bsm_mesh.geometries.cutting.block_cut",
    "Constant": "bsm_mesh.geometries.spacings",
    "Excavation": "bsm_mesh.geometries.rock_mass",
    "Exponential": "bsm_mesh.geometries.spacings",
    "Fault": "bsm_mesh.geometries.joint_sets",
    "JointAccount": "bsm_mesh.geometries.cutting.block_cut",
    "JointSet": "bsm_mesh.geometries.joint_sets",
    "Lognormal": "bsm_mesh.geometries.spacings",
    "Normal": "bsm_mesh.geometries.spacings",
    "PowerLaw": "bsm_mesh.geometries.spacings",
    "Opening": "bsm_mesh.geometries.rock_mass",
    "OutlineMesher": "bsm_mesh.geometries.outline_mesh",
    "Region": "bsm_mesh.geometries.rock_mass",
    "RockMass": "bsm_mesh.geometries.rock_mass",
    "bedding": "bsm_mesh.geometries.joint_sets",
    "cut_blocks": "bsm_mesh.geometries.cutting.cut",
    "mesh_blocks": "bsm_mesh.geometries.block_files",
    "quarter_blocks": "bsm_mesh.geometries.quarters",
    "close_short_sides": "bsm_mesh.geometries.short_sides",
    "write_blocks": "bsm_mesh.geometries.block_files",
}


if not TYPE_CHECKING:
    __getattr__ = names_from(_HOME, __name__)


def __dir__() -> list[str]:
    return __all__
