"""Ladanyi and Archambault's law: asperities are climbed over a part of the joint, and sheared through on the rest.

Ladanyi and Archambault (1970), 11th U.S. Symposium on Rock Mechanics, 105-125 (Wang Eqs. 4.3-4.5); the strength of the
asperities after Fairhurst (1964), Int. J. Rock Mech. Min. Sci. 1, 535-546.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.joint_laws.law import JointResponse, cut_to_strength
from bsm_mesh.model.quantities import DILATION, FRICTION, WALL_STRENGTH
from bsm_mesh.model.values import Rules, plain_numbers

K1, K2 = 1.5, 4.0  # exponents of shear area and dilation, from tests on rough surfaces (Ladanyi and Archambault 1970)
N = 10.0  # compressive over tensile strength of the rock (Fairhurst)
TOUCHING = np.geomspace(1e-4, 30.0, 24)  # stresses over the wall strength at which straight lines touch, or nearly
GRID = np.sort(np.concatenate([np.geomspace(1e-7, 1e3, 4001), np.linspace(0.3, 1.1, 4001)]))  # at which they are above
ROOM = 2e-6  # of the strength where a line touches: what a curve may rise by between two points of the grid


@dataclass(frozen=True, slots=True, kw_only=True)
class LadanyiArchambault:
    """Ladanyi-Archambault joint law: s (1 - a) (d + tan f) + a S over 1 - (1 - a) d tan f, at a stress s.

    Up to the wall strength c, asperities of strength S are sheared through on a part a = 1 - (1 - s/c)^1.5 of the
    joint. The rest climbs at the rate d = (1 - s/c)^4 tan(dilation). Beyond c the joint is as strong as rock.
    S = c (sqrt(n + 1) - 1) / n sqrt(1 + n s/c), n = 10. Slip takes nothing away; a contact that has opened, or that
    arose after the start, has the friction alone.

    Attributes
    ----------
    friction : float [degrees]
        Friction angle f of the smooth surface.
    dilation : float [degrees]
        Angle of the asperities; strength only, no opening with slip.
    jcs : float [Pa]
        Compressive strength c of the walls.

    Raises
    ------
    ModelError
        With every value out of range, and where friction and dilation together are 90 degrees or more.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.LadanyiArchambault(friction=30, dilation=15, jcs=60e6).dilation
    15
    """

    friction: Annotated[float, FRICTION]
    dilation: Annotated[float, DILATION]
    jcs: Annotated[float, WALL_STRENGTH]

    def __post_init__(self) -> None:
        rules = Rules("law 'ladanyi_archambault'")
        rules.numbers(self)
        if not rules.faults:
            rules.number("friction + dilation", self.friction + self.dilation, FRICTION)
        raise_faults(rules.faults)
        plain_numbers(self)

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the strength of climbing and shearing; friction alone once failed."""
        wall = self.jcs * length
        smooth = math.tan(math.radians(self.friction))
        pressing = np.maximum(pressure, 0.0)
        strength, slope = self._strength(pressing / wall)
        strength = np.where(failed, smooth * pressing, wall * strength)
        slope = np.where(pressure > 0, np.where(failed, smooth, slope), 0.0)
        return cut_to_strength(trial_shear, strength, slope, failed.copy())

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return lines that touch the strength from above: it is not concave everywhere, and they are."""
        strength, _ = self._strength(GRID)
        steepest = max(float((strength / GRID).max()), float(self._strength(np.zeros(1))[1][0]))
        chosen = np.append(steepest, self._strength(TOUCHING)[1])
        above = strength - chosen[:, None] * GRID
        touches = above.argmax(axis=1)
        intercept = np.maximum(above.max(axis=1), 0.0) + ROOM * strength[touches]
        return np.tile(chosen, (len(length), 1)), np.outer(self.jcs * length, intercept)

    def _strength(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return strength and its derivative at stresses, all over the wall strength."""
        smooth, steep = math.tan(math.radians(self.friction)), math.tan(math.radians(self.dilation))
        whole = np.maximum(1.0 - x, 0.0)
        climbs, dilation = whole**K1, whole**K2 * steep
        d_climbs, d_dilation = -K1 * whole ** (K1 - 1), -K2 * whole ** (K2 - 1) * steep
        part = (math.sqrt(N + 1) - 1) / N
        rock = part * np.sqrt(1 + N * x)
        d_rock = part * N / (2 * np.sqrt(1 + N * x))
        top = x * climbs * (dilation + smooth) + (1 - climbs) * rock
        d_top = (climbs + x * d_climbs) * (dilation + smooth) + x * climbs * d_dilation
        d_top += (1 - climbs) * d_rock - d_climbs * rock
        below = 1 - climbs * dilation * smooth
        d_below = -smooth * (d_climbs * dilation + climbs * d_dilation)
        return top / below, (d_top - top / below * d_below) / below
