"""Proof by limit analysis with friction cones that polyhedra must move, in words."""

from __future__ import annotations

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model
from bsm_mesh.results.evidence import Proof
from bsm_mesh.three_d.limit.of_model import ModelProgram

MAX_POINTS = 20_000  # that a conic program in a run has: it takes seconds, as the run does


def proof_in_space(model: Model) -> Proof:
    """Return whether forces within strength balance a model's loads where its blocks were given."""
    try:
        found = ModelProgram.of(model, MAX_POINTS).analyse()
    except (ModelError, np.linalg.LinAlgError, MemoryError) as error:
        return Proof(text=f"no proof: {str(error) or 'not enough memory'}")
    if found.admissible:
        return Proof(text="no proof: forces within strength exist that balance the loads, which proves nothing")
    return Proof(text=str(found))
