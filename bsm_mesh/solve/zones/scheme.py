"""Blocks with zones through the stages of a model, with the results that all schemes have."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from bsm_mesh.errors import ModelError, named_stage, raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import notes_of
from bsm_mesh.model.options import Options
from bsm_mesh.model.start import start_faults
from bsm_mesh.model.zones import zone_order
from bsm_mesh.results.records import StageResult, Status
from bsm_mesh.solve.zones.collapse import Prover, with_proof
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.mesh import Discretization
from bsm_mesh.solve.zones.stage_result import Before, stage_result
from bsm_mesh.solve.zones.stage_solution import StageEnd
from bsm_mesh.solve.zones.stages import Continuum
from bsm_mesh.solve.zones.zone_mesh import zone_mesh

SCHEME = "zones"
SOLVER = "superlu"


def zoned(model: Model, options: Options) -> Continuum:
    """Return a model with zones that can be analysed.

    Raises
    ------
    ModelError
        With everything that forbids it, as `bsm_mesh.run` says.
    """
    faults = start_faults(model)
    if options.scheme != "continuation":
        faults.append(
            f"scheme = '{options.scheme}' is of rigid blocks; take 'continuation' with zones, or leave zones out"
        )
    if options.linear_solver not in ("auto", SOLVER):
        faults.append(f"linear_solver = '{options.linear_solver}' does not solve zones; take 'auto' or '{SOLVER}'")
    raise_faults(faults)
    breaks = any(rock.has_strength for rock in model.rocks)
    elements = Discretization(order=zone_order(model), joints=True, rock_breaks=breaks)
    return Continuum(model, elements, mesh=zone_mesh(model))


def solve_zones(
    model: Model,
    options: Options,
    report: Callable[[str], None],
    finished: Callable[[StageResult], StageResult],
    prove: Prover,
    until: int | None = None,
) -> tuple[StageResult, ...]:
    """Return the results of all stages up to the first that is not at rest.

    Parameters
    ----------
    model : Model
        Some of its rocks have zones.
    options : Options
        Tolerance.
    report : callable
        Gets the name of each task.
    finished : callable
        Gets every stage and returns it as it is kept.
    prove : callable
        Says whether forces within strength balance the loads of a model, of which some blocks fall.
    until : int, optional
        Number of the last stage; None: of the model.

    Raises
    ------
    ModelError
        If the model cannot be analysed.
    """
    report("zones")
    continuum = zoned(model, options)
    results: list[StageResult] = []
    before = Before(continuum.presence[0], np.zeros((model.blocks.count, 3)), continuum.seconds, 0.0)
    began = time.perf_counter() - continuum.seconds
    last = len(model.stages) if until is None else until
    ends = continuum.ends(nominal_constants(model), 1 + last)
    for number, end in enumerate(_named(ends, model, report)):
        before = replace(before, seconds=time.perf_counter() - began)
        stage = stage_result(continuum, end, before, number, options.tolerance)
        stage = with_proof(continuum, end, stage, number, prove)
        if number == 0:
            stage = replace(stage, notes=tuple(notes_of(model)))
        stage = finished(stage)
        results.append(stage)
        if stage.status is not Status.STABLE:
            break
        before = Before(stage.present, stage.origin + stage.displacement, 0.0, stage.reference_weight)
        began = time.perf_counter()
    return tuple(results)


def _named(ends: Iterator[StageEnd], model: Model, report: Callable[[str], None]) -> Iterator[StageEnd]:
    """Yield the ends of stages; faults in one have its name."""
    for stage in (None, *model.stages):
        if stage is not None:
            report(named_stage(stage.name))
        try:
            end = next(ends, None)
        except ModelError as error:
            if stage is None:
                raise
            raise ModelError([f"{named_stage(stage.name)}: {text}" for text in error.faults]) from error
        if end is None:
            return
        yield end
