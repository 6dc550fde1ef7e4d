"""The result of the bolts: tensions, bond forces, slips, and which bolt is at its limit in what way."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.movements import lengths


class BoltStatus(IntEnum):
    """State of a bolt, the worst that is anywhere along it."""

    SLACK = 0
    ELASTIC = 1
    SLIPPING = 2
    YIELDING = 3
    ABSENT = 4


class BoltLimit(IntEnum):
    """The strength that a utilisation is a part of: of the steel, of bond, plate or anchorage, or of the dowel."""

    NONE = 0
    STEEL = 1
    BOND = 2
    DOWEL = 3


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class BoltForces(Portable):
    """Forces in the bolts, stored flat: element i of a bolt joins its nodes i and i + 1, from head to tip.

    Forces are those of one bolt. Points and directions have three coordinates in space.

    Attributes
    ----------
    names : tuple of str
        Of the bolts.
    node_start : (n_bolts + 1,) int32
        Bolt b has the nodes ``node_start[b]:node_start[b + 1]``.
    block : (n_nodes,) int32
        Block of each node.
    station : (n_nodes,) float64 [m]
        Distance from the head.
    original : (n_nodes, 2) float64 [m]
        Where the node was before anything moved.
    point : (n_nodes, 2) float64 [m]
        Where its force acts: where the node is, or `original` in the linear scheme.
    displacement : (n_nodes, 2) float64 [m]
        Of the rock there, since the start.
    spacing : (n_bolts,) float64 [m]
        Out of the plane: forces on the blocks are divided by it.
    status : (n_bolts,) int8
        `BoltStatus`: slack, elastic, slipping (bond or anchorage at its capacity), yielding (steel), or absent: not
        installed, or gone with its blocks.
    alive : (n_elements,) bool
        Elements that are installed and not cut.
    axial_force : (n_elements,) float64 [N]
        Tension.
    bond_force : (n_nodes,) float64 [N]
        On the rock, towards the tip positive (Wang Eq. 5.6).
    slip : (n_nodes,) float64 [m]
        Of the bolt against the rock, towards the tip positive.
    plastic_stretch : (n_elements,) float64 [m]
        What stays when the bolt is unloaded.
    utilisation : (n_elements,) float64
        The greatest of tension over yield force, bond force over capacity at its two nodes, and shear over strength.
    limit : (n_elements,) int8
        `BoltLimit`: which of the three it is; none where nothing acts, and in folders of before 2.0.0.
    shear_force : (n_elements,) float64 [N]
        Of a bolt with dowel action, where it crosses a joint: on the block on the head's side along `shear_direction`.
    shear_point, shear_direction : (n_elements, 2) float64 [m, -]
        Where and along which unit vector; zero without dowel action.
    """

    names: tuple[str, ...]
    node_start: IntArray
    block: IntArray
    station: FloatArray
    original: FloatArray
    point: FloatArray
    displacement: FloatArray
    spacing: FloatArray
    status: IntArray
    alive: BoolArray
    axial_force: FloatArray
    bond_force: FloatArray
    slip: FloatArray
    plastic_stretch: FloatArray
    utilisation: FloatArray
    limit: IntArray
    shear_force: FloatArray
    shear_point: FloatArray
    shear_direction: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @classmethod
    def none(cls, coordinates: int = 2) -> BoltForces:
        """Return the record of a model without bolts, whose points would have so many coordinates."""
        numbers, whole, points = np.zeros(0), np.zeros(0, np.int32), np.zeros((0, coordinates))
        return cls(
            names=(),
            node_start=np.zeros(1, np.int32),
            block=whole,
            station=numbers,
            original=points,
            point=points,
            displacement=points,
            spacing=numbers,
            status=np.zeros(0, np.int8),
            alive=np.zeros(0, dtype=bool),
            axial_force=numbers,
            bond_force=numbers,
            slip=numbers,
            plastic_stretch=numbers,
            utilisation=numbers,
            limit=np.zeros(0, np.int8),
            shear_force=numbers,
            shear_point=points,
            shear_direction=points,
        )

    @property
    def count(self) -> int:
        """Number of bolts."""
        return len(self.node_start) - 1

    @property
    def alone(self) -> BoolArray:
        """Which bolts lie in a single block, and carry nothing, (n_bolts,)."""
        alone: BoolArray = np.diff(self.node_start) == 1
        return alone

    @property
    def states(self) -> tuple[str, ...]:
        """State of every bolt in words."""
        named = zip(self.status.tolist(), self.alone.tolist(), strict=True)
        return tuple("in a single block" if alone else BoltStatus(k).name.lower() for k, alone in named)

    @property
    def first_node(self) -> IntArray:
        """First node of every element; the second is the next one."""
        inner = np.ones(len(self.block), dtype=bool)
        inner[self.node_start[1:] - 1] = False
        return np.flatnonzero(inner).astype(np.int32)

    @property
    def bolt(self) -> IntArray:
        """Bolt of every element, (n_elements,)."""
        return np.repeat(np.arange(self.count, dtype=np.int32), np.diff(self.node_start) - 1)

    @property
    def direction(self) -> FloatArray:
        """Unit vector of every element from head to tip, (n_elements, 2)."""
        vector = self.point[self.first_node + 1] - self.point[self.first_node]
        length = lengths(vector)[:, None]
        direction: FloatArray = np.divide(vector, length, out=np.zeros_like(vector), where=length > 0)
        return direction

    @property
    def greatest_force(self) -> FloatArray:
        """Greatest tension of every bolt, (n_bolts,) [N]."""
        greatest = np.zeros(self.count)
        np.maximum.at(greatest, self.bolt, self.axial_force)
        return greatest

    @property
    def head_force(self) -> FloatArray:
        """Tension at the head of every bolt, with which it supports the wall, (n_bolts,) [N]."""
        force = np.zeros(self.count)
        has_elements = np.diff(self.node_start) > 1
        first = (self.node_start[:-1] - np.arange(self.count))[has_elements]
        force[has_elements] = self.axial_force[first]
        return force

    @property
    def mean_force(self) -> FloatArray:
        """Mean tension along every bolt, (n_bolts,) [N]."""
        bolt, length = self.bolt, self.station[self.first_node + 1] - self.station[self.first_node]
        whole = np.bincount(bolt, length, minlength=self.count)
        summed = np.bincount(bolt, length * self.axial_force, minlength=self.count)
        mean: FloatArray = np.divide(summed, whole, out=np.zeros(self.count), where=whole > 0)
        return mean

    @property
    def wall_share(self) -> FloatArray:
        """Width of wall that every bolt supports, (n_bolts,) [m].

        Half the distance to the next head on either side, across the bolt, of bolts within 60 degrees of it; at an end
        of a row the whole distance to the one neighbour. Not a number for a bolt without a neighbour, and in space.
        """
        if self.original.shape[1] > 2:
            return np.full(self.count, np.nan)
        head = self.original[self.node_start[:-1]]
        along = self.original[self.node_start[1:] - 1] - head
        length = np.hypot(*along.T)[:, None]
        along = np.divide(along, length, out=np.zeros_like(along), where=length > 0)
        there = self.status != BoltStatus.ABSENT
        apart = head[None, :] - head[:, None]
        across = apart[..., 1] * along[:, None, 0] - apart[..., 0] * along[:, None, 1]
        beside = (along @ along.T > 0.5) & there[:, None] & there[None, :]
        right = np.where(beside & (across > 0), across, np.inf).min(axis=1, initial=np.inf)
        left = np.where(beside & (across < 0), -across, np.inf).min(axis=1, initial=np.inf)
        both = np.isfinite(right) & np.isfinite(left)
        share = np.where(both, (right + left) / 2, np.minimum(right, left))
        found: FloatArray = np.where(np.isfinite(share), share, np.nan)
        return found

    @property
    def support_pressure(self) -> FloatArray:
        """Pressure that every bolt exerts on the wall at its head, (n_bolts,) [Pa] (one reading of Wang Fig. 8.14).

        Its head force over its spacing and `wall_share`. Not a number for a bolt without a neighbour.
        """
        pressure: FloatArray = self.head_force / (self.spacing * self.wall_share)
        return pressure

    @property
    def mean_pressure(self) -> FloatArray:
        """Mean tension along every bolt over the same area, (n_bolts,) [Pa] (the other reading of Wang Fig. 8.14).

        Not a number for a bolt without a neighbour.
        """
        pressure: FloatArray = self.mean_force / (self.spacing * self.wall_share)
        return pressure

    def on_blocks(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return block, point [m] and force [N/m] of both ends of every element, and of both sides of its shear."""
        first, spacing = self.first_node, self.spacing[self.bolt, None]
        force = self.direction * self.axial_force[:, None] / spacing
        shear = self.shear_direction * self.shear_force[:, None] / spacing
        nodes = np.concatenate([first, first + 1])
        return (
            np.tile(self.block[nodes], 2),
            np.concatenate([self.point[nodes], self.shear_point, self.shear_point]),
            np.concatenate([force, -force, shear, -shear]),
        )
