"""Collapse of blocks with zones: parts that nothing holds, and mechanisms that limit analysis proves.

Stress within blocks only adds conditions to those of rigid blocks. So where no forces on the faces of rigid blocks
balance the loads within strength, none do in zones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from bsm_mesh.arrays import ROUNDING, FloatArray, IntArray
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.in_stage import present_bolts
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.submodel import SubModel, submodel_of
from bsm_mesh.model.supports import bars_of
from bsm_mesh.movements import angles, distances
from bsm_mesh.results.evidence import OF_SHAKEN, Proof
from bsm_mesh.results.records import StageResult, Status
from bsm_mesh.solve.stages.given_position import notes_on_given_position
from bsm_mesh.solve.stages.scheme import Prover
from bsm_mesh.solve.zones.stage_solution import StageEnd, movement
from bsm_mesh.solve.zones.stages import Continuum
from bsm_mesh.solve.zones.system import refuse_loose

MOVING = 0.25  # of the greatest movement: blocks above it are named, as rigid ones are
MOVES_FIRST = "no forces within strength balance the loads where blocks were given, so they move before any rest"
PROVED = (
    "no equilibrium was found in the zones, and none exists: no forces within strength balance the loads; "
    "displacements are those of the last equilibrium"
)


def falling_blocks(of: Continuum, end: StageEnd) -> IntArray:
    """Return the blocks of parts that nothing holds and loads move, and those that plastic collapse moves, (k,).

    Raises
    ------
    ModelError
        If the model has no support, or loads move none of those parts: any place of them is as good as another.
    """
    if end.fall is not None:
        return end.fall.blocks
    if end.collapse is not None:
        moved = distances(movement(of, end.u - end.origin)) * end.present
        moving: IntArray = np.flatnonzero(moved > MOVING * moved.max()).astype(np.int32)
        return moving
    driven = [part for part in end.loose if part.is_driven]
    if end.loose and not (driven and of.model.supports):
        refuse_loose(end.loose)
    cells = np.concatenate([np.zeros(0, np.int32), *(part.cells for part in driven)]).astype(np.int32)
    return np.unique(of.mesh.block[cells])


def with_proof(of: Continuum, end: StageEnd, stage: StageResult, number: int, prove: Prover) -> StageResult:
    """Return a stage that is not at rest with what limit analysis says: where that proves a collapse, it is unstable.

    In large displacement blocks may rest elsewhere, so that the proof is none.

    Parameters
    ----------
    of : Continuum
        The cells.
    end : StageEnd
        The end of the stage.
    stage : StageResult
        Its result.
    number : int
        Of the stage.
    prove : callable
        Says whether forces within strength balance the loads of a model, of which some blocks fall.
    """
    if stage.status is Status.STABLE:
        return stage
    down = stage.unstable_blocks
    if not down.size:
        moved = stage.displacement if end.astray is None else movement(of, end.astray)
        down = np.array([np.where(end.present, distances(moved), -1.0).argmax()])
    proof = _asked(of, end, stage, number, prove, down)
    if proof.witness is None:
        return replace(stage, proof=proof) if stage.status is Status.UNSTABLE else stage
    if stage.status is not Status.UNSTABLE and end.large is not None:  # it says nothing of blocks that moved
        return replace(stage, reason=f"{stage.reason}; {MOVES_FIRST}")
    if stage.status is not Status.UNSTABLE:
        named = _moving(proof.witness.velocity, of.model.blocks.moments.gyration)
        stage = replace(stage, status=Status.UNSTABLE, reason=PROVED, unstable_blocks=named)
    return replace(stage, proof=proof)


def notes_on_rest(of: Continuum, end: StageEnd, stage: StageResult, number: int, prove: Prover) -> Iterator[str]:
    """Return sentences on blocks at rest that limit analysis proves to be in no equilibrium where they were given."""
    before = distances(stage.displacement + stage.origin - stage.stage_displacement)[end.present]
    if before.max(initial=0.0) <= CONTACT_TOLERANCE * of.model.blocks.moments.median_size:
        yield from notes_on_given_position(of.model, stage, partial(_asked, of, end, stage, number, prove))


def _asked(of: Continuum, end: StageEnd, stage: StageResult, number: int, prove: Prover, down: IntArray) -> Proof:
    """Return what limit analysis says of the blocks that are there, of which some (k,) fall."""
    if stage.shaking is not None:
        return OF_SHAKEN
    part = _submodel(of, end, stage, present_bolts(of.model, number, end.present))
    proof = prove(part.model, np.searchsorted(part.block, down).astype(np.int32))
    return replace(proof, witness=None if proof.witness is None else proof.witness.in_whole(part))


def _moving(velocity: FloatArray, gyration: FloatArray) -> IntArray:
    """Return the blocks that move in a mechanism, (k,): in its velocities (n, 3), of 1 at most, more than rounding."""
    moves = np.maximum(distances(velocity), gyration * angles(velocity))
    named: IntArray = np.flatnonzero(moves > ROUNDING**0.5).astype(np.int32)
    return named


def _submodel(of: Continuum, end: StageEnd, stage: StageResult, bolts: list[Bolt]) -> SubModel:
    """Return the blocks that are there, as rigid ones under the forces of the stage, with bolts."""
    given = stage.evidence
    assert given is not None
    assert given.load_block is not None
    assert given.load_point is not None
    assert given.load_force is not None
    forces = PointForces(block=given.load_block, point=given.load_point, force=given.load_force)
    water = None if end.water is None else end.water.load.water
    part = submodel_of(end.model, end.present, bars_of(of.model.supports, of.model.blocks), forces, water)
    return replace(part, model=part.model.replace(bolts=bolts))
