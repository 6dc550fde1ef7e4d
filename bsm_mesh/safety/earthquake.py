"""Newmark's displacement of a model: its yield acceleration to either side, and a record integrated twice over it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

import numpy as np

from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.model.in_stage import model_up_to, resting_stage
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.sliding_block import Sliding, slide
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.values import Rules
from bsm_mesh.results.movement import step_in_words, verdict_in_words
from bsm_mesh.results.records import Status
from bsm_mesh.safety.answer import Safety, run_options
from bsm_mesh.safety.criterion import Failure
from bsm_mesh.safety.limits import limit_value
from bsm_mesh.solve.stages.as_built import counted_blocks
from bsm_mesh.solving import solve

Side = Literal["left", "right"]
SIGNS = {"left": -1.0, "right": 1.0}
PSEUDO_STATIC = "earthquake as weights"  # the stage that is added
MOST = 1.0  # of gravity: yield accelerations are looked for up to there, or to the peak of the record
LEVEL = 1e-6  # part of the record that is horizontal


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SlidingSide:
    """Sliding to one side.

    Attributes
    ----------
    side : {"left", "right"}
        Where blocks go: to -x or to +x.
    limit : Safety
        The yield acceleration over gravity, as the bracket of a search.
    sliding, turned : Sliding or None
        By the record, and by the record turned over, above the last stable acceleration. That is the greater
        displacement of the bracket. None: stable up to the peak of the record, so nothing slides.
    least, turned_least : float [m]
        The same displacements from the first unstable acceleration on; 0 where none was found.
    """

    side: Side
    limit: Safety
    sliding: Sliding | None
    turned: Sliding | None
    least: float
    turned_least: float

    @property
    def yields(self) -> float | None:
        """The last stable acceleration over gravity; None: stable up to the peak of the record."""
        return None if self.sliding is None else abs(self.limit.stable or 0.0)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ShakenMovement:
    """Result of the model's own shaken stage: its verdict, and how far blocks went to either side.

    Attributes
    ----------
    stage : str
        Its name.
    status : Status
        Its verdict.
    verdict : str
        The same in words, with the blocks that gave way before the others reached rest.
    reason : str
        Its reason.
    moved : dict of str to (int, float) [m]
        By side the block that went furthest to it, and how far.
    """

    stage: str
    status: Status
    verdict: str
    reason: str
    moved: dict[Side, tuple[int, float]]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Newmark:
    """Newmark's displacement of a model.

    Attributes
    ----------
    stage : str
        The stage whose blocks are shaken.
    peak : float
        Greatest horizontal acceleration of the record over gravity.
    shaking : Shaking
        The record.
    sides : tuple of SlidingSide
        Sliding to the left and to the right.
    shaken : ShakenMovement or None
        Result of the model's shaken stage; None: it has none, or it was not asked.
    """

    stage: str
    peak: float
    shaking: Shaking
    sides: tuple[SlidingSide, ...]
    shaken: ShakenMovement | None

    @property
    def is_decided(self) -> bool:
        """Whether no search was left open by trials without a verdict."""
        return all(side.limit.is_decided for side in self.sides)


def newmark(
    model: Model,
    shaking: Shaking | None = None,
    *,
    sides: Sequence[Side] = ("left", "right"),
    stage: str | None = None,
    options: Options | None = None,
    tolerance: float = 0.001,
    failure: Failure | None = None,
    trials: int = 40,
    processes: int = 1,
    shaken: bool = True,
    report: Callable[[str], None] = lambda text: None,
) -> Newmark:
    """Return how far a model slides in an earthquake by Newmark's method, and the result of its shaken stage.

    The yield acceleration is the greatest horizontal part of the weights that the blocks carry (`limit_value`). It acts
    in a stage of its own on blocks at rest. The record is integrated twice where it exceeds it, once as given and
    once turned over.

    Parameters
    ----------
    model : Model
        The model.
    shaking : Shaking, optional
        The record; by default that of the model's first shaken stage.
    sides : sequence of {"left", "right"}
        Where blocks may go: to -x, to +x.
    stage : str, optional
        The stage whose blocks are shaken, ``initial`` for the first; by default the one before the shaken one, or the
        last.
    tolerance : float
        Width of the bracket over gravity, or over the peak of the record where that is greater.
    shaken : bool
        Whether the shaken stage of the model is run as well, if it has one.
    options, failure, trials, processes, report
        As in `factor_of_safety`.

    Raises
    ------
    ModelError
        If there is no record, it has no horizontal part, or the blocks are not at rest before it.

    References
    ----------
    Newmark, N. M. (1965). Effects of earthquakes on dams and embankments. Geotechnique 15, 139-160.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> pulse = bsm.Shaking(waveform="pulse", frequency=1, cycles=0.3, amplitude=0.5 * 9.81)
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (9, 0), (9, 1), (0, 1)], [(4, 1), (5, 1), (5, 1.5), (4, 1.5)]], rock="granite"
    ...     ),
    ...     rocks=[bsm.Rock("granite", unit_weight=26e3)],
    ...     joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=11.31))],
    ...     default_joint="J1",
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> answer = bsm.newmark(model, pulse, sides=["left"], tolerance=0.01)
    >>> answer.sides[0].least < 0.33109 < answer.sides[0].sliding.permanent
    True
    """
    rules = Rules("newmark")
    rules.a_thing("model", model, Model)
    rules.a_thing("shaking", shaking, Shaking, optional=True)
    raise_faults(rules.faults)
    unknown = [side for side in sides if side not in get_args(Side)]
    if unknown or not sides:
        raise ModelError(f"newmark: sides = {list(sides)!r} must be 'left', 'right', or both")
    number = next((k for k, each in enumerate(model.stages) if each.shaking is not None), None)
    found = shaking if shaking is not None else None if number is None else model.stages[number].shaking
    if found is None:
        raise ModelError("newmark: no stage of the model is shaken; give a record")
    if found.boundary is not None:
        raise ModelError(
            f"newmark: the wave enters through '{found.boundary}' while supports are at rest; give the record of a "
            "ground that moves"
        )
    if in_space(model.blocks):
        raise ModelError(
            "newmark: models of polyhedra have no horizontal part of the weights yet; take one in the plane"
        )
    base = BaseMotion(found)
    if abs(base.axis[0]) < LEVEL:
        raise ModelError(f"newmark: the record is vertical (direction {found.direction:g}); Newmark's is horizontal")
    resting = model_up_to(model, number) if number is not None and stage is None else model
    last = resting_stage(resting, stage, "the yield acceleration")
    resting = model_up_to(resting, last)
    peak = abs(float(base.axis[0])) * base.peaks[0] / GRAVITY
    at, most = partial(with_weights_sideways, resting), max(MOST, peak)
    answers = []
    for side in dict.fromkeys(sides):
        report(f"yield acceleration to the {side}")
        limit = limit_value(
            at, 0.0, SIGNS[side] * most, options=options, quantity="gravity.horizontal", tolerance=tolerance,
            failure=failure, trials=trials, processes=processes, report=report,
        )  # fmt: skip
        answers.append(_sliding_side(side, limit, base, peak))
    name = resting.stages[-1].name if resting.stages else "initial"
    own = None if number is None or shaking is not None or not shaken else _run_shaken(model, number, options, report)
    return Newmark(stage=name, peak=peak, shaking=found, sides=tuple(answers), shaken=own)


def with_weights_sideways(model: Model, part: float) -> Model:
    """Return a model with a further stage, in which a part of the weights pulls to +x, in addition to present loads."""
    horizontal, vertical = model.gravity_horizontal, model.gravity_vertical
    for stage in model.stages:
        horizontal, vertical = (horizontal, vertical) if stage.gravity is None else stage.gravity
    added = Stage(name=PSEUDO_STATIC, gravity=(horizontal + part, vertical))
    return model.replace(stages=[*model.stages, added])


def _sliding_side(side: Side, limit: Safety, base: BaseMotion, peak: float) -> SlidingSide:
    """Return what slides to a side for the bracket of its yield acceleration."""
    if not limit.stable and limit.unstable is not None:
        what = f"no acceleration to the {side} leaves the blocks at rest; the least that was tried is"
        raise ModelError(f"newmark: {what} {abs(limit.unstable):.3g} g; there is no yield acceleration")
    if limit.stable is None:
        raise_faults([f"newmark: no verdict on the blocks at rest: {trial.reason}" for trial in limit.trials][:1])
    assert limit.stable is not None
    if limit.stable == 0 and peak > 0:
        undecided = [trial for trial in limit.trials if trial.value != 0]
        why = f": at {undecided[-1].value:.3g} g {undecided[-1].reason}" if undecided else "; allow more trials"
        raise ModelError(f"newmark: no acceleration to the {side} has a verdict{why}")
    axis, sign = float(base.axis[0]), SIGNS[side]
    if limit.unstable is None and abs(limit.stable) >= peak:
        return SlidingSide(side=side, limit=limit, sliding=None, turned=None, least=0.0, turned_least=0.0)
    resists = abs(limit.stable) * GRAVITY
    gives = (peak if limit.unstable is None else abs(limit.unstable)) * GRAVITY  # at the peak nothing slides
    return SlidingSide(
        side=side,
        limit=limit,
        sliding=slide(base, -sign * axis, resists),
        turned=slide(base, sign * axis, resists),
        least=slide(base, -sign * axis, gives).permanent,
        turned_least=slide(base, sign * axis, gives).permanent,
    )


def _run_shaken(
    model: Model, number: int, options: Options | None, report: Callable[[str], None]
) -> ShakenMovement | None:
    """Return the result of a model's shaken stage; None where an earlier one is not stable."""
    report(f"stage '{model.stages[number].name}'")
    model = model_up_to(model, number + 1)
    given = run_options(model, options, 1)
    results = solve(model, given, lambda record: report(step_in_words(record)), proves=False)
    last = results.stages[-1]
    if last.name != model.stages[number].name:
        return None
    counts = counted_blocks(model, given.falls)
    moved: dict[Side, tuple[int, float]] = {}
    for side in get_args(Side):
        far = np.where(counts, SIGNS[side] * last.stage_displacement[:, 0], -np.inf)
        moved[side] = int(far.argmax()), max(0.0, float(far.max()))
    verdict = verdict_in_words(model.blocks, last)
    return ShakenMovement(stage=last.name, status=last.status, verdict=verdict, reason=last.reason, moved=moved)
