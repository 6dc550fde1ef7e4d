"""The result of flow in the joints: heads, apertures, discharges, and where water enters and leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray, Portable, show_only

BARED = "new faces"  # surfaces that stages have laid bare


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class FlowResult(Portable):
    """Steady flow at the end of a stage, per metre of thickness.

    Attributes
    ----------
    point : (n, 2) float64 [m]
        The nodes, as the blocks were given.
    head : (n,) float64 [m]
        Height plus pressure head; of a node without pressure its height.
    filled : (n,) float64
        1 under water, 0 dry; between them where water trickles without pressure.
    outflow : (n,) float64 [m2/s]
        What leaves the network; negative where it enters.
    place : (n,) int32
        Where it may do so: number in `places`; -1: nowhere.
    places : tuple of str
        Boundaries, drains, wells, and `BARED`.
    first, last : (m,) int32
        Nodes at both ends of the joint pieces that are there.
    joint : (m,) int32
        Number of each piece's joint in ``Results.joint_names``.
    aperture : (m, 2) float64 [m]
        Hydraulic aperture at both ends.
    discharge : (m,) float64 [m2/s]
        From the first to the last node.
    wet : (m, 2) float64
        The part of each piece, over its length, in which there is pressure.
    wet_pressure : (m, 2) float64 [Pa]
        At both ends of that, linear between.
    shore : (s, 2, 2) float64 [m]
        Both ends of the parts of boundaries under water.
    shore_pressure : (s, 2) float64 [Pa]
        At both ends of these.
    imbalance : float
        Greatest imbalance of a node over the greatest discharge.
    rounds : int
        How often flow and blocks were solved alternately.
    change : float
        Change of pressure in the last turn over the greatest pressure; 0 where apertures are as given.
    """

    point: FloatArray
    head: FloatArray
    filled: FloatArray
    outflow: FloatArray
    place: IntArray
    places: tuple[str, ...]
    first: IntArray
    last: IntArray
    joint: IntArray
    aperture: FloatArray
    discharge: FloatArray
    wet: FloatArray
    wet_pressure: FloatArray
    shore: FloatArray
    shore_pressure: FloatArray
    imbalance: float
    rounds: int
    change: float

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def through(self) -> float:
        """Flow through the network [m2/s]: all that leaves it."""
        return float(np.maximum(self.outflow, 0.0).sum())

    @property
    def leaving(self) -> FloatArray:
        """Outflow of the network at every place, (p,) [m2/s]; negative where more enters."""
        at = self.place >= 0
        total = np.bincount(self.place[at], self.outflow[at], minlength=len(self.places))
        return total.astype(np.float64)

    @property
    def lines(self) -> FloatArray:
        """Both ends of every piece, (m, 2, 2) [m]."""
        return np.stack([self.point[self.first], self.point[self.last]], axis=1)

    @property
    def under_pressure(self) -> tuple[FloatArray, FloatArray]:
        """Both ends of what joints and boundaries have under pressure, (q, 2, 2) [m], and that, (q, 2) [Pa]."""
        wet = (self.wet_pressure > 0).any(axis=1)
        lines = self.lines[wet]
        parts = lines[:, :1] + self.wet[wet][:, :, None] * np.diff(lines, axis=1)
        return np.concatenate([parts, self.shore]), np.concatenate([self.wet_pressure[wet], self.shore_pressure])

    @property
    def mean_pressure(self) -> FloatArray:
        """Mean pressure of every piece over its length, (m,) [Pa]."""
        share = np.diff(self.wet, axis=1)[:, 0]
        mean: FloatArray = share * self.wet_pressure.mean(axis=1)
        return mean
