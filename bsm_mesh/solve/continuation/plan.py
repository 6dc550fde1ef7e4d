"""Which methods are tried in a step, in order, by the phase that it is in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

from bsm_mesh.solve.methods.nearby_equilibrium import NearbyEquilibrium
from bsm_mesh.solve.methods.newton import ExactNewton, RegularizedNewton
from bsm_mesh.solve.motion.dynamic_relaxation import LIGHTEST, RelaxToRest
from bsm_mesh.solve.motion.following import FollowMotion
from bsm_mesh.solve.step.attempt import Method


class Phase(StrEnum):
    """Purpose of a step."""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """A way to an equilibrium: the plans, and in which parts weights and loads are brought on.

    Attributes
    ----------
    name : str
        In words.
    first : mapping of Phase to tuple of Method
        Plans that replace those of `PLANS`.
    parts : tuple of float
        Of weights, loads and water in the first stage, rising to 1. Where there is in-situ stress they act from the
        start.
    repeats : str
        A method: the route is another only where the usual one tries it. Empty: always.
    """

    name: str
    first: Mapping[Phase, tuple[Method, ...]] = field(default_factory=dict)
    parts: tuple[float, ...] = (1.0,)
    repeats: str = ""

    def plan(self, phase: Phase) -> tuple[Method, ...]:
        """Return the methods of a phase, in order."""
        return self.first.get(phase, PLANS[phase])


GENTLER = RelaxToRest(replace(LIGHTEST, damping=LIGHTEST.damping / 2))
USUAL = Route(name="usual")
OTHERS = (
    Route(
        name="relaxation first",
        first={phase: (RelaxToRest(), FollowMotion()) for phase in (Phase.START, Phase.AFTER_CHANGE)},
    ),
    Route(name="four parts", parts=(0.25, 0.5, 0.75, 1.0)),
    Route(
        name="half the damping",
        first={
            phase: tuple(GENTLER if method.name == GENTLER.name else method for method in PLANS[phase])
            for phase in (Phase.START, Phase.AFTER_CHANGE)
        },
        repeats=GENTLER.name,
    ),
)
"""Routes that `run --spread` compares with the usual one; no run takes them otherwise.

Where relaxation decides whether blocks rest, its damping may decide near the limit; the last route shows it.
"""
