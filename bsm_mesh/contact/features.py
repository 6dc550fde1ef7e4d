"""The features of the contacts of a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.closure import Hyperbolic
from bsm_mesh.contact.dilation import Dilating
from bsm_mesh.contact.properties import LawCatalogue
from bsm_mesh.contact.shear_springs import Growing


class Features(NamedTuple):
    """All features of contacts, in the order in which callers ask them."""

    closure: Hyperbolic
    growing: Growing
    dilating: Dilating

    def of(self, number: IntArray) -> Features:
        """Return those of contacts that get a number (m,) of 0 or more."""
        return Features(self.closure.of(number), self.growing.of(number), self.dilating.of(number))

    def pressures(
        self, overlap: FloatArray, pressure: FloatArray, stiffness: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return pressures and their derivatives (m,), as `Feature.pressures`."""
        for each in self:
            pressure, stiffness = each.pressures(overlap, pressure, stiffness)
        return pressure, stiffness

    def opened(self, offset: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Return the offsets of contacts after slip paths continued (m,) [m], as `Feature.opened`."""
        for each in self:
            offset = each.opened(offset, before, after)
        return offset

    def once_open(self, offset: FloatArray, slip_path: FloatArray) -> FloatArray:
        """Return the gaps at which contacts would close again had they opened, (m,) [m]: without dilation, then lost.

        Only stress in situ, and filled blocks, leave any above 0.
        """
        return self.opened(offset, slip_path, np.zeros_like(slip_path))


def features_of(
    catalogue: LawCatalogue,
    joint: IntArray,
    length: FloatArray,
    stiffness: tuple[FloatArray, FloatArray],
    mated: BoolArray,
) -> Features:
    """Return the features of contacts by their joints.

    Parameters
    ----------
    catalogue : LawCatalogue
        What joints have.
    joint : (m,) int32
        Theirs; -1: rock.
    length : (m,) float64 [m]
        That contacts represent.
    stiffness : (m,), (m,) float64 [N/m2]
        Of joint and rock in series without stress, normal and in shear; 0 in shear: smooth.
    mated : (m,) bool
        Closed since the start: only these close by a hyperbola and open as they slide.
    """
    normal, shear = stiffness
    limit, own = catalogue.closure_of(joint)
    slope, last = catalogue.dilation_of(joint)
    return Features(
        closure=Hyperbolic.among(np.where(mated, limit, np.inf) if len(limit) else limit, own, length, normal),
        growing=Growing.among(*catalogue.shear_curve_of(joint), length, shear),
        dilating=Dilating.among(np.where(mated, slope, 0.0) if len(slope) else slope, last),
    )
