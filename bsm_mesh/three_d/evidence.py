"""The evidence for a verdict in space: strength, stiffness and supports where the blocks have come to."""

from __future__ import annotations

from bsm_mesh.arrays import IntArray
from bsm_mesh.results.evidence import Evidence
from bsm_mesh.solve.continuation.evidence import rows_of
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.three_d.contacts.forces import elastic_contacts
from bsm_mesh.three_d.step.block_system import BlockSystem


def evidence_of(system: BlockSystem, motion: Motion, kept: IntArray) -> Evidence:
    """Return the evidence at the end of a run, for the contact points `kept` (k,) of its contact set."""
    table, at, model = motion.contacts, motion.at, system.model
    block, point, force = system.point_forces_at(motion.position)
    return Evidence(
        **rows_of(system, motion, kept),
        shear_stiffness=table.shear_stiffness[kept],
        near=(elastic_contacts(table, at, system.size) & ~at.closed)[kept],
        weight=model.gravity_forces,
        unit_weight=model.unit_weights,
        gravity=model.gravity_vector,
        load_block=block,
        load_point=point,
        load_force=force,
        **system.water.recorded(),
    )
