"""The input: blocks, rocks, joints, supports, loads, bolts, and the model that holds them."""

from bsm_mesh.model.beside import Beside
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.earth_pressure import EarthPressure
from bsm_mesh.model.flow import Drain, Flow, FlowChange, Grout, Well
from bsm_mesh.model.histories import History
from bsm_mesh.model.hoek_brown import HoekBrown
from bsm_mesh.model.in_situ import InSitu
from bsm_mesh.model.joint_laws import BartonBandis, JointResponse, LadanyiArchambault, MohrCoulomb, Patton
from bsm_mesh.model.loads import EdgeTractions, InSituTraction, PointLoad, Pressure, Traction
from bsm_mesh.model.materials import Filling, Joint, Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.supports import Fixed, NormalRoller, PrescribedDisplacement, Roller
from bsm_mesh.model.water import HeadPlane, Water
from bsm_mesh.model.zones import Zones

__all__ = [
    "BartonBandis",
    "Beside",
    "Blocks",
    "Bolt",
    "Drain",
    "EarthPressure",
    "EdgeTractions",
    "Filling",
    "Fixed",
    "Flow",
    "FlowChange",
    "Grout",
    "HeadPlane",
    "History",
    "HoekBrown",
    "InSitu",
    "InSituTraction",
    "Joint",
    "JointResponse",
    "LadanyiArchambault",
    "Model",
    "MohrCoulomb",
    "NormalRoller",
    "Patton",
    "PointLoad",
    "PrescribedDisplacement",
    "Pressure",
    "Rock",
    "Roller",
    "Shaking",
    "Stage",
    "Traction",
    "Water",
    "Well",
    "Zones",
]
