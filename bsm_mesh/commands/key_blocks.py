"""The command ``key-blocks``: block theory on a model file of three dimensions, its table, VTU files and picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.commands.safety import folder_beside
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.key_block_files import NET, PICTURE, write_key_blocks
from bsm_mesh.folder.summary import versions
from bsm_mesh.model.excavated_water import depths_below, least_depth
from bsm_mesh.model.model import Model
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_file import LoadedSpace, load_space_file
from bsm_mesh.modelfile.space_model import space_model
from bsm_mesh.pictures.figures import save
from bsm_mesh.pictures.joint_net import joint_net, least_friction
from bsm_mesh.pictures.key_block_pictures import draw_key_blocks
from bsm_mesh.text.key_block_text import key_block_lines, key_block_table, unstable_rows
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.blocks.polygons import spread
from bsm_mesh.three_d.blocks.polyhedra import SLOPE
from bsm_mesh.three_d.key_blocks.analysis import key_blocks
from bsm_mesh.three_d.key_blocks.loads import RockLoads
from bsm_mesh.three_d.key_blocks.record import KeyBlocks
from bsm_mesh.three_d.limit.rock_mass import analyse_rock

MAX_ROWS = 30  # of the table on the terminal; the file has all
Proofs = dict[str, tuple[bool | None, str]]


def find_key_blocks(
    path: Path,
    output: Path | None,
    progress: Progress,
    *,
    as_json: bool,
    picture: bool,
    proof: bool,
    scripts: bool = True,
) -> None:
    """Find the key blocks of a model file, print what falls and slides, and write table, VTU files and picture."""
    with progress:
        progress.report("blocks")
        loaded = load_space_file(path, scripts=scripts)
        reach = Reach(folder=path.parent, scripts=scripts)
        added = AddedFiles(output or folder_beside(loaded, reach, "key-blocks"))
        progress.report("key blocks")
        model, found = _found(loaded, reach)
        if proof:
            progress.report("limit analysis")
        proofs = _proofs(loaded, model, found) if proof else {}
        progress.report("files")
        told = _told(loaded, model, found, proofs)
        files = write_key_blocks(loaded, found, told, added)
        if picture:
            progress.report("pictures")
            files += _draw(loaded, found, added)
    if as_json:
        say_json({**told, "files": [str(added.folder.path / name) for name in files]})
        return
    for note in told["notes"]:
        say(f"note: {note}", err=True)
    _print(loaded, found, told)
    for name, (_, text) in proofs.items():
        say(f"{name}: {text}")
    say(f"{', '.join(files)} written to {added.folder.path}")


def _found(loaded: LoadedSpace, reach: Reach) -> tuple[Model, KeyBlocks]:
    """Return the model of a file, and its key blocks."""
    asked, model = loaded.file.key_blocks, space_model(loaded, reach)
    found = key_blocks(
        model,
        free=_free(loaded),
        gravity=asked.gravity,
        joint_pressure=asked.joint_pressure,
        required=asked.required,
        rounds=asked.rounds,
    )
    return model, found


def _free(loaded: LoadedSpace) -> list[str]:
    """Return the boundaries that are free."""
    file = loaded.file
    if not (loaded.blocks.excavations or file.slope or file.key_blocks.free):
        raise ModelError(f"{loaded.path.name}: nothing is free: give [[excavation]], [slope] or [key_blocks] free")
    return [*loaded.file.key_blocks.free, *([SLOPE] if SLOPE in loaded.blocks.boundaries else [])]


def _notes(loaded: LoadedSpace, model: Model, found: KeyBlocks) -> list[str]:
    """Return notes on possible slips and on limits of the answer."""
    bare = [joint.name for joint in loaded.joints if joint.law is None]
    held = int(found.held.sum())
    notes = [f"joint '{name}' has no strength (law, friction): nothing slides on it" for name in bare]
    if slivers := len(loaded.blocks.slivers):
        notes.append(f"{counted(slivers, 'block')} of {loaded.blocks.count} are slivers, marked in key_blocks.csv")
    if held:
        notes.append(f"{counted(held, 'block')} at free faces reach the sides of the box and are not judged")
    notes += [*_not_considered(model), *_under_water(loaded, model, found)]
    rounds = loaded.file.key_blocks.rounds
    if (found.round == rounds).any():
        notes.append(
            f"blocks behind those of round {rounds} are not examined; give rounds = {rounds + 1} in [key_blocks]"
        )
    return notes


def _not_considered(model: Model) -> list[str]:
    """Return a note on each thing in the model that is a run's alone."""
    notes = []
    if model.in_situ is not None:
        notes.append("stress in the rock ([in_situ]) is not considered; a run does")
    for stage in model.stages:
        changes = [name for name in ("gravity", "water", "loads", "strength") if getattr(stage, name)]
        if changes:
            notes.append(f"stage '{stage.name}' changes {', '.join(changes)}: key blocks are those before the stages")
    return notes


def _under_water(loaded: LoadedSpace, model: Model, found: KeyBlocks) -> list[str]:
    """Return a note where the water presses on free faces."""
    blocks, water, depth = loaded.blocks, model.water, 0.0
    if water is not None and len(found.free_faces):
        sizes, first = np.diff(blocks.face_offsets)[found.free_faces], blocks.face_offsets[found.free_faces]
        depth = float(depths_below(water, blocks.vertices[blocks.face_vertices[spread(first, sizes)]]).max())
    if depth <= least_depth(model):
        return []
    return [
        f"the plane of groundwater lies up to {depth:.3g} m above free faces: the water presses on them like a pond. "
        "If the opening is drained, give joint_pressure and no plane"
    ]


def _proofs(loaded: LoadedSpace, model: Model, found: KeyBlocks) -> Proofs:
    """Return what limit analysis says of the whole rock, and of the rest without the unstable blocks.

    Of each whether it is admissible, None where no program could be solved, and the answer in words, or why not.
    """
    blocks, asked = loaded.blocks, loaded.file.key_blocks
    materials = Materials.checked(blocks, model.rocks, model.joints, model.default_joint)
    loads = RockLoads(model, asked.gravity, asked.joint_pressure)
    present = np.ones(blocks.count, dtype=bool)
    for gone in blocks.excavations.values():
        present[gone] = False
    left = present.copy()
    left[found.block[found.round > 0]] = False
    masses = {"whole rock": present} | ({"without these blocks": left} if (left != present).any() else {})
    free = _free(loaded)
    answers: Proofs = {}
    for name, there in masses.items():
        try:
            answer = analyse_rock(blocks, materials, there, free=free, loads=loads.on_blocks(there))
            answers[name] = answer.admissible, str(answer)
        except ModelError as error:  # the key blocks are known all the same
            answers[name] = None, f"no answer: {error}"
    return answers


def _told(loaded: LoadedSpace, model: Model, found: KeyBlocks, proofs: Proofs) -> dict[str, Any]:
    """Return the record."""
    below = found.round > 0
    return {
        "title": loaded.file.title or loaded.path.stem,
        "model_hash": model.digest,
        "report": loaded.file.report.model_dump(),
        "blocks": loaded.blocks.count,
        "at_free_faces": found.count,
        "removable": int(found.removable.sum()),
        "falls": [int(block) for block in found.block[below & (found.bolted_factor == 0)]],
        "slides": {
            str(block): round(float(factor), 6)
            for block, factor in zip(found.block[below], found.bolted_factor[below], strict=True)
            if factor > 0
        },
        "required": found.required,
        "volume": float(found.volume[below].sum()),
        "slivers": len(loaded.blocks.slivers),
        "limit_analysis": {name: {"admissible": known, "text": text} for name, (known, text) in proofs.items()},
        "notes": _notes(loaded, model, found),
        "versions": versions(),
    }


def _draw(loaded: LoadedSpace, found: KeyBlocks, added: AddedFiles) -> list[str]:
    """Draw blocks and stereonet, and return the names of the files."""
    title, drawn = loaded.file.title, [PICTURE]
    with added.file(PICTURE) as draft:
        draw_key_blocks(draft, loaded.blocks, found, title=title)
    angles = [getattr(joint.law, "friction", None) for joint in loaded.joints]
    net = joint_net(loaded.blocks, least_friction(angles), title, face=_face(loaded))
    if net is not None:
        with added.file(NET) as draft:
            save(net, draft)
        drawn.append(NET)
    return drawn


def _face(loaded: LoadedSpace) -> tuple[float, float] | None:
    """Return dip and dip direction of the slope's face; None without a slope."""
    slope = loaded.file.slope
    if slope is None or slope.face.dip_direction is None:
        return None
    return slope.face.dip, slope.face.dip_direction


def _print(loaded: LoadedSpace, found: KeyBlocks, told: dict[str, Any]) -> None:
    """Print the unstable blocks, the heaviest first, and lines on the others."""
    columns = found.table().columns
    rows = unstable_rows(columns)
    large = rows[~found.sliver[rows]][:MAX_ROWS]
    if large.size:
        header, shown = key_block_table(columns, large)
        print_table(loaded.file.title or str(loaded.path), header, shown, texts=2)
    if left := len(rows) - len(large):
        say(f"key_blocks.csv has {counted(left, 'block')} more, slivers included")
    for line in key_block_lines(told, columns):
        say(line)
