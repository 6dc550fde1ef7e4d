"""Supports that move blocks in large displacement: they do so by steps, along which joints slide on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.solve.zones.equilibrium import OPEN_STIFFNESS, Equations
from bsm_mesh.solve.zones.joint_history import JointHistory
from bsm_mesh.solve.zones.met_points import begun_between, met
from bsm_mesh.solve.zones.moving_points import MovingPoints


def steps(equations: Equations, u: FloatArray) -> Iterator[bool]:
    """Let the supports hold one part after the other of their movement beyond displacements u (N,).

    Yields whether they moved. First they stay, so that loads press joints before these slide. No step moves them by
    more than the side of a zone on a joint, the median.
    """
    free, joints = equations.free, equations.joints
    last = free.supports
    if not isinstance(joints, MovingPoints):
        yield False
        return
    turned = u if free.turn is None else free.turn.T @ u
    first = np.where(last.held, turned, 0.0), last.rows @ u
    way = last.given - first[0], last.values - first[1]
    furthest = max(float(np.abs(part).max(initial=0.0)) for part in way)
    count = int(np.ceil(round(furthest / joints.side, 6)))  # supports that stay do so but for rounding
    for step in range(count):
        free.hold(*(start + step / count * part for start, part in zip(first, way, strict=True)))
        yield step > 0
    free.hold(last.given, last.values)
    yield count > 0


def carried(equations: Equations, u: FloatArray) -> FloatArray:
    """Return displacements u (N,) after supports moved, with the blocks that they take along.

    By the present tangent: if the held nodes alone moved, they would strain their zones.
    """
    free, large = equations.free, equations.large
    jump = free.fulfilled(u) - u
    now = equations.at(u, free.none)
    assert large is not None
    assert equations.joints is not None
    assert equations.history is not None
    assert now.state is not None
    points = equations.joints.stiffness(now.state, equations.history, OPEN_STIFFNESS)
    K = large.matrix(u, equations.joints, now.state, points)
    if equations.bolts is not None and now.bolts is not None:
        K = K + equations.bolts.tangent(now.bolts)
    correction, _ = free.solve(free.reduced_matrix(K), now.residual - K @ jump, u)
    return large.moved(u, correction + jump)


def slid_on(
    equations: Equations,
    u: FloatArray,
    present: BoolArray,
    start: FloatArray | None = None,
    band: float = 0.0,
    *,
    keeps_lengths: bool = False,
) -> Equations | None:
    """Return the equations with joints at the places that they face at displacements u (N,), and where blocks met.

    None: none slid far, or met. Points over the end of a face have come apart for good.

    Parameters
    ----------
    equations : Equations
        As they are.
    u : (N,) float64 [m]
        Displacements.
    present : (n,) bool
        Which blocks are there.
    start : (N,) float64 or None [m]
        Displacements from which blocks at rest came: where they met on the way their slip begins.
    band : float [m]
        How near to each other blocks that move have met.
    keeps_lengths : bool
        Whether closed points keep their lengths, in time.
    """
    joints, history = equations.joints, equations.history
    if not isinstance(joints, MovingPoints) or history is None:
        return None
    moved, state = joints.slid_on(u, present), joints.evaluate(u, history)
    if moved is not None:
        over = moved.places.over
        breaks = over & np.isfinite(moved.tension)
        history = replace(
            history,
            present=present[moved.block].all(axis=1) & ~over,
            failed=history.failed | breaks,
            parted=history.parted | breaks,
            shear=np.where(over, 0.0, history.shear),
            offset=_offset_after(joints, moved, history, u) if band > 0 else history.offset,
        )
    further = met(moved or joints, history, u, present, state, band, keeps_lengths=keeps_lengths)
    if further is None:
        return None if moved is None else replace(equations, joints=moved, history=history)
    joints, history, fresh = further
    if start is not None:
        history = begun_between(joints, history, fresh, start, u)
    return replace(equations, joints=joints, history=history)


def _offset_after(joints: MovingPoints, moved: MovingPoints, history: JointHistory, u: FloatArray) -> FloatArray:
    """Return the gaps without force (q,) [m] of points in motion; points that pass to another block keep their force.

    Points that come back from beyond the end of a face had none. Without that a step between two faces would push the
    blocks apart. Where the face of the other block lies deeper, the point opens.
    """
    gap = np.where(joints.over, 0.0, joints.relative(u)[0] - history.offset)
    kept = np.minimum(moved.relative(u)[0] - gap, np.maximum(history.offset, 0.0))
    passed = (moved.block[:, 0] != joints.block[:, 0]) | (joints.over & ~moved.over)
    return np.where(passed, kept, history.offset)


def slip_begun(start: JointHistory | None, equations: Equations) -> JointHistory | None:
    """Return the history from which slip counts, for the points as they are now: later points are new."""
    joints, history = equations.joints, equations.history
    if start is None or history is None or not isinstance(joints, MovingPoints):
        return start
    path, count = history.slip_path.copy(), len(joints.own)
    path[:count] = start.slip_path[:count]
    return replace(history, slip_path=path)
