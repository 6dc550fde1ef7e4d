"""Pressure of soil or backfill on a boundary: active, at rest, passive, by Rankine's or Coulomb's theory."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal, get_args

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError, counted, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.quantities import (
    COHESION,
    COORDINATE,
    EARTH_FACTOR,
    FRICTION,
    OVERCONSOLIDATION,
    PRESSURE,
    UNIT_WEIGHT,
)
from bsm_mesh.model.values import Points, Rules, line, parts_of, plain_numbers

EarthState = Literal["active", "at_rest", "passive"]
EarthTheory = Literal["rankine", "coulomb"]
GAUSS = np.array([-1.0, 1.0]) / math.sqrt(3.0)  # two points, exact for cubic polynomials


@dataclass(frozen=True, slots=True, kw_only=True)
class EarthPressure:
    """Pressure of soil or backfill on a boundary, such as the back of a retaining wall.

    The depth of a point is its vertical distance below `surface`; above the surface nothing acts. Each face of the
    boundary has the coefficient of its own inclination. Water in the soil is a load of its own.

    Attributes
    ----------
    boundary : str
        Name of the boundary.
    state : {"active", "at_rest", "passive"}
        Movement of the boundary: away from the soil, none, or towards the soil.
    unit_weight : float [N/m^3]
        Unit weight of the soil; below water the buoyant one.
    friction : float [degrees]
        Friction angle of the soil.
    surface : float or pair of (x, y) [m]
        Level of the ground, or two points of its straight line; the line continues at its slope beyond them.
    theory : {"rankine", "coulomb"}
        Stress of a half-space at its limit, or equilibrium of a wedge that slides on the wall. At rest the theory
        has no effect.
    wall_friction : float [degrees]
        Friction angle between soil and wall, for Coulomb's theory.
    cohesion : float [Pa]
        Cohesion of the soil, for Rankine's theory with level ground. The active pressure is nowhere negative.
    surcharge : float [Pa]
        Vertical load per area of the surface.
    overconsolidation : float
        Overconsolidation ratio, for the state at rest: K0 = (1 - sin friction) sqrt(ratio).
    factor : float
        Multiplies the pressure, as a partial factor does.

    Raises
    ------
    ModelError
        With every fault found.

    References
    ----------
    Rankine: Mazindrani and Ganjali (1997), J. Geotech. Geoenviron. Eng. 123(2). Coulomb: NAVFAC DM-7.02 (1986),
    chapter 3. At rest: EN 1997-1:2004, 9.5.2.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> soil = bsm.EarthPressure(boundary="back", state="active", unit_weight=18e3, friction=30, surface=4.0)
    >>> round(soil.coefficient(), 4)
    0.3333
    """

    boundary: str
    state: EarthState
    unit_weight: Annotated[float, UNIT_WEIGHT]
    friction: Annotated[float, FRICTION]
    surface: Given[float | Points, float | Sequence[Sequence[float]]] = by_default(field())
    theory: EarthTheory = "rankine"
    wall_friction: Annotated[float, FRICTION] = 0.0
    cohesion: Annotated[float, COHESION] = 0.0
    surcharge: Annotated[float, PRESSURE] = 0.0
    overconsolidation: Annotated[float, OVERCONSOLIDATION] = 1.0
    factor: Annotated[float, EARTH_FACTOR] = 1.0

    def __post_init__(self) -> None:
        rules = Rules("load")
        rules.text("boundary", self.boundary)
        raise_faults(rules.faults)
        rules = Rules("earth pressure on", self.boundary)
        rules.choice("state", self.state, get_args(EarthState))
        rules.choice("theory", self.theory, get_args(EarthTheory))
        rules.numbers(self)
        if parts_of(self.surface) is None:
            rules.number("surface", self.surface, COORDINATE)
        else:
            object.__setattr__(self, "surface", line(self.surface, "surface", rules))
        raise_faults(rules.faults)
        raise_faults([f"{self._place}: {text}" for text in self._misfits()])
        plain_numbers(self)

    @property
    def _place(self) -> str:
        return f"earth pressure on '{self.boundary}'"

    def _misfits(self) -> list[str]:
        """Return what does not fit together, a sentence each."""
        found = []
        by_coulomb = self.theory == "coulomb" and self.state != "at_rest"
        if isinstance(self.surface, tuple) and len(self.surface) != 2:
            found.append(f"surface has {counted(len(self.surface), 'point')}; give a level, or two points of a line")
        if self.wall_friction and not by_coulomb:
            found.append('wall_friction has no effect here; give theory = "coulomb" and state active or passive')
        if self.wall_friction > self.friction:
            found.append(f"wall_friction = {self.wall_friction:g} is above friction = {self.friction:g} degrees")
        if self.cohesion and (by_coulomb or self.state == "at_rest"):
            found.append('cohesion has no effect here; give theory = "rankine" and state active or passive')
        if self.cohesion and self.slope:
            found.append("cohesion needs level ground; give surface as one number")
        if self.overconsolidation != 1 and self.state != "at_rest":
            found.append(f"overconsolidation belongs to the state at_rest, not {self.state}")
        if self.state != "at_rest" and abs(self.slope) > math.radians(self.friction) * (1 + 1e-12):
            found.append(
                f"the surface slopes by {abs(math.degrees(self.slope)):g} degrees, more than friction = "
                f"{self.friction:g}: such a slope is unstable; give a flatter surface"
            )
        return found

    @property
    def slope(self) -> float:
        """Inclination of the surface [radians], positive where it rises to the right."""
        if not isinstance(self.surface, tuple) or len(self.surface) != 2:
            return 0.0
        (x1, y1), (x2, y2) = self.surface
        return math.atan2(y2 - y1, x2 - x1)

    def coefficient(self, batter: float = 0.0, slope: float | None = None) -> float:
        """Return the coefficient of earth pressure K, without `factor`.

        Parameters
        ----------
        batter : float [degrees]
            Inclination of the wall from the vertical, positive where soil lies above the wall; Coulomb's theory alone
            depends on it.
        slope : float, optional [degrees]
            Inclination of the ground, positive where it rises from the wall; by default the surface's, for a wall with
            the soil on its right.

        Returns
        -------
        float
            Coulomb: the resultant on a wall of height H is K unit_weight H^2 / 2 at `wall_friction` to its normal.
            Else: the stress on a vertical plane is K unit_weight depth, parallel to the ground.
        """
        beta = self.slope if slope is None else math.radians(slope)
        if self.theory == "coulomb" and self.state != "at_rest":
            return float(self._coulomb(np.array([math.radians(batter)]), beta)[0])
        return self._on_vertical(beta)

    def _on_vertical(self, beta: float) -> float:
        """Return the stress on a vertical plane over the vertical stress of the soil's weight (Rankine, or at rest)."""
        phi = math.radians(self.friction)
        if self.state == "at_rest":
            return (1 - math.sin(phi)) * math.sqrt(self.overconsolidation) * (1 + math.sin(beta))
        root = math.sqrt(max(math.cos(beta) ** 2 - math.cos(phi) ** 2, 0.0))
        sign = 1.0 if self.state == "active" else -1.0
        return math.cos(beta) * (math.cos(beta) - sign * root) / (math.cos(beta) + sign * root)

    def _coulomb(self, theta: FloatArray, beta: float) -> FloatArray:
        """Return Coulomb's coefficient of walls at inclinations theta to the vertical [radians].

        Raises
        ------
        ModelError
            Where no wedge can slide on such a wall.
        """
        phi, delta = math.radians(self.friction), math.radians(self.wall_friction)
        sign = 1.0 if self.state == "active" else -1.0  # of angles that friction turns the other way
        across, above = np.cos(theta + sign * delta), np.cos(theta - beta)
        own = np.cos(phi - sign * theta)
        inside = math.sin(phi + delta) * max(math.sin(phi - sign * beta), 0.0)
        possible: BoolArray = (across > 0) & (above > 0) & (np.abs(phi - sign * theta) < math.pi / 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            bracket = 1 + sign * np.sqrt(inside / (across * above))
            possible &= bracket > 0
            found: FloatArray = own**2 / (np.cos(theta) ** 2 * across * bracket**2)
        if not possible.all():
            worst = math.degrees(theta[~possible][0])
            raise ModelError(
                f"{self._place}: Coulomb's theory has no {self.state} wedge on a face that is inclined by {worst:.6g} "
                f'degrees, with a surface at {math.degrees(beta):.6g} degrees; give theory = "rankine"'
            )
        return found

    def tractions(self, ends: FloatArray) -> FloatArray:
        """Return tractions that vary linearly along each edge, (k, 2 ends, 2) [Pa].

        Force and moment of every edge are exact, also where the pressure begins within an edge.

        Parameters
        ----------
        ends : (k, 2, 2) float64 [m]
            Ends of the loaded edges; blocks lie on their left.

        Raises
        ------
        ModelError
            If the surface lies below the whole boundary, or a face has no pressure by the theory.
        """
        depth = self._depth(ends)
        if not (depth > 0).any():
            raise ModelError(f"{self._place}: surface lies below the whole boundary; nothing acts on it")
        along = ends[:, 1] - ends[:, 0]
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        place, weight = _integration_points(self._kinks(depth))
        side = float(np.sign(along[:, 1].sum())) or 1.0  # the soil's: right is positive
        stress = self._stress(depth[:, :1] + place * (depth[:, 1:] - depth[:, :1]), self.slope * side)
        direction = self._directions(outward)
        traction = np.einsum("kqc,kcx->kqx", stress, direction)
        mean = np.einsum("kq,kqx->kx", weight, traction)
        moment = np.einsum("kq,kq,kqx->kx", weight, place, traction)
        return self.factor * np.stack([4 * mean - 6 * moment, 6 * moment - 2 * mean], axis=1)

    def _depth(self, points: FloatArray) -> FloatArray:
        """Return the vertical depth of points below the surface [m]."""
        if isinstance(self.surface, tuple):
            (x, y), _ = self.surface
            level: FloatArray = y + (points[..., 0] - x) * math.tan(self.slope) - points[..., 1]
            return level
        depth: FloatArray = self.surface - points[..., 1]
        return depth

    def _kinks(self, depth: FloatArray) -> FloatArray:
        """Return where along each edge the pressure may begin, (k, 2) in parts of its length."""
        grown = np.where(depth[:, 1] == depth[:, 0], 1.0, depth[:, 1] - depth[:, 0])
        parts = (np.array([0.0, self._depth_of_tension()]) - depth[:, :1]) / grown[:, None]
        return np.clip(parts, 0.0, 1.0)

    def _depth_of_tension(self) -> float:
        """Return the depth to which a cohesive soil at its active limit would pull at a wall [m]."""
        if not self.cohesion or self.state != "active" or not self.unit_weight:
            return 0.0
        reach = 2 * self.cohesion / math.sqrt(self._on_vertical(0.0))
        return max(reach - self.surcharge, 0.0) / self.unit_weight

    def _stress(self, depth: FloatArray, beta: float) -> FloatArray:
        """Return vertical stress and stress on the vertical plane at depths, (..., 2) [Pa]; zero above the surface."""
        vertical = self.unit_weight * depth + self.surcharge / math.cos(self.slope)
        if self.theory == "coulomb" and self.state != "at_rest":
            lateral = vertical  # Coulomb's coefficient is a face's
        else:
            K = self._on_vertical(beta)
            held = 2 * self.cohesion * math.sqrt(K) * (1 if self.state == "active" else -1)
            lateral = np.maximum(K * vertical - held, 0.0)
        stress: FloatArray = np.where(depth[..., None] > 0, np.stack([vertical, lateral], axis=-1), 0.0)
        return stress

    def _directions(self, outward: FloatArray) -> FloatArray:
        """Return the traction on every face per vertical stress, and per stress on the vertical plane, (k, 2, 2)."""
        zero = np.zeros(len(outward))
        if self.theory == "coulomb" and self.state != "at_rest":
            return np.stack([np.zeros_like(outward), self._on_face(outward)], axis=1)
        b = self.slope
        per_vertical = np.stack([zero, -outward[:, 1]], axis=1)
        lateral = np.array([[math.cos(b), math.sin(b)], [math.sin(b), math.sin(b) * math.tan(b)]])
        return np.stack([per_vertical, -outward @ lateral], axis=1)

    def _on_face(self, outward: FloatArray) -> FloatArray:
        """Return Coulomb's traction on every face per vertical stress of the soil next to it, (k, 2)."""
        sides = np.sign(outward[:, 0])
        if (np.abs(outward[:, 0]) < 1e-9).any() or (sides != sides[0]).any():
            raise ModelError(
                f"{self._place}: faces of the boundary are level or look both ways; Coulomb's theory needs a wall with "
                'the soil on one side: give a load for each side, or theory = "rankine"'
            )
        theta, beta = np.arcsin(outward[:, 1]), self.slope * sides[0]
        # K unit_weight z per height at the depth z below the face's plane at the surface; per length of the face, and
        # with the vertical depth below the surface, it has these cosines.
        size = self._coulomb(theta, beta) * math.cos(beta) * np.cos(theta) ** 2 / np.cos(theta - beta)
        delta = math.radians(self.wall_friction) * (1 if self.state == "active" else -1)
        down = np.stack([outward[:, 1], -outward[:, 0]], axis=1) * sides[:, None]  # along the face
        traction: FloatArray = size[:, None] * (down * math.sin(delta) - outward * math.cos(delta))
        return traction


def _integration_points(kinks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places along edges and their weights, (k, points) in parts of the length: two points a piece."""
    cuts = np.concatenate([np.zeros((len(kinks), 1)), np.sort(kinks, axis=1), np.ones((len(kinks), 1))], axis=1)
    middle, half = (cuts[:, 1:] + cuts[:, :-1]) / 2, (cuts[:, 1:] - cuts[:, :-1]) / 2
    place = middle[:, :, None] + half[:, :, None] * GAUSS
    return place.reshape(len(kinks), -1), np.repeat(half, 2, axis=1)
