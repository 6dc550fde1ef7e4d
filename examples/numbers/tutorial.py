"""Numbers of docs/tutorial.md: its files as printed, run."""

from __future__ import annotations

import runpy
from pathlib import Path
from tempfile import TemporaryDirectory

import bsm_mesh as bsm
from bsm_mesh.converters.continuum import compare_stages
from docs.code_blocks import ROOT, files_of
from examples.numbers.pages import Table, markdown

PAGE = "docs/tutorial.md"


def write_files(folder: Path) -> None:
    """Write the files of the page into a folder, and its mesh."""
    for name, content in files_of((ROOT / PAGE).read_text(encoding="utf-8")).items():
        (folder / name).write_text(content, encoding="utf-8")
    runpy.run_path(str(folder / "cutting.py"))["build"](folder / "cutting.msh")


def numbers() -> str:
    """Return the table of the page."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_files(folder)
        models = [bsm.load(folder / file) for file in ("cutting.toml", "bolted.toml")]
    bare, bolted = (bsm.run(model, model.options) for model in models)
    area = bare.blocks.moments.area
    last = bolted.stages[-1]
    chips = [fall.area for fall in last.falls]
    worst = int(last.bolts.greatest_force.argmax())
    factor = bsm.factor_of_safety(models[1])
    beside = compare_stages(models[1], bolted)[-1]
    rows = [
        ("blocks", str(area.size)),
        ("without bolts", bare.status.value),
        ("falls", f"{bare.unstable_blocks.size} blocks, {area[bare.unstable_blocks].sum():.1f} m2"),
        ("with bolts", last.status.value),
        ("scaled off", f"{len(chips)} chips, {sum(chips):.2f} m2"),
        ("greatest displacement", f"{1e3 * last.max_displacement:.2f} mm"),
        (
            "greatest force in a bolt",
            f"{last.bolts.greatest_force[worst] / 1e3:.0f} kN in {last.bolts.names[worst]}, "
            f"{100 * last.bolts.utilisation.max():.0f} % of its strength",
        ),
        ("factor of safety, bolted", f"stable at {factor.stable:.3f}, unstable at {factor.unstable:.3f}"),
        ("compared with finite elements", beside.sentence),
    ]
    return markdown(("", ""), rows)


TABLES: tuple[Table, ...] = (Table(name="tutorial", page=PAGE, make=numbers, tolerance=0.02),)
