"""The limit of any number of a model: the greatest load, water level, earthquake or tilt that it carries."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

from bsm_mesh.errors import ModelError, as_given
from bsm_mesh.model.in_stage import model_up_to, resting_stage
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.model.values import is_number
from bsm_mesh.safety.answer import Safety, Settings, answer_of, notes_on, run_options, with_unit
from bsm_mesh.safety.bound import Limit
from bsm_mesh.safety.bracket import Range
from bsm_mesh.safety.criterion import Ended, Failure
from bsm_mesh.safety.driver import Search
from bsm_mesh.safety.trials import ended, limited
from bsm_mesh.solve.stages.as_built import counted_blocks

ModelAt: TypeAlias = Callable[[float], Model]
"""Returns the model with a value; the input to other processes must be picklable."""

NO_BOUND = Limit(factor=math.inf, text="not asked: its bound is one on strength")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ValueTrials:
    """Runs of a model at values of one of its numbers, from the start to a stage."""

    model_at: ModelAt
    options: Options
    stage: int

    def run(self, value: float, limit: float | None = None) -> Ended:
        """Return how the model ends with a value, or once a block moves that far [m]."""
        model = self.model_at(value)
        return ended(model_up_to(model, self.stage), limited(self.options, limit), value)


def limit_value(
    model_at: ModelAt,
    good: float,
    bad: float,
    *,
    options: Options | None = None,
    stage: str | None = None,
    quantity: str = "value",
    unit: str = "",
    tolerance: float = 0.005,
    failure: Failure | None = None,
    trials: int = 40,
    processes: int = 1,
    report: Callable[[str], None] = lambda text: None,
) -> Safety:
    """Return the last value of a model's number at which it is stable, and the first at which it fails.

    Parameters
    ----------
    model_at : callable
        Returns the model with a value.
    good, bad : float
        The range: the model is to be stable at `good` and to get worse towards `bad`, which may be the smaller one.
    options : Options, optional
        How it is solved, instead of the model's own options.
    stage : str, optional
        The stage in question, ``initial`` for the first; None: the last.
    quantity : str
        Name of the number, for words and pictures.
    unit : str
        Its unit, for words and pictures.
    tolerance : float
        Width of the bracket over the range.
    failure, trials, processes, report
        As in `factor_of_safety`; movement counts from the state at `good`.

    Raises
    ------
    ModelError
        If the range is none, or a model cannot be analysed.

    Examples
    --------
    The greatest earthquake, of the weights: tan(35) = 0.70, beyond 0.5 at which a block twice as high would turn over.

    >>> import bsm_mesh as bsm
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (3, 0), (3, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="granite"
    ...     ),
    ...     rocks=[bsm.Rock("granite", unit_weight=26e3)],
    ...     joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
    ...     default_joint="J1",
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> answer = bsm.limit_value(lambda part: model.replace(gravity_horizontal=part), 0.0, 1.0)
    >>> answer.stable <= 0.7002 <= answer.unstable
    True
    """
    settings = Settings(tolerance=tolerance, failure=failure or Failure(), trials=trials, processes=processes)
    within = range_of(good, bad, tolerance)
    model = model_at(good)
    number = resting_stage(model, stage, "the limit of a number")
    name = [INITIAL, *(each.name for each in model.stages)][number]
    runs = ValueTrials(model_at=model_at, options=run_options(model, options, processes), stage=number)
    counts = counted_blocks(model, runs.options.falls)
    found = Search(runs, within, settings.failure, model.blocks, counts, report).run(
        settings.trials, settings.processes
    )
    start = f"whole runs up to stage '{name}'"
    changed = f"{quantity} from {with_unit(good, unit)} to {with_unit(bad, unit)}"
    answer = answer_of(found, NO_BOUND, quantity, name, start, changed)
    return replace(answer, unit=unit, notes=notes_on(found, settings))


def range_of(good: float, bad: float, tolerance: float) -> Range:
    """Return a range that is looked through from its good end.

    Raises
    ------
    ModelError
        If its ends are no two numbers.
    """
    if not (is_number(good) and is_number(bad)) or good == bad:
        raise ModelError(
            f"the range {as_given(good)} to {as_given(bad)} must have two different ends: first a stable one, then a "
            "failing one"
        )
    return Range(good=good, bad=bad, first=good, tolerance=tolerance, is_factor=False)
