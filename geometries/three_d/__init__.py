"""Jointed rock in three dimensions, cut into cells: joint sets, single joints, tunnels, caverns and slopes.

x east, y north, z up [m]; dip and dip direction in degrees, the direction clockwise from north.
"""

from bsm_mesh.geometries.three_d.bodies import Excavation, HalfSpaces, Opening, hull, prism, slope
from bsm_mesh.geometries.three_d.joints import JointPlane, Joints, JointSet, Planes
from bsm_mesh.geometries.three_d.rock_mass import CellCut, RockMass, cut_cells

__all__ = [
    "CellCut",
    "Excavation",
    "HalfSpaces",
    "JointPlane",
    "JointSet",
    "Joints",
    "Opening",
    "Planes",
    "RockMass",
    "cut_cells",
    "hull",
    "prism",
    "slope",
]
