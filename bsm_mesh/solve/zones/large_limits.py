"""How far joints may open and slide while blocks in large displacement keep their opposite nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.errors import place
from bsm_mesh.solve.zones.moving_points import MovingPoints

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_solution import StageEnd
    from bsm_mesh.solve.zones.stages import Continuum

SLID = 0.1  # of the side of a zone: beyond, a node lies opposite another part of its neighbour


def parted(of: Continuum, end: StageEnd) -> str:
    """Return where a face slid too far along its neighbour, in words; empty where none did.

    A point that is open may be anywhere: it carries nothing.
    """
    joints, state = of.joints, end.at.state
    if not isinstance(joints, MovingPoints) or state is None:
        return ""
    here = end.present[joints.block].all(axis=1) & state.closed
    share = np.abs(state.slip) / joints.pieces * here
    if share.max(initial=0.0) <= SLID:
        return ""
    worst = int(share.argmax())
    a, b = joints.block[worst, ::-1]
    return (
        f"block {a} slid by {abs(state.slip[worst]):.3g} m along block {b} at "
        f"{place(tuple(joints.placed(end.u)[worst]))}, and zones are followed up to {100 * SLID:g} % of the side of a "
        "zone; leave zones out to follow blocks"
    )
