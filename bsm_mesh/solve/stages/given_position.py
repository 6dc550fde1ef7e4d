"""Blocks that are at rest only after they moved: limit analysis proves that they cannot rest where they were given."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.errors import counted, numbered, place
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.movements import distances, in_mechanism
from bsm_mesh.results.evidence import Evidence, Proof
from bsm_mesh.results.records import ContactForces, StageResult


def notes_on_given_position(model: Model, stage: StageResult, prove: Callable[[IntArray], Proof]) -> Iterator[str]:
    """Return sentences on blocks at rest that limit analysis proves to be in no equilibrium where they were given.

    `prove` asks it about blocks (k,). It is asked where a block moved by more than the tolerance of contacts. It is
    also asked where contacts slipped and contacts outside of the joints carry force without a limit. Elsewhere the
    forces found balance the loads in the given position too.
    """
    evidence = stage.evidence
    if evidence is None or not stage.status.is_stable or in_space(model.blocks):
        return
    limitless, moved = _limitless(stage.contacts, evidence), distances(stage.stage_displacement)
    far = moved > CONTACT_TOLERANCE * model.blocks.moments.size
    if not far.any() and not (limitless.any() and evidence.slip_path.any()):
        return
    witness = prove(np.flatnonzero(stage.present).astype(np.int32)).witness
    if witness is None:
        return
    moves = in_mechanism(witness.velocity, model.blocks.moments.gyration) & stage.counts
    if moves.any():
        yield (
            f"limit analysis proves that {numbered('block', np.flatnonzero(moves))} cannot be at rest where given; "
            f"before rest came a movement of up to {moved[moves].max():.3g} m. "
            f"{_carried(stage.contacts, limitless, moves)}If that movement is a failure, the rock as given is "
            "unstable. bsm-mesh limit shows the mechanism; bsm-mesh limit --strength bounds the factor of safety"
        )


def _limitless(contacts: ContactForces, evidence: Evidence) -> BoolArray:
    """Return which contacts (m,) outside of the joints carry force and have no limit of shear strength.

    A block that moved onto a free face has one without tensile strength, and is held there whatever the slope.
    """
    elastic = np.array([law["kind"] == "elastic" for law in evidence.laws], dtype=bool)
    limitless: BoolArray = (contacts.joint < 0) & (contacts.normal_force != 0)
    return limitless & elastic[evidence.law] if len(limitless) else limitless


def _carried(contacts: ContactForces, limitless: BoolArray, moves: BoolArray) -> str:
    """Return a sentence on the contacts without a limit (m,) that hold moving blocks (n,), and a space behind it."""
    holding = np.flatnonzero(limitless & (moves[contacts.block_a] | moves[contacts.block_b]))
    if not holding.size:
        return ""
    length = contacts.length[holding]
    pressure, shear = -contacts.normal_force[holding] / length, np.abs(contacts.shear_force[holding]) / length
    k = int(pressure.argmax())
    one, other = sorted((int(contacts.block_a[holding[k]]), int(contacts.block_b[holding[k]])))
    return (
        f"{counted(holding.size, 'contact')} outside of the joints {'holds' if holding.size == 1 else 'hold'} them "
        f"without a limit of strength. The most stressed, between blocks {one} and {other} at "
        f"{place(contacts.point[holding[k]])}, carries {pressure[k] / 1e6:.3g} MPa of pressure and "
        f"{shear[k] / 1e6:.3g} MPa of shear over {length[k]:.3g} m. Compare that with the strength of the "
        "rock, or give these faces a joint (default_joint). "
    )
