"""The schemes ``continuation`` and ``wang``: large displacement, joints that slip and open; results where it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bsm_mesh.contact.strength import MOST_UTILISATION
from bsm_mesh.model.model import Model
from bsm_mesh.results.check import OVERLAP, unexplained_overlap
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult, Status, StepRecord
from bsm_mesh.results.stress import block_stress
from bsm_mesh.solve.continuation import Continuation, Motion
from bsm_mesh.solve.linear import Reporter, support_forces
from bsm_mesh.solve.options import Options
from bsm_mesh.solve.wang import WangIteration


def solve_nonlinear(
    model: Model,
    options: Options,
    report: Reporter = lambda text: None,
    observer: Callable[[StepRecord], None] = lambda record: None,
) -> tuple[StageResult, str]:
    """Return the stage ``initial`` at rest or in collapse, and the name of the linear solver used.

    Raises
    ------
    ModelError
        If blocks overlap at the start, or rigid rocks meet without a joint.
    """
    report(options.scheme)
    engine = (WangIteration if options.scheme == "wang" else Continuation)(model, options, observer)
    motion = engine.run()
    report(f"{motion.status.value}: {motion.reason}")
    displacement = motion.position - engine.start
    unbalanced = motion.loads + motion.at.forces
    reactions = motion.constraints.reactions(unbalanced)
    held = motion.constraints.bars.block
    point = motion.position[held, :2] + engine.bar_arms(motion.position)
    supports = support_forces(motion.constraints, reactions, point)
    contacts = _contact_forces(motion)
    loads = engine.point_forces_at(motion.position)
    centroid = motion.position[:, :2]
    acting = (loads, (supports.block, supports.point, supports.reaction))
    stage = StageResult(
        name="initial",
        status=motion.status,
        reason=motion.reason,
        present=np.ones(model.blocks.count, dtype=bool),
        displacement=displacement,
        stage_displacement=displacement,
        stress=block_stress(model.blocks, centroid, contacts, contacts.normal_force, contacts.shear_force, acting),
        loads=motion.loads,
        reactions=reactions,
        contacts=contacts,
        supports=supports,
        unstable_blocks=motion.unstable_blocks,
        residual=motion.residual,
        reference_weight=motion.reference,
        steps=motion.steps,
    )
    return _refuse_overlap(model, stage), motion.linear_solver


def _refuse_overlap(model: Model, stage: StageResult) -> StageResult:
    """Return the stage; at rest with blocks inside each other is no answer, so it counts as not converged."""
    if stage.status is not Status.STABLE or unexplained_overlap(model.blocks, stage) <= OVERLAP:
        return stage
    reason = "forces balance, but blocks have passed into each other (corners that met in a point): not an answer"
    return replace(stage, status=Status.NOT_CONVERGED, reason=reason)


def _contact_forces(motion: Motion) -> ContactForces:
    """Return the contacts that touch at the end."""
    table, at = motion.contacts, motion.at
    kept = np.flatnonzero(at.bearing | table.touching)
    c = table.candidates
    normal = np.stack([at.tangent[:, 1], -at.tangent[:, 0]], axis=1)
    status = np.where(at.sticking, ContactStatus.STICKING, ContactStatus.SLIPPING)
    status = np.where(at.bearing, status, ContactStatus.OPEN)
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.where(at.strength > 0, np.abs(at.shear) / at.strength, 0.0)
    slip = np.where(np.isnan(table.first_along), 0.0, at.along - table.first_along)
    return ContactForces(
        block_a=c.block_a[kept],
        block_b=c.block_b[kept],
        point=(motion.position[c.block_a, :2] + at.arm_a)[kept],
        normal=normal[kept],
        length=c.length[kept],
        normal_force=-at.pressure[kept],
        shear_force=at.shear[kept],
        opening=at.gap[kept],
        slip=slip[kept],
        status=status[kept].astype(np.int8),
        utilisation=np.minimum(used, MOST_UTILISATION)[kept],
        joint=table.properties.joint[kept],
    )
