"""Geometries of jointed rock, scripted with Gmsh, one module a case.

Importing the package needs no Gmsh; building a case does.
"""

from geometries import circular_tunnel
from geometries.block_files import mesh_blocks, write_blocks
from geometries.cases import Case, case_names, case_parameters, find_case, parse_settings
from geometries.cutting.block_cut import BlockCut, JointAccount
from geometries.cutting.cut import cut_blocks
from geometries.errors import GeometryError
from geometries.joint_sets import Fault, JointSet, bedding
from geometries.physical_groups import GroupKind, GroupName, parse_group_name
from geometries.rock_mass import Excavation, Opening, Region, RockMass
from geometries.session import gmsh_session, name_groups, write_mesh
from geometries.settings import Parameter
from geometries.spacings import Constant, Exponential, Lognormal, Normal

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
    "JointAccount",
    "JointSet",
    "Lognormal",
    "Normal",
    "Opening",
    "Parameter",
    "Region",
    "RockMass",
    "bedding",
    "case_names",
    "case_parameters",
    "circular_tunnel",
    "cut_blocks",
    "find_case",
    "gmsh_session",
    "mesh_blocks",
    "name_groups",
    "parse_group_name",
    "parse_settings",
    "write_blocks",
    "write_mesh",
]
