"""Back-analysis: which value of a number gives the movements that were measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.in_stage import resting_stage
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantities import COORDINATE
from bsm_mesh.model.values import Rules
from bsm_mesh.movements import lengths
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import Status
from bsm_mesh.safety.answer import Settings, run_options, with_unit
from bsm_mesh.safety.bracket import Bracket, Verdict
from bsm_mesh.safety.criterion import Ended, Failure, Judgement
from bsm_mesh.safety.driver import Search, Trial
from bsm_mesh.safety.limits import ModelAt, ValueTrials, range_of
from bsm_mesh.solve.stages.as_built import counted_blocks

Component = Literal["x", "y", "total"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A movement that was measured in the stage in question.

    Attributes
    ----------
    point : (float, float) [m]
        Where, in the geometry as given; it moves with its block.
    component : {"x", "y", "total"}
        Which part of the movement.
    movement : float [m]
        How much.
    deviation : float [m]
        Its standard deviation.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Measured(point=(4.5, 11), movement=0.012, deviation=0.002).component
    'total'
    """

    point: tuple[float, float]
    component: Component = "total"
    movement: float
    deviation: float = 0.0

    def __post_init__(self) -> None:
        rules = Rules("measured")
        object.__setattr__(self, "point", rules.point("point", self.point))
        rules.choice("component", self.component, get_args(Component))
        rules.number("movement", self.movement, COORDINATE)
        rules.number("deviation", self.deviation, COORDINATE)
        if not rules.faults and self.movement == 0:
            rules.faults.append(
                "measured: movement = 0 m: a point that did not move gives no information; leave it out"
            )
        elif not rules.faults and not 0 <= self.deviation < abs(self.movement):
            rules.faults.append(
                f"measured: deviation = {self.deviation:g} m must be 0 or more, and less than the movement of "
                f"{abs(self.movement):g} m: a movement within its deviation gives no information"
            )
        raise_faults(rules.faults)

    def of(self, ended: Ended, blocks: Blocks) -> float:
        """Return the movement of the point in a run [m].

        Raises
        ------
        ModelError
            If the point is in no block.
        """
        inside = blocks_at(blocks, self.point)
        if not len(inside):
            raise ModelError(f"measured: the point ({self.point[0]:g}, {self.point[1]:g}) is in no block")
        moved = displacement_of(blocks, ended.displacement, inside[:1], np.array([self.point]))
        if self.component == "total":
            return float(lengths(moved)[0])
        return float(moved[0, "xyz".index(self.component)])


@dataclass(frozen=True, slots=True)
class Reaches:
    """The criterion that a point moves as far as measured, or its block falls."""

    measured: Measured
    reached: float

    @property
    def movement(self) -> float:
        """No movement is a failure by itself."""
        return math.inf

    def judge(self, ended: Ended, reference: Ended | None, blocks: Blocks, counts: BoolArray) -> Judgement:
        """Return whether a run moved the point as far."""
        if ended.status is Status.UNSTABLE:
            return Judgement(Verdict.UNSTABLE, ended.reason, ended.down)
        if not ended.status.is_stable:
            return Judgement(Verdict.UNDECIDED, ended.reason)
        moved = self.measured.of(ended, blocks)
        verdict = Verdict.UNSTABLE if moved / self.reached >= 1 else Verdict.STABLE
        return Judgement(verdict, f"moves by {moved:.5g} m")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Estimate:
    """Estimate of the number by one measurement.

    Attributes
    ----------
    measured : Measured
        The measurement.
    value : float or None
        The value that gives it; None: none in the range does.
    low, high : float or None
        The values that give a standard deviation less and more, in the order of the numbers.
    """

    measured: Measured
    value: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BackAnalysis:
    """The value of a number that gives the measurement.

    Attributes
    ----------
    quantity : str
        Name of the number.
    value : float or None
        The estimate: of several measurements the mean, weighted by the inverse of their variances.
    deviation : float or None
        Its standard deviation, from the scatter of the measurements.
    estimates : tuple of Estimate
        The estimate of every measurement.
    trials : tuple of Trial
        The runs, by value.
    unit : str
        Unit of the quantity; empty: none.
    """

    quantity: str
    value: float | None
    deviation: float | None
    estimates: tuple[Estimate, ...]
    trials: tuple[Trial, ...]
    unit: str = ""

    def __str__(self) -> str:
        """Return the answer in a sentence."""
        if self.value is None:
            return f"{self.quantity}: no value in the range gives the measurement"
        scatter = f" with a standard deviation of {self.deviation:.3g} {self.unit}".rstrip() if self.deviation else ""
        return f"{self.quantity} = {with_unit(self.value, self.unit)}{scatter} gives the measurement"


def back_analysis(
    model_at: ModelAt,
    good: float,
    bad: float,
    measured: Sequence[Measured],
    *,
    options: Options | None = None,
    stage: str | None = None,
    quantity: str = "value",
    unit: str = "",
    tolerance: float = 0.005,
    trials: int = 40,
    processes: int = 1,
    report: Callable[[str], None] = lambda text: None,
) -> BackAnalysis:
    """Return which value of a model's number gives the movements that were measured, and how sure that is.

    For each measurement the value is bracketed as a limit is, a point that moved as far taking the place of failure;
    so for the measurement less and more its standard deviation. Movements must grow from `good` to `bad`.

    Parameters
    ----------
    model_at, good, bad, options, stage, quantity, unit, tolerance, trials, processes, report
        As in `limit_value`.
    measured : sequence of Measured
        Measurements in the stage; movements count from its start.

    Raises
    ------
    ModelError
        If there is no measurement, the range is none, or a model cannot be analysed.
    """
    if not measured:
        raise ModelError(
            "back-analysis: give a movement that was measured; for a factor of one find the limit of the number"
        )
    settings = Settings(tolerance=tolerance, failure=Failure(), trials=trials, processes=processes)
    within = range_of(good, bad, tolerance)
    model = model_at(good)
    number = resting_stage(model, stage, "back-analysis")
    run = ValueTrials(model_at=model_at, options=run_options(model, options, processes), stage=number)
    known: tuple[Ended, ...] = ()
    estimates: list[Estimate] = []
    shown: list[Trial] = []
    for each in measured:
        values: list[float | None] = []
        for movement in (each.movement, each.movement - each.deviation, each.movement + each.deviation):
            if values and not each.deviation:
                values.append(values[0])
                continue
            report(f"movement {movement:.4g} m at ({each.point[0]:g}, {each.point[1]:g})")
            search = Search(
                run,
                within,
                Reaches(each, movement),
                model.blocks,
                counted_blocks(model, run.options.falls),
                report,
                known,
                states=False,
            )
            found = search.run(len(known) + settings.trials, processes)
            known, shown = search.ended, list(found.trials)
            values.append(_middle(found.bracket))
        low, high = values[1:]
        ends = sorted(value for value in (low, high) if value is not None)
        estimates.append(
            Estimate(
                measured=each,
                value=values[0],
                low=ends[0] if ends else None,
                high=ends[-1] if ends else None,
            )
        )
    value, deviation = _together(estimates)
    return BackAnalysis(
        quantity=quantity, value=value, deviation=deviation, estimates=tuple(estimates), trials=tuple(shown), unit=unit
    )


def _middle(bracket: Bracket) -> float | None:
    if bracket.stable is None or bracket.unstable is None:
        return None
    return (bracket.stable + bracket.unstable) / 2


def _together(estimates: Sequence[Estimate]) -> tuple[float | None, float | None]:
    """Return the mean of all estimates, weighted by the inverse of their variances, and its standard deviation."""
    rows = [
        (each.value, (each.high - each.low) / 2)
        for each in estimates
        if each.value is not None and each.low is not None and each.high is not None
    ]
    if not rows:
        return None, None
    value, deviation = np.array(rows).T
    if not deviation.all():  # without scatter all count alike
        return float(value.mean()), None
    weight = deviation**-2.0
    return float((weight * value).sum() / weight.sum()), float(weight.sum() ** -0.5)
