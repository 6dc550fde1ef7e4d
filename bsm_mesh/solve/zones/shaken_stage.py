"""The end of a stage of zones that is shaken, and its begin where blocks are as they were given."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.base_motion import BaseMotion
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.shaking_memory import result_of
from bsm_mesh.solve.zones.quiet_nodes import quiet_nodes
from bsm_mesh.solve.zones.rock_in_motion import MovingRock
from bsm_mesh.solve.zones.shaken_zones import ShakenZones
from bsm_mesh.solve.zones.shaking_run import Watch, come_to_rest, shaken_through
from bsm_mesh.solve.zones.stage_solution import StageEnd
from bsm_mesh.solve.zones.water_near import StageLoads

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_run import StageRun


def shaken_end(run: StageRun, name: str, shaking: Shaking, present: BoolArray, watch: Watch) -> StageEnd:
    """Return the end of a stage that is shaken: the motion, and the rest to which it leads."""
    state, loads = run.state, run.loads_on(present)
    state.held_back(1.0)
    motion = in_motion(run, shaking, present, loads)

    def now() -> StageEnd:
        return run.end_at(name, present, motion.equations, motion.at, loads, converged=False)

    fault, fall = shaken_through(motion, shaking, partial(watch, now=now)), None
    if not fault:
        fault, fall = come_to_rest(run.of, motion, present)
    result = result_of(motion.memory)
    if fault or fall is not None:
        return replace(now(), shaking=result, fault=fault, fall=fall)
    state.u, state.joints = motion.at.u, motion.equations.joints
    state.history, state.bolts = motion.equations.history, motion.equations.bolts
    return replace(run.solved(name, present, (1.0,)), shaking=result)


def in_motion(run: StageRun, shaking: Shaking, present: BoolArray, loads: StageLoads) -> ShakenZones:
    """Return the blocks that are there (n,) at the begin of the shaking, under loads of `StageRun.loads_on`."""
    of, u = run.of, run.state.u
    equations, outer = run.equations(present, loads, shaking.quiet), of.merged(loads.forces)
    quiet = quiet_nodes(of, run.stiffness, shaking, BaseMotion(shaking).axis, present)
    if shaking.quiet:  # forces of the supports that dashpots replace stay
        held = equations.at(u, equations.free.none).residual * quiet.on_unknowns(of.basis)
        equations, outer = replace(equations, load=equations.load - held), outer - held
    rock = MovingRock(of, run.stiffness, present, equations, outer)
    return ShakenZones(rock, equations, u, shaking, present, quiet)


def as_given(run: StageRun, number: int, shaking: Shaking) -> ShakenZones:
    """Return the blocks of a stage that is shaken, by its number, where they were given, ready to be followed."""
    present = run.of.presence[number]
    run.recall(run.memory, number)
    if run.state.bolts is not None:
        for stage in range(1, number + 1):
            run.state.bolts = run.state.bolts.install(stage, run.state.u)
        run.state.bolts = run.state.bolts.without(~present)
    return in_motion(run, shaking, present, run.loads_on(present))
