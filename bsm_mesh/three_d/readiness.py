"""Whether a model of polyhedra can be run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from bsm_mesh.errors import raise_faults
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.supports import bars_of
from bsm_mesh.three_d.overlap import overlap_faults

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model


def refuse_unready(model: Model, solver_faults: Iterable[str], scheme: str) -> None:
    """Raise a `ModelError` with everything that forbids to run a model of polyhedra, `solver_faults` first."""
    bars = bars_of(model.supports, model.blocks)
    given = [model.worked_out(loads) for loads in (model.loads, *(stage.loads for stage in model.stages))]
    stages = [point_forces_of(loads, model.blocks).force for loads in given]
    assert in_space(model.blocks)
    faults = [*solver_faults, *overlap_faults(model.blocks)]
    if scheme != "continuation":
        faults.append(f"scheme = '{scheme}' is for the plane; polyhedra are solved by 'continuation'")
    if not len(bars.block):
        faults.append("the model is free to move in any direction: no support holds it; hold some blocks or a boundary")
    waters = [model.water, *(stage.water for stage in model.stages)]
    field = model.in_situ is not None and model.in_situ.method == "direct"
    loaded = field or model.weights.any() or any(force.any() for force in stages) or any(waters)
    if not loaded:
        faults.append("nothing loads the model; give the rocks their unit_weight, or a load")
    raise_faults(faults)
