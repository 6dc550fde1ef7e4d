"""The result of a stage of the continuum: averages over blocks, and forces at the points of joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.loads import ActingLoad
from bsm_mesh.model.model import Model
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import ContactForces, ContactStatus
from bsm_mesh.results.shaking import ShakingResult
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.equilibrium import Iterate
from bsm_mesh.solve.zones.fields import RockStiffness, mean_gradient, over_blocks, stress_of, vtk_cells
from bsm_mesh.solve.zones.fills import Fill, gradient_at_fill
from bsm_mesh.solve.zones.ground import PoreWater
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.large_blocks import LargeBlocks
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.plastic_rock import PlasticRock
from bsm_mesh.solve.zones.small_displacements import moved_far
from bsm_mesh.solve.zones.solution import ContinuumSolution
from bsm_mesh.solve.zones.supports import nodal_unknowns
from bsm_mesh.solve.zones.system import LoosePart

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stages import Continuum


RUNAWAY = 1.0  # of a block's size, or a radian: what small displacements balance only so far away is not at rest


class Fall(NamedTuple):
    """Blocks (k,) that fall, and by which rule."""

    blocks: IntArray
    reason: str


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class StageEnd:
    """The end of a stage in terms of unknowns.

    Attributes
    ----------
    name : str
        Of the stage.
    converged : bool
        Whether equilibrium was found.
    present : (n,) bool
        Which blocks are there.
    u, origin : (N,) float64 [m]
        Displacements, and those from which results count.
    fills : tuple of Fill
        Rock that was put back, and where it was then.
    at : Iterate
        Forces out of balance there, and the state of joints and bolts.
    bolts : EmbeddedBolts or None
        The bolts.
    loose : list of LoosePart
        Parts that nothing holds; with any of them no equilibrium was sought.
    collapse : float or None [m]
        Rock yields so that no equilibrium exists within small displacements.
    stiffness : (t, 3, 3) float64 [Pa]
        Of the rock.
    initial_stress : (3, t, i) float64 or None [Pa]
        Effective in-situ stress: xx, yy, xy.
    water : PoreWater or None
        The water.
    load : float64 [N/m]
        Weights, loads and water on the unknowns of `Continuum.loaded`.
    held_back : (N,) float64 [N/m]
        Rest of excavation forces.
    acting : tuple of load
        Those that act.
    pressures : float64 [N/m]
        Of `load` that of pressures on faces that excavations laid bare.
    history : JointHistory or None
        Of the joints.
    model : Model
        With the strength and the gravity of the stage.
    rock : RockStiffness
        Of the cells.
    plastic : PlasticRock or None
        The rock that yields.
    large : LargeBlocks or None
        The rock in large displacement.
    joints : JointPoints or None
        The joints, where they are.
    leaves : bool
        Whether the equilibrium is unstable.
    unknowns : int
        Number of displacement components that were solved for.
    solutions : int
        Of linear systems, on the way.
    shaking : ShakingResult or None
        Of a stage that was shaken.
    fault : str
        Why it is no answer, if it is none.
    fall : Fall or None
        Blocks that fall.
    astray : (N,) float64 or None [m]
        How far from the start of its part a search without equilibrium ended; `u` is as far as the stage is known.
    """

    name: str
    converged: bool
    present: BoolArray
    u: FloatArray
    origin: FloatArray
    fills: tuple[Fill, ...]
    at: Iterate
    bolts: EmbeddedBolts | None
    loose: list[LoosePart]
    collapse: float | None
    stiffness: FloatArray
    initial_stress: FloatArray | None
    water: PoreWater | None
    load: FloatArray
    held_back: FloatArray
    acting: tuple[ActingLoad, ...]
    pressures: FloatArray
    history: JointHistory | None
    model: Model
    rock: RockStiffness
    plastic: PlasticRock | None
    large: LargeBlocks | None
    joints: JointPoints | None
    leaves: bool
    unknowns: int
    solutions: int
    shaking: ShakingResult | None = None
    fault: str = ""
    fall: Fall | None = None
    astray: FloatArray | None = None

    def without_strain(self, block: IntArray) -> FloatArray | None:
        """Return the effective stress (3, t, i) [Pa] of rock without strain: in situ, less what yielding took."""
        stress = None
        if self.initial_stress is not None:
            virgin = ~np.any([np.zeros_like(self.present), *(fill.blocks for fill in self.fills)], axis=0)[block]
            stress = self.initial_stress * virgin[:, None]
        if self.plastic is not None:
            of, relief = self.plastic.of, np.moveaxis(self.plastic.relief, -1, 0)[:3]
            stress = np.zeros((3, len(block), of.points)) if stress is None else stress.copy()
            stress[:, of.cells] -= relief
        return None if stress is None else stress * self.present[block][:, None]


def stage_solution(
    of: Continuum, end: StageEnd, elasticity: str, seconds: float, notes: tuple[str, ...]
) -> ContinuumSolution:
    """Return a stage averaged over the blocks."""
    basis, block = of.basis, of.mesh.block
    stress, area = _total_stress(of, end)
    cells, points = vtk_cells(basis)
    node_dofs = nodal_unknowns(basis)
    moved = end.u - end.origin
    displacement = movement(of, end.u) - movement(of, end.origin)
    for fill in end.fills:
        displacement = np.where(fill.blocks[:, None], movement(of, end.u - fill.u), displacement)
    may_slide = end.joints is not None and not end.joints.are_linear
    ran_away = may_slide and end.large is None and moved_far(of.model, displacement, end.present, RUNAWAY)
    total_load = end.load[nodal_unknowns(of.loaded[1])].sum(axis=0)
    return ContinuumSolution(
        name=end.name,
        converged=end.converged and not ran_away,
        elasticity=elasticity,
        present=end.present,
        stress=over_blocks(stress, area, block, np.maximum(np.bincount(block, area), np.finfo(float).tiny)),
        displacement=displacement * end.present[:, None],
        contacts=contacts_of(end),
        bolts=_bolts(of, end),
        points=points,
        point_displacement=moved[node_dofs],
        cells=cells,
        cell_block=block,
        cell_stress=stress,
        total_load=total_load,
        total_reaction=-end.at.residual[node_dofs].sum(axis=0),
        unknowns=end.unknowns,
        seconds=seconds,
        notes=notes,
    )


def movement(of: Continuum, u: FloatArray) -> FloatArray:
    """Return the blocks' average displacement and rotation under displacements u (N,), (n, 3) [m, m, rad].

    Large rotations, from -pi to pi, are those of the polar decomposition of the mean deformation gradient.
    """
    area = of.basis.dx.sum(axis=1), of.mesh.block, of.model.blocks.moments.area
    gradient = over_blocks(mean_gradient(of.basis, u), *area)
    twice = gradient[:, 1, 0] - gradient[:, 0, 1]
    stretch = 2 + gradient[:, 0, 0] + gradient[:, 1, 1]
    turned = np.arctan2(twice, stretch) if of.discretization.large else twice / 2
    return np.column_stack([*(part @ u for part in of.averages), turned])


def _total_stress(of: Continuum, end: StageEnd) -> tuple[FloatArray, FloatArray]:
    """Return the average total stress of every cell, (t, 2, 2) [Pa], and its area (t,) [m2]; zero where there is none.

    In large displacement they are those of the cell as it is.
    """
    basis, block = of.basis, of.mesh.block
    if end.large is not None:
        cells = end.large.rock.at(end.u, basis.element_dofs)
        return end.large.rock.stress(cells) - _mean_pressure(of, end), end.large.rock.area(cells)
    stress = stress_of(mean_gradient(basis, end.u) - gradient_at_fill(end.fills, basis, block), end.stiffness)
    area = basis.dx.sum(axis=1)
    given = end.without_strain(block)
    if given is not None:
        xx, yy, xy = (given * basis.dx).sum(axis=2) / area
        stress = stress + np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)
    return (stress - _mean_pressure(of, end)) * end.present[block][:, None, None], area


def _mean_pressure(of: Continuum, end: StageEnd) -> FloatArray:
    """Return the mean pressure of the water in every cell that is there, on the diagonal of (t, 2, 2) [Pa]."""
    if end.water is None:
        return np.zeros((of.basis.nelems, 2, 2))
    dx = of.basis.dx
    mean: FloatArray = (end.water.pressure * dx).sum(axis=1) / dx.sum(axis=1) * end.present[of.mesh.block]
    return mean[:, None, None] * np.eye(2)


def _bolts(of: Continuum, end: StageEnd) -> BoltForces:
    if end.bolts is None or end.at.bolts is None:
        return BoltForces.none()
    return end.bolts.record(of.model, end.at.bolts)


def contacts_of(end: StageEnd, *, with_rock: bool = False) -> ContactForces:
    """Return the forces at the points of joints between blocks that are there, as the blocks' own contacts are given.

    The first side, out of which the normal points, takes the place of the block with the edge. `with_rock` says whether
    interfaces of rock are contacts too, as unjointed rock.
    """
    state, joints = end.at.state, end.joints
    if joints is None or state is None:
        return ContactForces.none()
    on = np.flatnonzero(end.present[joints.block].all(axis=1) & (joints.are_joints | with_rock))
    strength = state.strength
    with np.errstate(divide="ignore", invalid="ignore"):
        utilisation = np.where(np.isfinite(strength) & (strength > 0), np.abs(state.shear) / strength, 0.0)
    water = np.zeros(len(joints.length)) if end.water is None else end.water.at_joints
    point, normal = joints.point, joints.normal
    if isinstance(joints, MovingPoints):
        point, (normal, _) = joints.placed(end.u), joints.frames(end.u)
    return ContactForces(
        block_a=joints.block[on, 1],
        block_b=joints.block[on, 0],
        point=point[on],
        normal=normal[on],
        length=joints.length[on],
        normal_force=-state.pressure[on],
        shear_force=state.shear[on],
        opening=state.opening[on],
        slip=state.slip[on],
        status=_status(state)[on],
        utilisation=utilisation[on],
        joint=np.where(joints.are_joints, joints.joint, -1)[on],
        water_pressure=water[on],
    )


def met_rows(end: StageEnd) -> int:
    """Return how many rows of `contacts_of`, the last ones, are where blocks met later."""
    return int(end.present[end.joints.met.block].all(axis=1).sum()) if isinstance(end.joints, MovingPoints) else 0


def _status(state: JointState) -> IntArray:
    status: IntArray = np.where(
        ~state.closed,
        int(ContactStatus.OPEN),
        np.where(state.sticking, int(ContactStatus.STICKING), int(ContactStatus.SLIPPING)),
    ).astype(np.int8)
    return status
