"""The continuum through the stages of construction, as the Block-Spring Model goes through them.

A stage takes cells away or puts them back and brings loads, a pressure on the new faces, water, bolts and another
strength; the forces that the removed rock exerted on the rest are released by parts. Rock is elastic or yields, and
displacements are small; joints and bolts keep their history.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.in_stage import model_in_stage
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL, Stage, presence
from bsm_mesh.solve.zones import departures
from bsm_mesh.solve.zones.apart import Apart
from bsm_mesh.solve.zones.elasticity import BlockElasticity
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate, find_equilibrium, refuse_unsolved
from bsm_mesh.solve.zones.fields import RockStiffness, block_averages, forces_of_stress
from bsm_mesh.solve.zones.fills import Fill
from bsm_mesh.solve.zones.ground import (
    initial_history,
    initial_stress,
    pore_water,
    seepage_forces,
)
from bsm_mesh.solve.zones.interfaces import open_joints
from bsm_mesh.solve.zones.joint_points import JointPoints, slip_path_after
from bsm_mesh.solve.zones.loads import load_vector, pressure_on_new_faces
from bsm_mesh.solve.zones.mesh import ContinuumMesh, Discretization, continuum_mesh
from bsm_mesh.solve.zones.near_blocks import broken_at, moved_with_blocks
from bsm_mesh.solve.zones.placed_points import joint_points
from bsm_mesh.solve.zones.plastic_rock import PlasticCells, PlasticRock, strength_of
from bsm_mesh.solve.zones.solution import ContinuumSolution
from bsm_mesh.solve.zones.stage_solution import StageEnd, stage_solution
from bsm_mesh.solve.zones.supports import held_displacements
from bsm_mesh.solve.zones.system import FreeUnknowns, loose_parts, refuse_loose
from bsm_mesh.solve.zones.tangents import Tangents
from bsm_mesh.solve.zones.zones_state import ZonesState

PARTS = 4  # of the unbalanced force, one after the other, where all at once leads nowhere
MAX_FAILURES = 50  # times that points of joints fail or wear in a part of a stage and the others take over their load
WORN = 1e-6  # of a law's wear length: slip by which two equilibria in turn may differ


class Continuum:
    """A model's mesh and joints in scikit-fem, ready to be solved with different elastic constants.

    Parameters
    ----------
    model : Model
        The model.
    discretization : Discretization
        Elements and interfaces.
    present : sequence of (n,) bool or None
        Blocks that are there in the first stages, if a run lost some that its stages do not take away. The pressures of
        stages do not act on faces of lost blocks.
    mesh : ContinuumMesh, optional
        Its cells; None: those of the discretization. With given cells the forces between blocks that share nodes are
        worked out too (`apart`).
    """

    def __init__(
        self,
        model: Model,
        discretization: Discretization,
        present: Sequence[BoolArray] | None = None,
        mesh: ContinuumMesh | None = None,
    ) -> None:
        import skfem

        departures.refuse(model, discretization.joints)
        began = time.perf_counter()
        self.model, self.discretization = model, discretization
        self.as_planned = presence(model.stages, model.blocks)
        self.presence = self.as_planned if present is None else list(present)
        whole = self.mesh = continuum_mesh(model.blocks, discretization) if mesh is None else mesh
        interfaces = None
        if discretization.joints:
            self.mesh, interfaces = open_joints(model, self.mesh, self.presence, discretization.rock_breaks)
        elements = {
            False: (skfem.ElementTriP1, skfem.ElementTriP2),
            True: (skfem.ElementQuad1, skfem.ElementQuadS2),
        }[self.mesh.are_quads]
        element = elements[discretization.order - 1]()
        self.basis = skfem.CellBasis(self.mesh.mesh, skfem.ElementVector(element))
        self.averages = block_averages(self.basis, self.mesh.block, model.blocks.moments.area)
        self.joints: JointPoints | None = None
        self.facets = np.zeros((0, 2), dtype=np.int32)
        self.ties = np.zeros((2, 0), dtype=np.int32)
        if interfaces is not None and interfaces.joint.size:
            self.joints = joint_points(model, self.mesh, interfaces, self.basis, discretization.order)
            self.facets = interfaces.facet
            self.ties = self.basis.nodal_dofs[0, interfaces.vertex.T]
        self.apart = None if mesh is None else Apart.of(model, whole, interfaces, self.basis, discretization)
        self.bolts: EmbeddedBolts | None = None
        if model.bolts:
            how = {"elastic": discretization.elastic_bolts, "straight": mesh is not None}
            self.bolts = EmbeddedBolts.of(model, self.mesh, self.basis, **how)
        self.seconds = time.perf_counter() - began

    def solve(
        self, elasticity: BlockElasticity, count: int | None = None, near: Sequence[FloatArray] = ()
    ) -> tuple[ContinuumSolution, ...]:
        """Return the first `count` stages with these elastic constants, up to the first without equilibrium.

        Each is sought from where the last left the rock, or, for as many as have one, near positions of the blocks,
        (n, 3) each [m, m, rad].
        """
        began = time.perf_counter()
        notes = (
            *departures.notes(self.model, self.joints is not None, self.discretization.rock_breaks),
            *elasticity.notes,
        )
        found: list[ContinuumSolution] = []
        for end in self.ends(elasticity, count, near):
            refuse_loose(end.loose)
            seconds = self.seconds + time.perf_counter() - began
            found.append(stage_solution(self, end, elasticity.name, seconds, notes))
            if not found[-1].converged:
                break
        return tuple(found)

    def ends(
        self, elasticity: BlockElasticity, count: int | None = None, near: Sequence[FloatArray] = ()
    ) -> Iterator[StageEnd]:
        """Yield the ends of the stages, one after the other; parameters as for `solve`."""
        run = _Run(self, elasticity.stiffness[self.mesh.block])
        stages: tuple[Stage | None, ...] = (None, *self.model.stages)
        for number, (before, present) in enumerate(
            pairwise([self.presence[0], *self.presence][: None if count is None else count + 1])
        ):
            stage = stages[number]
            run.near = near[number] if number < len(near) else None
            yield run.first(present) if stage is None else run.next(stage, number, before, present)

    @property
    def loaded(self) -> tuple[ContinuumMesh, Any, IntArray]:
        """The cells on which loads act, their basis, and pairs of facets that lie on each other, (k, 2)."""
        return (self.mesh, self.basis, self.facets) if self.apart is None else self.apart.loaded

    def merged(self, forces: FloatArray) -> FloatArray:
        """Return forces on the cells of `loaded` as forces on the unknowns, (N,) [N/m]."""
        return forces if self.apart is None else self.apart.merged(forces)


class _Run:
    """The stages of one continuum with one set of elastic constants (t, 3, 3) [Pa], one after the other."""

    def __init__(self, continuum: Continuum, stiffness: FloatArray) -> None:
        self.of, self.stiffness = continuum, stiffness
        self.rock = RockStiffness(continuum.basis, stiffness)
        model, basis, joints = continuum.model, continuum.basis, continuum.joints
        water = pore_water(model, model.water, basis, joints)
        self.initial_stress = initial_stress(model, continuum.mesh, basis, water)
        history = None if joints is None else initial_history(model, joints, water)
        zero = np.zeros(basis.N)
        bolts = None if continuum.bolts is None else continuum.bolts.install(0, zero)
        none = np.zeros(continuum.loaded[1].N)
        self.plastic = PlasticCells(model, basis, continuum.mesh.block, stiffness)
        relief, loads = self.plastic.nothing(), model.acting_loads
        self.state = ZonesState(model, zero, zero, joints, history, bolts, loads, water, none, relief)
        self.reactions = zero  # of supports that hold blocks or points between nodes, at the end of the last stage
        self.near: FloatArray | None = None  # of blocks at the end of the stage, where its last part is to begin

    def first(self, present: BoolArray) -> StageEnd:
        """Return the state before the first stage."""
        self._wet()
        if self.state.bolts is not None:
            self.state.bolts = self.state.bolts.without(~present)
        end = self._solved(INITIAL, present, (1.0,))
        if self.of.model.in_situ is not None:
            self.state.origin = self.state.u
        return end

    def next(self, stage: Stage, number: int, before: BoolArray, present: BoolArray) -> StageEnd:
        """Return the end of a stage: the excavation's forces are those out of balance without the rock that leaves."""
        state, of = self.state, self.of
        stays = before & present
        equations = self.equations(stays, self._loads(stays))
        old = equations.at(state.u, equations.free.none)
        excavation = old.residual - state.held_back(0.0) - self.reactions
        state.unreleased.append((excavation, 0.0))
        state.model = model_in_stage(of.model, number)
        if state.joints is not None:
            state.joints = state.joints.with_strength_of(state.model)
        if (present & ~before).any():
            self._fill(stays, present & ~before)
        if state.bolts is not None:
            state.bolts = state.bolts.install(number, state.u).without(~present)
        if stage.pressure:
            leaves = before & ~of.as_planned[number]
            state.pressures = state.pressures + pressure_on_new_faces(*of.loaded, stays, leaves, stage.pressure)
        state.loads = (*state.loads, *of.model.worked_out(stage.loads))
        if stage.water is not None:
            state.water = pore_water(of.model, stage.water, of.basis, of.joints)
            self._wet()
        return self._solved(stage.name, present, stage.relaxation)

    def _fill(self, stays: BoolArray, comes: BoolArray) -> None:
        """Put blocks (n,) back as they were given, without stress and without force in their joints."""
        state, of = self.state, self.of
        fresh = np.zeros(of.basis.N, dtype=bool)
        fresh[of.basis.element_dofs[:, comes[of.mesh.block]]] = True
        fresh[of.basis.element_dofs[:, stays[of.mesh.block]]] = False
        state.u, state.origin = np.where(fresh, 0.0, state.u), np.where(fresh, 0.0, state.origin)
        state.relief[comes[self.plastic.block]] = 0.0
        state.fills = (*(fill.without(comes) for fill in state.fills), Fill(blocks=comes, u=state.u))
        if state.joints is not None and state.history is not None:
            state.history = state.joints.put_back(state.history, stays, comes, state.u)

    def _wet(self) -> None:
        """Put the water's own pressure into the joints."""
        state, joints = self.state, self.state.joints
        if joints is not None and state.history is not None and state.water is not None:
            state.history = replace(state.history, water=joints.lumped(state.water.beyond_table))

    def _solved(self, name: str, present: BoolArray, parts: tuple[float, ...]) -> StageEnd:
        state, of = self.state, self.of
        cells = np.flatnonzero(present[of.mesh.block]).astype(np.int32)
        here = np.zeros(of.basis.N, dtype=bool)
        here[of.basis.element_dofs[:, cells]] = True
        both = here[of.ties].all(axis=0)
        loads = self._loads(present)
        equations = self.equations(present, loads)
        held = equations.free.supports
        for part in parts:
            held_back = state.held_back(part)
            equations = replace(equations, load=equations.load - held_back)
            at, converged = equations.at(state.u, equations.free.none), False
            loose = loose_parts(held, of.basis, cells, of.ties[:, both], at.residual)
            if loose:
                break
            if self.near is not None and part == parts[-1]:
                state.u = moved_with_blocks(of.model.blocks, of.mesh, of.basis, self.near)
                equations = broken_at(equations, state.u)
            equations, at, converged = self._reached(equations)
            equations = replace(equations, load=equations.load + held_back)
            state.u, state.history, state.bolts = at.u, equations.history, equations.bolts
            if equations.plastic is not None:
                state.relief = equations.plastic.relief
            if not converged:
                break
        self.reactions = held.rows.T @ at.multipliers
        return StageEnd(
            name=name,
            converged=converged,
            present=present,
            u=at.u,
            origin=state.origin,
            fills=state.fills,
            at=at,
            bolts=equations.bolts,
            loose=loose,
            stiffness=self.stiffness,
            initial_stress=self.initial_stress,
            water=state.water,
            load=loads,
            held_back=held_back,
            acting=state.loads,
            pressures=state.pressures,
            history=equations.history,
            model=state.model,
            rock=self.rock,
            plastic=equations.plastic,
            unknowns=equations.free.free.size,
            solutions=equations.free.solutions,
        )

    def _reached(self, equations: Equations) -> tuple[Equations, Iterate, bool]:
        """Return equilibrium, sought at once and, where that fails, in parts of the unbalanced force."""
        u = self.state.u
        first = self._settled(equations)
        if first[2]:
            return first
        out_of_balance = equations.at(u, equations.free.none).residual
        self.state.u, now = u, equations
        for part in range(1, PARTS + 1):
            held_back = (1 - part / PARTS) * out_of_balance
            now, at, converged = self._settled(replace(now, load=equations.load - held_back))
            if not converged:
                return first
            self.state.u = at.u
        return now, at, True

    def _settled(self, equations: Equations) -> tuple[Equations, Iterate, bool]:
        """Return equilibrium once no more points of joints fail or wear, and the equations with the kept part of it.

        Where failing takes force away the others take it over from where they are then, as blocks do from step to step.
        """
        start = equations.history
        for _ in range(MAX_FAILURES):
            at, converged = find_equilibrium(equations, self.state.u)
            if equations.are_linear:
                refuse_unsolved(at)
                converged = True
            history = equations.history
            joints = equations.joints
            if not converged:
                break
            if history is None or start is None or joints is None or at.state is None:
                equations = equations.after(at, None)
                break
            path = slip_path_after(start, at.state)
            wears = np.abs(path - history.slip_path) > WORN * joints.wear_length
            if (at.state.failed == history.failed).all() and not wears.any():
                equations = equations.after(at, path)
                break
            self.state.u = at.u
            failed = replace(history, failed=at.state.failed, parted=at.state.parted)
            if replace(equations, history=failed).at(at.u, at.multipliers).is_balanced:
                equations = replace(equations, history=replace(failed, slip_path=path))
            else:
                equations = equations.after(at, path)
                start = equations.history
        else:
            converged = False
        return equations, at, converged

    def _loads(self, present: BoolArray) -> FloatArray:
        """Return weights, loads and water on the rock that is there, on the unknowns of `loaded`."""
        state, (mesh, basis, _) = self.state, self.of.loaded
        loads = load_vector(state.model, mesh, basis, state.loads, present) + state.pressures
        if state.water is None:
            return loads
        water = seepage_forces(state.water, present, mesh, basis)
        if self.of.apart is not None:
            water = water + self.of.apart.left_of_water(state.water, water, state.history, present)
        return loads + water

    def equations(self, present: BoolArray, loads: FloatArray) -> Equations:
        """Return the equations of equilibrium of the present rock under loads, as `_loads` returns them."""
        of, state = self.of, self.state
        history, on = state.history, present[of.mesh.block]
        load = of.merged(loads)
        virgin = on.copy()
        for fill in state.fills:
            filled = on & fill.blocks[of.mesh.block]
            load = load + self.rock.of(filled) @ fill.u
            virgin &= ~filled
        if self.initial_stress is not None:
            load = load - forces_of_stress(of.basis, self.initial_stress * virgin[:, None])
        held = held_displacements(of.model, of.mesh, of.basis, of.averages, present)
        idle = np.ones(of.basis.N, dtype=bool)
        idle[of.basis.element_dofs[:, on]] = False
        if state.joints is not None and history is not None:
            first, second = state.joints.block.T
            history = replace(history, present=present[first] & present[second])
        stiffness, free, joints = self.rock.of(on), FreeUnknowns(held, idle), state.joints
        opening, slip = (None, None) if joints is None else (joints.opening_rows, joints.slip_rows)
        return Equations(
            stiffness=stiffness,
            load=load,
            free=free,
            joints=joints,
            history=history,
            bolts=state.bolts,
            plastic=self._plastic(present, virgin),
            tangents=Tangents(stiffness, opening, slip, free),
            size=float(np.sqrt(np.median(of.model.blocks.moments.area))),
        )

    def _plastic(self, present: BoolArray, virgin: BoolArray) -> PlasticRock | None:
        """Return the rock that yields; its cells that are `virgin` (t,) have the in-situ stress."""
        of, state = self.plastic, self.state
        if not len(of.cells):
            return None
        initial, nodes = of.nothing(), np.zeros_like(of.at_nodes(state.u))
        if self.initial_stress is not None:
            xx, yy, xy = self.initial_stress[:, of.cells] * virgin[of.cells, None]
            initial = np.stack([xx, yy, xy, xx], axis=-1)  # as much across the plane as along it
        for fill in state.fills:
            nodes += of.at_nodes(fill.u) * fill.blocks[of.block][:, None, None]
        return PlasticRock(
            of=of,
            strength=strength_of(state.model, of),
            there=present[of.block],
            initial=initial,
            without_strain=nodes,
            relief=state.relief,
        )
