"""Quiet boundaries: dashpots replace the rock beyond (Lysmer and Kuhlemeyer 1969), half a block further out.

A wave passes centroids, and a dashpot belongs at the edge, half a block away. Take rigid blocks of mass m with springs
k, ``c = sqrt(k m)``, ``tau = m / 2 c``. At the centroid of the last block nothing is reflected under the force
``c (sqrt(1 - (w tau)^2) - i w tau)`` over its velocity, w the circular frequency. A dashpot c on a mass M that hangs on
the block by a spring K has this force up to second order for ``M / c = tau / sqrt(2)``,
``c / K = tau (1 + 1 / sqrt(2))``.
The middle of an edge has one for each of the two waves across it; their speeds are those of blocks on their springs.
Beyond a shear wave's edge blocks turn with those at it, so nothing holds their turns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError, numbered
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.movements import turned
from bsm_mesh.solve.motion.wave_speeds import waves_along


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class QuietEnds:
    """Dashpots of quiet boundaries, one row each, and the forces of supports that they replace.

    Attributes
    ----------
    block : (k,) int32
        Block on which it acts.
    arm, direction : (k, 2) float64 [m, -]
        Where, from the centroid in the given geometry; unit vector of the wave's movement.
    dashpot : (k,) float64 [N s/m2]
        Density times speed of waves times the edge.
    delay : (k,) float64 [s]
        Time of a wave from the centroid to the edge.
    push : (k,) float64 [N s/m2 or m]
        Force over the velocity or stress of the wave that enters here; 0 where none does.
    stretch, velocity : (k,) float64 [m, m/s]
        Lead of its mass over the block's point along `direction`; the mass's velocity half a step before.
    held : PointForces
        Forces of the supports at the begin, which stay.
    """

    block: IntArray
    arm: FloatArray
    direction: FloatArray
    dashpot: FloatArray
    delay: FloatArray
    push: FloatArray
    stretch: FloatArray
    velocity: FloatArray
    held: PointForces

    @classmethod
    def begin(
        cls, model: Model, shaking: Shaking, axis: FloatArray, stiffness: FloatArray, held: PointForces
    ) -> QuietEnds:
        """Return the ends of a model's quiet boundaries at rest.

        Parameters
        ----------
        model, shaking : Model, Shaking
            The model, and its shaking.
        axis : (2,) float64
            Unit vector of the wave that enters.
        stiffness : (rocks, 3, 3) float64 [Pa]
            Of each rock's blocks, as `stiffness_of_blocks` returns it.
        held : PointForces
            Forces of the supports.

        Raises
        ------
        ModelError
            If blocks at such a boundary have no closed contact, so that no wave leaves them. If a centroid lies beyond
            the boundary, so that no dashpot has a place.
        """
        parts = [_of_edges(model, name, stiffness) for name in shaking.quiet]
        enters = np.repeat([name == shaking.boundary for name in shaking.quiet], [len(part[0]) for part in parts])
        block, arm, direction, dashpot, delay, length = (np.concatenate(column) for column in zip(*parts, strict=True))
        over = length if shaking.quantity == "stress" else 2 * dashpot
        none = np.zeros(len(block))
        return cls(
            block=block, arm=arm, direction=direction, dashpot=dashpot, delay=delay,
            push=np.where(enters, over * (direction @ axis), 0.0), stretch=none, velocity=none, held=held,
        )  # fmt: skip

    @property
    def mass(self) -> FloatArray:
        """Masses (k,) [kg/m]."""
        mass: FloatArray = np.sqrt(0.5) * self.dashpot * self.delay
        return mass

    @property
    def spring(self) -> FloatArray:
        """Springs (k,) [N/m2]."""
        spring: FloatArray = self.dashpot / ((1 + np.sqrt(0.5)) * self.delay)
        return spring

    def along(self, position: FloatArray) -> FloatArray:
        """Return the movement of each end by that of its block at a position (n, 3), (k, 3)."""
        arm = turned(self.arm, position[self.block, 2])
        return np.column_stack([self.direction, arm[:, 0] * self.direction[:, 1] - arm[:, 1] * self.direction[:, 0]])

    def forces(self, position: FloatArray) -> FloatArray:
        """Return the forces of the ends' springs on blocks at a position, (n, 3) [N/m, N/m, N]."""
        forces = np.zeros_like(position)
        np.add.at(forces, self.block, (self.spring * self.stretch)[:, None] * self.along(position))
        return forces

    def sums(self, position: FloatArray) -> FloatArray:
        """Return what their springs add to the stiffness sums of blocks, (n, 3)."""
        sums, one = np.zeros_like(position), np.ones(len(self.block))
        axes = np.column_stack([one, one, (self.arm**2).sum(axis=1)])
        np.add.at(sums, self.block, self.spring[:, None] * axes)
        return sums

    def rates(self, given: float, time_step: float) -> FloatArray:
        """Return the power that an input puts in now, and the one that dashpots take, (2,) [N/s]."""
        velocity = self.at_half(given, time_step, 0.0).velocity
        rates: FloatArray = np.array([(self.push * velocity).sum() * given, (self.dashpot * velocity**2).sum()])
        return rates

    def stored(self, given: float, time_step: float) -> float:
        """Return the energy in springs and masses now under an input [N]: of velocities half a step to either side."""
        after = self.at_half(given, time_step, -time_step).velocity
        return float((self.spring * self.stretch**2 + self.mass * self.velocity * after).sum() / 2)

    @property
    def needed(self) -> float:
        """Least inverse square of the time step [1/s2] with which their masses are stable."""
        return float((self.spring / self.mass).max(initial=0.0))

    def at_half(self, given: float, before: float, after: float) -> QuietEnds:
        """Return them with velocities half a time step `after` before now, not half of `before`, under an input."""
        pushed = self.push * given - self.spring * self.stretch - self.dashpot * self.velocity
        return replace(self, velocity=self.velocity + pushed / self.mass * (before - after) / 2)

    def in_part(self, part: SubModel) -> QuietEnds:
        """Return those of some of the blocks."""
        number = np.cumsum(part.present, dtype=np.int32) - 1
        return self._with(part.present[self.block], part.present[self.held.block], number)

    def in_whole(self, part: SubModel) -> QuietEnds:
        """Return the same in the numbers of the whole."""
        return self._with(np.ones(len(self.block), bool), np.ones(len(self.held.block), bool), part.block)

    def _with(self, rows: BoolArray, held: BoolArray, number: IntArray) -> QuietEnds:
        names = "arm", "direction", "dashpot", "delay", "push", "stretch", "velocity"
        forces = self.held
        return replace(
            self,
            block=number[self.block[rows]],
            held=PointForces(block=number[forces.block[held]], point=forces.point[held], force=forces.force[held]),
            **{name: getattr(self, name)[rows] for name in names},
        )


def _of_edges(model: Model, name: str, stiffness: FloatArray) -> tuple[Any, ...]:
    """Return block, arm, direction, dashpot, delay and length of the ends of a boundary, two of every edge."""
    blocks = model.blocks
    edges = blocks.boundary_edges(name)
    owner, along = blocks.owner[edges], blocks.edge_vectors[edges]
    rock = blocks.rock[owner]
    if len(still := np.flatnonzero(~stiffness[rock].any(axis=(1, 2)))):
        rock_name = blocks.rock_names[rock[still[0]]]
        raise ModelError(
            f"shaking: quiet: rock '{rock_name}' at boundary '{name}' has no closed contacts, so no waves: remove "
            f"'{name}' from quiet, or support the blocks that carry stress there"
        )
    length = np.hypot(*along.T)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    arm = blocks.vertices[edges] + along / 2 - blocks.moments.centroid[owner]
    depth = (arm * normal).sum(axis=1)
    if len(behind := owner[depth <= ROUNDING * length]):
        raise ModelError(
            f"shaking: quiet: {numbered('block', behind)}: the centroid is not inside boundary '{name}', so a dashpot "
            f"has no place; divide concave blocks there, or remove '{name}' from quiet"
        )
    density = (model.weights / GRAVITY / blocks.moments.area)[owner, None]
    moduli, directions = waves_along(stiffness[rock], normal)
    speed = np.sqrt(moduli / density)
    delay = depth[:, None] / speed
    owner, length, arm = (np.repeat(each, 2, axis=0) for each in (owner, length, arm))
    return owner, arm, directions.reshape(-1, 2), (density * speed).ravel() * length, delay.ravel(), length
