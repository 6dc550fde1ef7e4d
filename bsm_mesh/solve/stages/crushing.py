"""Contacts whose pressure would crush the walls of their joint: reported, not limited."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bsm_mesh.errors import counted, place
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import StageResult


def notes_on_crushing(model: Model, stage: StageResult) -> Iterator[str]:
    """Return a sentence on every joint with a crushing strength that contacts' effective stresses exceed."""
    c = stage.contacts
    stress = np.maximum(-c.normal_force, 0.0) / np.maximum(c.length, np.finfo(float).tiny)
    for number, joint in enumerate(model.joints):
        mine = c.joint == number
        crushed = np.flatnonzero(mine & (stress > (joint.crushing_strength or np.inf)))
        if not crushed.size:
            continue
        worst = crushed[int(np.argmax(stress[crushed]))]
        yield (
            f"joint '{joint.name}': {crushed.size} of {counted(int(mine.sum()), 'contact')} press with more than its "
            f"crushing_strength = {joint.crushing_strength:g} Pa (the most, {stress[worst]:.3g} Pa, at "
            f"{place(c.point[worst])}): walls are crushed there, which moves no block here"
        )
