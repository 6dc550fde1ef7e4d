"""The command ``liner``: forces in a liner of blocks against its capacity, as a table and a diagram."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.result_tables import write_table
from bsm_mesh.model.quantities import LINER_COMPRESSION, TENSILE_STRENGTH
from bsm_mesh.model.quantity import Quantity, convert, typed
from bsm_mesh.pictures.liner_pictures import draw_capacity
from bsm_mesh.results.liner import Capacity, LinerForces, liner_forces
from bsm_mesh.results.results import Results
from bsm_mesh.results.tables import ResultTable
from bsm_mesh.text.headings import stage_number
from bsm_mesh.text.tables import engineering, print_table
from bsm_mesh.text.terminal import say, say_json

TABLE, PICTURE = "liner.csv", "liner.png"
MAX_ROWS = 8  # sections on the terminal, the most used ones; the file has all


def check_liner(
    out: Path, *, rock: str, stage: str | None, compressive_strength: str, tensile_strength: str, as_json: bool
) -> None:
    """Write table and diagram of a liner in a results folder, and print the sections that are used most."""
    capacity = Capacity(
        compressive_strength=_strength("--compressive-strength", compressive_strength, LINER_COMPRESSION),
        tensile_strength=_strength("--tensile-strength", tensile_strength, TENSILE_STRENGTH),
    )
    results = Results.load(out)
    record = results.stages[-1 if stage is None else stage_number(results, stage)]
    found = liner_forces(results, rock, record)
    used = found.utilisation(capacity.compressive_strength, capacity.tensile_strength)
    added = AddedFiles(out)
    with added.file(TABLE) as draft:
        write_table(_table(found, used), draft)
    with added.file(PICTURE) as draft:
        draw_capacity(found, capacity, f"liner '{rock}', stage {record.name}", draft)
    worst = int(np.argmax(used))
    if as_json:
        told = {
            "stage": record.name,
            "sections": len(used),
            "utilisation": float(used[worst]) if np.isfinite(used[worst]) else None,
            "at": found.point[worst].tolist(),
            "thrust": [float(found.thrust.min()), float(found.thrust.max())],
            "moment": [float(found.moment.min()), float(found.moment.max())],
            "files": [str(added.folder.path / name) for name in (TABLE, PICTURE)],
        }
        say_json(told)
        return
    _print(found, used, f"Liner '{rock}', stage {record.name}")
    verdict = "within its capacity" if used[worst] <= 1 else "beyond its capacity"
    say(f"the liner is {verdict}: greatest utilisation {used[worst]:.3f}")
    say(f"{TABLE}, {PICTURE} written to {added.folder.path}")


def _strength(name: str, text: str, quantity: Quantity) -> float:
    try:
        return convert(typed(text), quantity)
    except ValueError as error:
        raise ModelError(f"liner: {name} {text!a}: {error}") from None


def _table(found: LinerForces, used: np.ndarray) -> ResultTable:
    columns = {
        "block_a": found.block_a,
        "block_b": found.block_b,
        "x": found.point[:, 0],
        "y": found.point[:, 1],
        "thickness": found.thickness,
        "thrust": found.thrust,
        "shear": found.shear,
        "moment": found.moment,
        "stress_inside": found.stress[:, 0],
        "stress_outside": found.stress[:, 1],
        "utilisation": used,
    }
    units = dict.fromkeys(("x", "y", "thickness"), "m") | dict.fromkeys(("thrust", "shear"), "N/m")
    units |= {"moment": "N m/m", "stress_inside": "Pa", "stress_outside": "Pa"}
    return ResultTable(columns=columns, units=units)


def _print(found: LinerForces, used: np.ndarray, title: str) -> None:
    rows = [
        (
            f"({found.point[k, 0]:.2f}, {found.point[k, 1]:.2f}) m",
            f"{1e3 * found.thickness[k]:.0f} mm",
            engineering(float(found.thrust[k]), "N/m"),
            engineering(float(found.moment[k]), "N m/m"),
            f"{used[k]:.3f}",
        )
        for k in np.argsort(-used, kind="stable")[:MAX_ROWS]
    ]
    print_table(title, ("section", "thickness", "thrust", "moment", "utilisation"), rows)
