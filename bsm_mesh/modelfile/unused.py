"""Nothing that a model file names ends on nothing: an error, or a note where the file allows it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.errors import ModelError, counted
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.kinds import AnyBlocks
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage, blocks_in
from bsm_mesh.model.unused import in_single_blocks, unused_bolts, unused_in
from bsm_mesh.modelfile.build_bolts import unused_curves
from bsm_mesh.modelfile.model_tables import ModelFile

if TYPE_CHECKING:
    from bsm_mesh.converters import MeshReport

CURE = "correct its name or place, leave it out, or continue without it by [mesh] allow_unused = true"


def unused_notes(file: ModelFile, model: Model, report: MeshReport, bolts: Sequence[Sequence[Bolt]]) -> tuple[str, ...]:
    """Return notes on groups of the mesh, and parts of the model file, that nothing uses.

    Parameters
    ----------
    file : ModelFile
        The model file.
    model : Model
        The model built from it.
    report : MeshReport
        Findings in its mesh.
    bolts : sequence of sequences of Bolt
        The bolts of each of its tables.

    Raises
    ------
    ModelError
        For everything that the file names and that acts on nothing. For joints and boundaries of which more than a
        hundredth is not in the mesh. The file may allow both.
    """
    from bsm_mesh.converters import NoteKind

    named = [*_groups_on_nothing(file, report), *_groups_left(file, model, report), *bolts_on_nothing(model, bolts)]
    lost = [note.text for note in report.notes if note.kind is NoteKind.LOST]
    if not file.mesh.allow_unused and (faults := [*lost, *unused_in(model), *named]):
        raise ModelError([f"{fault}; {CURE}" for fault in faults])
    told = set(file.groups.values())
    return (
        *(named if file.mesh.allow_unused else ()),
        *(text for name, text in excavations_left(model.blocks, model.stages) if f"excavation:{name}" not in told),
        *(text for name, text in unused_curves(report.bolts, file.bolt).items() if f"bolt:{name}" not in told),
    )


def _groups_on_nothing(file: ModelFile, report: MeshReport) -> Iterator[str]:
    """Say which entries of [groups] are in no block and on no edge, without rocks and joints that have a table."""
    tables = {*(f"rock:{name}" for name in file.rock), *(f"joint:{name}" for name in file.joint)}
    for key, target in file.groups.items():
        if not report.groups.get(target) and target not in tables:
            yield f"[groups] '{key}' = '{target}': no block and no edge of one is in the group"


def _groups_left(file: ModelFile, model: Model, report: MeshReport) -> Iterator[str]:
    """Say which excavations and bolt curves that [groups] names are neither excavated nor bolts."""
    told = set(file.groups.values())
    yield from (text for name, text in excavations_left(model.blocks, model.stages) if f"excavation:{name}" in told)
    yield from (text for name, text in unused_curves(report.bolts, file.bolt).items() if f"bolt:{name}" in told)


def excavations_left(blocks: AnyBlocks, stages: Sequence[Stage]) -> Iterator[tuple[str, str]]:
    """Return the name of every excavation that no stage takes away, and a sentence on it."""
    gone = np.zeros(blocks.count, dtype=bool)
    for region in (region for stage in stages for region in stage.excavate):
        gone |= blocks_in(region, blocks)
    for name, ids in blocks.excavations.items():
        if not gone[ids].any():
            yield name, f"excavation '{name}' ({counted(len(ids), 'block')}) is left in place: no stage excavates it"


def bolts_on_nothing(model: Model, bolts: Sequence[Sequence[Bolt]]) -> Iterator[str]:
    """Say which tables of bolts have none that crosses from block to block."""
    alone = unused_bolts(model)
    first = 0
    for k, group in enumerate(bolts):
        mine = np.arange(first, first + len(group))
        first += len(group)
        if alone[mine].all():
            yield f"[[bolt]] number {k + 1}: {in_single_blocks(model, mine.tolist())}"
