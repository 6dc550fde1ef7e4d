"""The model file's tables of rocks and joints."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from bsm_mesh.model import quantities as q
from bsm_mesh.model.hoek_brown import HoekBrown
from bsm_mesh.model.joint_laws import LAWS
from bsm_mesh.model.materials import Filling, Joint, Rock
from bsm_mesh.model.zones import Zones
from bsm_mesh.modelfile.class_keys import keys_of
from bsm_mesh.modelfile.mesh_tables import Along, Border, Table


@keys_of(Zones)
class ZonesTable(Table):
    """Triangles that the blocks of a rock are divided into, so that they deform."""


@keys_of(HoekBrown)
class HoekBrownTable(Table):
    """The strength of a rock mass after Hoek and Brown."""


@keys_of(Rock, without=("name", "zones", "hoek_brown"))
class RockTable(Table):
    """A rock."""

    zones: ZonesTable | None = Field(default=None, description="its blocks deform; left out: they are rigid")
    hoek_brown: HoekBrownTable | None = Field(
        default=None, description='the strength of its zones, with zones = { law = "hoek_brown" }'
    )


@keys_of(Filling)
class FillingTable(Table):
    """A joint's filling."""


@keys_of(*LAWS.values(), optional=True, names={kind: name for name, kind in LAWS.items()})
@keys_of(Joint, without=("name",))
class JointTable(Table):
    """A joint or joint set."""

    along: Along | None = Field(default=None, description="lines over the mesh, or a file of them: elements are cut")
    between: str | Border | None = Field(
        default=None, description='two rocks or groups of the mesh; "rocks": any two; or an array of whole numbers'
    )
    filling: FillingTable | None = None
    law: Literal["patton", "mohr_coulomb", "barton_bandis", "ladanyi_archambault"] | None = Field(
        default=None, description="patton where friction is given without it"
    )
    tensile_strength: Annotated[float, q.JOINT_TENSILE_STRENGTH] | None = Field(default=None, description="default: 0")
