"""Thrust, shear and moment in a liner whose elements are blocks, and how near they are to its capacity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray, Portable
from bsm_mesh.errors import ModelError, as_given, nearest, raise_faults
from bsm_mesh.model.quantities import LINER_COMPRESSION, TENSILE_STRENGTH
from bsm_mesh.model.values import Rules
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results

CLOCKWISE = -1.0


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LinerForces(Portable):
    """Forces in the sections between neighbouring blocks of a liner, per metre of tunnel.

    Attributes
    ----------
    block_a, block_b : (k,) int32
        The blocks on both sides of each section.
    point : (k, 2) float64 [m]
        Middle of the section.
    thickness : (k,) float64 [m]
        Length of the section.
    thrust : (k,) float64 [N/m]
        Normal force, compression positive.
    shear : (k,) float64 [N/m]
        Force along the section.
    moment : (k,) float64 [N m/m]
        Positive where the side towards the middle of the liner is compressed.
    """

    block_a: IntArray
    block_b: IntArray
    point: FloatArray
    thickness: FloatArray
    thrust: FloatArray
    shear: FloatArray
    moment: FloatArray

    @property
    def stress(self) -> FloatArray:
        """Stress at the inner and the outer side of each section, (k, 2) [Pa], compression positive."""
        bending = 6 * self.moment / self.thickness**2
        sides: FloatArray = (self.thrust / self.thickness)[:, None] + np.stack([bending, -bending], axis=1)
        return sides

    def utilisation(self, compressive_strength: float, tensile_strength: float) -> FloatArray:
        """Return by how much thrust and moment use up the elastic capacity of each section, (k,); above 1 it fails.

        Thrust and moment together may be divided by it before the greatest stress of a side reaches a strength.

        Parameters
        ----------
        compressive_strength, tensile_strength : float [Pa]
            Strengths of the liner, both positive.

        Raises
        ------
        ModelError
            For strengths out of their range.
        """
        given = Capacity(compressive_strength=compressive_strength, tensile_strength=tensile_strength)
        stress = self.stress
        compressed = stress.max(axis=1) / given.compressive_strength
        with np.errstate(divide="ignore", invalid="ignore"):
            pulled = np.where(stress.min(axis=1) < 0, -stress.min(axis=1) / given.tensile_strength, 0.0)
        used: FloatArray = np.maximum(np.maximum(compressed, pulled), 0.0)
        return used


@dataclass(frozen=True, slots=True, kw_only=True)
class Capacity:
    """Strengths of a liner.

    Attributes
    ----------
    compressive_strength, tensile_strength : float [Pa]
        Both positive.

    References
    ----------
    Carranza-Torres and Diederichs (2009), Tunnelling and Underground Space Technology 24(5): the elastic envelope of
    thrust and moment.
    """

    compressive_strength: Annotated[float, LINER_COMPRESSION]
    tensile_strength: Annotated[float, TENSILE_STRENGTH]

    def __post_init__(self) -> None:
        rules = Rules("liner")
        rules.numbers(self)
        raise_faults(rules.faults)

    def envelope(self, thickness: float) -> tuple[FloatArray, FloatArray]:
        """Return moments [N m/m] and thrusts [N/m] of the envelope of a section, a closed line, (5,) each."""
        c, t = self.compressive_strength, self.tensile_strength
        balanced, most = (c - t) / 2 * thickness, (c + t) / 2 * thickness**2 / 6
        moments = np.array([0.0, most, 0.0, -most, 0.0])
        return moments, np.array([c * thickness, balanced, -t * thickness, balanced, c * thickness])


def liner_forces(results: Results, rock: str, stage: StageResult | int | str = -1) -> LinerForces:
    """Return thrust, shear and moment between neighbouring blocks of a rock, as between elements of a liner.

    Parameters
    ----------
    results : Results
        Of a run.
    rock : str
        Name of the rock of which the liner consists.
    stage : StageResult, int or str
        One of ``results.stages``, or its number or name; negative numbers count from the last stage.

    Raises
    ------
    ModelError
        If there is no such stage or rock, or no blocks of the rock touch each other there.

    Examples
    --------
    A block of 26 kN/m on another presses with its weight.

    >>> import bsm_mesh as bsm
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1), (1, 1), (1, 2), (0, 2)]], rock="concrete"
    ...     ),
    ...     rocks=[bsm.Rock("concrete", unit_weight=26e3, young=20e9, poisson=0.2)],
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> found = bsm.liner_forces(bsm.run(model), "concrete")
    >>> found.thrust.round(6).tolist(), found.thickness.round(9).tolist()
    ([26000.0], [1.0])
    """
    blocks = results.blocks
    if not isinstance(rock, str) or rock not in blocks.rock_names:
        raise ModelError(f"liner: there is no rock {as_given(rock)}{nearest(rock, blocks.rock_names)}")
    record = stage if isinstance(stage, StageResult) else results.stages[stage]
    is_liner = blocks.rock == blocks.rock_names.index(rock)
    contacts = record.contacts
    rows = np.flatnonzero(is_liner[contacts.block_a] & is_liner[contacts.block_b])
    if not rows.size:
        raise ModelError(
            f"liner: no two blocks of rock '{rock}' touch in stage '{record.name}'; give a stage with the liner"
        )
    pair = np.sort(np.stack([contacts.block_a[rows], contacts.block_b[rows]], axis=1), axis=1)
    pair, of = np.unique(pair, axis=0, return_inverse=True)
    of = of.reshape(-1)

    def total(values: FloatArray) -> FloatArray:
        summed: FloatArray = np.zeros((len(pair), *values.shape[1:]))
        np.add.at(summed, of, values)
        return summed

    onto = np.where(contacts.block_b[rows] == pair[of, 1], 1.0, -1.0)[:, None]  # b is the pair's second block
    length = contacts.length[rows]
    across = total(-onto * contacts.normal[rows] * length[:, None])  # from the first block to the second
    across /= np.hypot(*across.T)[:, None]
    thickness = total(length)
    point = total(contacts.point[rows] * length[:, None]) / thickness[:, None]
    middle = blocks.moments.centroid[is_liner].mean(axis=0)
    inward = np.stack([-across[:, 1], across[:, 0]], axis=1)
    inward *= np.where(((middle - point) * inward).sum(axis=1) < 0, CLOCKWISE, 1.0)[:, None]
    force = onto * contacts.force[rows]
    pressed = (force * across[of]).sum(axis=1)
    arm = ((contacts.point[rows] - point[of]) * inward[of]).sum(axis=1)
    return LinerForces(
        block_a=pair[:, 0].astype(np.int32),
        block_b=pair[:, 1].astype(np.int32),
        point=point,
        thickness=thickness,
        thrust=total(pressed),
        shear=total((force * inward[of]).sum(axis=1)),
        moment=total(arm * pressed),
    )
