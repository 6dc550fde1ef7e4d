"""Flow in the joints as ``check`` and the report show it is given: levels, and what drains, wells and grout meet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from bsm_mesh.errors import counted, named_stage, place
from bsm_mesh.flow.joint_network import JointNetwork
from bsm_mesh.model.flow import Drain, Flow, FlowChange, Grout, Well
from bsm_mesh.model.model import Model
from bsm_mesh.text.flow_text import discharge_text
from bsm_mesh.text.tables import engineering

Row = tuple[str, str]


def given_flow(model: Model, joints: JointNetwork) -> list[dict[str, Any]]:
    """Return the input of a model's flow, an entry a thing, in the order of the model file.

    Parameters
    ----------
    model : Model
        With a ``flow``.
    joints : JointNetwork
        The network of its joints, cut by all drains, wells and grout of its stages.

    Returns
    -------
    list of dict
        ``what`` and ``stage`` (empty: from the start) of all; of boundaries ``name`` and ``level`` [m], of drains
        their ends, ``length`` [m] and at how many ``points`` they meet joints, of wells ``discharge`` [m2/s] and the
        ``point`` [m] of a joint they are in, of grout ``aperture`` [m] and the ``length`` [m] of joints in it.
    """
    changes: list[tuple[str, Flow | FlowChange]] = [] if model.flow is None else [("", model.flow)]
    changes += [(stage.name, stage.flow) for stage in model.stages if stage.flow is not None]
    count = {"drain": 0, "well": 0, "grout": 0}
    entries: list[dict[str, Any]] = []
    for stage, part in changes:
        entries += [{"what": "head", "name": name, "level": level, "stage": stage} for name, level in part.head.items()]
        entries += [{"what": "seepage", "name": name, "stage": stage} for name in part.seepage]
        if isinstance(part, FlowChange):
            entries += [{"what": "closed", "name": name, "stage": stage} for name in part.closed]
        things: tuple[Drain | Well | Grout, ...] = (*part.drains, *part.wells, *part.grout)
        for thing in things:
            kind = type(thing).__name__.lower()
            met = _met(thing, joints, count[kind])
            count[kind] += 1
            entries.append({"what": kind, "name": str(count[kind]), **met, "stage": stage})
    return entries


def _met(thing: Drain | Well | Grout, joints: JointNetwork, number: int) -> dict[str, Any]:
    """Return the record of a thing, the one of its kind of that number, from 0."""
    network = joints.network
    if isinstance(thing, Drain):
        length = float(np.hypot(*np.subtract(thing.end, thing.start)))
        points = len(joints.on_drain[number])
        return {"start": thing.start, "end": thing.end, "level": thing.level, "length": length, "points": points}
    if isinstance(thing, Well):
        return {"discharge": thing.discharge, "point": tuple(network.point[joints.at_well[number]].tolist())}
    return {"aperture": thing.aperture, "length": float(network.length[joints.in_grout[number]].sum())}


def given_rows(entries: list[dict[str, Any]]) -> list[Row]:
    """Return the input of a flow as rows of a table."""
    return list(_rows(entries))


def _rows(entries: list[dict[str, Any]]) -> Iterator[Row]:
    for entry in entries:
        since = f" from {named_stage(entry['stage'])} on" if entry["stage"] else ""
        yield f"flow: {entry['what']} {entry['name']}", _told(entry) + since


def _told(entry: dict[str, Any]) -> str:
    match entry["what"]:
        case "head":
            return f"water up to {entry['level']:.6g} m"
        case "seepage":
            return "open to the air"
        case "closed":
            return "lets no water through"
        case "drain":
            level = "" if entry["level"] is None else f", water in it up to {entry['level']:.6g} m"
            ends = f"{place(entry['start'])} to {place(entry['end'])}"
            return f"{ends}, {entry['length']:.4g} m long, meets joints at {counted(entry['points'], 'point')}{level}"
        case "well":
            out = "takes out" if entry["discharge"] > 0 else "puts in"
            at = place([round(x, 3) for x in entry["point"]])
            return f"{out} {discharge_text(abs(entry['discharge']))}, in the joint at {at}"
    sealed = "sealed" if entry["aperture"] == 0 else f"aperture {engineering(entry['aperture'], 'm')}"
    return f"{entry['length']:.4g} m of joints, {sealed}"
