"""Flow in the joints as ``run`` and the report tell it: what enters and leaves, and where."""

from __future__ import annotations

from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.records import StageResult

LITRES = ((1.0, "l/s"), (60.0, "l/min"), (3600.0, "l/h"))  # per second
LEAST = 0.1  # of a unit: what is less is told in the next smaller

FLOW_HEADER = ("water in the joints", "leaves", "enters")


def discharge_text(discharge: float) -> str:
    """Return a discharge [m2/s] in litres, per metre of thickness.

    Examples
    --------
    >>> discharge_text(2.5e-3), discharge_text(-5e-6), discharge_text(1e-7), discharge_text(0.0)
    ('2.5 l/s per m', '-0.3 l/min per m', '0.36 l/h per m', '0 l/s per m')
    """
    factor, unit = in_litres(discharge)
    return f"{factor * discharge:.4g} {unit} per m"


def in_litres(discharge: float) -> tuple[float, str]:
    """Return the factor that turns a discharge [m2/s] into litres, in the unit that suits it, and that unit."""
    factor, unit = next(((f, u) for f, u in LITRES if discharge == 0 or abs(1e3 * discharge * f) >= LEAST), LITRES[-1])
    return 1e3 * factor, unit


def flow_rows(stage: StageResult) -> list[tuple[str, ...]]:
    """Return what ``run`` prints of the places where water enters and leaves; nothing without flow."""
    flow = stage.flow
    if flow is None:
        return []
    rows = [
        (name, discharge_text(value) if value > 0 else "-", discharge_text(-value) if value < 0 else "-")
        for name, value in zip(flow.places, flow.leaving.tolist(), strict=True)
    ]
    return [*rows, ("all", discharge_text(flow.through), discharge_text(float(-flow.outflow.clip(max=0.0).sum())))]


def how_solved(flow: FlowResult) -> str:
    """Return how flow and blocks were brought together, and how well the water balances."""
    balance = f"the water of every node balances to {flow.imbalance:.1g} of the greatest discharge"
    if flow.rounds == 0:
        return balance
    turns = "1 turn" if flow.rounds == 1 else f"{flow.rounds} turns"
    return f"{turns} of flow and blocks, the last changed pressures by {flow.change:.1g} of the greatest; {balance}"
