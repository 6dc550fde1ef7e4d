"""Parts of faces that blocks in large displacement bring upon each other, where the joints have no points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.errors import place
from bsm_mesh.solve.zones.moving_points import MovingPoints

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_solution import StageEnd


def parted(end: StageEnd) -> str:
    """Return where a face slid along its neighbour with a part that has no contact, in words; empty where none did.

    A point that is open may be anywhere: it carries nothing.
    """
    joints, state = end.joints, end.at.state
    if not isinstance(joints, MovingPoints) or state is None:
        return ""
    worst = np.flatnonzero(joints.uncovered & state.closed)
    if not worst.size:
        return ""
    b, a = joints.block[worst[0]]
    return (
        f"block {a} slid along block {b} at {place(tuple(joints.placed(end.u)[worst[0]]))} with a part of its face "
        "that touched nothing before, and zones do not follow that; leave zones out to follow blocks"
    )
