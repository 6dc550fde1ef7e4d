"""The schemes ``continuation`` and ``wang`` over stages: large displacement, joints that slip and open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import counted
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.model.supports import Bars, Target
from bsm_mesh.results.movement import as_given
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.memory import BoltMemory
from bsm_mesh.solve.bolts.record import bolt_forces
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.continuation.mechanics import mechanics_of
from bsm_mesh.solve.continuation.plan import USUAL, Route
from bsm_mesh.solve.continuation.shaken import ShakenBlocks, ShakenContinuation
from bsm_mesh.solve.continuation.state import ContinuationState, LoopState
from bsm_mesh.solve.continuation.wang import WangIteration
from bsm_mesh.solve.motion.motion import Motion, Start
from bsm_mesh.solve.motion.shaking_memory import ShakingMemory, result_of
from bsm_mesh.solve.stages.scheme import Observer, Outcome, Reporter


class ContinuationScheme:
    """The continuation over the stages of a model: position and history continue from one to the next.

    Parameters
    ----------
    model : Model
        The whole.
    options : Options
        Tolerance, limits, linear solver.
    report : callable
        Called with a short text on progress.
    route : Route
        The way to equilibrium.

    Attributes
    ----------
    moved : (n, axes) float64 [m, rad]
        Displacement of every block since it was given, or placed.
    history : History
        Contact history, in the numbers of the whole.
    bolts : InstalledBolts
        The bolts, in the numbers of the whole.
    linear_solver : str
        Name of the solver used.
    """

    in_rows = False
    _velocity: FloatArray | None = None  # of blocks that continue after a fall, in the numbers of the whole
    _intact = True  # until the first solution
    _engine: Continuation | None = None  # while it solves
    _resumed: LoopState | None = None  # of the solution that continues
    _shaken: ShakingMemory | None = None  # of a stage that is shaken, in the numbers of the whole

    def __init__(self, model: Model, options: Options, report: Reporter, route: Route = USUAL) -> None:
        self.model, self.options, self.report, self.route = model, options, report, route
        self.moved = np.zeros((model.blocks.count, model.blocks.axes))
        self._mechanics = mechanics_of(model)
        self.history = self._mechanics.no_history()
        self.bolts = InstalledBolts.of(model, self.moved)
        self._origin = self.moved.copy()
        self.linear_solver = ""

    @property
    def state(self) -> ContinuationState:
        """Its state from stage to stage, and from step to step within one."""
        loop = None if self._engine is None else self._engine.state
        return ContinuationState(
            moved=self.moved.copy(),
            history=self.history if loop is None else self._mechanics.no_history(),
            bolts=BoltMemory.of(self.bolts),
            origin=self._origin,
            velocity=self._velocity,
            intact=self._intact,
            linear_solver=self.linear_solver,
            loop=loop,
            shaken=self._shaken,
        )

    def restore(self, state: ContinuationState) -> None:
        """Go back to a state of the same run; `solve` then continues where it was."""
        self.moved, self._origin, self._velocity = state.moved.copy(), state.origin, state.velocity
        self.history, self.bolts = state.history, state.bolts.recalled(self.bolts)
        self._intact, self.linear_solver, self._resumed = state.intact, state.linear_solver, state.loop
        self._shaken = state.shaken

    def set_in_situ(self) -> tuple[str, ...]:
        """Set the contact forces from the in-situ field, and return notes on it."""
        self.history, notes = self._mechanics.in_situ_history(self.model)
        return notes

    def stage_bars(self, bars: Bars, number: int) -> Bars:
        """Return the supports for a stage; their displacements so far are in the blocks' positions."""
        return bars

    def remove_and_place_blocks(self, stays: BoolArray, comes: BoolArray) -> None:
        """Remove contacts and bolts of blocks that do not stay; filled ones fit their neighbours, without force."""
        self.history = self._mechanics.between(self.history, stays)
        self.bolts = self.bolts.without(~stays)
        self.moved[~stays] = 0.0
        if comes.any():
            given = self.history, self.model, comes, stays | comes, self.moved
            self.history, self.moved = self._mechanics.with_filled_blocks(*given)

    def install(self, number: int) -> None:
        """Install the bolts of a stage as the blocks are; their movement in the stage counts from there."""
        self.bolts = self.bolts.install(number, self.moved)
        self._origin, self._shaken = self.moved.copy(), None

    def as_given(self, block: IntArray, point: FloatArray) -> FloatArray:
        """Return the positions in the given geometry of points of blocks, a row each."""
        return as_given(self.model.blocks, self.moved, block, point)

    def solve(
        self,
        part: SubModel,
        number: int,
        bars_before: FloatArray,
        observer: Observer,
        accepted: Callable[[], None],
    ) -> Outcome:
        """Return the part in equilibrium or collapse, and keep its position and history."""
        self.report(self.options.scheme)
        start = self._start(part)
        self._intact = False
        whole = number > 0 or self.model.in_situ is not None
        for share in (1.0,) if whole else self.route.parts:
            loaded = loaded_in_part(part.model, share)
            engine = self._engine = self._loop(
                replace(part, model=loaded), number, start, bars_before, observer, accepted
            )
            self._resumed = None
            motion = engine.run()
            self._engine = None
            history, _ = engine.system.commit(motion.contacts, motion.at, motion.position)
            start = replace(start, position=motion.position, history=history, intact=False, bolts=motion.bolts)
            if motion.status is not Status.STABLE:
                break
        if self.options.falls.takes_away(motion.small):
            self.report(f"{motion.reason}: {counted(motion.small.size, 'block')} taken away, the run continues")
        else:
            self.report(f"{motion.status.value}: {motion.reason}")
        self.linear_solver = motion.linear_solver
        self.moved[part.block] = motion.position
        self.history = self._mechanics.in_whole(history, part)
        self.bolts = self.bolts.after(motion.bolts)
        self._velocity = None if motion.velocity is None else part.in_whole(motion.velocity)
        self._shaken = None if engine.shaken is None else engine.shaken.in_whole(part)
        return self._outcome(engine, motion, bars_before)

    def blocks_before_shaking(self, part: SubModel, number: int) -> ShakenBlocks:
        """Return the blocks of a part when a stage that is shaken begins, ready to be followed."""
        bars_before = np.zeros(len(part.bar))
        loop = self._loop(part, number, self._start(part), bars_before, lambda *_: None, lambda: None)
        assert isinstance(loop, ShakenContinuation)
        return loop.blocks_at_start()

    def _start(self, part: SubModel) -> Start:
        """Return the state of a part as it is now."""
        return Start(
            position=self.moved[part.block],
            history=self._mechanics.in_part(self.history, part),
            intact=self._intact,
            bolts=self.bolts.in_part(part),
            origin=self._origin[part.block],
            velocity=None if self._velocity is None else self._velocity[part.block],
        )

    def _loop(
        self,
        part: SubModel,
        number: int,
        start: Start,
        bars_before: FloatArray,
        observer: Observer,
        accepted: Callable[[], None],
    ) -> Continuation:
        """Return the loop of a part in a stage, at its start."""

        def watch(record: StepRecord, motion: Callable[[], Motion]) -> None:
            observer(record, lambda: self._outcome(engine, motion(), bars_before).stage)

        given = part.model, self.options, watch, start, self._resumed, accepted, self.route
        engine: Continuation
        shaking = self.model.stages[number - 1].shaking if number else None
        if shaking is not None:
            shaken = None if self._shaken is None else self._shaken.in_part(part)
            engine = ShakenContinuation(*given, shaking=shaking, shaken=shaken, quiet=self._quiet(shaking))
        else:
            engine = (WangIteration if self.options.scheme == "wang" else Continuation)(*given)
        return engine

    def _quiet(self, shaking: Shaking) -> IntArray:
        """Return the numbers of the supports of quiet boundaries."""
        supports = self.model.supports
        found = [k for k, one in enumerate(supports) if isinstance(one, Target) and one.boundary in shaking.quiet]
        return np.array(found, dtype=np.int32)

    def _outcome(self, engine: Continuation, motion: Motion, bars_before: FloatArray) -> Outcome:
        bolts = bolt_forces(self.model.bolts, self.bolts.after(motion.bolts), motion.bolts_at)
        outcome = self._mechanics.outcome(engine.system, motion, engine.origin, bars_before, bolts)
        if engine.shaken is None:
            return outcome
        return replace(outcome, stage=replace(outcome.stage, shaking=result_of(engine.shaken)))


def loaded_in_part(model: Model, share: float) -> Model:
    """Return a model under a share of its weights, loads and water."""
    if share == 1:
        return model
    forces = point_forces_of(model.acting_loads, model.blocks)
    return model.replace(
        rocks=[replace(rock, unit_weight=share * rock.unit_weight) for rock in model.rocks],
        loads=[replace(forces, force=share * forces.force)],
        water=None if model.water is None else model.water.scaled(share),
        face_water=None if model.face_water is None else model.face_water.scaled(share),
    )
