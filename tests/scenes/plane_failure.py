"""Plane failure with a tension crack, and the factor of safety that limit equilibrium gives it (Hoek & Bray 1981)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import bsm_mesh as bsm


@dataclass(frozen=True, kw_only=True)
class PlaneFailure:
    """A block on a plane through the toe, a vertical crack behind it.

    Attributes
    ----------
    crest, top, crack : (float, float) [m]
        Crest of the face, top and foot of the crack; the toe is the origin.
    gamma, water : float [N/m3]
        Unit weights.
    friction, cohesion : float [degrees, Pa]
        Of the plane.
    zw : float [m]
        Depth of the water in the crack; it falls to nothing at the toe.
    horizontal : float
        Pseudo-static coefficient; positive: out of the slope.
    """

    crest: tuple[float, float]
    top: tuple[float, float]
    crack: tuple[float, float]
    gamma: float
    water: float = 9.81e3
    friction: float
    cohesion: float = 0.0
    zw: float = 0.0
    horizontal: float = 0.0

    @property
    def factor(self) -> float:
        """The factor of safety of limit equilibrium."""
        return self.factor_with_bolt(0.0, 0.0)

    def factor_with_bolt(self, pull: float, plunge: float) -> float:
        """Return the factor with a bolt that pulls the block with a force [N/m], plunging by so many degrees."""
        p, base = np.arctan2(self.crack[1], self.crack[0]), float(np.hypot(*self.crack))
        x, y = np.array([(0.0, 0.0), self.crack, self.top, self.crest]).T
        W = self.gamma * 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        V, U = self.water * self.zw**2 / 2, self.water * self.zw * base / 2
        a, t = self.horizontal, np.tan(np.radians(self.friction))
        along = np.radians(plunge) + p
        normal = W * (np.cos(p) - a * np.sin(p)) - U - V * np.sin(p) + pull * np.sin(along)
        shear = W * (np.sin(p) + a * np.cos(p)) + V * np.cos(p) - pull * np.cos(along)
        return float((self.cohesion * base + normal * t) / shear)

    def model(self, factor: float = 1.0, **law: float) -> bsm.Model:
        """Return the model, the strength of its plane divided by a factor."""
        depth, behind = 1.25 * self.crest[1], 2 * self.top[0]
        rock = [(0.0, -depth), (behind, -depth), (behind, self.top[1]), self.top, self.crack, (0.0, 0.0)]
        sliding = np.array([(0.0, 0.0), self.crack, self.top, self.crest])
        reduced = np.degrees(np.arctan(np.tan(np.radians(self.friction)) / factor))
        blocks = bsm.Blocks.from_polygons([np.array(rock), sliding], rock="rock")
        x = self.crack[0]
        in_crack = (blocks.vertices[:, 0] == x) & (blocks.vertices[blocks.following, 0] == x)
        joints = [
            bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=reduced, cohesion=self.cohesion / factor, **law)),
            bsm.Joint("crack", 1e10, 1e10, law=bsm.MohrCoulomb(friction=0.0)),
        ]
        table = [(0.0, 0.0), (x, self.crack[1] + self.zw)]
        shaken = {"gravity_horizontal": -self.horizontal} if self.horizontal else {}
        return bsm.Model(
            blocks=replace(blocks, edge_joint=np.where(in_crack, 0, -1).astype(np.int32), joint_names=("crack",)),
            rocks=[bsm.Rock("rock", unit_weight=self.gamma)],
            joints=joints,
            default_joint="J",
            supports=[bsm.Fixed(blocks=[0])],
            water=bsm.Water(table=table, unit_weight=self.water) if self.zw else None,
            **shaken,
        )


def hoek_and_bray(**given: float) -> PlaneFailure:
    """Return the worked example of Hoek & Bray (1981), chapter 7."""
    sides = {"crest": (6.928, 12.0), "top": (10.928, 12.0), "crack": (10.928, 7.652)}
    return PlaneFailure(**sides, gamma=26e3, friction=37.0, **{"cohesion": 25e3, **given})


def sau_mau_ping(**given: float) -> PlaneFailure:
    """Return the slope at Sau Mau Ping Road (Hoek, Practical Rock Engineering, chapter 8): 60 m at 50 degrees."""
    H, face, plane = 60.0, np.radians(50.0), np.radians(35.0)
    z = H * (1 - np.sqrt(np.tan(plane) / np.tan(face)))
    x = (H - z) / np.tan(plane)
    sides = {"crest": (H / np.tan(face), H), "top": (x, H), "crack": (x, H - z)}
    return PlaneFailure(**sides, gamma=26e3, water=10e3, friction=35.0, **{"cohesion": 100e3, **given})
