"""Models in folders: the files of some small models, and the content of their results folders."""

from __future__ import annotations

import copy
import json
import tomllib
from pathlib import Path
from typing import Any

import tomli_w

from tests.scenes.small_case import ROOT
from tests.scenes.small_models import MESH, MODELS

NAMES = ("staged", "bolted", "collapsing")
BOLT_TABLE = b"start_x,start_y,end_x,end_y,diameter\n0.5,1.9,0.5,0.2,25 mm\n1.5,1.9,1.5,0.2,0.025\n"
Tree = dict[str, Any]


def _models() -> dict[str, Tree]:
    staged, bolted = copy.deepcopy(MODELS[2]), copy.deepcopy(MODELS[3])
    staged["output"] = {"snapshots": "steps"}
    collapsing = tomllib.loads((ROOT / "examples/incline/slides.toml").read_text(encoding="utf-8"))
    collapsing["output"] = {"snapshots": "steps"}
    return {"staged": staged, "bolted": bolted, "collapsing": collapsing}


def put_model(
    root: Path, name: str, *, title: str = "A run", unit_weight: str = "26 kN/m^3", tables: Tree | None = None
) -> Path:
    """Write a model with its mesh and bolts into a folder and return the model file.

    Parameters
    ----------
    root : Path
        The folder.
    name : str
        One of `NAMES`.
    title, unit_weight : str
        Of the model, and of all its rocks.
    tables : dict, optional
        Tables to be added to the model file.
    """
    tree = _models()[name]
    tree["title"] = title
    for rock in tree["rock"].values():
        rock["unit_weight"] = unit_weight
    for table, keys in (tables or {}).items():
        tree[table] = {**tree.get(table, {}), **keys}
    root.mkdir(parents=True, exist_ok=True)
    (root / "model.toml").write_text(tomli_w.dumps(tree), encoding="utf-8")
    (root / "mesh.msh").write_bytes(MESH)
    (root / "bolts.csv").write_bytes(BOLT_TABLE)
    return root / "model.toml"


def content(folder: Path) -> dict[str, Any]:
    """Return what the files of a run hold, wall times and the number of the run aside."""
    told: dict[str, Any] = {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}
    rows = [line.split(",") for line in told["history.csv"].decode().splitlines()]
    at = rows[0].index("seconds")
    told["history.csv"] = [row[:at] + row[at + 1 :] for row in rows]
    summary = json.loads(told["summary.json"])
    for stage in summary["stages"]:
        del stage["seconds"]
    del summary["checksum"], summary["run"], summary["files"]["history.csv"]
    return {**told, "summary.json": summary}
