"""Which methods are tried in a step, in order, by the phase that it is in."""

from __future__ import annotations

from enum import StrEnum

from bsm_mesh.solve.methods.nearby_equilibrium import NearbyEquilibrium
from bsm_mesh.solve.methods.newton import ExactNewton
from bsm_mesh.solve.methods.regularized_newton import RegularizedNewton
from bsm_mesh.solve.motion.following import FollowMotion
from bsm_mesh.solve.motion.relaxation import RelaxToRest
from bsm_mesh.solve.step.attempt import Method


class Phase(StrEnum):
    """What a step is about."""

    START = "start"  # the first of a run: contacts carry nothing yet, or the in-situ field
    AFTER_CHANGE = "after a change"  # the first after an excavation, fill, new loads, water or bolts
    NEAR_REST = "near rest"  # blocks are slow, or were at rest: an equilibrium may be near
    MOVING = "moving"


PLANS: dict[Phase, tuple[Method, ...]] = {
    Phase.START: (NearbyEquilibrium(), RelaxToRest(), FollowMotion()),
    Phase.AFTER_CHANGE: (NearbyEquilibrium(localized=True), RelaxToRest(), FollowMotion()),
    Phase.NEAR_REST: (RegularizedNewton(), ExactNewton(), FollowMotion()),
    Phase.MOVING: (FollowMotion(),),
}
