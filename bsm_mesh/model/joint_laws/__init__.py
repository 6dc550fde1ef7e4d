"""Joint laws, one a file: their shear strength under a pressure, and their memory (`law`)."""

from typing import Any

from bsm_mesh.model.joint_laws.barton_bandis import BartonBandis
from bsm_mesh.model.joint_laws.elastic import Elastic
from bsm_mesh.model.joint_laws.ladanyi_archambault import LadanyiArchambault
from bsm_mesh.model.joint_laws.law import (
    BEYOND_STRENGTH,
    JointLaw,
    JointResponse,
    ReducibleLaw,
    StraightLaw,
    WearingLaw,
    handed_on,
    memory_of,
    remembered_by,
    signed,
    wear_length_of,
)
from bsm_mesh.model.joint_laws.mohr_coulomb import MohrCoulomb
from bsm_mesh.model.joint_laws.patton import Patton
from bsm_mesh.model.joint_laws.reduction import refuse_factor
from bsm_mesh.model.joint_laws.weaker import Weaker

LAWS: dict[str, type[Any]] = {
    "patton": Patton,
    "mohr_coulomb": MohrCoulomb,
    "barton_bandis": BartonBandis,
    "ladanyi_archambault": LadanyiArchambault,
}
"""Laws by the names that a model file gives them; the fields of each are its keys there."""

__all__ = [
    "BEYOND_STRENGTH",
    "LAWS",
    "BartonBandis",
    "Elastic",
    "JointLaw",
    "JointResponse",
    "LadanyiArchambault",
    "MohrCoulomb",
    "Patton",
    "ReducibleLaw",
    "StraightLaw",
    "Weaker",
    "WearingLaw",
    "handed_on",
    "memory_of",
    "refuse_factor",
    "remembered_by",
    "signed",
    "wear_length_of",
]
