"""Motion of blocks with zones in large displacement, where no equilibrium is near: to rest, or until blocks fall.

Blocks move as in a shaken stage, over a base at rest. Impacts are damped critically, as those of rigid blocks. Rock
yields no further in motion; it yields in the equilibrium after it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.errors import ModelError
from bsm_mesh.movements import distances
from bsm_mesh.results.movement import LOST_CONTACT, moved_beyond
from bsm_mesh.solve.motion.falling import SETTINGS as COLLAPSE
from bsm_mesh.solve.motion.following import DAMPED, FREE
from bsm_mesh.solve.zones.equilibrium import Equations
from bsm_mesh.solve.zones.large_water import wetted
from bsm_mesh.solve.zones.quiet_nodes import quiet_nodes
from bsm_mesh.solve.zones.rock_in_motion import MovingRock
from bsm_mesh.solve.zones.shaken_zones import SINGLE
from bsm_mesh.solve.zones.shaking_run import PARTS, go_on, time_to_rest
from bsm_mesh.solve.zones.stage_solution import Fall, movement
from bsm_mesh.solve.zones.unyielding import yielding_no_further
from bsm_mesh.solve.zones.zones_to_rest import STILL, ZonesToRest

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_run import StageRun
    from bsm_mesh.solve.zones.stages import Continuum

RUNS_ON = f"blocks move on after {COLLAPSE.runs:g} times their size"
STIFFEST = 100.0  # times a joint's stiffness and a block's size: stiffer rock takes more cycles to the same rest


def follow(run: StageRun, equations: Equations, present: BoolArray) -> tuple[Equations, Fall | None] | None:
    """Return the equations after the motion, and the blocks that fall; the displacements of the run are those there.

    None: rock has no mass, supports hold blocks by their mean, blocks do not reach rest, or motion diverges. Nothing is
    changed then.
    """
    of, u = run.of, run.state.u
    if not of.model.unit_weights[present].all():
        return None
    try:
        motion = _in_motion(run, equations, present)
    except ModelError:
        return None
    blocks, start, free = of.model.blocks.moments, movement(of, u), _free(of, equations, present)
    size = np.maximum(blocks.size, blocks.mean_size(free))
    allowed, runs_on = COLLAPSE.runs * size, RUNS_ON
    if run.limit is not None:
        allowed, runs_on = np.full_like(size, run.limit), moved_beyond(run.limit)
    recent, held = deque([start], PARTS), start
    last, most, gone = 0.0, 0.0, np.zeros_like(present)
    longest = time_to_rest(size[free])
    while motion.memory.time < longest and not gone.any():
        go_on(motion)
        if motion.diverged:
            return None
        motion.equations = wetted(run, motion.equations, motion.at.u, present) or motion.equations
        here = movement(of, motion.at.u)
        held = np.where(_held(of, motion)[:, None], here, held)
        far = (distances(here - start) > allowed) & present
        gone = far | (distances(here - held) > COLLAPSE.free_move * size) & present
        is_near = (distances(here - recent[0]) < CONTACT_TOLERANCE * size)[present].all()
        recent.append(here)
        farthest = distances(here - start)[present].max()
        run.report(f"blocks move: by up to {farthest:.3g} m after {motion.memory.time:.3g} s of motion")
        motion.damping = (DAMPED if is_near else FREE).damping
        before, last = last, motion.kinetic
        most = max(most, abs(motion.stored))
        if is_near and last <= min(before, SINGLE * most):
            break
    else:
        if not gone.any():
            return None
    run.state.u = motion.at.u
    kept = {name: getattr(motion.equations, name) for name in ("joints", "history", "bolts", "load", "water")}
    reason = runs_on if far.any() else LOST_CONTACT
    fall = Fall(np.flatnonzero(gone).astype(np.int32), reason) if gone.any() else None
    return replace(equations, **kept), fall


def _in_motion(run: StageRun, equations: Equations, present: BoolArray) -> ZonesToRest:
    """Return the blocks at the begin, in rock that is no stiffer than it has to be: equilibrium is found as it is."""
    large, joints = equations.large, run.of.model.joints
    assert large is not None
    stiffest = STIFFEST * equations.size * max((joint.contact_stiffness[0] for joint in joints), default=np.inf)
    part = np.minimum(1.0, stiffest / run.stiffness.max(axis=(1, 2)))
    stiffness = run.stiffness * part[:, None, None]
    rock = replace(large.rock, stiffness=stiffness)
    softer = yielding_no_further(replace(equations, large=replace(large, rock=rock)), part)
    moving = MovingRock(run.of, stiffness, present, softer, softer.load)
    quiet = quiet_nodes(run.of, stiffness, STILL, np.zeros(2), present)
    motion = ZonesToRest(moving, softer, run.state.u, STILL, present, quiet)
    motion.is_over, motion.damping = True, DAMPED.damping  # blocks begin damped, as rigid ones do
    return motion


def _free(of: Continuum, equations: Equations, present: BoolArray) -> BoolArray:
    """Return the blocks whose sizes count, (n,): those without a support, or all blocks if each has one."""
    free = present.copy()
    free[of.mesh.block[equations.free.supports.held[of.basis.element_dofs].any(axis=0)]] = False
    return free if free.any() else present


def _held(of: Continuum, motion: ZonesToRest) -> BoolArray:
    """Return which blocks are connected to a support by points, bolts in tension and rock, (n,).

    Points count that were closed at any time since the last look: stiff blocks that bounce are seldom closed at once.
    """
    joints, state, free = motion.equations.joints, motion.at.state, motion.equations.free
    dofs, block, count = of.basis.element_dofs, of.mesh.block, of.model.blocks.count
    assert joints is not None
    assert state is not None
    # Blocks, then unknowns: cells tie both.
    one, other = np.concatenate([joints.block[state.closed], motion.touched]).T
    bolts, forces = motion.equations.bolts, motion.at.bolts
    if bolts is not None and forces is not None:
        first = bolts.bolts.layout.first_node[forces.tension > 0]
        one, other = np.append(one, bolts.block[first]), np.append(other, bolts.block[first + 1])
    pairs = np.concatenate([np.tile(block, len(dofs)), one]), np.concatenate([count + dofs.ravel(), other])
    size = count + of.basis.N
    graph = coo_matrix((np.ones(len(pairs[0]), np.int8), pairs), shape=(size, size))
    part = connected_components(graph, directed=False)[1]
    return np.isin(part[:count], part[count + np.flatnonzero(free.supports.held)])
