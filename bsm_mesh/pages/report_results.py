"""Parts of a report on a results folder; every number is of the results."""

from __future__ import annotations

import base64
import re
import tomllib
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from bsm_mesh.errors import ModelError, counted, named_stage, numbered, place
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.folder.storage import load_results
from bsm_mesh.folder.verify import grounds_in
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.quantities import STRESS, STRESS_GRADIENT
from bsm_mesh.modelfile.keys import quantity_within, table_within
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.model_text import MODEL
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.movements import distances
from bsm_mesh.pictures.plot import EARLIER
from bsm_mesh.reading import refuse_special
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.spread import spread_text
from bsm_mesh.text.beside_tables import HEADER as BESIDE_HEADER
from bsm_mesh.text.beside_tables import beside_rows
from bsm_mesh.text.bolt_tables import BOLT_HEADER, bolt_table
from bsm_mesh.text.flow_text import flow_rows
from bsm_mesh.text.headings import PICTURES_FOLDER, heading
from bsm_mesh.text.quality import Thresholds, poor_blocks
from bsm_mesh.text.tables import (
    SPREAD_HEADER,
    balance_rows,
    describe,
    engineering,
    fall_header,
    fall_rows,
    joint_header,
    joint_rows,
    spread_rows,
)

PLANE = "Plane problem, one metre thick: x to the right, y up; forces are per metre, those of bolts for one bolt."
SPACE = "Three dimensions: x to the east, y to the north, z up; forces are those of whole blocks and single bolts."
ASSUMPTIONS = (
    "Blocks are rigid; rock and joints deform in the springs of their contacts (Wang 1992).",
    "Joints slip and open by their laws, and carry no tension beyond the strength that is given.",
    "Static equilibrium; where there is none near, blocks are followed with their masses until they rest or fall.",
)
PNG = b"\x89PNG\r\n\x1a\n"  # how every such file begins
OVERVIEW = "model"  # the picture on the first page
OF_STAGE = re.compile(r"(.+)_stage_(\d+)")  # a picture of such a stage
Rows = list[tuple[str, ...]]


def content_of(out: Path) -> dict[str, Any]:
    """Return the results part of the page."""
    saved, results = SavedResults(out), load_results(out)
    told = saved.told
    grounds = {ground.stage: ground for ground in grounds_in(out)}
    model = saved.content(MODEL).decode("utf-8") if MODEL in saved else ""
    return {
        "title": told["title"] or out.name,
        "fields": tomllib.loads(model).get("report", {}) if model else {},
        "heading": heading(told),
        "doubts": [
            f"the verdict on {named_stage(stage)} DOES NOT HOLD in the check (bsm-mesh verify): {ground.text}"
            for stage, ground in grounds.items()
            if not ground.holds
        ],
        "stages": [_stage(results, stage, grounds.get(stage.name)) for stage in results.stages],
        "joint_header": joint_header(results),
        "bolt_header": BOLT_HEADER,
        "fall_header": fall_header(results),
        "falls": fall_rows(results),
        "beside_header": BESIDE_HEADER,
        "beside": beside_rows(results),
        "spread_header": SPREAD_HEADER,
        "spread": spread_rows(results.spread),
        "spread_text": spread_text(results.spread) if results.spread else "",
        "facts": _facts(results),
        "assumptions": (SPACE if in_space(results.blocks) else PLANE, *ASSUMPTIONS),
        "input": input_tables(model),
        "model": model,
        "quality": _quality(results),
        **_pictures(out, [stage.name for stage in results.stages]),
        "versions": {**told["versions"], "linear solver": told["linear_solver"]},
        "model_hash": told["model_hash"],
        "files": [(name, f"{listed['bytes']}", listed["sha256"]) for name, listed in told["files"].items()],
    }


def _stage(results: Results, stage: StageResult, ground: Any) -> dict[str, Any]:
    """Return the part of the page on a stage."""
    moved = distances(stage.stage_displacement) * stage.counts
    most = int(moved.argmax())
    at = place(results.blocks.moments.centroid[most].round(2))  # to the centimetre
    rows: Rows = list(describe(results, stage))
    rows.insert(2, ("checked", "no ground was written" if ground is None else str(ground)))
    if moved[most] > 0:
        rows.append(
            ("greatest displacement in this stage", f"block {most} at {at} m, {engineering(float(moved[most]), 'm')}")
        )
    rows += balance_rows(results, stage)
    if stage.unstable_blocks.size:
        rows.append(("unstable blocks", numbered("block", stage.unstable_blocks)))
    rows += [(f"water, out and in: {place}", f"{leaves}, {enters}") for place, leaves, enters in flow_rows(stage)]
    if stage.flow is not None:
        met = np.bincount(stage.flow.place[stage.flow.place >= 0], minlength=len(stage.flow.places)).tolist()
        named = zip(stage.flow.places, met, strict=True)
        rows += [
            ("joints end at", "; ".join(f"{name}: {counted(number, 'point')}" for name, number in named)),
        ]
    return {
        "name": stage.name,
        "holds": ground is None or ground.holds,
        "rows": rows,
        "joints": joint_rows(results, stage),
        "bolts": bolt_table(stage.bolts),
        "notes": stage.notes,
    }


def _pictures(out: Path, stages: list[str]) -> dict[str, Any]:
    """Return the pictures of the page, stage by stage, and how many more there are.

    All of the last stage, and all parts of the model that were asked for; `EARLIER` of the stages before. Those of a
    stage have the order in which they are drawn: the model first.
    """
    from bsm_mesh.pictures.pictures import NAMES

    shown, more, overview = [], 0, ""
    for path in sorted((out / PICTURES_FOLDER).glob("*.png")):
        found = OF_STAGE.fullmatch(path.stem)
        if found and int(found[2]) >= len(stages):
            continue  # of a stage that these results do not have: nothing of theirs
        if found and found[1] not in EARLIER:
            more += 1
            continue
        if path.stem == OVERVIEW:
            overview = picture_data(path)
            continue
        name, number = (found[1], int(found[2])) if found else (path.stem, len(stages) - 1)
        caption = name.replace("_", " ") + (f", {named_stage(stages[number])}" if found else "")
        place_in_stage = NAMES.index(name) if name in NAMES else len(NAMES)  # parts of the model at the end
        shown.append((number, place_in_stage, caption, picture_data(path)))
    shown.sort(key=lambda picture: picture[:2])
    return {"pictures": [picture[2:] for picture in shown], "more_pictures": more, "overview": overview}


def picture_data(path: Path) -> str:
    """Return a picture as text for the page itself.

    Raises
    ------
    ModelError
        If it is no PNG: a link may lead to any file, whose content does not belong in a page.
    """
    refuse_special(path)
    content = path.read_bytes()
    if not content.startswith(PNG):
        raise ModelError(f"{path}: is no PNG picture; draw it again, or give another one")
    return base64.b64encode(content).decode("ascii")


def _facts(results: Results) -> Rows:
    blocks = results.blocks
    low, high = blocks.vertices.min(axis=0), blocks.vertices.max(axis=0)
    bulk = blocks.moments.bulk
    return [
        ("scheme", results.scheme),
        ("tolerance", f"{results.tolerance:g} of the reference weight"),
        ("stages", ", ".join(stage.name for stage in results.stages)),
        ("extent", f"{place(low)} to {place(high)} m"),
        (
            "blocks",
            f"{blocks.count}, of {float(bulk.min()):.3g} to {float(bulk.max()):.3g} {blocks.bulk_unit}",
        ),
    ]


def _quality(results: Results) -> Rows:
    """Return which blocks are poor, by the thresholds of `bsm-mesh check`; of polyhedra the slivers."""
    blocks = results.blocks
    poor = {"slivers": blocks.slivers} if in_space(blocks) else poor_blocks(blocks, Thresholds())
    return [
        (name.replace("_", " "), counted(len(found), "block"), numbered("block", found) if len(found) else "")
        for name, found in poor.items()
    ]


def input_tables(model: str) -> list[tuple[str, Rows]]:
    """Return the tables of a model file as it was run, with units: rocks, joints and all else that is not empty."""
    content = tomllib.loads(model) if model else {}
    file = SpaceFile if content.get("dimensions") == 3 else ModelFile
    tables: list[tuple[str, dict[str, Any], type[Table] | None]] = []
    for kind in ("rock", "joint"):
        tables += [(f"{kind} {name}", table, _kind(file, kind)[1]) for name, table in content.get(kind, {}).items()]
    for kind in ("slope", "key_blocks", "gravity", "in_situ", "water", "flow", "falls", "solver"):
        tables += [(kind.replace("_", " "), content[kind], _kind(file, kind)[1])] if kind in content else []
    for kind in ("joint_set", "joint_plane", "excavation", "support", "load", "bolt", "stage", "history"):
        name = kind.replace("_", " ")
        given, schema = content.get(kind, []), _kind(file, kind)[1]
        tables += [(f"{name} {table.get('name', k)}", table, schema) for k, table in enumerate(given, 1)]
    return [(name, _rows_of(table, schema)) for name, table, schema in tables]


def _rows_of(table: dict[str, Any], schema: type[Table] | None) -> Rows:
    """Return the keys of a table that are not empty, with the units that its schema gives their numbers."""
    return [(key, _shown(value, *_kind(schema, key))) for key, value in table.items() if value not in ([], {}, "")]


def _kind(schema: type[Table] | None, key: str) -> tuple[str, type[Table] | None]:
    """Return the unit of the numbers of a key, and the schema of the table that it holds."""
    field = None if schema is None else schema.model_fields.get(key)
    if field is None:
        return "", None
    annotation = Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    quantity = quantity_within(annotation)
    return "" if quantity is None else quantity.unit, table_within(annotation)


def _shown(value: Any, unit: str = "", schema: type[Table] | None = None) -> str:
    """Return a value of a model file as a reader writes it; with a prefix where that loses no digit."""
    if isinstance(value, int | float) and not isinstance(value, bool) and unit:
        exact = float(f"{value:.4g}") == value and unit != "degrees"
        return engineering(value, unit) if exact else f"{value:.10g} {unit}"
    if isinstance(value, dict):
        told = {key: _kind(schema, key) if schema else (unit, None) for key in value}
        text = ", ".join(f"{key} {_part(each, *told[key])}" for key, each in value.items() if each not in ([], {}))
    elif isinstance(value, list):
        holds_tables = any(isinstance(each, dict) for each in value)
        parts = ", ".join(_part(each, "", schema) for each in value)
        text = parts if holds_tables or not unit else _with_unit(value, parts, unit)
    else:
        text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) < 200 else f"{text[:197]}..."


def _part(value: Any, unit: str = "", schema: type[Table] | None = None) -> str:
    if isinstance(value, list):
        return _with_unit(value, _shown(value), unit) if unit else f"({_shown(value, schema=schema)})"
    return _shown(value, unit, schema)


def _with_unit(value: list[Any], parts: str, unit: str) -> str:
    """Return the entries of a list with their unit; a stress of three numbers or more has gradients after it."""
    innermost = value[0] if isinstance(value[0], list) else value
    if unit == STRESS.unit and len(innermost) > 2:
        unit = f"{unit}, {STRESS_GRADIENT.unit}"
    return f"({parts}) {unit}" if len(value) > 1 and not isinstance(value[0], list) else f"{parts} {unit}"
