"""The model file's tables of bolts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from bsm_mesh.model import quantities as q
from bsm_mesh.model.bolts import BoltKind
from bsm_mesh.modelfile.mesh_tables import PathText, Table
from bsm_mesh.modelfile.units import In, Point


class RadialTable(Table):
    """Bolts that point away from a centre, their heads on a circle."""

    centre: Point
    radius: Annotated[float, In(q.RADIUS)]
    length: Annotated[float, In(q.BOLT_LENGTH)]
    count: Annotated[int, In(q.BOLT_COUNT)]
    first: Annotated[float, In(q.DIRECTION)] = Field(default=0.0, description="direction of the first bolt")
    last: Annotated[float, In(q.DIRECTION)] = Field(default=180.0, description="direction of the last bolt")


class RowTable(Table):
    """Bolts in a row along a boundary, into the rock."""

    boundary: str
    length: Annotated[float, In(q.BOLT_LENGTH)]
    interval: Annotated[float, In(q.BOLT_INTERVAL)] = Field(description="distance of the heads along the boundary")
    offset: Annotated[float, In(q.DISTANCE)] | None = Field(
        default=None, description="of the first head; default: half an interval"
    )
    direction: Annotated[float, In(q.DIRECTION)] | None = Field(
        default=None, description="of all bolts; default: normal to the boundary"
    )


class BoltTable(Table):
    """A bolt (start and end) or many (one of radial, row, curve, table); forces are those of one bolt."""

    start: Point | None = Field(default=None, description="head")
    end: Point | None = Field(default=None, description="tip")
    radial: RadialTable | None = None
    row: RowTable | None = None
    curve: str | None = Field(default=None, description='NAME of the mesh group "bolt:NAME"')
    table: PathText | None = Field(default=None, description="CSV file: start_x, start_y, end_x, end_y and other keys")
    name: str = ""
    kind: BoltKind = "grouted"
    diameter: Annotated[float, In(q.BOLT_DIAMETER)] | None = None
    young: Annotated[float, In(q.BOLT_YOUNG)] = 200e9
    stiffness: Annotated[float, In(q.BOLT_STIFFNESS)] | None = Field(
        default=None, description="axial, times length, in N; default: young times the section"
    )
    yield_strength: Annotated[float, In(q.YIELD_STRENGTH)] | None = Field(
        default=None, description="of the steel; default: unlimited"
    )
    pretension: Annotated[float, In(q.BOLT_FORCE)] = 0.0
    anchor_capacity: Annotated[float, In(q.BOLT_CAPACITY)] | None = Field(
        default=None, description="end_anchored only; default: unlimited"
    )
    spacing: Annotated[float, In(q.BOLT_SPACING)] = Field(default=1.0, description="out of the plane")
    stage: str | None = Field(default=None, description="stage that installs it; default: there from the start")
    bond_strength: Annotated[float, In(q.BOND_STRENGTH)] | None = Field(
        default=None, description="grouted only; default: unlimited"
    )
    hole_diameter: Annotated[float, In(q.HOLE_DIAMETER)] | None = None
    bond_steel_grout: Annotated[float, In(q.BOND_SHEAR_STRENGTH)] | None = None
    bond_grout_rock: Annotated[float, In(q.BOND_SHEAR_STRENGTH)] | None = None
    bond_stiffness: Annotated[float, In(q.BOND_STIFFNESS)] | None = Field(
        default=None, description="per length of bolt, in N/m2; default: rigid"
    )
    bearing_stiffness: Annotated[float, In(q.BOND_STIFFNESS)] | None = Field(
        default=None, description="dowel action: of the grout, N/m2; default: none"
    )
    bearing_strength: Annotated[float, In(q.BEARING_STRENGTH)] | None = Field(
        default=None, description="of grout or rock; default: unlimited shear"
    )
    plate: Annotated[float, In(q.BOLT_FORCE)] = Field(
        default=0.0, description="capacity of a face plate at the head; grouted only"
    )
