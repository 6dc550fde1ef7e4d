"""Shear strength of contacts at the pressure they bear, to say how near each is to slipping."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.model.materials import JointLaw, MohrCoulomb, Rock
from bsm_mesh.model.model import Model

MOST_UTILISATION = 999.0  # shown where a contact without strength bears shear


def peak_strength(law: JointLaw, pressure: FloatArray, length: FloatArray) -> FloatArray:
    """Return the peak shear strength of contacts [N/m].

    Parameters
    ----------
    law : Patton or MohrCoulomb
        The joint law.
    pressure : (m,) float64 [N/m]
        Normal force, compression positive, not negative.
    length : (m,) float64 [m]
        Length that each contact stands for.
    """
    friction = np.tan(np.radians(law.friction))
    if isinstance(law, MohrCoulomb):
        return np.asarray(law.cohesion * length + pressure * friction)
    residual = law.friction if law.residual_friction is None else law.residual_friction
    first: FloatArray = pressure * np.tan(np.radians(law.friction + law.dilation))  # Wang Eq. 4.1
    second = law.cohesion * length + pressure * np.tan(np.radians(residual))  # Wang Eq. 4.2
    return np.asarray(np.minimum(first, second))


def utilisation(model: Model, contacts: ContactTable, normal_force: FloatArray, shear_force: FloatArray) -> FloatArray:
    """Return shear force over peak shear strength of every contact; 0 where the strength is unlimited."""
    pressure = np.maximum(-normal_force, 0.0)
    strength = np.full(contacts.count, np.inf)
    for number, joint in enumerate(model.joints):
        chosen = contacts.joint == number
        if joint.law is not None and chosen.any():
            strength[chosen] = peak_strength(joint.law, pressure[chosen], contacts.length[chosen])
    unjointed = contacts.joint < 0
    laws = [_face_law(model, name) for name in model.blocks.rock_names]
    if unjointed.any() and any(laws):
        for side in (contacts.block_a, contacts.block_b):
            rock = model.blocks.rock[side]
            for number, law in enumerate(laws):
                chosen = unjointed & (rock == number)
                if law is not None and chosen.any():  # between two rocks the weaker governs
                    here = peak_strength(law, pressure[chosen], contacts.length[chosen])
                    strength[chosen] = np.minimum(strength[chosen], here)
    shear = np.abs(shear_force)
    noise = 1e-12 * float(shear.max(initial=0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.where(shear > noise, shear / strength, 0.0)
    return np.minimum(used, MOST_UTILISATION)


def _face_law(model: Model, name: str) -> MohrCoulomb | None:
    """Return the law of a rock's unjointed faces; None where it gives no strength."""
    rock: Rock = next(rock for rock in model.rocks if rock.name == name)
    if rock.cohesion is None and rock.friction is None and rock.tensile_strength is None:
        return None
    return MohrCoulomb(friction=rock.friction or 0.0, cohesion=rock.cohesion or 0.0)
