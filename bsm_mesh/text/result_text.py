"""The tables of a result, in words, for the terminal, a notebook and the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from bsm_mesh.errors import named_stage, of_stage
from bsm_mesh.results.results import Results
from bsm_mesh.results.spread import spread_text
from bsm_mesh.text.beside_tables import beside_lines
from bsm_mesh.text.flow_text import FLOW_HEADER, flow_rows
from bsm_mesh.text.tables import (
    SPREAD_HEADER,
    describe,
    down_header,
    down_rows,
    fall_header,
    fall_reasons,
    fall_rows,
    joint_header,
    joint_rows,
    spread_rows,
    stage_header,
    stage_rows,
)


class ResultTable(NamedTuple):
    """A table and the sentences below it; either may be empty.

    Attributes
    ----------
    title : str
        Its heading.
    header : sequence of str
        Names of its columns.
    rows : sequence of sequence of str
        Their texts.
    texts : int
        Columns from the left that hold texts; the others hold numbers.
    lines : sequence of str
        Sentences.
    """

    title: str
    header: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    texts: int = 1
    lines: Sequence[str] = ()


def tables_of(results: Results, *, verbose: bool = False) -> list[ResultTable]:
    """Return the tables of a result, in the order of reading; `verbose`: with how the solution was found."""
    last, title = results.stages[-1], results.title or "Results"
    several = len(results.stages) > 1
    down, of = down_rows(results), results.unstable_blocks.size
    reasons = [row[:-1] for row in fall_rows(results)]  # sentences, too long for a column: lines below
    notes = [of_stage(stage.name, note) for stage in results.stages for note in stage.notes]
    found = [
        ResultTable(f"{title}: stages", stage_header(results), stage_rows(results) if several else (), 2),
        ResultTable(
            "Blocks that fell and were taken away", fall_header(results)[:-1], reasons, 2, fall_reasons(results)
        ),
        ResultTable(
            f"{title}: after {named_stage(last.name)}" if several else title,
            ("", ""),
            describe(results, verbose=verbose),
        ),
        ResultTable(
            "Every unstable block" if len(down) == of else f"The {len(down)} largest of {of} unstable blocks",
            down_header(results),
            down,
            2,
        ),
        ResultTable("Joints", joint_header(results), joint_rows(results)),
        ResultTable("Flow", FLOW_HEADER, flow_rows(last)),
        ResultTable("Histories at the end, and the values compared with them:", lines=beside_lines(results)),
        ResultTable("", lines=notes),
        ResultTable(
            "Other routes",
            SPREAD_HEADER,
            spread_rows(results.spread),
            2,
            [f"spread: {spread_text(results.spread)}"] if results.spread else (),
        ),
    ]
    return [table for table in found if table.rows or table.lines]
