"""The command ``back-analysis``: the value of a number of a model file that gives the measurement."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from bsm_mesh.model.quantity import typed
from bsm_mesh.modelfile.build_mesh import stdout_to_stderr
from bsm_mesh.modelfile.variation import Variation
from bsm_mesh.safety.measurements import BackAnalysis, Measured, back_analysis
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import engineering, print_table
from bsm_mesh.text.terminal import say, say_json

EXIT_DONE, EXIT_NOT_FOUND = 0, 3
HEADER = ("measured at", "movement", "deviation", "value", "from", "to")


def analyse_back(
    path: Path,
    told: Progress,
    *,
    vary: tuple[str, str, str],
    measured: tuple[tuple[float, float, str, float, float], ...],
    as_json: bool,
    scripts: bool,
    **asked: Any,
) -> int:
    """Find the value, print it, and return the exit code: 3 where none in the range gives the measurement."""
    name = vary[0]
    rows = [Measured(point=(x, y), component=part, movement=m, deviation=d) for x, y, part, m, d in measured]  # type: ignore[arg-type]
    with told as progress, stdout_to_stderr():
        variation = Variation(path, scripts=scripts)
        good, bad = variation.ends(name, [typed(word) for word in vary[1:]])
        loaded = variation.model({})
        asked |= {"options": loaded.options, "quantity": name, "unit": variation.unit(name)}
        at = partial(variation.with_value, name)
        found = back_analysis(at, good, bad, rows, report=progress.report, **asked)
    if as_json:
        say_json(told_of(found))
    else:
        print_table(loaded.model.title or str(path), HEADER, table_rows(found))
        say(f"{found}.")
    return EXIT_DONE if found.value is not None else EXIT_NOT_FOUND


def table_rows(found: BackAnalysis) -> list[tuple[str, ...]]:
    """Return the printed rows of every measurement."""
    return [
        (
            f"({each.measured.point[0]:g}, {each.measured.point[1]:g}), {each.measured.component}",
            engineering(each.measured.movement, "m"),
            engineering(each.measured.deviation, "m"),
            *("-" if value is None else f"{value:.5g}" for value in (each.value, each.low, each.high)),
        )
        for each in found.estimates
    ]


def told_of(found: BackAnalysis) -> dict[str, Any]:
    """Return the answer as JSON holds it."""
    return {
        "quantity": found.quantity,
        "unit": found.unit,
        "value": found.value,
        "deviation": found.deviation,
        "estimates": [
            {
                "point": list(each.measured.point),
                "component": each.measured.component,
                "movement": each.measured.movement,
                "deviation": each.measured.deviation,
                "value": each.value,
                "low": each.low,
                "high": each.high,
            }
            for each in found.estimates
        ],
        "trials": [{"value": trial.value, "status": trial.status.value} for trial in found.trials],
        "answer": str(found),
    }
