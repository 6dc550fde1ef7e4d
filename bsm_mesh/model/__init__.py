"""What is given: blocks, rocks, joints, supports, loads, bolts, and the model that holds them."""

from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.joint_laws import MohrCoulomb, Patton
from bsm_mesh.model.loads import EdgeTractions, PointLoad, Pressure, Traction
from bsm_mesh.model.materials import Filling, Joint, Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Fixed, NormalRoller, PrescribedDisplacement, Roller

__all__ = [
    "Blocks",
    "Bolt",
    "EdgeTractions",
    "Filling",
    "Fixed",
    "Joint",
    "Model",
    "MohrCoulomb",
    "NormalRoller",
    "Patton",
    "PointLoad",
    "PrescribedDisplacement",
    "Pressure",
    "Rock",
    "Roller",
    "Traction",
]
