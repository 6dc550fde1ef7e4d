"""The doors of the program, each with its good inputs and what is done to them."""

from __future__ import annotations

from ..inputs import Target
from . import calls, commands, meshes, models, results, tables

TARGETS: dict[str, Target] = {
    target.name: target
    for target in (
        Target("calls", calls.draw, 0.34),
        Target("traces", tables.draw_traces, 0.16, tables.prepare_traces),
        Target("meshes", meshes.draw, 0.2, meshes.prepare),
        Target("models", models.draw, 0.2),
        Target("bolts", tables.draw_bolts, 0.06),
        Target("results", results.draw, 0.03, results.prepare),
        Target("commands", commands.draw, 0.01, results.prepare),
    )
}
