"""Strength of contact points as cones: shear bounded by straight lines of the pressure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.joint_laws.law import StraightLaw
from bsm_mesh.model.strength import law_name
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.limit.points import LimitPoints


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ConeStrength:
    """What contact points bear: ``|shear| <= slope * pressure + intercept`` for every line, ``pressure >= -tension``.

    Attributes
    ----------
    slope : (m, k) float64
        Of the lines.
    intercept : (m, k) float64 [N]
        Of the lines; infinite for no bound.
    tension : (m,) float64 [N]
        Greatest tension; infinite for no bound.
    bolts : float
        Part of the bolts' strength that they have.
    """

    slope: FloatArray
    intercept: FloatArray
    tension: FloatArray
    bolts: float = 1.0

    @classmethod
    def coulomb(cls, area: FloatArray, friction: float, cohesion: float = 0.0) -> ConeStrength:
        """Return Coulomb's strength: friction [degrees], cohesion [Pa], of points that stand for areas (m,) [m2]."""
        slope = np.full((len(area), 1), np.tan(np.radians(friction)))
        return cls(slope=slope, intercept=cohesion * area[:, None], tension=np.zeros(len(area)))

    def divided(self, factor: float, chosen: BoolArray | None = None, *, bolts: bool = False) -> ConeStrength:
        """Return the strength with that of all points, or of chosen ones (m,), divided by a factor, and of bolts."""
        by = np.full(len(self.tension), factor) if chosen is None else np.where(chosen, factor, 1.0)
        return replace(
            self,
            slope=self.slope / by[:, None],
            intercept=self.intercept / by[:, None],
            tension=self.tension / by,
            bolts=self.bolts / factor if bolts else self.bolts,
        )


def cone_strength(materials: Materials, blocks: Polyhedra, points: LimitPoints) -> ConeStrength:
    """Return the strength of contact points.

    Where a contact has tensile strength the lines are shifted by it: a little more than it bears.

    Raises
    ------
    ModelError
        For a law that has no straight lines.
    """
    laws, number, pulls = materials.laws(blocks, np.stack([points.block_a, points.block_b]), points.joint)
    slope, intercept = np.zeros((points.count, 1)), np.full((points.count, 1), np.inf)
    tension = pulls * points.area
    for k, law in enumerate(laws):
        rows = np.flatnonzero((number == k) & np.isfinite(tension))
        if law is None or not rows.size:
            continue
        if not isinstance(law, StraightLaw):
            raise ModelError(f"limit analysis needs strength as straight lines, and the law {law_name(law)} has none")
        a, b = (np.asarray(values, dtype=np.float64) for values in law.strength_lines(points.area[rows]))
        if a.shape[1] > slope.shape[1]:
            more = ((0, 0), (0, a.shape[1] - slope.shape[1]))
            slope, intercept = np.pad(slope, more), np.pad(intercept, more, constant_values=np.inf)
        slope[rows, : a.shape[1]] = a
        intercept[rows, : a.shape[1]] = b + a * tension[rows, None]
    return ConeStrength(slope=slope, intercept=intercept, tension=tension)
