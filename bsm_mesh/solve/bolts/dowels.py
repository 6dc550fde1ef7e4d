"""Dowel action: shear of a bolt where it crosses from one block into the next.

Every crossing is a spring across the bolt's hole in the near block, elastic up to its strength. Both ends of it are
fixed to their blocks where the bolt crosses; its force acts on both at the far end, so that it balances itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.model.bolt_layout import BoltLayout
from bsm_mesh.movements import turned


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class DowelEvaluation:
    """Shear of the crossings at a position.

    Attributes
    ----------
    across : (k, 2) float64
        Unit vector across the bolt, its direction from head to tip turned by +90 degrees.
    arm_near, arm_far : (k, 2) float64 [m]
        From the centroids of the near and the far block to the far end of the spring.
    point : (k, 2) float64 [m]
        Where that end is.
    shear : (k,) float64 [m]
        Displacement of the far block against the near one along `across`, from zero force.
    force : (k,) float64 [N]
        On the near block along `across`, on the far block against it; of one bolt.
    """

    across: FloatArray
    arm_near: FloatArray
    arm_far: FloatArray
    point: FloatArray
    shear: FloatArray
    force: FloatArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Dowels:
    """Crossings of bolts with their state after accepted steps.

    Attributes
    ----------
    element : (k,) int32
        Element that crosses the joint.
    near, far : (k,) int32
        Blocks on the head's and on the tip's side.
    arm_near, arm_far : (k, 2) float64 [m]
        From their centroids to the crossing, in the blocks' own axes.
    crossing : (k, 2) float64 [m]
        Where the crossings were when the blocks were given.
    across : (k, 2) float64
        Unit vector across the bolt, in the near block's axes.
    stiffness, strength, spacing : (k,) float64 [N/m, N, m]
        Of one bolt.
    place : (k, 4) int32
        Places of the blocks far-far, far-near, near-far, near-near among those of the bolts (`find_places`).
    rest : (k,) float64 [m]
        Coordinate along `across` at zero force.
    """

    coordinates: ClassVar[int] = 2

    element: IntArray
    near: IntArray
    far: IntArray
    arm_near: FloatArray
    arm_far: FloatArray
    crossing: FloatArray
    across: FloatArray
    stiffness: FloatArray
    strength: FloatArray
    spacing: FloatArray
    place: IntArray
    rest: FloatArray

    @classmethod
    def of(cls, layout: BoltLayout, centroid: FloatArray) -> Dowels:
        """Return the crossings of the bolts that resist shear."""
        bolt = layout.bolt_of_element
        element = np.flatnonzero(np.isfinite(layout.crossing) & (layout.dowel_stiffness[bolt] > 0)).astype(np.int32)
        bolt, first = bolt[element], layout.first_node[element]
        along = layout.point[first + 1] - layout.point[first]
        span = layout.station[first + 1] - layout.station[first]
        along = along / span[:, None]
        crossing = layout.point[first] + (layout.crossing[element] - layout.station[first])[:, None] * along
        sizes = np.diff(layout.node_start).astype(np.int64)
        n = sizes[bolt]
        begin = (np.cumsum(sizes**2) - sizes**2)[bolt]
        near, far = layout.block[first], layout.block[first + 1]
        own = first - layout.node_start[bolt]  # number of the near node within its bolt
        corner = begin + own * (n + 1)
        return cls(
            element=element,
            near=near,
            far=far,
            arm_near=crossing - centroid[near],
            arm_far=crossing - centroid[far],
            crossing=crossing,
            across=cls._across(along),
            stiffness=layout.dowel_stiffness[bolt],
            strength=layout.dowel_strength[bolt],
            spacing=layout.spacing[bolt],
            place=np.stack([corner + n + 1, corner + n, corner + 1, corner], axis=1),
            rest=cls._unsheared(len(element)),
        )

    @staticmethod
    def _across(along: FloatArray) -> FloatArray:
        """Return the unit vectors of shear across bolts of directions (k, 2)."""
        return np.stack([-along[:, 1], along[:, 0]], axis=1)

    @staticmethod
    def _unsheared(count: int) -> FloatArray:
        """Return the coordinates of so many dowels at zero force, as given."""
        return np.zeros(count)

    def at_points(self, first: int) -> Dowels:
        """Return a copy whose sides are fixed to bodies of their own, two a crossing from number `first` on."""
        near = first + 2 * np.arange(len(self.near), dtype=np.int32)
        nothing = np.zeros_like(self.arm_near)
        return replace(self, near=near, far=near + 1, arm_near=nothing, arm_far=nothing)

    def evaluate(self, position: FloatArray, alive: BoolArray) -> DowelEvaluation:
        """Return the shear at a position (n_blocks, 3); elements (n_elements,) that are not alive have none."""
        across = turned(self.across, position[self.near, 2])
        arm_far = turned(self.arm_far, position[self.far, 2])
        moved = position[self.far, :2] + (arm_far - self.arm_far)
        arm_near = self.arm_near + moved - position[self.near, :2]
        own = turned(self.arm_near, position[self.near, 2])
        shear = ((arm_near - own) * across).sum(axis=1) - self.rest
        force = np.clip(self.stiffness * shear, -self.strength, self.strength) * alive[self.element]
        point = self.crossing + moved
        return DowelEvaluation(across=across, arm_near=arm_near, arm_far=arm_far, point=point, shear=shear, force=force)

    def tangent(self, at: DowelEvaluation, alive: BoolArray) -> FloatArray:
        """Return the derivative of every crossing's force by its shear, (k,) [N/m]."""
        stiffness: FloatArray = self.stiffness * (np.abs(at.force) < self.strength) * alive[self.element]
        return stiffness

    def strained(self, at: DowelEvaluation, U: FloatArray, alive: BoolArray) -> DowelEvaluation:
        """Return the shear after further small displacements U (n_blocks, 3), nothing giving way."""
        moved = [
            np.stack([U[b, 0] - U[b, 2] * arm[:, 1], U[b, 1] + U[b, 2] * arm[:, 0]], axis=1)
            for b, arm in ((self.far, at.arm_far), (self.near, at.arm_near))
        ]
        more = ((moved[0] - moved[1]) * at.across).sum(axis=1)
        return replace(at, shear=at.shear + more, force=at.force + self.stiffness * more * alive[self.element])

    def add_forces(self, at: DowelEvaluation, total: FloatArray) -> None:
        """Add force and moment on both blocks of every crossing to `total` (n_blocks, 3) [N/m, N/m, N]."""
        force = at.across * (at.force / self.spacing)[:, None]
        for block, arm, sign in ((self.near, at.arm_near, 1.0), (self.far, at.arm_far, -1.0)):
            moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
            np.add.at(total, block, sign * np.column_stack([force, moment]))

    def add_tangent(
        self, at: DowelEvaluation, alive: BoolArray, places: IntArray, data: FloatArray, *, turning: bool
    ) -> None:
        """Add the tangent of minus the forces to the blocks of a matrix; `places` are those of the bolts."""
        stiffness = self.tangent(at, alive) / self.spacing
        force = at.force / self.spacing if turning else np.zeros_like(at.force)
        _add_tangent(places[self.place], stiffness, force, at.across, at.arm_near, at.arm_far, data)

    def commit(self, at: DowelEvaluation) -> Dowels:
        """Return the crossings after an accepted step: shear beyond the strength stays."""
        return replace(self, rest=self.rest + at.shear - at.force / self.stiffness)

    def install(self, position: FloatArray, chosen: BoolArray) -> Dowels:
        """Return a copy with zero force in the crossings of chosen elements (n_elements,) at a position."""
        at = self.evaluate(position, np.ones(len(chosen), dtype=bool))
        return replace(self, rest=np.where(chosen[self.element], self.rest + at.shear, self.rest))


@njit(allocates=True)
def _add_tangent(
    place: IntArray,
    stiffness: FloatArray,
    force: FloatArray,
    across: FloatArray,
    near: FloatArray,
    far: FloatArray,
    data: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add stiffness times the square of the first derivatives of the shear, and force times the second ones."""
    g = np.empty((2, 3))
    second = np.empty((2, 2, 3, 3))
    for k in range(stiffness.size):
        tx, ty = across[k, 0], across[k, 1]
        ax, ay, rx, ry = far[k, 0], far[k, 1], near[k, 0], near[k, 1]
        g[0, 0], g[0, 1], g[0, 2] = tx, ty, ax * ty - ay * tx
        g[1, 0], g[1, 1], g[1, 2] = -tx, -ty, -(rx * ty - ry * tx)
        second[:] = 0.0
        second[0, 0, 2, 2] = -(ax * tx + ay * ty)
        second[0, 1, 0, 2] = second[1, 0, 2, 0] = -ty
        second[0, 1, 1, 2] = second[1, 0, 2, 1] = tx
        second[0, 1, 2, 2] = second[1, 0, 2, 2] = ax * tx + ay * ty
        second[1, 1, 0, 2] = second[1, 1, 2, 0] = ty
        second[1, 1, 1, 2] = second[1, 1, 2, 1] = -tx
        second[1, 1, 2, 2] = -(rx * tx + ry * ty)
        for r in range(2):
            for s in range(2):
                p = place[k, 2 * r + s]
                if p >= 0:
                    for i in range(3):
                        for j in range(3):
                            data[p, i, j] += stiffness[k] * g[r, i] * g[s, j] + force[k] * second[r, s, i, j]
