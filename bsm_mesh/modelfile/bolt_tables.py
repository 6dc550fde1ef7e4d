"""The model file's tables of bolts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from bsm_mesh.model import quantities as q
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.modelfile.class_keys import keys_of
from bsm_mesh.modelfile.mesh_tables import PathText, Table
from bsm_mesh.modelfile.units import Point, Vector


class RadialTable(Table):
    """Bolts that point away from a centre, their heads on a circle."""

    centre: Point = Field(description="x and y")
    radius: Annotated[float, q.RADIUS] = Field(description="of the circle with the heads")
    length: Annotated[float, q.BOLT_LENGTH] = Field(description="of every bolt")
    count: Annotated[int, q.BOLT_COUNT] = Field(description="bolts from first to last, at equal angles")
    first: Annotated[float, q.DIRECTION] = Field(default=0.0, description="direction of the first bolt")
    last: Annotated[float, q.DIRECTION] = Field(default=180.0, description="direction of the last bolt")


class RowTable(Table):
    """Bolts in a row along a boundary, into the rock."""

    boundary: str = Field(description='NAME of the mesh group "boundary:NAME" or of [boundary.NAME]')
    length: Annotated[float, q.BOLT_LENGTH] = Field(description="of every bolt")
    interval: Annotated[float, q.BOLT_INTERVAL] = Field(description="distance of the heads along the boundary")
    offset: Annotated[float, q.DISTANCE] | None = Field(
        default=None,
        description="of the first head along the boundary, the rock on its left; default: half an interval",
    )
    direction: Annotated[float, q.DIRECTION] | None = Field(
        default=None, description="of all bolts; default: normal to the boundary"
    )


@keys_of(Bolt)
class BoltTable(Table):
    """A bolt (start and end) or many (one of radial, row, curve, table); forces are those of one bolt."""

    start: Point | None = Field(default=None, description="head")
    end: Point | None = Field(default=None, description="tip")
    radial: RadialTable | None = None
    row: RowTable | None = None
    curve: str | None = Field(default=None, description='NAME of the mesh group "bolt:NAME"')
    table: PathText | None = Field(default=None, description="CSV file: start_x, start_y, end_x, end_y and other keys")
    name: str = Field(default="", description="in results; of several bolts NAME 1, NAME 2, ...")
    diameter: Annotated[float, q.BOLT_DIAMETER] | None = Field(default=None, description="of the bar")


@keys_of(Bolt, without=("spacing",))
class SpaceBoltTable(Table):
    """A bolt (start and end) or many (table); forces are those of one bolt."""

    start: Vector | None = Field(default=None, description="head")
    end: Vector | None = Field(default=None, description="tip")
    table: PathText | None = Field(
        default=None, description="CSV file: start_x, start_y, start_z, end_x, end_y, end_z and other keys"
    )
    name: str = Field(default="", description="in results; of several bolts NAME 1, NAME 2, ...")
    diameter: Annotated[float, q.BOLT_DIAMETER] | None = Field(default=None, description="of the bar")
