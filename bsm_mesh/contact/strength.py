"""Contact strength: shear strength as the lower of straight lines over the pressure, and tensile strength.

Patton's and Mohr-Coulomb's criteria bound the shear force by the lower of straight lines, intercept + slope *
pressure. So do two different rocks that meet without a joint: the weaker governs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.model.joint_laws import JointLaw, MohrCoulomb, Patton
from bsm_mesh.model.materials import Rock
from bsm_mesh.model.model import Model

MAX_UTILISATION = 999.0  # shown where a contact without strength carries shear


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactStrength:
    """Peak strength of every contact.

    Attributes
    ----------
    slope, intercept : (m, 2) float64 [-, N/m]
        Shear force is bounded by the lower of ``intercept + slope * pressure``; infinite: no bound.
    tension : (m,) float64 [N/m]
        Greatest tension; infinite: no bound.
    """

    slope: FloatArray
    intercept: FloatArray
    tension: FloatArray

    def peak(self, pressure: FloatArray) -> FloatArray:
        """Return the peak shear strength, (m,) [N/m], at a pressure (m,) [N/m], compression positive."""
        strength: FloatArray = (self.intercept + self.slope * pressure[:, None]).min(axis=1)
        return strength


def strength_lines(law: JointLaw, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return slope and intercept (m, 2) of a law's two lines for contacts of the given lengths (m,) [m]."""
    slope, intercept = np.zeros((len(length), 2)), np.full((len(length), 2), np.inf)
    if isinstance(law, MohrCoulomb):
        slope[:, 0], intercept[:, 0] = np.tan(np.radians(law.friction)), law.cohesion * length
        return slope, intercept
    if not isinstance(law, Patton):
        raise TypeError(f"the law {type(law).__name__} has no straight lines of strength")
    slope[:, 0], intercept[:, 0] = np.tan(np.radians(law.friction + law.dilation)), 0.0  # Wang Eq. 4.1
    slope[:, 1], intercept[:, 1] = np.tan(np.radians(law.residual)), law.cohesion * length  # Wang Eq. 4.2
    return slope, intercept


def peak_strength(law: JointLaw, pressure: FloatArray, length: FloatArray) -> FloatArray:
    """Return the peak shear strength of contacts [N/m] (Wang Eq. 4.8).

    Parameters
    ----------
    law : Patton or MohrCoulomb
        The joint law.
    pressure : (m,) float64 [N/m]
        Normal force, compression positive, not negative.
    length : (m,) float64 [m]
        Length that each contact stands for.
    """
    slope, intercept = strength_lines(law, length)
    return ContactStrength(slope=slope, intercept=intercept, tension=np.zeros(len(length))).peak(pressure)


def contact_strength(model: Model, contacts: ContactTable) -> ContactStrength:
    """Return the strength of every contact: of its joint, or of the rocks on both sides where it has none."""
    m, length = contacts.count, contacts.length
    slope, intercept, tension = np.zeros((m, 2)), np.full((m, 2), np.inf), np.full(m, np.inf)
    for number, joint in enumerate(model.joints):
        chosen = contacts.joint == number
        if joint.law is not None and chosen.any():
            slope[chosen], intercept[chosen] = strength_lines(joint.law, length[chosen])
            tension[chosen] = joint.tensile_strength * length[chosen]
    unjointed = contacts.joint < 0
    for side, blocks in enumerate((contacts.block_a, contacts.block_b)):
        rock_of = model.blocks.rock[blocks]
        for number, name in enumerate(model.blocks.rock_names):
            rock = next(rock for rock in model.rocks if rock.name == name)
            chosen = unjointed & (rock_of == number)
            if not _has_strength(rock) or not chosen.any():
                continue
            law = MohrCoulomb(friction=rock.friction or 0.0, cohesion=rock.cohesion or 0.0)
            lines = strength_lines(law, length[chosen])
            slope[chosen, side], intercept[chosen, side] = lines[0][:, 0], lines[1][:, 0]
            tension[chosen] = np.minimum(tension[chosen], (rock.tensile_strength or 0.0) * length[chosen])
    return ContactStrength(slope=slope, intercept=intercept, tension=tension)


def utilisation(model: Model, contacts: ContactTable, normal_force: FloatArray, shear_force: FloatArray) -> FloatArray:
    """Return shear force over peak shear strength of every contact; 0 where the strength is unlimited."""
    strength = contact_strength(model, contacts).peak(np.maximum(-normal_force, 0.0))
    shear = np.abs(shear_force)
    noise = 1e-12 * float(shear.max(initial=0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.where(shear > noise, shear / strength, 0.0)
    return np.minimum(used, MAX_UTILISATION)


def _has_strength(rock: Rock) -> bool:
    """Whether a rock's unjointed faces can fail: it gives cohesion, friction or tensile strength."""
    return not (rock.cohesion is None and rock.friction is None and rock.tensile_strength is None)
