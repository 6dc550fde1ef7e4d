"""Whether a stage of the Block-Spring Model may be set beside a continuum at all, and why not."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.converters.continuum import departures
from bsm_mesh.converters.continuum.solution import ContinuumSolution
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import ContactForces, ContactStatus, Results, StageResult, Status

MOVED = (
    0.01  # of a block's size: beyond it rotations and new contacts matter, which small displacements know nothing of
)
NEW_FORCES = 1e-3  # of all contact forces, between blocks that did not touch at first
BROKEN = 1e-3  # of the length of faces without a joint, which whole rock does not break on
MAY_MOVE_FAR = ("linear",)  # schemes whose displacements are small by definition


class Comparability(StrEnum):
    """What a stage can be compared with."""

    COMPARABLE = "comparable"
    WITH_INTERFACES = "with interfaces"
    NOT_COMPARABLE = "not comparable"


def obstacle(model: Model, results: Results, stage: StageResult) -> str:
    """Return why a stage of a run cannot be compared with a continuum of small displacements; empty if it can.

    Parameters
    ----------
    model : Model
        What was run.
    results : Results
        What came out.
    stage : StageResult
        One of its stages.
    """
    if faults := departures.missing(model):
        return faults[0]
    if stage.status not in (Status.STABLE, Status.NO_VERDICT):
        what = {
            Status.UNSTABLE: "blocks come down",
            Status.STABLE_AFTER_FALLS: "blocks came down and were taken away",
        }.get(stage.status, "the blocks' solution did not converge")
        return f"{what}: there is no state of rest to compare"
    if results.scheme not in MAY_MOVE_FAR:
        size = np.sqrt(model.blocks.moments.area)
        share = np.hypot(*(stage.displacement + stage.origin)[:, :2].T) / size * stage.present
        if share.max() > MOVED:
            return (
                f"block {int(share.argmax())} moved {100 * share.max():.3g} % of its size, and small displacements "
                f"hold up to {100 * MOVED:g} %"
            )
    return _new_contacts(model, stage.contacts) or _broken_rock(stage.contacts)


def _new_contacts(model: Model, contacts: ContactForces) -> str:
    """Return a sentence where blocks press on each other that did not touch at first."""
    faces, owner, count = find_faces(model.blocks), model.blocks.owner, model.blocks.count

    def key(a: IntArray, b: IntArray) -> IntArray:
        return np.minimum(a, b).astype(np.int64) * count + np.maximum(a, b)

    new = ~np.isin(key(contacts.block_a, contacts.block_b), key(owner[faces.edge_a], owner[faces.edge_b]))
    size = np.hypot(contacts.normal_force, contacts.shear_force)
    if not size[new].sum() > NEW_FORCES * size.sum():
        return ""
    worst = int(np.where(new, size, -1.0).argmax())
    a, b = sorted((int(contacts.block_a[worst]), int(contacts.block_b[worst])))
    return f"gaps close: blocks {a} and {b} press on each other and did not touch at first"


def _broken_rock(contacts: ContactForces) -> str:
    rock = contacts.joint < 0
    length = contacts.length * rock
    broken = float((length * (contacts.status != ContactStatus.STICKING)).sum())
    if not broken > BROKEN * length.sum():
        return ""
    return f"rock breaks: {100 * broken / length.sum():.2g} % of its faces without a joint slip or part"


def has_joints(model: Model) -> bool:
    """Whether faces of the blocks have joints."""
    return bool((face_joints(model, find_faces(model.blocks)) >= 0).any())


def continuum_obstacle(model: Model, stages: tuple[ContinuumSolution, ...], number: int, moved_far: bool) -> str:
    """Return why the continuum's side of a stage cannot be compared; empty if it can.

    Parameters
    ----------
    model : Model
        What was solved.
    stages : tuple of ContinuumSolution
        As far as the continuum came.
    number : int
        Of the stage.
    moved_far : bool
        Whether displacements may be as large as they like.
    """
    if number >= len(stages):
        return f"the finite elements found no equilibrium in the stage before, {stages[-1].name}"
    stage = stages[number]
    if not stage.converged:
        return "the finite elements found no equilibrium, which proves nothing"
    share = np.hypot(*stage.displacement[:, :2].T) / np.sqrt(model.blocks.moments.area)
    if not moved_far and share.max() > MOVED:
        block = int(share.argmax())
        return (
            f"the finite elements move block {block} by {100 * share.max():.3g} % of its size, and small displacements "
            f"hold up to {100 * MOVED:g} %"
        )
    return ""


def slipping_length(contacts: ContactForces, held: BoolArray) -> float:
    """Return the share of the joints' length that slips or is open, but for joints between two held blocks (n,)."""
    length = contacts.length * (contacts.joint >= 0) * ~(held[contacts.block_a] & held[contacts.block_b])
    total = float(length.sum())
    return float((length * (contacts.status != ContactStatus.STICKING)).sum()) / total if total else 0.0
