"""Faults of a model's flow: joints without an aperture, boundaries that are none, levels off the model."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.flow import Flow, FlowChange
from bsm_mesh.model.unused import used_joints

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model

DEEPEST = 1e4  # m of water over the model, as for water tables
MAX_LIGHTER = 500.0  # water than rock: no two materials are so far apart, but a unit and its thousandth are


def flow_in_stage(model: Model, number: int) -> Flow | None:
    """Return the flow as it is in a stage, 0 for the start; None where there is none.

    Raises
    ------
    ModelError
        Where a stage so far leaves nothing that lets water in.
    """
    flow = model.flow
    for stage in model.stages[:number]:
        flow = None if flow is None else flow.changed(stage.flow)
    return flow


def water_weight_faults(place: str, unit_weight: float, model: Model) -> Iterator[str]:
    """Return a sentence where water is lighter than any beside rock: one of the two has another unit."""
    rock = min((rock.unit_weight for rock in model.rocks if rock.unit_weight > 0), default=0.0)
    if rock > MAX_LIGHTER * unit_weight:
        yield (
            f"{place}: unit_weight = {unit_weight:g} N/m^3 is {rock / unit_weight:.4g} times less than that of every "
            f'rock ({rock:g} N/m^3 or more); give both in one unit, for example "9.81 kN/m^3" and "26 kN/m^3"'
        )


def flow_faults(model: Model) -> Iterator[str]:
    """Return a sentence on everything of the flow that does not fit the model."""
    changes: list[tuple[str, Flow | FlowChange]] = []
    changes += [(f"stage '{stage.name}': flow", stage.flow) for stage in model.stages if stage.flow is not None]
    if model.flow is None:
        yield from (
            f"{place}: the model has no flow at the start; give [flow], with a level below the joints "
            "where they are dry before"
            for place, _ in changes
        )
        return
    yield from _two_kinds_of_water(model)
    yield from water_weight_faults("flow", model.flow.unit_weight, model)
    yield from _aperture_faults(model, model.flow)
    yield from (
        f"stage '{stage.name}': fill: apertures of joints that come later are not followed; give [flow] coupling = "
        '"one_way", which leaves apertures as given'
        for stage in model.stages
        if stage.fill and model.flow.coupling == "two_way"
    )
    for place, part in [("flow", model.flow), *changes]:
        yield from _boundary_faults(place, part, model)
    for number in range(1, 1 + len(model.stages)):
        try:
            flow_in_stage(model, number)
        except ModelError as error:
            yield from (f"stage '{model.stages[number - 1].name}': {fault}" for fault in error.faults)
            return


def _two_kinds_of_water(model: Model) -> Iterator[str]:
    if model.water is not None:
        yield "water and flow are both given: give one, a water table, or levels at boundaries"
    for stage in model.stages:
        if stage.water is not None:
            yield f"stage '{stage.name}': water: with flow a stage changes flow instead, for example its head"


def _aperture_faults(model: Model, flow: Flow) -> Iterator[str]:
    """Return the faults of the apertures of joints that faces carry."""
    for joint in used_joints(model):
        if joint.aperture is None:
            yield (
                f"joint '{joint.name}': flow needs its aperture [m], the hydraulic one without normal stress "
                '(for example "0.2 mm"; 0 where it is sealed)'
            )
        elif flow.coupling == "two_way" and joint.aperture > 0 and joint.residual_aperture == 0:
            yield (
                f"joint '{joint.name}': two-way coupling needs residual_aperture [m], which no stress closes; "
                'or give [flow] coupling = "one_way", which leaves apertures as given'
            )


def _boundary_faults(place: str, part: Flow | FlowChange, model: Model) -> Iterable[str]:
    closed = part.closed if isinstance(part, FlowChange) else ()
    for key, names in (("head", tuple(part.head)), ("seepage", part.seepage), ("closed", closed)):
        for name in names:
            if name not in model.blocks.boundaries:
                yield f"{place}: {key}: there is no boundary '{name}'{nearest(name, model.blocks.boundaries)}"
    low, high = model.blocks.vertices[:, 1].min(), model.blocks.vertices[:, 1].max()
    for name, level in part.head.items():
        if level - high > DEEPEST:
            yield (
                f"{place}: head of '{name}' is {level - high:.6g} m above the model, at most {DEEPEST:g} m are taken: "
                f"the model reaches from y = {low:.6g} m to {high:.6g} m; check the level and its unit"
            )
