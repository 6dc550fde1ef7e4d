"""Dowel action in space: shear of a bolt where it crosses from one block into the next, in any direction across it.

The law is that of the plane, by the magnitude of shear: elastic up to the strength, which acts along the shear.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.movements import cross, lengths, turned
from bsm_mesh.solve.bolts.dowels import DowelEvaluation, Dowels


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SpaceDowelEvaluation(DowelEvaluation):
    """Shear of the crossings at a position: `across` is the unit vector of the shear, `shear` and `force` its sizes.

    Attributes
    ----------
    axis : (k, 3) float64
        Unit vector along the bolt, as the near block has turned it.
    in_near : (k, 3) float64
        Unit vector of the shear in the near block's axes.
    """

    axis: FloatArray
    in_near: FloatArray


class SpaceDowels(Dowels):
    """Crossings of bolts in polyhedra.

    Other than in the plane, `across` (k, 3) is the unit vector along the bolt and `rest` (k, 3) [m] the shear at zero
    force, both in the near block's axes.
    """

    __slots__ = ()
    coordinates: ClassVar[int] = 3

    @staticmethod
    def _across(along: FloatArray) -> FloatArray:
        return along

    @staticmethod
    def _unsheared(count: int) -> FloatArray:
        return np.zeros((count, 3))

    def evaluate(self, position: FloatArray, alive: BoolArray) -> SpaceDowelEvaluation:
        """Return the shear at a position (n_blocks, 6); elements (n_elements,) that are not alive have none."""
        near, far = position[self.near], position[self.far]
        arm_far = turned(self.arm_far, far[:, 3:])
        moved = far[:, :3] + (arm_far - self.arm_far)
        arm_near = self.arm_near + moved - near[:, :3]
        offset = turned(arm_near - turned(self.arm_near, near[:, 3:]), -near[:, 3:])  # in the near block's axes
        sheared = offset - (offset * self.across).sum(axis=1)[:, None] * self.across - self.rest
        shear = lengths(sheared)
        along = np.divide(sheared, shear[:, None], out=np.zeros_like(sheared), where=(shear > 0)[:, None])
        return SpaceDowelEvaluation(
            across=turned(along, near[:, 3:]),
            axis=turned(self.across, near[:, 3:]),
            in_near=along,
            arm_near=arm_near,
            arm_far=arm_far,
            point=self.crossing + moved,
            shear=shear,
            force=np.minimum(self.stiffness * shear, self.strength) * alive[self.element],
        )

    def add_forces(self, at: DowelEvaluation, total: FloatArray) -> None:
        """Add force and moment on both blocks of every crossing to `total` (n_blocks, 6) [N, N m]."""
        force = at.across * (at.force / self.spacing)[:, None]
        for block, arm, sign in ((self.near, at.arm_near, 1.0), (self.far, at.arm_far, -1.0)):
            np.add.at(total, block, sign * np.hstack([force, cross(arm, force)]))

    def add_tangent(
        self, at: DowelEvaluation, alive: BoolArray, places: IntArray, data: FloatArray, *, turning: bool
    ) -> None:
        """Add the tangent of minus the forces to the blocks of a matrix; `places` are those of the bolts.

        The shear changes by ``u + w x arm`` of the far block less the same of the near one, across the bolt. At its
        strength the force keeps its size and follows the direction of shear.
        """
        assert isinstance(at, SpaceDowelEvaluation)
        if not len(at.force):
            return
        axes, along = (vector[:, :, None] * vector[:, None, :] for vector in (at.axis, at.across))
        flows, acts = at.force >= self.strength, alive[self.element] / self.spacing
        secant = acts * np.divide(at.force, at.shear, out=self.stiffness.copy(), where=flows)
        stiff = secant[:, None, None] * (np.eye(3) - axes) - np.where(flows, secant, 0.0)[:, None, None] * along
        moves = [_movement(arm, sign) for arm, sign in ((at.arm_far, 1.0), (at.arm_near, -1.0))]
        force = at.across * (at.force / self.spacing * turning)[:, None]
        second = _second(force, at.arm_far, at.arm_near)
        place = places[self.place].reshape(-1, 2, 2)
        for r in (0, 1):
            for s in (0, 1):
                block = moves[r].transpose(0, 2, 1) @ stiff @ moves[s] + second[r][s]
                there = place[:, r, s] >= 0
                np.add.at(data, place[there, r, s], block[there])

    def commit(self, at: DowelEvaluation) -> SpaceDowels:
        """Return the crossings after an accepted step: shear beyond the strength stays."""
        assert isinstance(at, SpaceDowelEvaluation)
        beyond = at.shear - at.force / self.stiffness
        return replace(self, rest=self.rest + beyond[:, None] * at.in_near)

    def install(self, position: FloatArray, chosen: BoolArray) -> SpaceDowels:
        """Return a copy with zero force in the crossings of chosen elements (n_elements,) at a position."""
        at = self.evaluate(position, np.ones(len(chosen), dtype=bool))
        here = self.rest + at.shear[:, None] * at.in_near
        return replace(self, rest=np.where(chosen[self.element][:, None], here, self.rest))


def _movement(arm: FloatArray, sign: float) -> FloatArray:
    """Return the displacement ``u + w x arm`` of points by movements of their blocks, times a sign, (k, 3, 6)."""
    found = np.zeros((len(arm), 3, 6))
    found[:, :, :3], found[:, :, 3:] = sign * np.eye(3), -sign * _product_with(arm)
    return found


def _second(force: FloatArray, far: FloatArray, near: FloatArray) -> list[list[FloatArray]]:
    """Return force times the second derivatives of the shear by movements of far and near block, 2 x 2 of (k, 6, 6).

    The near block turns the frame of the shear: ``f . exp(-w_near) (r + u_far - u_near + (exp(w_far) - 1) a)``.
    """
    k = len(force)
    blocks = [[np.zeros((k, 6, 6)) for _ in range(2)] for _ in range(2)]
    spin = _product_with(force)
    for side, arm in ((0, far), (1, near)):
        dyad = force[:, :, None] * arm[:, None, :]
        work = (force * arm).sum(axis=1)[:, None, None] * np.eye(3)
        blocks[side][side][:, 3:, 3:] = (dyad + dyad.transpose(0, 2, 1)) / 2 - work
    blocks[1][0][:, 3:, :3], blocks[1][0][:, 3:, 3:] = spin, -spin @ _product_with(far)
    blocks[0][1] = blocks[1][0].transpose(0, 2, 1).copy()
    blocks[1][1][:, 3:, :3] -= spin
    blocks[1][1][:, :3, 3:] -= spin.transpose(0, 2, 1)
    return blocks


def _product_with(vector: FloatArray) -> FloatArray:
    """Return the matrices (k, 3, 3) of the vector products ``vector x v``."""
    x, y, z = vector.T
    nothing = np.zeros_like(x)
    rows = [nothing, -z, y, z, nothing, -x, -y, x, nothing]
    found: FloatArray = np.stack(rows, axis=1).reshape(-1, 3, 3)
    return found
