"""The linear scheme (Wang ch. 3, Fig. 3.15): small displacements, contacts of unlimited strength, a step a stage."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.in_situ import beyond_strength, in_situ_contacts
from bsm_mesh.contact.strength import contact_strength, utilisation
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import MAX_NAMED, SingularMatrixError
from bsm_mesh.model.joint_laws import Elastic
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.model.supports import Bars
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.evidence import Evidence, bar_rows, law_table
from bsm_mesh.results.records import ContactForces, StageResult, Status, StepRecord
from bsm_mesh.results.stress import total_and_effective_stress
from bsm_mesh.solve.algebra.loads import given_of, relative_residual
from bsm_mesh.solve.algebra.mechanisms import FreePart
from bsm_mesh.solve.algebra.reactions import bar_forces, support_forces
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.memory import BoltMemory
from bsm_mesh.solve.bolts.record import bolt_forces
from bsm_mesh.solve.bolts.tangent import bolt_tangent
from bsm_mesh.solve.linear.state import LinearState
from bsm_mesh.solve.linear.system import LinearSystem, Solution
from bsm_mesh.solve.stages.new_faces import concatenate
from bsm_mesh.solve.stages.scheme import Observer, Outcome, Reporter


class LinearScheme:
    """The linear scheme over the stages of a model: contact forces continue from one to the next.

    Parameters
    ----------
    model : Model
        The whole.
    options : Options
        Linear solver and threads.
    report : callable
        Called with a short text on progress.
    contacts : ContactTable
        Those of the blocks as they are given.

    Attributes
    ----------
    moved : (n, 3) float64 [m, m, rad]
        Displacement of every block since it was given, or placed.
    bolts : InstalledBolts
        The bolts; `tension` (n_elements,) [N] of their elements, `bolt_shear` (k,) [N] of their crossings.
    linear_solver : str
        Name of the solver used.
    """

    in_rows = True

    def __init__(self, model: Model, options: Options, report: Reporter, contacts: ContactTable) -> None:
        self.model, self.options, self.report, self.contacts = model, options, report, contacts
        m = self.contacts.count
        self.normal_force, self.shear_force = np.zeros(m), np.zeros(m)
        self.opening, self.slip = np.zeros(m), np.zeros(m)
        self.moved = np.zeros((model.blocks.count, 3))
        self.given = np.zeros((model.blocks.count, 3))  # the position of contacts and bolts
        self.bolts = InstalledBolts.of(model, self.given)
        at = self.bolts.evaluate(self.given)
        self.tension, self.bolt_shear = at.tension, at.dowels.force
        self.linear_solver = ""

    @property
    def state(self) -> LinearState:
        """Its state from stage to stage."""
        return LinearState(
            normal_force=self.normal_force.copy(),
            shear_force=self.shear_force.copy(),
            opening=self.opening.copy(),
            slip=self.slip.copy(),
            moved=self.moved.copy(),
            bolts=BoltMemory.of(self.bolts),
            tension=self.tension,
            bolt_shear=self.bolt_shear,
            linear_solver=self.linear_solver,
        )

    def restore(self, state: LinearState) -> None:
        """Go back to a state of the same run."""
        self.normal_force, self.shear_force = state.normal_force.copy(), state.shear_force.copy()
        self.opening, self.slip, self.moved = state.opening.copy(), state.slip.copy(), state.moved.copy()
        self.bolts, self.tension, self.bolt_shear = state.bolts.recalled(self.bolts), state.tension, state.bolt_shear
        self.linear_solver = state.linear_solver

    def set_in_situ(self) -> tuple[str, ...]:
        """Set the contact forces from the in-situ field, and return notes on it."""
        self.normal_force, self.shear_force = in_situ_contacts(self.model, self.contacts)
        return _beyond_strength(self.model, self.contacts, self.normal_force, self.shear_force)

    def stage_bars(self, bars: Bars, number: int) -> Bars:
        """Return the supports for a stage: prescribed displacements belong to the first."""
        return bars if number == 0 else replace(bars, value=np.zeros(len(bars.value)))

    def remove_and_place_blocks(self, stays: BoolArray, comes: BoolArray) -> None:
        """Remove contact forces and cut bolts of blocks that do not stay; placed ones have no contact forces."""
        gone = ~(stays[self.contacts.block_a] & stays[self.contacts.block_b])
        for values in (self.normal_force, self.shear_force, self.opening, self.slip):
            values[gone] = 0.0
        self.bolts = self.bolts.without(~stays)
        self.tension = self.tension * self.bolts.alive
        self.bolt_shear = self.bolt_shear * self.bolts.alive[self.bolts.dowels.element]
        self.moved[~stays] = 0.0

    def install(self, number: int) -> None:
        """Install the bolts of a stage."""
        installed = self.bolts.install(number, self.given)
        fresh = installed.alive & ~self.bolts.alive
        self.tension = np.where(fresh, installed.evaluate(self.given).tension, self.tension)
        self.bolts = installed

    def as_given(self, block: IntArray, point: FloatArray) -> FloatArray:
        """Return the positions in the given geometry of points (k, 2) of blocks (k,): displacements are small."""
        return point

    def solve(
        self,
        part: SubModel,
        number: int,
        bars_before: FloatArray,
        observer: Observer,
        accepted: Callable[[], None],
    ) -> Outcome:
        """Return the submodel in linear equilibrium and keep its contact forces.

        Where a part of it is free to move nothing is solved: a stage has taken its hold away, and it is unstable.
        """
        began = time.perf_counter()
        chosen = np.flatnonzero(part.present[self.contacts.block_a] & part.present[self.contacts.block_b])
        contacts = _contacts_of(part, self.contacts, chosen)
        self.report("assembly")
        forces_before = self.normal_force[chosen], self.shear_force[chosen]
        system = LinearSystem(
            part.model, contacts, *forces_before, self.bolts.in_part(part), (self.tension, self.bolt_shear)
        )
        free = system.free_parts(part.block if number else None)
        idle = [part for part in free if not system.loads[part.blocks].any()]
        free = [part for part in free if system.loads[part.blocks].any()]
        start = system.at_start(self.linear_solver)
        solution, spoilt = (start, "") if free else self._solve(system, idle, start)
        self.report("forces and stresses")
        opened, slipped = system.spring_forces(solution.displacement)
        self.opening[chosen] += opened / contacts.normal_stiffness
        self.slip[chosen] += slipped / contacts.shear_stiffness
        self.normal_force[chosen], self.shear_force[chosen] = solution.normal_force, solution.shear_force
        self.moved[part.block] += solution.displacement
        self.tension, self.bolt_shear = solution.bolts.tension, solution.bolts.dowels.force
        forces = self._contact_forces(part, contacts, chosen)
        bolts = bolt_forces(self.model.bolts, self.bolts, solution.bolts)
        unsolved = (free, spoilt)
        outcome = _outcome(system, start, solution, forces, bolts, bars_before, self.options.tolerance, unsolved, began)
        notes = _beyond_strength(
            part.model,
            contacts,
            solution.normal_force,
            solution.shear_force,
            what="forces are",
            meaning="here nothing slips or opens; scheme = 'continuation' says whether it is stable",
        )
        outcome = replace(outcome, stage=replace(outcome.stage, notes=notes))
        observer(outcome.stage.steps[0], lambda: replace(outcome.stage, displacement=self.moved[part.block]))
        return outcome

    def _solve(self, system: LinearSystem, idle: list[FreePart], start: Solution) -> tuple[Solution, str]:
        """Return the solution; where there is none the start, and why."""
        stiffness = system.stiffness()
        for part in idle:  # unloaded: with any stiffness it stays at rest
            stiffness[system.pattern.diagonal[part.blocks]] += np.eye(3) * float(np.abs(stiffness).max())
        self.report("linear solution")
        try:
            solution = system.solve(stiffness, self.options)
        except SingularMatrixError as error:
            return start, str(error)
        self.linear_solver = solution.linear_solver
        return solution, ""

    def _contact_forces(self, part: SubModel, contacts: ContactTable, chosen: IntArray) -> ContactForces:
        normal_force, shear_force = self.normal_force[chosen], self.shear_force[chosen]
        return ContactForces(
            block_a=contacts.block_a,
            block_b=contacts.block_b,
            point=contacts.point,
            normal=contacts.normal,
            length=contacts.length,
            normal_force=normal_force,
            shear_force=shear_force,
            opening=self.opening[chosen],
            slip=self.slip[chosen],
            status=np.zeros(contacts.count, dtype=np.int8),
            utilisation=utilisation(part.model, contacts, normal_force, shear_force),
            joint=contacts.joint,
            water_pressure=WaterLoad(part.model).pressure(contacts.point, contacts.joint),
        )


def _beyond_strength(
    model: Model, contacts: ContactTable, normal_force: FloatArray, shear_force: FloatArray, **words: str
) -> tuple[str, ...]:
    strength = contact_strength(model, contacts)
    peak = strength.peak(np.maximum(-normal_force, 0.0))
    return beyond_strength(contacts.point, -normal_force, shear_force, peak, strength.tension, **words)


def _contacts_of(part: SubModel, contacts: ContactTable, chosen: IntArray) -> ContactTable:
    """Return rows of the whole's contacts in the part's numbers."""
    if part.present.all():
        return contacts
    columns = {field.name: getattr(contacts, field.name)[chosen] for field in fields(ContactTable)}
    for name, known in (("block_a", part.block), ("block_b", part.block), ("edge", part.corner)):
        columns[name] = np.searchsorted(known, columns[name]).astype(np.int32)
    return ContactTable(**columns)


def _outcome(
    system: LinearSystem,
    start: Solution,
    solution: Solution,
    contacts: ContactForces,
    bolts: BoltForces,
    bars_before: FloatArray,
    tolerance: float,
    unsolved: tuple[list[FreePart], str],
    began: float,
) -> Outcome:
    """Return the result; `unsolved`: the parts that are free to move, or why there is no solution."""
    free, spoilt = unsolved
    model, constraints = system.model, system.constraints
    blocks, bars = model.blocks, constraints.bars
    centroid = blocks.moments.centroid
    reactions = constraints.reactions(solution.residual)
    size = bar_forces(constraints, reactions, bars.point - centroid[bars.block], bars_before)
    supports = support_forces(bars, bars.point, size)
    reference = system.reference_of(solution)
    residual = relative_residual(model, solution.residual + reactions, reference)
    at_start = relative_residual(model, start.residual + constraints.reactions(start.residual), reference)
    status, reason = _verdict(free, spoilt, within_tolerance=residual <= tolerance)
    water = WaterLoad(model)
    stress, effective = total_and_effective_stress(
        blocks,
        centroid,
        contacts,
        (concatenate([point_forces_of(model.acting_loads, blocks), system.bolts.on_blocks(solution.bolts)]), supports),
        water.point_forces(blocks.vertices),
    )
    U = solution.displacement
    stage = StageResult.of_submodel(
        U,
        len(model.joints),
        status=status,
        reason=reason,
        stage_displacement=U,
        stress=stress,
        stress_effective=effective,
        loads=system.loads,
        reactions=reactions,
        water=water.on_blocks(blocks.vertices, centroid),
        **water.recorded(),
        contacts=contacts,
        supports=supports,
        bolts=bolts,
        unstable_blocks=_blocks_of(free),
        start_residual=at_start,
        residual=residual,
        reference_weight=reference,
        steps=(_step_record(solution, residual, began, solved=not free),),
        evidence=_evidence(system, solution),
    )
    return Outcome(stage, size)


def _evidence(system: LinearSystem, solution: Solution) -> Evidence:
    """Return the evidence: in this scheme no contact can fail or open."""
    contacts, bars, model = system.contacts, system.constraints.bars, system.model
    m, nothing = contacts.count, np.zeros(contacts.count, dtype=bool)
    pair, tangent = bolt_tangent(system.bolts, solution.bolts, turning=False)
    return Evidence(
        laws=law_table((Elastic(),)),
        law=np.zeros(m, np.int32),
        failed=nothing,
        slip_path=np.zeros(m),
        tension=np.full(m, np.inf),
        normal_stiffness=contacts.normal_stiffness,
        shear_stiffness=contacts.shear_stiffness,
        near=nothing,
        **given_of(model, WaterLoad(model), point_forces_of(model.acting_loads, model.blocks)),
        bolt_pair=pair,
        bolt_tangent=tangent,
        **bar_rows(bars, bars.point),
    )


def _verdict(free: list[FreePart], spoilt: str, *, within_tolerance: bool) -> tuple[Status, str]:
    """Return the status and its reason; `free`, `spoilt`: parts that are free to move, or why there is no solution."""
    if free:
        return Status.UNSTABLE, "; ".join(part.text for part in free[:MAX_NAMED])
    if spoilt:
        return Status.NOT_CONVERGED, spoilt
    if within_tolerance:
        return Status.NO_VERDICT, "one linear step: nothing can fail in this scheme"
    return Status.NOT_CONVERGED, "rounding spoils the linear solution"


def _blocks_of(free: list[FreePart]) -> IntArray:
    """Return the blocks of all parts, (k,)."""
    return np.sort(np.concatenate([np.zeros(0, np.int32), *(part.blocks for part in free)])).astype(np.int32)


def _step_record(solution: Solution, residual: float, began: float, *, solved: bool) -> StepRecord:
    """Return the record of the one step of a stage."""
    return StepRecord(
        stage=0,
        step=0,
        residual=residual,
        max_displacement=float(np.hypot(*solution.displacement[:, :2].T).max()),
        newton_iterations=int(solved),
        factorizations=solution.factorizations if solved else 0,
        open_contacts=0,
        slipping_contacts=0,
        seconds=time.perf_counter() - began,
        method="linear system",
    )
