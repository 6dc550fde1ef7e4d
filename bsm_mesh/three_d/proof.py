"""What limit analysis with friction cones says of polyhedra that come down, in words."""

from __future__ import annotations

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.results.evidence import Proof
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.limit.analysis import LimitAnalysis3D
from bsm_mesh.three_d.limit.strength import cone_strength
from bsm_mesh.three_d.step.block_system import BlockSystem

MAX_POINTS = 20_000  # that a conic program in a run has: it takes seconds, as the run does


def proof_in_space(model: Model) -> Proof:
    """Return whether forces within strength balance a model's loads where its blocks were given."""
    assert in_space(model.blocks)
    if model.bolts:
        return Proof(text="no proof was sought: limit analysis of polyhedra knows no bolts")
    blocks, system = model.blocks, BlockSystem(model)
    if system.parts_touch:
        return Proof(text="no proof was sought: blocks touch on parts of faces, which limit analysis does not know")
    held = system.prescribed_blocks
    if not held[system.bars.block].all():
        return Proof(text="no proof was sought: limit analysis of polyhedra knows blocks that are fixed or free")
    analysis = LimitAnalysis3D(
        blocks.moments, blocks.contact_polygons, held, "corners" if model.contact_points == "corners" else "both"
    )
    if analysis.points.count > MAX_POINTS:
        return Proof(text=f"no proof was sought: {analysis.points.count} contact points are too many for one in a run")
    try:
        materials = Materials.checked(blocks, model.rocks, model.joints, model.default_joint)
        strength = cone_strength(materials, blocks, analysis.polygons, analysis.points)
        found = analysis.analyse(system.loads, strength)
    except (ModelError, np.linalg.LinAlgError, MemoryError) as error:
        return Proof(text=f"no proof: {str(error) or 'not enough memory'}")
    if found.admissible:
        return Proof(text="no proof: forces within strength exist that balance the loads, which proves nothing")
    return Proof(text=str(found))
