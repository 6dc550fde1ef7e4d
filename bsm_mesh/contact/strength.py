"""Strength of contacts that have not failed: in shear by their laws, or by the laws' straight lines, and in tension."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import ModelError
from bsm_mesh.model.joint_laws import JointLaw, StraightLaw
from bsm_mesh.model.model import Model
from bsm_mesh.model.strength import law_name

MAX_UTILISATION = 999.0  # shown where a contact without strength carries shear


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactStrength:
    """Strength of contacts that have not failed.

    Attributes
    ----------
    laws : tuple of JointLaw
        Different ones.
    law : (m,) int32
        Number of every contact's law there.
    length : (m,) float64 [m]
        Of the face, represented by every contact.
    tension : (m,) float64 [N/m]
        Greatest tension; infinite: no bound.
    """

    laws: tuple[JointLaw, ...]
    law: IntArray
    length: FloatArray
    tension: FloatArray

    def peak(self, pressure: FloatArray) -> FloatArray:
        """Return the shear strength, (m,) [N/m], at pressures (m,) [N/m], compression positive and not negative."""
        found = np.zeros(len(pressure))
        for number in np.unique(self.law):
            rows = np.flatnonzero(self.law == number)
            found[rows] = peak_strength(self.laws[number], pressure[rows], self.length[rows])
        return found

    def lines(self) -> tuple[FloatArray, FloatArray]:
        """Return slope and intercept of the straight lines that bound the shear, (m, k) each; infinite: no bound.

        Raises
        ------
        ModelError
            Where a law has none.
        """
        rows = {int(number): np.flatnonzero(self.law == number) for number in np.unique(self.law)}
        lines = {number: _lines_of(self.laws[number], self.length[chosen]) for number, chosen in rows.items()}
        most = max((slope.shape[1] for slope, _ in lines.values()), default=0)
        slope, intercept = np.zeros((len(self.law), most)), np.full((len(self.law), most), np.inf)
        for number, (of_slope, of_intercept) in lines.items():
            columns = np.arange(of_slope.shape[1])
            slope[rows[number][:, None], columns] = of_slope
            intercept[rows[number][:, None], columns] = of_intercept
        return slope, intercept


def peak_strength(law: JointLaw, pressure: FloatArray, length: FloatArray) -> FloatArray:
    """Return the peak shear strength of contacts [N/m] (Wang Eq. 4.8).

    Parameters
    ----------
    law : JointLaw
        The joint law.
    pressure : (m,) float64 [N/m]
        Normal force, compression positive, not negative.
    length : (m,) float64 [m]
        Length that each contact represents.
    """
    return law.respond(pressure, np.zeros(len(pressure)), length, np.zeros(len(pressure), dtype=bool)).strength


def _lines_of(law: JointLaw, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    name = law_name(law)
    if not isinstance(law, StraightLaw):
        raise ModelError(
            f"limit analysis needs the shear strength of every joint as straight lines, and the law {name} has no "
            "method strength_lines(length): add it (docs/theory_joint_laws.md), or choose a law that has this method"
        )
    try:
        slope, intercept = (np.asarray(values, dtype=float) for values in law.strength_lines(length))
    except Exception as error:  # of the user's own
        raise ModelError(
            f"the law {name}: strength_lines failed: {type(error).__name__}: {error}; it must return slope and "
            f"intercept of k lines, ({len(length)}, k) each"
        ) from error
    if slope.ndim != 2 or len(slope) != len(length) or slope.shape != intercept.shape:
        raise ModelError(
            f"the law {name}: strength_lines returns arrays of shape {slope.shape} and {intercept.shape}; "
            f"it must return slope and intercept of k lines, ({len(length)}, k) each"
        )
    if not (np.isfinite(slope).all() and (slope >= 0).all() and (intercept >= 0).all()):
        raise ModelError(
            f"the law {name}: strength_lines returns a slope or intercept that is negative or no number; each line is "
            "a strength, 0 or more at every pressure"
        )
    return slope, intercept


def contact_strength(model: Model, contacts: ContactTable) -> ContactStrength:
    """Return the strength of every contact: of its joint, or of the rocks on both sides where it has none."""
    catalogue = JointCatalogue(model)
    law, tension = catalogue.laws_of(contacts.joint, contacts.block_a, contacts.block_b)
    return ContactStrength(laws=catalogue.laws, law=law, length=contacts.length, tension=tension * contacts.length)


def utilisation(model: Model, contacts: ContactTable, normal_force: FloatArray, shear_force: FloatArray) -> FloatArray:
    """Return shear force over peak shear strength of every contact; 0 where the strength is unlimited."""
    strength = contact_strength(model, contacts).peak(np.maximum(-normal_force, 0.0))
    shear = np.abs(shear_force)
    noise = 1e-12 * float(shear.max(initial=0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.where(shear > noise, shear / strength, 0.0)
    return np.minimum(used, MAX_UTILISATION)
