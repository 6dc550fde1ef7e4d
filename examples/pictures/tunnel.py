"""The run of the tunnel of docs/key_blocks.md: its blocks that fall."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bsm_mesh as bsm
from docs.code_blocks import ROOT, files_of

SIDES = ("west", "east", "south", "north", "bottom", "top")
UNIT_WEIGHT = 'unit_weight = "26 kN/m^3"'
STIFFNESS = 'young = "20 GPa"\npoisson = 0.25'  # of faces without a joint


def blocks_that_fall() -> bsm.Results:
    """Return a run of the page's tunnel: the sides of the box are fixed, and one stage excavates."""
    page = (ROOT / "docs/key_blocks.md").read_text(encoding="utf-8")
    text = files_of(page)["tunnel.toml"].replace(UNIT_WEIGHT, f"{UNIT_WEIGHT}\n{STIFFNESS}")
    text += "".join(f'\n[[support]]\nboundary = "{side}"\nfix = "all"\n' for side in SIDES)
    text += '\n[[stage]]\nname = "tunnel"\nexcavate = ["tunnel"]\n'
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tunnel.toml"
        path.write_text(text, encoding="utf-8")
        return bsm.run(path, output=False)
