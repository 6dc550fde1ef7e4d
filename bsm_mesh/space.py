"""What models, results and the solver hand polyhedra to: rooms of `bsm_mesh.three_d`, by the kind of blocks.

The one place where the plane's and the shared rooms name those of space (`tests/test_architecture.py`); imported when
first asked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bsm_mesh.lazy import names_from

if TYPE_CHECKING:
    from bsm_mesh.three_d.blocks.cell_sides import polyhedra_at
    from bsm_mesh.three_d.bolts.geometry import SpaceBolts
    from bsm_mesh.three_d.check import check_stage
    from bsm_mesh.three_d.contacts.history import PointHistory, PolygonPoints
    from bsm_mesh.three_d.joint_polygons import joint_polygons
    from bsm_mesh.three_d.limit.of_model import SpaceLimit, limit_in_space, strength_in_space
    from bsm_mesh.three_d.mechanics import Space
    from bsm_mesh.three_d.model.bolts import pass_polyhedra
    from bsm_mesh.three_d.model.given import faults_in_space
    from bsm_mesh.three_d.model.loads import forces_in_space, in_situ_forces
    from bsm_mesh.three_d.model.notes import notes_in_space
    from bsm_mesh.three_d.model.parts import some_polyhedra
    from bsm_mesh.three_d.model.supports import bars_in_space
    from bsm_mesh.three_d.proof import proof_in_space
    from bsm_mesh.three_d.readiness import refuse_unready
    from bsm_mesh.three_d.step.block_system import BlockSystem

__all__ = [
    "BlockSystem",
    "PointHistory",
    "PolygonPoints",
    "Space",
    "SpaceBolts",
    "SpaceLimit",
    "bars_in_space",
    "check_stage",
    "faults_in_space",
    "forces_in_space",
    "in_situ_forces",
    "joint_polygons",
    "limit_in_space",
    "notes_in_space",
    "pass_polyhedra",
    "polyhedra_at",
    "proof_in_space",
    "refuse_unready",
    "some_polyhedra",
    "strength_in_space",
]

HOMES = {
    "BlockSystem": "bsm_mesh.three_d.step.block_system",
    "SpaceLimit": "bsm_mesh.three_d.limit.of_model",
    "PointHistory": "bsm_mesh.three_d.contacts.history",
    "PolygonPoints": "bsm_mesh.three_d.contacts.history",
    "Space": "bsm_mesh.three_d.mechanics",
    "SpaceBolts": "bsm_mesh.three_d.bolts.geometry",
    "bars_in_space": "bsm_mesh.three_d.model.supports",
    "check_stage": "bsm_mesh.three_d.check",
    "faults_in_space": "bsm_mesh.three_d.model.given",
    "forces_in_space": "bsm_mesh.three_d.model.loads",
    "in_situ_forces": "bsm_mesh.three_d.model.loads",
    "joint_polygons": "bsm_mesh.three_d.joint_polygons",
    "limit_in_space": "bsm_mesh.three_d.limit.of_model",
    "notes_in_space": "bsm_mesh.three_d.model.notes",
    "pass_polyhedra": "bsm_mesh.three_d.model.bolts",
    "polyhedra_at": "bsm_mesh.three_d.blocks.cell_sides",
    "proof_in_space": "bsm_mesh.three_d.proof",
    "refuse_unready": "bsm_mesh.three_d.readiness",
    "some_polyhedra": "bsm_mesh.three_d.model.parts",
    "strength_in_space": "bsm_mesh.three_d.limit.of_model",
}

if not TYPE_CHECKING:
    __getattr__ = names_from(HOMES, __name__)
