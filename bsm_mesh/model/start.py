"""Faults of a model that prevent a run, from the input alone; a run refuses them, and so does ``bsm-mesh check``."""

from __future__ import annotations

from bsm_mesh.model.loading import faults_of_loading
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of


def start_faults(model: Model) -> list[str]:
    """Return a sentence for everything that forbids a start, whatever the scheme."""
    return [*_unsupported(model), *faults_of_loading(model), *model.blocks.overlaps.faults()]


def _unsupported(model: Model) -> list[str]:
    """Return a sentence where all of the model would fall: a forgotten line, no collapse."""
    if len(bars_of(model.supports, model.blocks).block):
        return []
    return [
        "the model is free to move in any direction: no support holds it; hold a boundary, some blocks or a point: "
        '[[support]] boundary = "...", fix = "all" in a model file, supports=[bsm.Fixed(boundary="...")] in Python'
    ]
