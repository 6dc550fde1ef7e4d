"""Numbers of docs/safety.md: factors that are known, and what they depend on."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from functools import cache
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import bsm_mesh as bsm
from bsm_mesh.commands.starters import write_starter
from bsm_mesh.pictures.safety_pictures import draw_mechanism
from bsm_mesh.safety.answer import Safety
from bsm_mesh.safety.factor import factor_of_safety
from bsm_mesh.text.safety_text import answer_rows
from examples.numbers.pages import Table, markdown
from tests.scenes.known_factors import known
from tests.scenes.large import jointed_slope

PAGE, PICTURE = "docs/safety.md", "docs/safety.png"
ROOT = Path(__file__).parents[2]
WIDTH = 0.002


def known_factors() -> str:
    """Return the table of factors that are known."""
    rows = []
    for case in known():
        found = factor_of_safety(case.build(), joints=case.joints, tolerance=WIDTH)
        limit = f"{found.limit.factor:.4f}"
        rows.append((case.name, f"{case.factor:.4f}", *_ends(found), limit, str(len(found.trials))))
    return markdown(("model", "known", "stable", "unstable", "bound", "trials"), rows)


def starter_slope() -> str:
    """Return what the command prints of the starter `slope` that rounding does not decide.

    Which blocks fail beyond the limit it does, and how much of a joint slips just before: the picture shows them.
    """
    _, found = _slope()
    rows = [
        row
        for row in answer_rows(found)
        if not row[0].startswith(("trials", "blocks that fail", "at the last stable value"))
    ]
    return markdown(("", ""), rows)


def draw_starter_slope() -> None:
    """Draw what fails."""
    title, found = _slope()
    draw_mechanism(found, f"{title}: {found}", ROOT / PICTURE)


@cache
def _slope() -> tuple[str, Safety]:
    model = starter("slope")
    return model.title, factor_of_safety(model, replace(model.options or bsm.Options(), linear_solver="superlu"))


def larger() -> Iterator[tuple[str, bsm.Model]]:
    """Return models whose factor nobody knows: name, model."""
    for blocks, friction in ((170, 40.0), (400, 35.0)):
        yield (
            f"slope of two joint sets, {blocks} blocks wanted, friction {friction:g}",
            jointed_slope(blocks, friction).model(),
        )
    yield "starter `cavern`, bolted, after its bench", starter("cavern")
    yield "starter `tunnel`, bolted", starter("tunnel")


def starter(name: str) -> bsm.Model:
    """Return the model that `bsm-mesh new NAME` writes."""
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        write_starter(name, Path(folder) / name)
        return bsm.load(Path(folder) / name / "model.toml")


def dependence() -> str:
    """Return the table of factors and what they depend on."""
    rows = []
    for name, model in larger():
        found = factor_of_safety(model, spread=True)
        others = dict(found.spread)
        after, stiffer = (next(each for text, each in others.items() if word in text) for word in ("after", "stiff"))
        limit = f"{found.limit.factor:.3f}" if math.isfinite(found.limit.factor) else "none"
        rows.append((name, *_ends(found), limit, _value(after.stable), _value(stiffer.stable)))
    return markdown(("model", "stable", "unstable", "bound", "weakened at rest", "joints ten times as stiff"), rows)


def _value(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"


def _ends(found: Safety) -> tuple[str, str]:
    return _value(found.stable), _value(found.unstable)


TABLES: tuple[Table, ...] = (
    Table(name="starter-slope", page=PAGE, make=starter_slope, tolerance=0.02, draw=draw_starter_slope),
    Table(name="known-factors", page=PAGE, make=known_factors, tolerance=2e-3, is_slow=True),
    Table(name="dependence", page=PAGE, make=dependence, tolerance=0.02, is_slow=True),
)
