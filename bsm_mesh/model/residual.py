"""Joints and rocks that lose strength as they slip: limit analysis counts their peak strength."""

from __future__ import annotations

from collections.abc import Iterator

from bsm_mesh.model.joint_laws import JointLaw
from bsm_mesh.model.law_faults import fails_by_slip, loses_strength
from bsm_mesh.model.model import Model


def residual_note(model: Model) -> str:
    """Return a sentence on the joints and rocks of a model that slip weakens; empty where there are none."""
    names = list(_weakened(model))
    if not names:
        return ""
    return (
        "limit analysis counts peak strength everywhere. A run follows the residual strength that slip leaves "
        f"({', '.join(names)}): its factor of safety may be lower"
    )


def _weakened(model: Model) -> Iterator[str]:
    """Return the joints and rocks whose strength slip lessens, as messages name them."""
    for joint in model.joints:
        if joint.law is not None and _loses(joint.law, joint.tensile_strength, joint.residual_tensile_strength):
            yield f"joint '{joint.name}'"
    for rock in model.rocks:
        if rock.law is not None and _loses(rock.law, rock.tensile_strength or 0.0, rock.residual_tensile_strength):
            yield f"rock '{rock.name}'"


def _loses(law: JointLaw, tension: float, residual_tension: float) -> bool:
    """Return whether slip lessens the shear strength of a law or its tensile strength [Pa]."""
    return loses_strength(law) or (residual_tension < tension and fails_by_slip(law))
