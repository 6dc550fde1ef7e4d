"""Newmark's displacement in words and as JSON."""

from __future__ import annotations

from typing import Any

from bsm_mesh.safety.earthquake import Newmark, SlidingSide
from bsm_mesh.text.tables import engineering

HEADER = ("to the", "yields at, g", "slides", "turned over", "shaken")


def side_rows(answer: Newmark) -> list[tuple[str, ...]]:
    """Return a row a side: yield acceleration, displacement by both signs of the record, that of the shaken stage."""
    rows: list[tuple[str, ...]] = []
    for side in answer.sides:
        shaken = "-" if answer.shaken is None else engineering(answer.shaken.moved[side.side][1], "m")
        rows.append((side.side, _yields(side), *_displacements(side), shaken))
    return rows


def _yields(side: SlidingSide) -> str:
    stable, unstable = side.limit.stable, side.limit.unstable
    assert stable is not None
    if unstable is None:
        return f"above {abs(stable):.4g}"
    return f"{abs(stable):.4g} to {abs(unstable):.4g}"


def _displacements(side: SlidingSide) -> tuple[str, str]:
    if side.sliding is None or side.turned is None:
        return engineering(0.0, "m"), engineering(0.0, "m")
    return _range(side.least, side.sliding.permanent), _range(side.turned_least, side.turned.permanent)


def _range(least: float, most: float) -> str:
    ends = [f"{engineering(each, 'm')}" for each in (least, most)]
    short = ends[0].rpartition(" ")[0] if ends[0].split()[1:] == ends[1].split()[1:] else ends[0]
    return ends[0] if ends[0] == ends[1] else f"{short} to {ends[1]}"


def remarks(answer: Newmark) -> list[str]:
    """Return notes for the reader, a sentence each."""
    found = [f"Greatest horizontal acceleration of the record: {answer.peak:.4g} g."]
    found += [f"{side.side}: {note}." for side in answer.sides for note in side.limit.notes]
    undecided = [side.side for side in answer.sides if not side.limit.is_decided]
    found += [f"{side}: trials without a verdict leave a wide range." for side in undecided]
    shaken = answer.shaken
    if shaken is not None:
        found.append(f"Shaken stage '{shaken.stage}': {shaken.verdict} ({shaken.reason}).")
        for side in answer.sides:
            block, far = shaken.moved[side.side]
            if far > 0:
                found.append(f"Greatest displacement to the {side.side}: {far:.4g} m, block {block}.")
    return found


def told_of(answer: Newmark) -> dict[str, Any]:
    """Return an answer as JSON holds it."""
    shaken = answer.shaken
    return {
        "stage": answer.stage,
        "peak_acceleration": answer.peak,
        "sides": [
            {
                "side": side.side,
                "stable": side.limit.stable,
                "unstable": side.limit.unstable,
                "undecided": list(side.limit.undecided),
                "decided": side.limit.is_decided,
                "displacement": [side.least, 0.0 if side.sliding is None else side.sliding.permanent],
                "turned_over": [side.turned_least, 0.0 if side.turned is None else side.turned.permanent],
                "blocks": [] if side.limit.mechanism is None else side.limit.mechanism.blocks.tolist(),
            }
            for side in answer.sides
        ],
        "shaken": None
        if shaken is None
        else {
            "stage": shaken.stage,
            "status": shaken.status.value,
            "verdict": shaken.verdict,
            "reason": shaken.reason,
            "displacement": {side: {"block": block, "metres": far} for side, (block, far) in shaken.moved.items()},
        },
        "remarks": remarks(answer),
    }
