"""contacts.csv, supports.csv and joints.csv: all stages, one below the other, units in the header."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from bsm_mesh.files import whole_file
from bsm_mesh.results.joint_sets import ROCK_FACE, joint_sets
from bsm_mesh.results.records import ContactStatus, Results, StageResult

Columns = dict[str, Sequence[Any]]
STATUS_NAMES = tuple(status.name.lower() for status in ContactStatus)


def write_tables(results: Results, folder: Path) -> list[str]:
    """Write the three tables; return their names."""
    for name, columns_of in _TABLES.items():
        tables = [columns_of(results, stage) for stage in results.stages]
        with whole_file(folder / name) as draft, draft.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["stage", "stage_name", *tables[0]])
            for number, (stage, columns) in enumerate(zip(results.stages, tables, strict=True)):
                writer.writerows((number, stage.name, *row) for row in _rows(columns))
    return list(_TABLES)


def _rows(columns: Columns) -> Iterable[tuple[Any, ...]]:
    return zip(*columns.values(), strict=True)


def _contacts(results: Results, stage: StageResult) -> Columns:
    """Return a row a contact; forces act on block b, tension positive."""
    c, joints = stage.contacts, [*results.joint_names, ROCK_FACE]
    return {
        "block_a": c.block_a.tolist(),
        "block_b": c.block_b.tolist(),
        "joint": [joints[number] for number in c.joint.tolist()],
        "x [m]": c.point[:, 0].tolist(),
        "y [m]": c.point[:, 1].tolist(),
        "normal_x": c.normal[:, 0].tolist(),
        "normal_y": c.normal[:, 1].tolist(),
        "length [m]": c.length.tolist(),
        "normal_force [N/m]": c.normal_force.tolist(),
        "shear_force [N/m]": c.shear_force.tolist(),
        "water_pressure [Pa]": c.water_pressure.tolist(),
        "slip [m]": c.slip.tolist(),
        "opening [m]": c.opening.tolist(),
        "utilisation": c.utilisation.tolist(),
        "status": [STATUS_NAMES[number] for number in c.status.tolist()],
    }


def _supports(results: Results, stage: StageResult) -> Columns:
    """Return a row a held point; forces act on the block."""
    s = stage.supports
    return {
        "block": s.block.tolist(),
        "x [m]": s.point[:, 0].tolist(),
        "y [m]": s.point[:, 1].tolist(),
        "force_x [N/m]": s.reaction[:, 0].tolist(),
        "force_y [N/m]": s.reaction[:, 1].tolist(),
        "moment [N]": s.moment.tolist(),
    }


def _joints(results: Results, stage: StageResult) -> Columns:
    """Return a row a joint set."""
    sets = joint_sets(results, stage)
    columns = {
        "joint": "name",
        "length [m]": "length",
        "slipping_share": "slipping",
        "open_share": "open",
        "mean_pressure [Pa]": "pressure",
        "mean_slip [m]": "slip",
        "greatest_slip [m]": "greatest_slip",
        "mean_opening [m]": "opening",
        "greatest_opening [m]": "greatest_opening",
    }
    return {header: [getattr(one, name) for one in sets] for header, name in columns.items()}


_TABLES = {"contacts.csv": _contacts, "supports.csv": _supports, "joints.csv": _joints}
