"""Mechanics of polygons in the plane: their system and motion, contact histories, and the record of a stage's end."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.history import History
from bsm_mesh.contact.search import corner_positions
from bsm_mesh.contact.stage_transfer import between, in_part, in_situ_history, in_whole, with_filled_blocks
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import ContactForces
from bsm_mesh.results.stress import total_and_effective_stress
from bsm_mesh.solve.algebra.reactions import bar_forces, support_forces
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.continuation.evidence import evidence_of
from bsm_mesh.solve.continuation.record import contact_columns, motion_outcome
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.stages.new_faces import concatenate
from bsm_mesh.solve.stages.scheme import Outcome
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.system import System


class Plane:
    """Mechanics of polygons, as `Mechanics` asks for them."""

    def system(self, model: Model, bolts: InstalledBolts | None, position: FloatArray | None) -> BlockSystem:
        """Return the block system of a model."""
        system = BlockSystem(model, bolts, position)
        system.in_motion = ExplicitMotion
        return system

    def no_history(self) -> History:
        """Return the empty contact history of the start."""
        return History.none()

    def in_situ_history(self, model: Model) -> tuple[History, tuple[str, ...]]:
        """Return the contact history under the in-situ field, and notes on it."""
        return in_situ_history(model)

    def between(self, history: History, stays: BoolArray) -> History:
        """Return the history of contacts between blocks that stay, (n,)."""
        return between(history, stays)

    def in_part(self, history: History, part: SubModel) -> History:
        """Return the history in the numbers of a submodel."""
        return in_part(history, part)

    def in_whole(self, history: History, part: SubModel) -> History:
        """Return the history of a submodel in the numbers of the whole."""
        return in_whole(history, part)

    def with_filled_blocks(
        self, history: History, model: Model, comes: BoolArray, present: BoolArray, moved: FloatArray
    ) -> tuple[History, FloatArray]:
        """Return the history with contacts of filled blocks (n,), without force, and movements with theirs."""
        return with_filled_blocks(history, model, comes, present, moved)

    def outcome(
        self, system: System, motion: Motion, origin: FloatArray, bars_before: FloatArray, bolts: BoltForces
    ) -> Outcome:
        """Return the record of a stage's end; displacements count from `origin` (n, 3)."""
        assert isinstance(system, BlockSystem)
        return _outcome(system, motion, origin, bars_before, bolts)


def _outcome(
    system: BlockSystem, motion: Motion, origin: FloatArray, bars_before: FloatArray, bolts: BoltForces
) -> Outcome:
    model = system.model
    residual = motion.loads + motion.bolts_at.forces + motion.at.forces
    reactions = motion.constraints.reactions(residual)
    bars = motion.constraints.bars
    arm = system.bar_arms(motion.position)
    size = bar_forces(motion.constraints, reactions, arm, bars_before)
    placed = system.outlines.placed(motion.position)
    supports = support_forces(bars, placed[bars.block, :2] + arm, size)
    kept = np.flatnonzero(motion.at.closed | motion.contacts.within_tolerance)
    contacts = _contact_forces(motion, kept, placed, system.water)
    block, point, force = system.point_forces_at(motion.position)
    corners = corner_positions(system.outlines, placed)
    stress, effective = total_and_effective_stress(
        model.blocks,
        placed[:, :2],
        contacts,
        (
            concatenate([PointForces(block=block, point=point, force=force), motion.bolts.on_blocks(motion.bolts_at)]),
            supports,
        ),
        system.water.point_forces(corners),
    )
    return motion_outcome(
        motion,
        origin,
        size,
        len(model.joints),
        stress=stress,
        stress_effective=effective,
        reactions=reactions,
        water=system.water_at(motion.position),
        **system.water.recorded(),
        contacts=contacts,
        supports=supports,
        bolts=bolts,
        evidence=evidence_of(system, motion, kept),
    )


def _contact_forces(motion: Motion, kept: IntArray, placed: FloatArray, water: WaterLoad) -> ContactForces:
    """Return the forces of the contacts `kept` (k,) at the end, of placed blocks (n, 3)."""
    table, at = motion.contacts, motion.at
    tangent, arm_a = (vectors[kept] for vectors in table.frames(at.position)[:2])
    point = placed[table.candidates.block_a[kept], :2] + arm_a
    slip = np.where(np.isnan(table.first_tangential), 0.0, at.tangential - table.first_tangential)
    return ContactForces(
        **contact_columns(motion, kept, np.abs(at.shear)),
        point=point,
        normal=np.stack([tangent[:, 1], -tangent[:, 0]], axis=1),
        shear_force=at.shear[kept],
        slip=slip[kept],
        water_pressure=water.pressure(point, table.joint[kept]),
    )
