"""Mechanics of polyhedra in space, as the shared loop and scheme ask for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.fitted_fill import are_supported, fitted_fill
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.stages.scheme import Outcome
from bsm_mesh.solve.step.system import System
from bsm_mesh.three_d.contacts.history import PointHistory
from bsm_mesh.three_d.in_situ import in_situ_history
from bsm_mesh.three_d.motion.explicit import ExplicitMotion
from bsm_mesh.three_d.record import outcome_of
from bsm_mesh.three_d.step.block_system import BlockSystem


class Space:
    """Mechanics of polyhedra, as `Mechanics` asks for them."""

    def system(self, model: Model, bolts: InstalledBolts | None, position: FloatArray | None) -> BlockSystem:
        """Return the block system of a model."""
        system = BlockSystem(model, bolts, position)
        system.in_motion = ExplicitMotion
        return system

    def no_history(self) -> PointHistory:
        """Return the empty contact history of the start."""
        return PointHistory.none()

    def in_situ_history(self, model: Model) -> tuple[PointHistory, tuple[str, ...]]:
        """Return contact points with the forces of the in-situ field, and notes on it."""
        return in_situ_history(model)

    def between(self, history: PointHistory, stays: BoolArray) -> PointHistory:
        """Return the history of contacts between blocks that stay, (n,)."""
        return history.some(np.flatnonzero(stays[history.block_a] & stays[history.block_b]))

    def in_part(self, history: PointHistory, part: SubModel) -> PointHistory:
        """Return the history in the numbers of a submodel; its blocks must be in the part."""
        if part.present.all():
            return history
        number, face = np.cumsum(part.present, dtype=np.int32) - 1, np.zeros(part.corner.max() + 1, np.int32)
        face[part.corner] = np.arange(len(part.corner))
        return history.renumbered(face, number)

    def in_whole(self, history: PointHistory, part: SubModel) -> PointHistory:
        """Return the history of a submodel in the numbers of the whole."""
        if part.present.all():
            return history
        return history.renumbered(part.corner, part.block)

    def with_filled_blocks(
        self, history: PointHistory, model: Model, comes: BoolArray, present: BoolArray, moved: FloatArray
    ) -> tuple[PointHistory, FloatArray]:
        """Return the history with points of filled blocks (n,), without force, and movements with theirs."""
        system = BlockSystem(model)
        found = system.gather(PointHistory.none(), system.start, first=True)
        c = found.candidates
        new = (comes[c.block_a] & present[c.block_b]) | (comes[c.block_b] & present[c.block_a])
        found = found.some(np.flatnonzero(found.within_tolerance & new), np.arange(len(moved), dtype=np.int32))
        c = found.candidates
        point = system.centroid[c.block_a] + found.geometry[:, :3]
        fill = comes & ~are_supported(model)
        moved = fitted_fill(moved, fill, (c.block_a, c.block_b), point, c.length, system.centroid)
        _, place, *_ = found.frames(moved)
        found = replace(found, failed=np.isfinite(found.tension))
        return history.with_more(found.closed_history(place, np.zeros_like(place), found.gaps(place))), moved

    def outcome(
        self, system: System, motion: Motion, origin: FloatArray, bars_before: FloatArray, bolts: BoltForces
    ) -> Outcome:
        """Return the record of a stage's end; displacements count from `origin` (n, 6)."""
        assert isinstance(system, BlockSystem)
        return outcome_of(system, motion, origin, bars_before, bolts)
