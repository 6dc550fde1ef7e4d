"""Flow in the joints as ``run`` and the report show it: inflow and outflow, with their places."""

from __future__ import annotations

import numpy as np

from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.records import StageResult

LITRES = ((1.0, "l/s"), (60.0, "l/min"), (3600.0, "l/h"))  # per second
LEAST = 0.2  # of a unit: what is less is reported in the next smaller

FLOW_HEADER = ("water in the joints", "leaves", "enters")


def discharge_text(discharge: float, beside: float | None = None) -> str:
    """Return a discharge [m2/s] in litres, per metre of thickness, in the unit that suits it or the one `beside` it.

    Examples
    --------
    >>> discharge_text(2.5e-3), discharge_text(-5e-6), discharge_text(1e-7), discharge_text(0.0)
    ('2.5 l/s per m', '-0.3 l/min per m', '0.36 l/h per m', '0 l/s per m')
    >>> discharge_text(1e-7, beside=5e-6)
    '0.006 l/min per m'
    """
    factor, unit = in_litres(discharge if beside is None else beside)
    return f"{factor * discharge:.4g} {unit} per m"


def in_litres(discharge: float) -> tuple[float, str]:
    """Return the factor that turns a discharge [m2/s] into litres, in the unit that suits it, and that unit."""
    factor, unit = next(((f, u) for f, u in LITRES if discharge == 0 or abs(1e3 * discharge * f) >= LEAST), LITRES[-1])
    return 1e3 * factor, unit


def flow_rows(stage: StageResult) -> list[tuple[str, ...]]:
    """Return what leaves and enters at every place where water may, and in all, in one unit; nothing without flow."""
    flow = stage.flow
    if flow is None:
        return []
    enters = float(np.maximum(-flow.outflow, 0.0).sum())

    def told(value: float) -> str:
        return discharge_text(value, beside=flow.through) if value > 0 else "-"

    rows = [(name, told(value), told(-value)) for name, value in zip(flow.places, flow.leaving.tolist(), strict=True)]
    return [*rows, ("all", told(flow.through), told(enters))]


def how_solved(flow: FlowResult) -> str:
    """Return how flow and blocks were brought together, and how well the water balances."""
    rounding = flow.imbalance <= np.finfo(float).eps
    how_well = "rounding" if rounding else f"{flow.imbalance:.1g} of the greatest discharge"
    balance = f"the water of every node balances to {how_well}"
    if flow.rounds == 0:
        return balance
    turns = "1 turn" if flow.rounds == 1 else f"{flow.rounds} turns"
    return f"{turns} of flow and blocks, the last changed pressures by {flow.change:.1g} of the greatest; {balance}"
