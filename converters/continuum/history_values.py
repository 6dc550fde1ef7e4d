"""The model's histories at the end of a stage, by both methods."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from bsm_mesh.model.beside import UNITS, Beside
from bsm_mesh.model.model import Model
from bsm_mesh.results.beside import along_line
from bsm_mesh.results.histories import Recorded, Recorder
from bsm_mesh.results.results import Results, StageResults
from bsm_mesh.solve.zones.solution import ContinuumSolution

if TYPE_CHECKING:
    from bsm_mesh.converters.continuum.compared_stages import ComparedStage


class HistoryValue(NamedTuple):
    """A quantity of a history at the end of a stage; not a number where there is none."""

    history: str
    quantity: str
    unit: str
    bsm: float
    fem: float


def history_values(
    model: Model, results: Results, number: int, nominal: ContinuumSolution, matched: ContinuumSolution
) -> tuple[HistoryValue, ...]:
    """Return all quantities of a model's histories at the end of a stage.

    In the elements, points and blocks move with their block's average displacement and rotation under the matched
    elastic constants; joints and bolts are those of the rock's own.
    """
    if not model.histories:
        return ()
    recorder, stage = Recorder(model), results.stages[number]
    theirs = replace(
        stage,
        displacement=matched.displacement,
        contacts=nominal.contacts,
        bolts=nominal.bolts,
        present=matched.present,
    )
    ours, fem = (recorder.measure(replace(results, stages=StageResults((side,)))) for side in (stage, theirs))
    columns = [
        (one.name, quantity, unit)
        for one in recorder.recorded
        for quantity, unit in zip(one.quantities, one.units, strict=True)
    ]
    return tuple(HistoryValue(*column, a, b) for column, a, b in zip(columns, ours, fem, strict=True))


def beside_of_elements(
    results: Results, recorded: Sequence[Recorded], stages: Sequence[ComparedStage], source: str
) -> dict[str, tuple[Beside, ...]]:
    """Return the elements' values of the histories at the end of the compared stages, by the histories' names.

    Lines move as points do, each with its block's average displacement and rotation.
    """
    found: dict[str, list[Beside]] = {}
    numbers = {stage.name: number for number, stage in enumerate(results.stages)}
    for compared in stages:
        comparison = compared.comparison
        if comparison is None:
            continue
        for one in comparison.histories:
            if one.quantity in UNITS and math.isfinite(one.fem):
                value = Beside(quantity=one.quantity, value=one.fem, stage=compared.name, source=source)
                found.setdefault(one.history, []).append(value)
        theirs = replace(
            results.stages[numbers[compared.name]],
            displacement=comparison.matched.displacement,
            present=comparison.matched.present,
        )
        for line in (each for each in recorded if each.kind == "line"):
            found.setdefault(line.name, []).extend(
                Beside(quantity=quantity, value=value, stage=compared.name, distance=at, source=source)
                for quantity, value, at in along_line(results, theirs, line)
                if math.isfinite(value)
            )
    return {name: tuple(values) for name, values in found.items()}
