"""Numbers on the tunnel of a starter: blocks that fall in a run, beside the rounds of block theory."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.three_d.key_blocks.record import KeyBlocks
from docs.code_blocks import ROOT
from examples.numbers.pages import Table, markdown
from tests.scenes.rock_3d import alone

PAGE = "docs/verification_3d.md"
SIDES = ("west", "east", "south", "north", "bottom", "top")
ROUNDS = 60  # of block theory: until it names nothing more
FALLS = bsm.Falls(on_fall="remove")
EVERY = bsm.Options(threads=1, falls=bsm.Falls(ignore_below=0))


def _tunnel() -> bsm.Model:
    """Return the starter of the key blocks as a run: sides fixed, and one stage that excavates."""
    text = (ROOT / "bsm_mesh/commands/starters/key_blocks/model.toml").read_text(encoding="utf-8")
    text = text.replace("[mesh]\n", '[mesh]\ndefault_joint = "J1"\n')
    text += "".join(f'\n[[support]]\nboundary = "{side}"\nfix = "all"\n' for side in SIDES)
    text += '\n[[stage]]\nname = "tunnel"\nexcavate = ["tunnel"]\n'
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.toml"
        path.write_text(text, encoding="utf-8")
        return bsm.load(path)


def _that_move(model: bsm.Model, blocks: IntArray, present: BoolArray, *, turns: bool) -> list[int]:
    """Return those of the blocks that move alone between fixed neighbours."""
    moved = []
    for block in blocks.tolist():
        stage = bsm.run(alone(model, block, present, turns=turns), EVERY).stages[-1]
        moved += [block] * bool(len(stage.unstable_blocks))
    return moved


def _listed(blocks: Sequence[int]) -> str:
    return ", ".join(map(str, blocks)) or "-"


def falls() -> str:
    """Return the blocks that fall, and those of every round, with which of them move alone."""
    model = _tunnel()
    found = bsm.key_blocks(model, excavated=["tunnel"], rounds=ROUNDS)
    fallen = [fall.block for fall in bsm.run(model, replace(bsm.Options(threads=1), falls=FALLS)).stages[-1].falls]
    named = found.block[found.round > 0]
    told = (
        f"In the run of {model.blocks.count} blocks these fall, one after the other: {_listed(fallen)}. Block theory "
        f"names {len(named)} blocks, and {int(np.isin(fallen, named).sum())} of the {len(fallen)}:"
    )
    header = ("round", "named", "fall in the run", "rest alone", "rest alone, without turning")
    return f"{told}\n\n{markdown(header, _rounds(model, found, fallen))}"


def _rounds(model: bsm.Model, found: KeyBlocks, fallen: Sequence[int]) -> list[tuple[str, ...]]:
    """Return a row a round."""
    present = np.ones(model.blocks.count, dtype=bool)
    present[model.blocks.excavations["tunnel"]] = False
    rows = []
    for number in range(1, int(found.round.max()) + 1):
        named = found.block[found.round == number]
        rest = [np.setdiff1d(named, _that_move(model, named, present, turns=turns)).tolist() for turns in (True, False)]
        fall = [block for block in named.tolist() if block in fallen]
        rows.append((str(number), *map(_listed, (named.tolist(), fall, *rest))))
        present[named] = False
    return rows


TABLES = (Table(name="tunnel_falls", page=PAGE, make=falls, is_slow=True),)
