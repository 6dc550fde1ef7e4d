"""Quiet boundaries: what lies beyond is replaced by dashpots (Lysmer and Kuhlemeyer 1969), half a block further out.

A wave passes centroids, and a dashpot belongs at the edge, half a block away. Rigid blocks of mass m with springs k
between them ask at the centroid of the last one for the force ``c (sqrt(1 - (w tau)^2) - i w tau)`` over its velocity:
``c = sqrt(k m)``, ``tau = m / 2 c``, ``w`` the circular frequency. A dashpot c on a mass M that hangs on the block by a
spring K has the same up to second order for ``M / c = tau / sqrt(2)``, ``c / K = tau (1 + 1 / sqrt(2))``.
Both ends of an edge have one across it and one along it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.movements import turned

MASS, COMPLIANCE = np.sqrt(0.5), 1 + np.sqrt(0.5)  # of an end, over c tau and tau / c


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class QuietEnds:
    """Dashpots of quiet boundaries, one row each, and the forces of supports that they stand for.

    Attributes
    ----------
    block : (k,) int32
        Block on which it acts.
    arm, direction : (k, 2) float64 [m, -]
        Where, from the centroid in the given geometry; unit vector across or along the edge.
    dashpot : (k,) float64 [N s/m2]
        Density times speed of waves times half the edge.
    delay : (k,) float64 [s]
        Time of a wave from the centroid to the edge.
    push : (k,) float64 [N s/m2 or m]
        Force over the velocity or stress of the wave that enters here; 0 where none does.
    stretch, velocity : (k,) float64 [m, m/s]
        How much farther along `direction` its mass is than the block's point; the mass's velocity half a step before.
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
    def begin(cls, model: Model, shaking: Shaking, axis: FloatArray, held: PointForces) -> QuietEnds:
        """Return the ends of a model's quiet boundaries at rest; `axis` (2,) is that of the wave."""
        blocks = model.blocks
        parts = [_of_edges(model, blocks.boundary_edges(name)) for name in shaking.quiet]
        enters = np.repeat([name == shaking.boundary for name in shaking.quiet], [len(part[0]) for part in parts])
        block, arm, direction, dashpot, delay, half = (np.concatenate(column) for column in zip(*parts, strict=True))
        over = half if shaking.quantity == "stress" else 2 * dashpot
        none = np.zeros(len(block))
        return cls(
            block=block, arm=arm, direction=direction, dashpot=dashpot, delay=delay,
            push=np.where(enters, over * (direction @ axis), 0.0), stretch=none, velocity=none, held=held,
        )  # fmt: skip

    @property
    def mass(self) -> FloatArray:
        """Masses (k,) [kg/m]."""
        mass: FloatArray = MASS * self.dashpot * self.delay
        return mass

    @property
    def spring(self) -> FloatArray:
        """Springs (k,) [N/m2]."""
        spring: FloatArray = self.dashpot / (COMPLIANCE * self.delay)
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

    @property
    def stored(self) -> float:
        """Energy in springs and masses [N]."""
        return float((self.spring * self.stretch**2 + self.mass * self.velocity**2).sum() / 2)

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


def _of_edges(model: Model, edges: IntArray) -> tuple[FloatArray, ...]:
    """Return block, arm, direction, dashpot, delay and half the edge's length of the ends of some edges."""
    blocks = model.blocks
    owner, along = blocks.owner[edges], blocks.edge_vectors[edges]
    length = np.hypot(*along.T)
    tangent = along / length[:, None]
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    corners = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
    arm = corners - blocks.moments.centroid[owner][:, None]
    density, across, shear = _waves(model)[:, blocks.rock[owner]]
    depth = (arm[:, 0] * normal).sum(axis=1)
    speed = np.stack([across, shear], axis=1)
    half = np.repeat(length / 2, 4)
    delay = np.repeat(depth[:, None] / speed, 2, axis=0).reshape(len(edges), 2, 2)
    impedance = np.repeat(density[:, None] * speed, 2, axis=0).reshape(len(edges), 2, 2)
    directions = np.broadcast_to(np.stack([normal, tangent], axis=1)[:, None], (len(edges), 2, 2, 2))
    arms = np.broadcast_to(arm[:, :, None], (len(edges), 2, 2, 2))
    return (
        np.repeat(owner, 4), arms.reshape(-1, 2), directions.reshape(-1, 2), impedance.ravel() * half, delay.ravel(), half,
    )  # fmt: skip


def _waves(model: Model) -> FloatArray:
    """Return density [kg/m3] and speeds of pressure and shear waves [m/s] of the rocks of blocks, (3, rocks)."""
    rocks = {rock.name: rock for rock in model.rocks}
    found = np.ones((3, len(model.blocks.rock_names)))
    for number, name in enumerate(model.blocks.rock_names):
        rock = rocks.get(name)
        if rock is not None and rock.young is not None and rock.poisson is not None and rock.unit_weight > 0:
            density, shear = rock.unit_weight / GRAVITY, rock.young / (2 * (1 + rock.poisson))
            pressure = shear * 2 * (1 - rock.poisson) / (1 - 2 * rock.poisson)
            found[:, number] = density, np.sqrt(pressure / density), np.sqrt(shear / density)
    return found
