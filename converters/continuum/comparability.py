"""Whether a stage of the Block-Spring Model may be compared with a continuum at all, and why not."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.model import Model
from bsm_mesh.results.joint_faces import AT_STRENGTH
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult, Status
from bsm_mesh.results.results import Results
from bsm_mesh.solve.zones.small_displacements import moved_far
from bsm_mesh.solve.zones.solution import ContinuumSolution

NEW_FORCES = 1e-3  # of all contact forces, between blocks that did not touch at first
MET = 0.01  # of the mean contact force: what a corner bears less that met another block's at a node of the mesh
BROKEN = 1e-3  # of the length of faces without a joint: what breaks less is whole rock
MAY_MOVE_FAR = ("linear",)  # schemes whose displacements are small by definition


class Comparability(StrEnum):
    """Classes of comparison of a stage."""

    COMPARABLE = "comparable"
    WITH_INTERFACES = "with interfaces"
    NOT_COMPARABLE = "not comparable"


def obstacle(model: Model, results: Results, stage: StageResult) -> str:
    """Return why a stage of a run cannot be compared with a continuum of small displacements; empty if it can.

    Parameters
    ----------
    model : Model
        The model that was run.
    results : Results
        Its results.
    stage : StageResult
        One of its stages.
    """
    if stage.status not in (Status.STABLE, Status.NO_VERDICT):
        what = {
            Status.UNSTABLE: "blocks fall",
            Status.STABLE_AFTER_FALLS: "blocks fell and were taken away",
        }.get(stage.status, "the blocks' solution did not converge")
        return f"{what}: there is no state of rest to compare"
    far = moved_far(model, stage.displacement + stage.origin, stage.counts)
    if far and results.scheme not in MAY_MOVE_FAR:
        return f"block {far}"
    return _new_contacts(model, stage.contacts)


def _new_contacts(model: Model, contacts: ContactForces) -> str:
    """Return a sentence where blocks press on each other that did not touch at first, not even at a corner."""
    a, b = contacts.block_a, contacts.block_b
    new = ~_touching(model.blocks, a, b)
    size = np.hypot(contacts.normal_force, contacts.shear_force)
    if not size[new].sum() > NEW_FORCES * size.sum():
        return ""
    worst = int(np.where(new, size, -1.0).argmax())
    one, other = sorted((int(a[worst]), int(b[worst])))
    return f"gaps close: blocks {one} and {other} press on each other and did not touch at first"


def corners_met(model: Model, contacts: ContactForces) -> str:
    """Return what corners bear that slid past a node of the mesh, in words; empty where they bear next to nothing.

    Blocks about a node that have no face in common press on each other once they have moved. Small displacements have
    no such contacts, and elements no interface there.
    """
    a, b = contacts.block_a, contacts.block_b
    size = np.hypot(contacts.normal_force, contacts.shear_force)
    bears = size > 0
    met = bears & ~_have_a_face(model.blocks, a, b)
    if not met.any() or size[met].max() <= MET * size[bears].mean():
        return ""
    one = met.sum() == 1
    corners = "a corner that met another carries" if one else f"{met.sum()} corners that met others carry up to"
    force = float(f"{size[met].max() / 1e3:.3g}")
    return f"{corners} {force:g} kN/m in the blocks, and nothing in the elements"


def _have_a_face(blocks: Blocks, a: IntArray, b: IntArray) -> BoolArray:
    """Return which pairs of blocks (k,) have a face in common."""
    faces, owner = find_faces(blocks), blocks.owner
    known: BoolArray = np.isin(_key(blocks, a, b), _key(blocks, owner[faces.edge_a], owner[faces.edge_b]))
    return known


def _key(blocks: Blocks, one: IntArray, other: IntArray) -> IntArray:
    """Return one number for every pair of blocks (k,), in either order."""
    return np.minimum(one, other).astype(np.int64) * blocks.count + np.maximum(one, other)


def _touching(blocks: Blocks, a: IntArray, b: IntArray) -> BoolArray:
    """Return which pairs of blocks (k,) have a face or a corner in common."""
    owner, count = blocks.owner, blocks.count
    corners = sp.csr_matrix(
        (np.ones(len(owner), np.int8), (owner, blocks.nodes)), shape=(count, blocks.nodes.max() + 1)
    )
    shared = np.asarray(corners[a].multiply(corners[b]).sum(axis=1)).ravel() > 0
    touching: BoolArray = shared | _have_a_face(blocks, a, b)
    return touching


def has_joints(model: Model) -> bool:
    """Whether faces of the blocks have joints."""
    return bool((face_joints(model, find_faces(model.blocks)) >= 0).any())


def rock_breaks(contacts: ContactForces) -> bool:
    """Whether faces without a joint slip or part, over more than a negligible length."""
    length = contacts.length * (contacts.joint < 0)
    broken = float((length * (contacts.status != ContactStatus.STICKING)).sum())
    return broken > BROKEN * float(length.sum())


def continuum_obstacle(model: Model, stages: tuple[ContinuumSolution, ...], number: int, may_move_far: bool) -> str:
    """Return why the continuum's side of a stage cannot be compared; empty if it can.

    Parameters
    ----------
    model : Model
        The model that was solved.
    stages : tuple of ContinuumSolution
        As far as the continuum came.
    number : int
        Of the stage.
    may_move_far : bool
        Whether displacements may be as large as they like.
    """
    if number >= len(stages):
        return f"the finite elements found no equilibrium in the stage before, {stages[-1].name}"
    stage = stages[number]
    if not stage.converged:
        return "the finite elements found no equilibrium, which proves nothing"
    if not may_move_far and (far := moved_far(model, stage.displacement, stage.present)):
        return f"in the finite elements block {far}"
    return ""


def slipping_length(contacts: ContactForces, held: BoolArray, whole: float | None = None) -> float:
    """Return the share of the joints' length that slips, or nearly, or is open, but between held blocks (n,).

    Parameters
    ----------
    contacts : ContactForces
        Of blocks, where contacts that are open may be missing, or of a continuum.
    held : (n,) bool
        Blocks with a support.
    whole : float [m]
        Length of all joints; None: that of the contacts.
    """
    length = contacts.length * (contacts.joint >= 0) * ~(held[contacts.block_a] & held[contacts.block_b])
    whole = float(length.sum()) if whole is None else whole
    sticks = (contacts.status == ContactStatus.STICKING) & (contacts.utilisation < AT_STRENGTH)
    sticking = float((length * sticks).sum())
    return max(0.0, 1.0 - sticking / whole) if whole else 0.0


def jointed_length(contacts: ContactForces, held: BoolArray) -> float:
    """Return the length of the joints [m] among a continuum's contacts, but for those between two held blocks (n,)."""
    return float((contacts.length * ~(held[contacts.block_a] & held[contacts.block_b])).sum())
