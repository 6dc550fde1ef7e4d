"""Verdicts of the thesis's examples by both schemes, with their steps and cycles, and the cycles of a slide."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bsm_mesh as bsm
from examples.numbers.pages import Table, markdown

PAGE = "docs/theory_differences.md"
ROOT = Path(__file__).parents[2]
MOST_CYCLES = 500
PARTS = (1e-4, 1e-6, 1e-8)  # least parts of the shear stiffness; the second is the default
EXAMPLES = (  # file, the thesis's verdict
    ("02_pushed_block/model", "stable"),
    ("02_pushed_block/apart", "unstable: block 2"),
    ("03_stratified_slope/dip_24_5", "-"),
    ("03_stratified_slope/dip_25_5", "-"),
    ("03_stratified_slope/model", "slides, stops at the toe"),
    ("03_stratified_slope/floor", "slides, stops at the bottom"),
    ("03_stratified_slope/layered", "slides, stops at the bottom"),
    ("04_bolted_opening/unbolted", "unstable: roof block"),
    ("04_bolted_opening/roof_bolt", "unstable: left wall block"),
    ("04_bolted_opening/two_bolts", "stable"),
    ("04_bolted_opening/model", "stable"),
    ("04_bolted_opening/thick_two_bolts", "stable"),
    ("04_bolted_opening/thick", "stable"),
    ("05_dam_foundation/slip", "stable"),
)


def verdicts() -> str:
    """Return the table of verdicts."""
    lines = []
    for name, thesis in EXAMPLES:
        model = bsm.load(ROOT / f"examples/{name}.toml")
        options = replace(model.options or bsm.Options(), scheme="continuation")
        usual = bsm.run(model, options)
        ours = [
            bsm.run(model, replace(options, scheme="wang", max_steps=MOST_CYCLES, sliding_stiffness=part))
            for part in PARTS
        ]
        lines.append((name, thesis, _told(usual), *map(_told, ours)))
    columns = (f'`"wang"`, part {part:g}: cycles' for part in PARTS)
    return markdown(("example", "thesis", '`"continuation"`: steps', *columns), lines)


def _told(results: bsm.Results) -> str:
    steps = sum(len(stage.steps) for stage in results.stages)
    down = results.unstable_blocks.tolist()
    return f"{results.status.value}{f': block {down[0]}' if len(down) == 1 else ''}, {steps}"


def slides() -> str:
    """Return the cycles of a slide with all of its shear stiffness kept, and with the default."""
    model = bsm.load(ROOT / "examples/02_pushed_block/model.toml")
    lines = []
    for stiffness in (1e6, 1e7):
        joints = [replace(joint, normal_stiffness=stiffness, shear_stiffness=stiffness) for joint in model.joints]
        softer = model.replace(joints=joints)
        counts = [
            len(bsm.run(softer, bsm.Options(scheme="wang", sliding_stiffness=part, max_steps=2000)).stages[-1].steps)
            for part in (1.0, 1e-6)
        ]
        closed_form = 0.5 * stiffness / (30e3 - 26e3 * 3**-0.5)
        lines.append((f"{stiffness / 1e6:g} MPa/m", f"{closed_form:.0f}", *map(str, counts)))
    return markdown(
        ("shear stiffness", "L k_s / ΔP", "cycles, all of it kept", "cycles, `sliding_stiffness = 1e-6`"), lines
    )


TABLES: tuple[Table, ...] = (
    Table(name="schemes", page=PAGE, make=verdicts, tolerance=0.1, is_slow=True),
    Table(name="slides", page=PAGE, make=slides, tolerance=0.1),
)
