"""Summaries of a model, of results and of a factor of safety for a notebook, as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from typing import TYPE_CHECKING

from bsm_mesh.errors import counted, place
from bsm_mesh.results.results import Results
from bsm_mesh.safety.answer import Safety
from bsm_mesh.text.result_text import tables_of
from bsm_mesh.text.safety_text import answer_rows, spread_rows
from bsm_mesh.text.tables import engineering

if TYPE_CHECKING:
    from bsm_mesh.model.materials import Joint, Rock
    from bsm_mesh.model.model import Model


def model_html(model: Model) -> str:
    """Return a summary of a model: how many of what, with their numbers."""
    blocks = model.blocks
    area = blocks.moments.area
    low, high = blocks.vertices.min(axis=0), blocks.vertices.max(axis=0)
    rows = [
        ("blocks", f"{blocks.count}, of {engineering(area.min(), 'm2')} to {engineering(area.max(), 'm2')}"),
        ("extent", f"{place(low)} to {place(high)} m"),
        *((f"rock {rock.name}", _rock(rock)) for rock in model.rocks),
        *((f"joint {joint.name}", _joint(joint)) for joint in model.joints),
        ("default joint", model.default_joint or ""),
        ("supports, loads, bolts", f"{len(model.supports)}, {len(model.loads)}, {len(model.bolts)}"),
        ("stress in situ", "" if model.in_situ is None else model.in_situ.method),
        ("flow", "" if model.flow is None else f"steady, {counted(len(model.flow.head), 'level')}"),
        ("water", "" if model.water is None else counted(len(model.water.table), "table")),
        ("stages", ", ".join(stage.name for stage in model.stages)),
        ("histories", ", ".join(history.name for history in model.histories)),
    ]
    return _page(model.title or "Model", _table((), (row for row in rows if row[1])))


def results_html(results: Results) -> str:
    """Return the tables of results that the terminal shows."""
    parts = []
    for table in tables_of(results):
        parts += [_table(table.header if any(table.header) else (), table.rows)] if table.rows else []
        parts += [f"<p>{escape(line)}</p>" for line in table.lines]
    return _page(results.title or "Results", *parts)


def safety_html(answer: Safety) -> str:
    """Return the rows of a factor of safety that the terminal shows, and its notes."""
    spread = spread_rows(answer)
    parts = [_table((), answer_rows(answer))]
    parts += [_table(("other starts", "last stable", "first unstable"), spread)] if spread else []
    return _page(str(answer), *parts, *(f"<p>note: {escape(note)}</p>" for note in answer.notes))


def _rock(rock: Rock) -> str:
    stiff = "rigid" if rock.young is None else f"E {engineering(rock.young, 'Pa')}, nu {rock.poisson:g}"
    return f"{engineering(rock.unit_weight, 'N/m3')}, {stiff}"


def _joint(joint: Joint) -> str:
    normal, shear = joint.contact_stiffness
    return f"kn {engineering(normal, 'Pa/m')}, ks {engineering(shear, 'Pa/m')}; {_law(joint.law)}"


def _law(law: object) -> str:
    if law is None:
        return "elastic"
    if not is_dataclass(law):
        return type(law).__name__
    given = ((one.name, getattr(law, one.name)) for one in fields(law))
    return f"{type(law).__name__}({', '.join(f'{name}={value}' for name, value in given if value is not None)})"


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{f'<tr>{head}</tr>' if head else ''}{body}</table>"


def _page(title: str, *parts: str) -> str:
    return f"<div><b>{escape(title)}</b>{''.join(parts)}</div>"
