"""The command ``key-blocks``: block theory on a model file of three dimensions, its table, VTU files and picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.commands.safety import folder_beside
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.result_tables import write_table
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.modelfile.build_bolts import make_space_bolts
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_file import SLOPE, LoadedSpace, load_space_file
from bsm_mesh.text.tables import engineering, print_table
from bsm_mesh.text.terminal import say, say_json
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.key_blocks.analysis import key_blocks
from bsm_mesh.three_d.key_blocks.modes import FALLS
from bsm_mesh.three_d.key_blocks.record import KeyBlocks
from bsm_mesh.three_d.limit.rock_mass import analyse_rock

MAX_ROWS = 30  # of the table on the terminal; the file has all
PICTURE = "key_blocks.png"


def find_key_blocks(
    path: Path, output: Path | None, *, as_json: bool, picture: bool, proof: bool, scripts: bool = True
) -> None:
    """Find the key blocks of a model file, print what falls and slides, and write table, VTU files and picture."""
    loaded = load_space_file(path, scripts=scripts)
    reach = Reach(folder=path.parent, scripts=scripts)
    added = AddedFiles(output or folder_beside(loaded, reach, "key-blocks"))
    asked = loaded.file.key_blocks
    found = key_blocks(
        loaded.blocks,
        rocks=loaded.rocks,
        joints=loaded.joints,
        free=_free(loaded),
        excavated=list(loaded.blocks.excavations),
        default_joint=loaded.file.mesh.default_joint,
        bolts=_bolts(loaded, reach),
        gravity=asked.gravity or (0.0, 0.0, -1.0),
        joint_pressure=asked.joint_pressure,
        required=asked.required,
        rounds=asked.rounds,
    )
    proofs = _proofs(loaded, found) if proof else {}
    files = _write(loaded, found, added, picture)
    if as_json:
        told = {name: {"admissible": admissible, "text": text} for name, (admissible, text) in proofs.items()}
        names = [str(added.folder.path / name) for name in files]
        say_json({**_told(loaded, found), "limit_analysis": told, "files": names, "notes": _notes(loaded, found)})
        return
    for note in _notes(loaded, found):
        say(f"note: {note}", err=True)
    _print(loaded, found)
    for name, (_, text) in proofs.items():
        say(f"{name}: {text}")
    say(f"{', '.join(files)} written to {added.folder.path}")


def _bolts(loaded: LoadedSpace, reach: Reach) -> list[Bolt]:
    """Return the bolts of all stages."""
    tables = enumerate(loaded.file.bolt, 1)
    return [bolt for k, table in tables for bolt in make_space_bolts(table, f"[[bolt]] number {k}", reach)]


def _free(loaded: LoadedSpace) -> list[str]:
    """Return the boundaries that are free."""
    file = loaded.file
    if not (loaded.blocks.excavations or file.slope or file.key_blocks.free):
        raise ModelError(f"{loaded.path.name}: nothing is free: give [[excavation]], [slope] or [key_blocks] free")
    return [*loaded.file.key_blocks.free, *([SLOPE] if SLOPE in loaded.blocks.boundaries else [])]


def _notes(loaded: LoadedSpace, found: KeyBlocks) -> list[str]:
    """Return notes on possible slips and on limits of the answer."""
    bare = [joint.name for joint in loaded.joints if joint.law is None]
    held = int(found.held.sum())
    notes = [f"joint '{name}' has no strength (law, friction): nothing slides on it" for name in bare]
    if slivers := len(loaded.blocks.slivers):
        notes.append(f"{counted(slivers, 'block')} of {loaded.blocks.count} are slivers, marked in key_blocks.csv")
    if held:
        notes.append(f"{counted(held, 'block')} at free faces reach the sides of the box and are not judged")
    return notes


def _proofs(loaded: LoadedSpace, found: KeyBlocks) -> dict[str, tuple[bool | None, str]]:
    """Return what limit analysis says of the whole rock, and of the rest without the unstable blocks.

    Of each whether it is admissible, None where no program could be solved, and the answer in words, or why not.
    """
    blocks, asked = loaded.blocks, loaded.file.key_blocks
    default = loaded.file.mesh.default_joint
    materials = Materials.checked(blocks, loaded.rocks, loaded.joints, default)
    present = np.ones(blocks.count, dtype=bool)
    for gone in blocks.excavations.values():
        present[gone] = False
    left = present.copy()
    left[found.block[found.round > 0]] = False
    masses = {"whole rock": present} | ({"without these blocks": left} if (left != present).any() else {})
    given: dict[str, Any] = {"free": _free(loaded), "joint_pressure": asked.joint_pressure}
    given["gravity"] = asked.gravity or (0.0, 0.0, -1.0)
    answers: dict[str, tuple[bool | None, str]] = {}
    for name, there in masses.items():
        try:
            answer = analyse_rock(blocks, materials, there, **given)
            answers[name] = answer.admissible, str(answer)
        except ModelError as error:  # the key blocks are known all the same
            answers[name] = None, f"no answer: {error}"
    return answers


def _write(loaded: LoadedSpace, found: KeyBlocks, added: AddedFiles, picture: bool) -> list[str]:
    """Write the files, and return their names."""
    from bsm_mesh.converters.three_d import write_blocks, write_contacts
    from bsm_mesh.pictures.key_block_pictures import draw_key_blocks

    files = ["key_blocks.csv", "blocks.vtu", "contacts.vtu"]
    with added.file(files[0]) as draft:
        write_table(found.table(), draft)
    with added.file(files[1]) as draft:
        write_blocks(draft, loaded.blocks, key_blocks=found)
    with added.file(files[2]) as draft:
        write_contacts(draft, loaded.blocks)
    if picture:
        with added.file(PICTURE) as draft:
            draw_key_blocks(draft, loaded.blocks, found, title=loaded.file.title)
        files.append(PICTURE)
    return files


def _told(loaded: LoadedSpace, found: KeyBlocks) -> dict[str, Any]:
    """Return the JSON record."""
    below = found.round > 0
    return {
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
    }


def _print(loaded: LoadedSpace, found: KeyBlocks) -> None:
    """Print the unstable blocks, the heaviest first, and lines on the others."""
    rows = np.flatnonzero(found.round > 0)
    rows = rows[np.lexsort((-found.weight[rows], found.round[rows]))]
    large, several = rows[~found.sliver[rows]], found.round.max(initial=0) > 1
    header = ("block", "movement", *(("round",) if several else ()), "factor", "m3", "weight", "support")
    shown = [_row(found, k, several) for k in large[:MAX_ROWS]]
    if shown:
        print_table(loaded.file.title or str(loaded.path), header, shown, texts=2)
    left = len(rows) - len(shown)
    if left:
        say(f"key_blocks.csv has {counted(left, 'block')} more, slivers included")
    falls = int((found.bolted_factor[rows] == 0).sum())
    say(f"{counted(loaded.blocks.count, 'block')}: {found.count} at free faces, {int(found.removable.sum())} removable")
    say(
        f"{falls} fall and {len(rows) - falls} slide below a factor of {found.required:g}: "
        f"{found.volume[rows].sum():.4g} m3 in all"
    )
    least = np.flatnonzero(found.removable & ~found.sliver & np.isfinite(found.bolted_factor) & (found.round == 0))
    if not len(rows) and len(least):
        k = least[np.argmin(found.bolted_factor[least])]
        block, movement, factor = _row(found, k, several=False)[:3]
        say(f"least factor {factor}: block {block} {movement}")
    if held := int(((found.factor < found.required) & (found.round == 0) & (found.pull > 0)).sum()):
        say(f"bolts hold {counted(held, 'block')} that would fall or slide without them")


def _row(found: KeyBlocks, k: int, several: bool) -> tuple[str, ...]:
    """Return a row of the table on the terminal."""
    joints = [found.joint_names[j] if j >= 0 else "rock" for j in found.joints[k][: max(0, found.mode[k] - FALLS)]]
    return (
        str(found.block[k]),
        f"slides on {', '.join(joints)}" if joints else "falls",
        *((str(found.round[k]),) if several else ()),
        f"{found.bolted_factor[k]:.3f}",
        f"{found.volume[k]:.4g}",
        engineering(float(found.weight[k]), "N"),
        "-" if np.isnan(found.bolted_support[k]) else engineering(float(found.bolted_support[k]), "Pa"),
    )
