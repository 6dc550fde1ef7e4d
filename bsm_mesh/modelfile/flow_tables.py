"""The model file's tables of flow in the joints, and their part of the model."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any

from pydantic import Field

from bsm_mesh.errors import placed
from bsm_mesh.model import quantities as q
from bsm_mesh.model.flow import Drain, Flow, FlowChange, Grout, Well
from bsm_mesh.modelfile.class_keys import given_in, keys_of
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.units import Point


@keys_of(Drain)
class DrainTable(Table):
    """A drain: a hole that lets water out of all joints it crosses."""

    start: Point = Field(description="one end of the hole: x and y")
    end: Point = Field(description="its other end")


@keys_of(Well)
class WellTable(Table):
    """A well, in the nearest joint."""

    point: Point = Field(description="x and y, in a joint or near one")


@keys_of(Grout)
class GroutTable(Table):
    """A region in which joints are grouted."""

    polygon: list[Point] = Field(description="its corners")


class FlowPartsTable(Table):
    """Inflow, outflow and barriers of the flow."""

    head: dict[str, Annotated[float, q.COORDINATE]] = Field(
        default_factory=dict, description="level of the water at boundaries, by name"
    )
    seepage: list[str] = Field(default_factory=list, description="boundaries that are open to the air")
    drain: list[DrainTable] = Field(default_factory=list)
    well: list[WellTable] = Field(default_factory=list)
    grout: list[GroutTable] = Field(default_factory=list)


class FlowChangeTable(FlowPartsTable):
    """Changes of the flow by a stage; all else stays."""

    closed: list[str] = Field(default_factory=list, description="boundaries that let no water through from now on")


@keys_of(Flow, without=("drains", "wells"))
class FlowTable(FlowPartsTable):
    """Steady flow of water in the joints."""


PARTS = ("head", "seepage", "drains", "wells", "grout")


def make_flow(table: FlowTable) -> Flow:
    """Return the flow in the joints."""
    with placed("[flow]"):
        return Flow(**_parts(table), **given_in(table, Flow, without=PARTS))


def make_flow_change(table: FlowChangeTable, place: str) -> FlowChange:
    """Return the changes of the flow by a stage."""
    with placed(place):
        return FlowChange(**_parts(table), closed=tuple(table.closed))


def _parts(table: FlowPartsTable) -> dict[str, Any]:
    return {
        "head": table.head,
        "seepage": tuple(table.seepage),
        "drains": tuple(Drain(**drain.model_dump()) for drain in table.drain),
        "wells": tuple(Well(**well.model_dump()) for well in table.well),
        "grout": tuple(Grout(**{**grout.model_dump(), "polygon": tuple(grout.polygon)}) for grout in table.grout),
    }


def flow_content(flow: Flow | FlowChange) -> dict[str, Any]:
    """Return the table of a model file that makes a flow, or a change of it."""
    parts: dict[str, Any] = {
        "head": dict(flow.head),
        "seepage": list(flow.seepage),
        "drain": [_given(start=list(d.start), end=list(d.end), level=d.level) for d in flow.drains],
        "well": [{"point": list(well.point), "discharge": well.discharge} for well in flow.wells],
        "grout": [
            {"polygon": [list(corner) for corner in grout.polygon], "aperture": grout.aperture} for grout in flow.grout
        ],
    }
    if isinstance(flow, FlowChange):
        return {key: value for key, value in (parts | {"closed": list(flow.closed)}).items() if value}
    settings = [field.name for field in fields(Flow) if field.name not in PARTS]
    given = {key: value for key, value in parts.items() if value}
    return given | {name: getattr(flow, name) for name in settings}


def _given(**values: Any) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}
