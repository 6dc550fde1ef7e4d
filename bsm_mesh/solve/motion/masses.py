"""Masses of explicit motion: real ones, or as small as stability allows; dashpots that leave them stable."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.algebra.constraints import Constraints
from bsm_mesh.solve.motion.contact_columns import SingleArray, stiffness_sums
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.solve.step.system import System

# Contacts: both blocks (k,), columns (k,) by the names of `CONTACT` and `CLOSURE`.
Weighed = tuple[IntArray, IntArray, Mapping[str, SingleArray]]

WEIGHED = "bx", "by", "ax", "ay", "normal_stiffness", "rock_share", "shear_stiffness"


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionSettings:
    """How blocks are moved.

    Attributes
    ----------
    damps_impacts : bool
        Whether impacts are damped critically: rock hardly rebounds.
    real_masses : bool
        Weights over gravity, in a time in which nine of ten blocks are stable; else the least that are.
    damping : float
        Part of a force that acts against the velocity (local damping, Cundall 1987).
    window : float
        Movement that ends a window, over the step length: forces within are changes from its reference, exact in the
        turns, and strengths are tangents there.
    cycles : int
        Cycles in a window at most: so often the residual is looked at where nothing moves far. With 2000 one verdict
        of 166 changed, at 0.9 of the time.
    min_cycles : int
        In which a block falls freely by a step length, or crosses it with the velocity it has: a cycle moves it
        by a hundredth of that.
    min_dashpot : float [cycles]
        Least dashpot of a contact, over its normal stiffness, that masses leave room for.
    light : float
        Blocks lighter than this part of the mean do not count for the time: with a splinter a fall would take
        many cycles.
    stiff : float
        The quantile of the others that does: the stiffest tenth becomes heavier than it is.
    heavier_bolts : float
        Times the stiffness of bolts: for the part of a chain and its turning in the highest frequency.
    """

    damps_impacts: bool
    real_masses: bool
    damping: float = 0.5
    window: float = 0.125
    cycles: int = 500
    min_cycles: int = 200
    min_dashpot: float = 1.0
    light: float = 0.1
    stiff: float = 0.9
    heavier_bolts: float = 1.2

    @property
    def heavier(self) -> float:
        """Masses over stiffness sums with which no wave grows."""
        return 1 + self.damping + 2 * self.min_dashpot * self.damps_impacts


class Masses:
    """Masses over the square of a cycle, with which no wave grows.

    Parameters
    ----------
    step : StepEquations
        The equations.
    settings : MotionSettings
        How blocks are moved.
    sums : (n, axes) float64
        Of the springs at every block, as `update` takes them.
    velocity : (n, axes) float64 [sqrt(m), rad / sqrt(m)]
        Where it begins.

    Attributes
    ----------
    mass : (n, axes) float64 [N/m2, N]
        The masses.
    inverse_rate : float [1/m]
        Masses over weights: the square of the cycles in which a block falls freely by half a metre.
    """

    def __init__(self, step: StepEquations, settings: MotionSettings, sums: FloatArray, velocity: FloatArray) -> None:
        self._system, self._settings = step.system, settings
        least = settings.heavier * sums
        self.inverse_rate = self._time_scale(step, least, velocity)
        # Masses of blocks that touch nothing, and may not weigh anything.
        typical = least.min(axis=0, where=least > 0, initial=np.inf)
        self._floor = np.where(least > 0, least, np.where(np.isfinite(typical), typical, 1.0))
        self.update(sums)

    def update(self, sums: FloatArray) -> None:
        """Set the masses for the stiffness sums (n, axes) that there are: along each axis, moments by rotations."""
        self._sums, settings = sums, self._settings
        least = settings.heavier * sums
        real = self.inverse_rate * self._system.mass if settings.real_masses else self._floor
        self.mass = np.maximum(np.where(real > 0, real, self._floor), least)

    def dashpots(self, a: IntArray, b: IntArray, normal_stiffness: SingleArray | FloatArray) -> SingleArray:
        """Return the dashpots of contacts (k,): the critical ones, or the most with which no wave grows; or none."""
        settings = self._settings
        if not settings.damps_impacts:
            return np.zeros(len(a), np.float32)
        with np.errstate(divide="ignore"):
            slack = ((self.mass / self._sums).min(axis=1) - 1 - settings.damping) / 2
            inverse = 1 / self.mass[:, 0]
        slack[self._system.prescribed_blocks], inverse[self._system.prescribed_blocks] = np.inf, 0.0
        stiffness = normal_stiffness.astype(float)
        critical = 2 * np.sqrt(stiffness / (inverse[a] + inverse[b]))
        stable = stiffness * np.minimum(slack[a], slack[b])
        dashpots: SingleArray = np.minimum(critical, stable).astype(np.float32)
        return dashpots

    def _time_scale(self, step: StepEquations, least: FloatArray, velocity: FloatArray) -> float:
        """Return masses over weights [1/m]: nine of ten blocks are stable, and none crosses a step length in a jump."""
        system, settings, d = self._system, self._settings, self._system.d
        rate = (1 + step.movement(velocity) ** 2 / d) * settings.min_cycles**2 / d
        heavy = ~system.prescribed_blocks & (least[:, 0] > 0) & (system.mass[:, 0] > 0)  # there may be no weight at all
        if heavy.any():
            heavy &= system.mass[:, 0] >= settings.light * system.mass[heavy, 0].mean()
            rate = max(rate, float(np.quantile((least / system.mass)[heavy].max(axis=1), settings.stiff)))
        return rate


def spring_sums(system: System, weighed: Weighed, heavier: float) -> FloatArray:
    """Return the stiffness sums (n, 3) of contacts, as `stiffness_sums`, and of bolts, as `bolt_sums`."""
    a, b, columns = weighed
    sums: FloatArray = stiffness_sums(a, b, *(columns[name] for name in WEIGHED), len(system.mass))
    sums += bolt_sums(system, heavier)
    return sums


def bolt_sums(system: System, heavier: float) -> FloatArray:
    """Return what bolts and dowels add to the stiffness sums of blocks, (n, axes), their stiffness times `heavier`."""
    bolts, sums = system.bolts, np.zeros_like(system.mass)
    if not len(bolts.alive):
        return sums
    layout, dowels = bolts.layout, bolts.dowels
    first = layout.first_node
    axial = heavier * bolts.stiffness * bolts.alive / layout.spacing[layout.bolt_of_element]
    parts = [(layout.block[node], axial, bolts.arm[node]) for node in (first, first + 1)]
    sheared = heavier * dowels.stiffness * bolts.alive[dowels.element] / dowels.spacing
    parts += [(dowels.near, sheared, dowels.arm_near), (dowels.far, sheared, dowels.arm_far)]
    for block, stiffness, arm in parts:
        moves = arm.shape[1]
        sums[:, :moves] += np.bincount(block, stiffness, len(sums))[:, None]
        sums[:, moves:] += np.bincount(block, stiffness * (arm**2).sum(axis=1), len(sums))[:, None]
    return sums


def projectors(supports: Constraints, mass: FloatArray) -> FloatArray:
    """Return the projectors (k, axes, axes) of supported blocks onto their free axes, orthogonal over masses."""
    projector, axes = np.zeros_like(supports.basis), mass.shape[1]
    moves = np.flatnonzero(supports.constrained < axes)  # of the others it is zero
    if not len(moves):
        return projector
    own, held = mass[supports.block[moves]], np.arange(axes) < supports.constrained[moves, None]
    free = np.where(held, 0.0, 1.0)[:, None, :] * supports.basis[moves]
    inverse = np.linalg.pinv(np.einsum("kri,kr,krj->kij", free, own, free), hermitian=True)
    projector[moves] = np.einsum("kri,kij,ksj,ks->krs", free, inverse, free, own)
    return projector
