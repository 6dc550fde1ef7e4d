"""Law and tensile strength of unjointed faces between two rocks."""

from __future__ import annotations

import math

from bsm_mesh.model.joint_laws import Elastic, JointLaw, Weaker
from bsm_mesh.model.materials import Rock


def law_between(one: Rock, other: Rock) -> JointLaw:
    """Return the law of the faces between two rocks: Mohr-Coulomb, of which the weaker governs."""
    laws = [rock.law for rock in (one, other) if rock.law is not None]
    if not laws:
        return Elastic()
    return laws[0] if len(laws) == 1 or laws[0] == laws[1] else Weaker(laws[0], laws[1])


def tension_between(one: Rock, other: Rock) -> float:
    """Return the tensile strength of the faces between two rocks [Pa]; infinite where neither gives a strength."""
    return min((rock.tensile_strength or 0.0) if rock.has_strength else math.inf for rock in (one, other))


def residual_tension_between(one: Rock, other: Rock) -> float:
    """Return what slip leaves of the tensile strength of the faces between two rocks [Pa].

    A rock that never fails keeps its strength, so that the other rock governs.
    """
    left = [rock.residual_tensile_strength for rock in (one, other) if rock.has_strength]
    return min(left, default=0.0)
