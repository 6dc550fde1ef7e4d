"""The model file's tables of rocks and joints."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from bsm_mesh.model import quantities as q
from bsm_mesh.model.materials import RockStiffness
from bsm_mesh.modelfile.mesh_tables import Along, Border, Table
from bsm_mesh.modelfile.units import In


class RockTable(Table):
    """A rock."""

    unit_weight: Annotated[float, In(q.UNIT_WEIGHT)]
    young: Annotated[float, In(q.YOUNG)] | None = None
    poisson: Annotated[float, In(q.POISSON)] | None = None
    cohesion: Annotated[float, In(q.COHESION)] | None = None
    friction: Annotated[float, In(q.FRICTION)] | None = None
    tensile_strength: Annotated[float, In(q.TENSILE_STRENGTH)] | None = None
    stiffness: RockStiffness = "wang"
    residual_friction: Annotated[float, In(q.FRICTION)] | None = None
    residual_cohesion: Annotated[float, In(q.COHESION)] | None = Field(
        default=None, description="with it, or with residual_friction, faces fall to both at their first slip"
    )
    softening_slip: Annotated[float, In(q.SLIP)] | None = Field(
        default=None, description="slip over which strength falls to the residual values"
    )
    residual_tensile_strength: Annotated[float, In(q.TENSILE_STRENGTH)] = Field(
        default=0.0, description="tension that faces still bear once they have failed by slip"
    )


class FillingTable(Table):
    """A joint's filling."""

    thickness: Annotated[float, In(q.THICKNESS)]
    young: Annotated[float, In(q.YOUNG)]
    poisson: Annotated[float, In(q.POISSON)]


class JointTable(Table):
    """A joint or joint set."""

    along: Along | None = Field(default=None, description="lines over the mesh, or a file of them: elements are cut")
    between: str | Border | None = Field(
        default=None, description='two rocks or groups of the mesh; "rocks": any two; or an array of whole numbers'
    )

    normal_stiffness: Annotated[float, In(q.STIFFNESS)] | None = None
    shear_stiffness: Annotated[float, In(q.STIFFNESS)] | None = None
    filling: FillingTable | None = None
    law: Literal["patton", "mohr_coulomb", "barton_bandis", "ladanyi_archambault"] | None = Field(
        default=None, description="patton where friction is given without it"
    )
    friction: Annotated[float, In(q.FRICTION)] | None = None
    dilation: Annotated[float, In(q.DILATION)] | None = None
    cohesion: Annotated[float, In(q.JOINT_COHESION)] | None = None
    residual_friction: Annotated[float, In(q.FRICTION)] | None = None
    residual_cohesion: Annotated[float, In(q.JOINT_COHESION)] | None = Field(
        default=None, description="mohr_coulomb: with it, or with residual_friction, joints fall to both at first slip"
    )
    softening_slip: Annotated[float, In(q.SLIP)] | None = Field(
        default=None, description="mohr_coulomb: slip over which strength falls to the residual values"
    )
    jrc: Annotated[float, In(q.JRC)] | None = Field(
        default=None, description="barton_bandis: joint roughness coefficient of a sample 0.1 m long"
    )
    jcs: Annotated[float, In(q.WALL_STRENGTH)] | None = Field(
        default=None, description="joint wall compressive strength; barton_bandis: of such a sample"
    )
    joint_length: Annotated[float, In(q.JOINT_LENGTH)] | None = Field(
        default=None, description="barton_bandis: length of the joint, or of the blocks along it; default: 0.1 m"
    )
    roughness_wears: bool | None = Field(
        default=None, description="barton_bandis: true: slip beyond the peak wears roughness off"
    )
    tensile_strength: Annotated[float, In(q.JOINT_TENSILE_STRENGTH)] | None = Field(
        default=None, description="default: 0"
    )
    residual_tensile_strength: Annotated[float, In(q.JOINT_TENSILE_STRENGTH)] = Field(
        default=0.0, description="tension that it still bears once it has failed by slip"
    )
    max_closure: Annotated[float, In(q.CLOSURE)] | None = Field(
        default=None,
        description="greatest closure: joints close by a hyperbola; normal_stiffness is that without stress",
    )
    dilation_angle: Annotated[float, In(q.DILATION)] = Field(
        default=0.0, description="angle by which the walls part as they slide; strength is the law's own"
    )
    dilation_slip: Annotated[float, In(q.SLIP)] | None = Field(
        default=None, description="slip after which dilation_angle has worn off"
    )
    shear_stiffness_exponent: Annotated[float, In(q.STIFFNESS_EXPONENT)] | None = Field(
        default=None, description="power of normal stress over reference_stress by which shear_stiffness grows"
    )
    reference_stress: Annotated[float, In(q.REFERENCE_STRESS)] | None = Field(
        default=None,
        description="normal stress of shear_stiffness; without that, barton_bandis gives it: peak over displacement",
    )
    crushing_strength: Annotated[float, In(q.WALL_STRENGTH)] | None = Field(
        default=None, description="effective normal stress that crushes the walls: notes say where; it limits nothing"
    )
    aperture: Annotated[float, In(q.APERTURE)] | None = Field(
        default=None, description="hydraulic aperture without normal stress, for flow; 0: sealed"
    )
    residual_aperture: Annotated[float, In(q.APERTURE)] = Field(
        default=0.0, description="aperture that no stress closes"
    )
