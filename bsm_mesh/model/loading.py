"""Whether anything loads a model: where nothing does, rest says nothing of its stability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.loads import InSituTraction, Load, point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of, unit_vector
from bsm_mesh.model.water import Water


def faults_of_loading(model: Model) -> list[str]:
    """Return one sentence if nothing loads the model at any stage, an empty list otherwise.

    A load is a weight, a force, a traction or the pressure of a stage. Water that reaches the blocks, flow in joints,
    in-situ stress, pretension of bolts and prescribed displacements are loads too.
    """
    loaded = (
        (model.weights.any() and any(part.any() for part in _gravities(model)))
        or any(_acts(loads, model) for loads in (model.loads, *(stage.loads for stage in model.stages)))
        or any(_wets(water, model) for water in (model.water, *(stage.water for stage in model.stages)))
        or model.flow is not None
        or (model.in_situ is not None and model.in_situ.method == "direct" and _has_field(model))
        or any(bolt.pretension for bolt in model.bolts)
        or bars_of(model.supports, model.blocks).value.any()
        or any(stage.pressure for stage in model.stages)
    )
    if loaded:
        return []
    weight = "gravity is zero" if model.weights.any() else "no rock has a weight"
    return [
        f"nothing loads the model, so that rest would prove nothing: {weight}, and there is no load, water, "
        "in-situ stress, pretension or prescribed movement in any stage; give the rocks their unit_weight, or a load"
    ]


def _gravities(model: Model) -> list[FloatArray]:
    """Return gravity as a vector over weight at the start, and in the stages that change it, (2,) each."""
    given = [stage.gravity for stage in model.stages if stage.gravity is not None]
    return [model.gravity_vector, *(unit_vector(model.gravity_direction) + part for part in given)]


def _acts(loads: Sequence[Load], model: Model) -> bool:
    given = [load for load in loads if not isinstance(load, InSituTraction)]
    forces = point_forces_of(given, model.blocks).force.any()
    return bool(forces) or (len(given) < len(loads) and _has_field(model))


def _wets(water: Water | None, model: Model) -> bool:
    if water is None:
        return False
    lowest = model.blocks.vertices[:, 1].min()
    return any(water.joint_pressure.values()) or any(y > lowest for table in water.table for _, y in table)


def _has_field(model: Model) -> bool:
    """Return whether the in-situ field is other than the weight of the rocks."""
    in_situ = model.in_situ
    if in_situ is None:
        return False
    return bool(in_situ.surcharge) or (in_situ.stress is not None and bool(np.any(in_situ.stress)))
