"""The one-step linear scheme (Wang ch. 3, Fig. 3.15): small displacements, contacts that bear everything."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.strength import utilisation
from bsm_mesh.contact.table import ContactTable, initial_contacts
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import ContactForces, StageResult, Status, StepRecord, SupportForces
from bsm_mesh.results.stress import PointForce, block_stress
from bsm_mesh.solve.bolts import bolt_forces
from bsm_mesh.solve.constraints import Constraints
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.system import LinearSystem, relative_residual

Reporter = Callable[[str], None]


def solve_linear(
    model: Model,
    options: Options,
    report: Reporter = lambda text: None,
    observer: Callable[[StepRecord], None] = lambda record: None,
) -> tuple[StageResult, str]:
    """Return the stage ``initial`` in linear equilibrium, and the name of the linear solver used.

    Parameters
    ----------
    model : Model
        What is given.
    options : Options
        Linear solver and threads.
    report : callable
        Told what is being done, a few words each.

    Raises
    ------
    ModelError
        If a part of the model is free to move, blocks overlap, or rigid rocks meet without a joint.
    """
    began = time.perf_counter()
    report("contacts")
    contacts = initial_contacts(model)
    report("assembly")
    system = LinearSystem(model, contacts)
    system.check_supports()
    stiffness = system.stiffness()
    report("linear solution")
    solution = system.solve(stiffness, options)
    del stiffness
    report("forces and stresses")
    U, normal_force, shear_force = solution.displacement, solution.normal_force, solution.shear_force
    constraints = system.constraints
    reactions = constraints.reactions(solution.unbalanced)
    supports = support_forces(constraints, reactions)
    reference = system.reference_of(solution)
    residual = relative_residual(model, solution.unbalanced + reactions, reference)
    converged = residual <= options.tolerance
    forces = point_forces_of(model.loads, model.blocks)
    bolts = bolt_forces(model.bolts, system.bolts, solution.bolts)
    acting: tuple[PointForce, ...] = (
        (forces.block, forces.point, forces.force),
        bolts.on_blocks(),
        (supports.block, supports.point, supports.reaction),
    )
    step = StepRecord(
        stage=0,
        step=0,
        residual=residual,
        max_displacement=float(np.hypot(U[:, 0], U[:, 1]).max()),
        newton_iterations=1,
        factorizations=solution.factorizations,
        open_contacts=0,
        slipping_contacts=0,
        seconds=time.perf_counter() - began,
    )
    observer(step)
    stage = StageResult(
        name="initial",
        status=Status.STABLE if converged else Status.NOT_CONVERGED,
        reason="one linear step: no contact can fail" if converged else "rounding spoils the linear solution",
        present=np.ones(model.blocks.count, dtype=bool),
        displacement=U,
        stage_displacement=U,
        stress=block_stress(model.blocks, model.blocks.moments.centroid, contacts, normal_force, shear_force, acting),
        loads=system.loads,
        reactions=reactions,
        contacts=_contact_forces(model, contacts, normal_force, shear_force),
        supports=supports,
        bolts=bolts,
        unstable_blocks=np.zeros(0, dtype=np.int32),
        residual=residual,
        reference_weight=reference,
        steps=(step,),
    )
    return stage, solution.linear_solver


def support_forces(constraints: Constraints, reactions: FloatArray, point: FloatArray | None = None) -> SupportForces:
    """Return the bars' forces, those at the same point of the same block added up; `point` is where they are now."""
    bars = constraints.bars
    point = bars.point if point is None else point
    size = constraints.bar_forces(reactions)
    key = np.column_stack([bars.block, bars.point])
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    place = place.reshape(-1)
    force, moment = np.zeros((len(first), 2)), np.zeros(len(first))
    np.add.at(force, place, size[:, None] * bars.direction)
    np.add.at(moment, place, size * bars.holds_rotation)
    return SupportForces(block=bars.block[first], point=point[first], reaction=force, moment=moment)


def _contact_forces(
    model: Model, contacts: ContactTable, normal_force: FloatArray, shear_force: FloatArray
) -> ContactForces:
    return ContactForces(
        block_a=contacts.block_a,
        block_b=contacts.block_b,
        point=contacts.point,
        normal=contacts.normal,
        length=contacts.length,
        normal_force=normal_force,
        shear_force=shear_force,
        opening=normal_force / contacts.normal_stiffness,
        slip=shear_force / contacts.shear_stiffness,
        status=np.zeros(contacts.count, dtype=np.int8),
        utilisation=utilisation(model, contacts, normal_force, shear_force),
        joint=contacts.joint,
    )
