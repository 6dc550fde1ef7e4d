"""The stages of one continuum with one set of elastic constants, from the start or from a memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.in_stage import model_in_stage, water_in_stage
from bsm_mesh.model.stages import INITIAL, Stage
from bsm_mesh.model.water import Water
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate
from bsm_mesh.solve.zones.fields import RockStiffness, forces_of_stress
from bsm_mesh.solve.zones.fills import put_back
from bsm_mesh.solve.zones.ground import PoreWater, initial_history, initial_stress, pore_water, seepage_forces
from bsm_mesh.solve.zones.joint_points import slip_path_after
from bsm_mesh.solve.zones.large_blocks import LargeBlocks
from bsm_mesh.solve.zones.large_rock import LargeRock
from bsm_mesh.solve.zones.large_water import water_near, wetted
from bsm_mesh.solve.zones.last_known import last_known
from bsm_mesh.solve.zones.loads import load_vector, pressure_on_new_faces
from bsm_mesh.solve.zones.loose_blocks import loose
from bsm_mesh.solve.zones.moved_supports import carried, slid_on, slip_begun, steps
from bsm_mesh.solve.zones.near_blocks import broken_at, moved_with_blocks
from bsm_mesh.solve.zones.newton import find_equilibrium
from bsm_mesh.solve.zones.plastic_collapse import plastic_collapse
from bsm_mesh.solve.zones.plastic_rock import PlasticCells, PlasticRock, strength_of
from bsm_mesh.solve.zones.reached import reached
from bsm_mesh.solve.zones.shaken_stage import shaken_end
from bsm_mesh.solve.zones.shaking_run import Watch, unwatched
from bsm_mesh.solve.zones.stage_solution import Fall, StageEnd
from bsm_mesh.solve.zones.supports import held_displacements
from bsm_mesh.solve.zones.system import FreeUnknowns, refuse_unsolved
from bsm_mesh.solve.zones.tangents import Tangents
from bsm_mesh.solve.zones.unyielding import yielding_no_further
from bsm_mesh.solve.zones.water_near import StageLoads
from bsm_mesh.solve.zones.zones_state import Part, ZonesMemory, ZonesState

if TYPE_CHECKING:
    from bsm_mesh.solve.stages.scheme import Reporter
    from bsm_mesh.solve.zones.stages import Continuum

MAX_FAILURES = 50  # times that points of joints fail or wear in a part of a stage and the others take over their load
WORN = 1e-6  # of a law's wear length: slip by which two equilibria in turn may differ


class StageRun:
    """The stages of one continuum with one set of elastic constants (t, 3, 3) [Pa], one after the other."""

    def __init__(self, continuum: Continuum, stiffness: FloatArray, limit: float | None = None) -> None:
        self.of, self.stiffness, self.limit = continuum, stiffness, limit
        self.report: Reporter = lambda text: None
        self.rock = RockStiffness(continuum.basis, stiffness)
        model, basis, joints = continuum.model, continuum.basis, continuum.joints
        water = pore_water(model, model.water, basis, joints)
        self.initial_stress = initial_stress(model, continuum.mesh, basis, water)
        history = None if joints is None else initial_history(model, joints, water)
        zero = np.zeros(basis.N)
        bolts = None if continuum.bolts is None else continuum.bolts.install(0, zero)
        none = np.zeros(continuum.loaded[1].N)
        large = continuum.discretization.large
        self.plastic = PlasticCells(model, basis, continuum.mesh.block, stiffness, large=large)
        relief, loads = self.plastic.nothing(), model.acting_loads
        fallen = np.zeros(model.blocks.count, dtype=bool)
        self.state = ZonesState(model, zero, zero, joints, history, bolts, loads, water, none, relief, fallen)
        self._part = Part(INITIAL, fallen, (), self.state)
        self.reactions = zero  # of supports that hold blocks or points between nodes, at the end of the last stage
        self.fall: Fall | None = None  # in the stage
        self.near: FloatArray | None = None  # of blocks at the end of the stage, where its last part is to begin

    @property
    def memory(self) -> ZonesMemory:
        """State variables at the end of a stage."""
        return ZonesMemory.of(self.state, self.reactions)

    def recall(self, memory: ZonesMemory, number: int) -> None:
        """Continue after a stage, by its number, with its memory."""
        of, state = self.of, self.state
        state.recall(memory)
        self.reactions = memory.reactions
        state.model = model_in_stage(of.model, number)
        state.joints = None if state.joints is None else state.joints.with_strength_of(state.model)
        stages = of.model.stages[:number]
        state.loads = (*state.loads, *(load for stage in stages for load in of.model.worked_out(stage.loads)))
        state.water = self._water(water_in_stage(of.model, number))

    def end_of(self, number: int, near: FloatArray | None = None, watch: Watch = unwatched) -> StageEnd:
        """Return the end of a stage; its last part begins near positions (n, 3) [m, m, rad], if any are given.

        `watch` is called at the times of a stage that is shaken.
        """
        of, self.near, there = self.of, near, ~self.state.fallen
        if number == 0:
            return self._first(of.presence[0])
        before, present = (of.presence[each] & there for each in (number - 1, number))
        return self._next(of.model.stages[number - 1], number, before, present, watch)

    def without(self, down: IntArray) -> StageEnd:
        """Return the end of the stage without blocks (k,) that fall, from the begin of the part in which they do."""
        name, present, parts, state = self._part
        self.state = state.without(down)
        return self.solved(name, present & ~self.state.fallen, parts)

    def _first(self, present: BoolArray) -> StageEnd:
        """Return the state before the first stage."""
        self._wet()
        if self.state.bolts is not None:
            self.state.bolts = self.state.bolts.without(~present)
        end = self.solved(INITIAL, present, (1.0,))
        if self.of.model.in_situ is not None:
            self.state.origin = self.state.u
        return end

    def _next(self, stage: Stage, number: int, before: BoolArray, present: BoolArray, watch: Watch) -> StageEnd:
        """Return the end of a stage: the excavation's forces are those out of balance without the rock that leaves."""
        state, of = self.state, self.of
        stays = before & present
        equations = self.equations(stays, self.loads_on(stays))
        old = equations.at(state.u, equations.free.none)
        excavation = old.residual - state.held_back(0.0) - self.reactions
        state.unreleased.append((equations.free.on_free(excavation), 0.0))  # supports hold the rest
        state.model = model_in_stage(of.model, number)
        if state.joints is not None:
            state.joints = state.joints.with_strength_of(state.model)
        if (present & ~before).any():
            put_back(self, stays, present & ~before)
        if state.bolts is not None:
            state.bolts = state.bolts.install(number, state.u).without(~present)
        if stage.pressure:
            leaves = before & ~of.as_planned[number]
            state.pressures = state.pressures + pressure_on_new_faces(*of.loaded, stays, leaves, stage.pressure)
        state.loads = (*state.loads, *of.model.worked_out(stage.loads))
        if stage.water is not None:
            state.water = self._water(stage.water)
            self._wet()
        if stage.shaking is not None:
            return shaken_end(self, stage.name, stage.shaking, present, watch)
        return self.solved(stage.name, present, tuple(stage.relaxation))

    def _water(self, water: Water | None) -> PoreWater | None:
        return pore_water(self.of.model, water, self.of.basis, self.state.joints, self._where)

    @property
    def _where(self) -> FloatArray | None:
        """Displacements that count for the water, (N,) [m]; None: small ones."""
        return self.state.u if self.of.discretization.large else None

    def _wet(self) -> None:
        """Put the joints' own pressure of water into them; in large displacement they have none."""
        state, joints = self.state, self.state.joints
        if joints is not None and state.history is not None and state.water is not None and self._where is None:
            state.history = replace(state.history, water=joints.lumped(state.water.beyond_table))

    def solved(self, name: str, present: BoolArray, parts: tuple[float, ...]) -> StageEnd:
        """Return the equilibrium of a stage after every released part of excavation forces, or the first failure."""
        state, of, self.fall = self.state, self.of, None
        loads = self.loads_on(present)
        equations = self.equations(present, loads)
        held, collapse, astray = equations.free.supports, None, None
        for number, part in enumerate(parts):
            self._part = Part(name, present, parts[number:], replace(state))
            held_back = state.held_back(part)
            equations = replace(equations, load=equations.load - held_back)
            at, converged = equations.at(state.u, equations.free.none), False
            apart = loose(self.of, equations, at, present)
            if apart and equations.large is None:
                break
            if self.near is not None and part == parts[-1]:
                state.u = moved_with_blocks(of.model.blocks, of.mesh, of.basis, self.near)
                equations = broken_at(equations, state.u)
            begun, start = equations, state.u
            equations, at, converged = self._moved(equations, at, present)
            apart = [] if converged or self.fall else loose(self.of, equations, at, present)
            if not converged and self.fall is None:
                collapse, astray = plastic_collapse(equations, at, start), at.u - start
                equations, at = last_known(begun, equations, at, state.u, start, collapses=collapse is not None)
            equations = replace(equations, load=equations.load + held_back)
            state.u, state.joints, state.history = at.u, equations.joints, equations.history
            state.bolts = equations.bolts
            if equations.plastic is not None:
                state.relief = equations.plastic.relief
            if not converged:
                break
        self.reactions = held.rows.T @ at.multipliers
        if equations.plastic is not None and at.plastic is not None and not converged:
            equations = replace(equations, plastic=equations.plastic.after(at.plastic))  # not stresses of elastic rock
        if state.water is not None and of.discretization.large:
            state.water, loads = self._water(state.water.load.water), self.loads_on(present)
        end = self.end_at(name, present, equations, at, loads, converged)
        end = replace(end, loose=apart, fall=self.fall, collapse=collapse, astray=astray, held_back=held_back)
        return replace(end, leaves=converged and equations.leaves(at))

    def end_at(
        self, name: str, present: BoolArray, equations: Equations, at: Iterate, loads: StageLoads, converged: bool
    ) -> StageEnd:
        """Return the state at displacements and forces `at`, with nothing held back."""
        state = self.state
        return StageEnd(
            name=name,
            converged=converged,
            present=present,
            u=at.u,
            origin=state.origin,
            fills=state.fills,
            at=at,
            bolts=equations.bolts,
            loose=[],
            collapse=None,
            stiffness=self.stiffness,
            initial_stress=self.initial_stress,
            water=state.water,
            load=loads.forces,
            held_back=np.zeros_like(at.u),
            acting=state.loads,
            pressures=state.pressures,
            history=equations.history,
            model=state.model,
            rock=self.rock,
            plastic=equations.plastic,
            large=yielding_no_further(equations).large,
            joints=equations.joints,
            leaves=False,
            unknowns=equations.free.free.size,
            solutions=equations.free.solutions,
        )

    def _moved(self, equations: Equations, at: Iterate, present: BoolArray) -> tuple[Equations, Iterate, bool]:
        """Return equilibrium after the steps in which supports move; parameters as at the start."""
        state, converged = self.state, False
        for moved in steps(equations, state.u):
            state.u = carried(equations, state.u) if moved else state.u
            equations, at, converged = reached(self, equations, present)
            if not converged:
                break
            state.u = at.u
        return equations, at, converged

    def settled(self, equations: Equations, present: BoolArray) -> tuple[Equations, Iterate, bool]:
        """Return equilibrium once no more points of joints fail or wear, and the equations with the kept part of it.

        Where failing takes force away the others take it over from where they are then, as blocks do from step to step.
        """
        start = equations.history
        for _ in range(MAX_FAILURES):
            at, converged = find_equilibrium(equations, self.state.u, self.report)
            if equations.are_linear:
                refuse_unsolved(at.size)
                converged = True
            history = equations.history
            joints = equations.joints
            if not converged:
                break
            if (further := slid_on(equations, at.u, present, self.state.u)) is not None:
                self.state.u, equations = at.u, further
                start = slip_begun(start, further)
                at = equations.at(at.u, equations.free.none)
                if loose(self.of, equations, at, present):
                    return equations, at, False
                continue
            if (wetter := wetted(self, equations, at.u, present)) is not None:
                self.state.u, equations = at.u, wetter
                continue
            if history is None or start is None or joints is None or at.state is None:
                equations = equations.after(at, None)
                break
            path = slip_path_after(start, at.state)
            wears = np.abs(path - history.slip_path) > WORN * joints.wear_length
            if (at.state.failed == history.failed).all() and not wears.any():
                known = np.isfinite(joints.wear_length)  # their strength is that after the slip which is remembered
                equations = equations.after(at, np.where(known, history.slip_path, path))
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

    def loads_on(self, present: BoolArray) -> StageLoads:
        """Return weights, loads and water on the rock that is there."""
        state, (mesh, basis, _) = self.state, self.of.loaded
        loads = load_vector(state.model, mesh, basis, state.loads, present) + state.pressures
        if state.water is None:
            return StageLoads(loads)
        if (near := water_near(self, state.u, present)) is not None:
            return StageLoads(loads + near.on_blocks, near)
        water = seepage_forces(state.water, present, mesh, basis)
        if self.of.apart is not None:
            water = water + self.of.apart.left_of_water(state.water, water, state.history, present)
        return StageLoads(loads + water)

    def equations(self, present: BoolArray, loads: StageLoads, quiet: Sequence[str] = ()) -> Equations:
        """Return the equations of the rock that is there under loads, as `loads_on` returns them.

        Supports of `quiet` boundaries are left out.
        """
        of, state = self.of, self.state
        history, on = state.history, present[of.mesh.block]
        load = of.merged(loads.forces)
        virgin = on.copy()
        for fill in state.fills:
            filled = on & fill.blocks[of.mesh.block]
            load = load + self.rock.of(filled) @ fill.u
            virgin &= ~filled
        large = of.discretization.large
        if self.initial_stress is not None and not large:
            load = load - forces_of_stress(of.basis, self.initial_stress * virgin[:, None])
        supports = [support for support in of.model.supports if getattr(support, "boundary", None) not in quiet]
        held = held_displacements(supports, of.model.blocks, of.mesh, of.basis, of.averages, present)
        idle = np.ones(of.basis.N, dtype=bool)
        idle[of.basis.element_dofs[:, on]] = False
        if state.joints is not None and history is not None:
            first, second = state.joints.block.T
            history = replace(history, present=present[first] & present[second] & ~state.joints.over)
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
            large=self._large(on, free) if large else None,
            water=loads.water,
        )

    def _large(self, on: BoolArray, free: FreeUnknowns) -> LargeBlocks:
        """Return the rock of cells that are there (t,) in large displacement."""
        of = self.of
        rock = LargeRock.of(of.basis, self.stiffness, on, self.initial_stress)
        return LargeBlocks.of(rock, of.basis, on, free)

    def _plastic(self, present: BoolArray, virgin: BoolArray) -> PlasticRock | None:
        """Return the rock that yields; its cells that are `virgin` (t,) have the in-situ stress."""
        of, state = self.plastic, self.state
        if not len(of.cells):
            return None
        initial = of.nothing()
        without_stress = np.zeros((*initial.shape[:2], 3))
        if self.initial_stress is not None:
            xx, yy, xy = self.initial_stress[:, of.cells] * virgin[of.cells, None]
            initial = np.stack([xx, yy, xy, xx], axis=-1)  # as much across the plane as along it
        for fill in state.fills:
            without_stress += of.strains(of.at_nodes(fill.u))[0] * fill.blocks[of.block][:, None, None]
        return PlasticRock(
            of=of,
            strength=strength_of(state.model, of),
            there=present[of.block],
            initial=initial,
            without_stress=without_stress,
            relief=state.relief,
        )
