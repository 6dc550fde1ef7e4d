"""The strength of a rock mass after Hoek and Brown."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

from bsm_mesh.errors import raise_faults
from bsm_mesh.model.quantities import (
    DISTURBANCE,
    GSI,
    HOEK_BROWN_A,
    HOEK_BROWN_MB,
    HOEK_BROWN_MI,
    HOEK_BROWN_S,
    REDUCTION,
    TENSILE_STRENGTH,
    WALL_STRENGTH,
)
from bsm_mesh.model.values import Rules, plain_numbers

BY_INDEX, BY_CONSTANTS = ("gsi", "mi"), ("mb", "s", "a")


@dataclass(frozen=True, slots=True, kw_only=True)
class HoekBrown:
    """The strength ``s1 = s3 + sigma_ci (mb s3 / sigma_ci + s)^a`` of a rock mass, compression positive.

    Give `gsi` and `mi` (and `disturbance`), or `mb`, `s` and `a`.

    Attributes
    ----------
    sigma_ci : float [Pa]
        Uniaxial compressive strength of the intact rock.
    gsi : float or None
        Geological Strength Index.
    mi : float or None
        Constant of the intact rock.
    disturbance : float
        Disturbance factor D: 0 undisturbed, 1 heavily disturbed by blasting and relaxation.
    mb, s, a : float or None
        Constants of the rock mass; None: by `gsi`, `mi` and `disturbance`.
    tensile_strength : float or None [Pa]
        Tension cut-off; None: the tip of the curve, s sigma_ci / mb.
    reduction : float
        Shear strength is that of the curve over it, at every normal stress.

    References
    ----------
    Hoek, Carranza-Torres & Corkum (2002), Hoek-Brown failure criterion - 2002 edition, Proc. NARMS-TAC, Toronto,
    267-273: Eqs. 2-5.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> mass = bsm.HoekBrown(sigma_ci=30e6, gsi=50, mi=10)
    >>> [round(value, 4) for value in mass.constants]
    [1.6768, 0.0039, 0.5057]
    >>> round(mass.tension / 1e3, 1)  # kPa
    69.2
    """

    sigma_ci: Annotated[float, WALL_STRENGTH]
    gsi: Annotated[float, GSI] | None = None
    mi: Annotated[float, HOEK_BROWN_MI] | None = None
    disturbance: Annotated[float, DISTURBANCE] = 0.0
    mb: Annotated[float, HOEK_BROWN_MB] | None = None
    s: Annotated[float, HOEK_BROWN_S] | None = None
    a: Annotated[float, HOEK_BROWN_A] | None = None
    tensile_strength: Annotated[float, TENSILE_STRENGTH] | None = None
    reduction: Annotated[float, REDUCTION] = 1.0

    def __post_init__(self) -> None:
        rules = Rules("hoek_brown")
        rules.numbers(self)
        raise_faults(rules.faults)
        given = {name for name in (*BY_INDEX, *BY_CONSTANTS) if getattr(self, name) is not None}
        if given not in (set(BY_INDEX), set(BY_CONSTANTS)):
            said = ", ".join(name for name in (*BY_INDEX, *BY_CONSTANTS) if name in given) or "none of them"
            rules.faults.append(f"hoek_brown: give gsi and mi, or mb, s and a; given: {said}")
        if self.disturbance and "mb" in given:
            rules.faults.append("hoek_brown: disturbance is of gsi and mi; mb, s and a hold it already, leave it out")
        raise_faults(rules.faults)
        plain_numbers(self)

    @property
    def constants(self) -> tuple[float, float, float]:
        """The constants mb, s and a of the rock mass."""
        if self.gsi is None or self.mi is None:
            assert self.mb is not None
            assert self.s is not None
            assert self.a is not None
            return self.mb, self.s, self.a
        less = self.gsi - 100
        mb = self.mi * math.exp(less / (28 - 14 * self.disturbance))
        a = 0.5 + (math.exp(-self.gsi / 15) - math.exp(-20 / 3)) / 6
        return mb, math.exp(less / (9 - 3 * self.disturbance)), a

    @property
    def tension(self) -> float:
        """Tensile strength [Pa]: the cut-off, or that of the curve's tip where it is less."""
        mb, s, _ = self.constants
        tip = s * self.sigma_ci / mb
        return tip if self.tensile_strength is None else min(self.tensile_strength, tip)

    def reduced(self, factor: float) -> HoekBrown:
        """Return the strength over a factor; a tension cut-off is divided too."""
        tension = None if self.tensile_strength is None else self.tensile_strength / factor
        return replace(self, tensile_strength=tension, reduction=self.reduction * factor)
