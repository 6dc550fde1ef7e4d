"""The model's histories at the end of a stage, by both methods."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from bsm_mesh.converters.continuum.solution import ContinuumSolution
from bsm_mesh.model.model import Model
from bsm_mesh.results.histories import Recorder
from bsm_mesh.results.results import Results


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
    ours, fem = (recorder.measure(replace(results, stages=(side,))) for side in (stage, theirs))
    columns = [
        (one.name, quantity, unit)
        for one in recorder.recorded
        for quantity, unit in zip(one.quantities, one.units, strict=True)
    ]
    return tuple(HistoryValue(*column, a, b) for column, a, b in zip(columns, ours, fem, strict=True))
