"""A factor of safety in words and as JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from bsm_mesh.errors import numbered, place
from bsm_mesh.safety.answer import Safety, with_unit
from bsm_mesh.safety.mechanism import Mechanism
from bsm_mesh.text.tables import engineering


def _value(value: float | None, unit: str = "") -> str:
    return "-" if value is None else with_unit(value, unit)


def answer_rows(answer: Safety) -> list[tuple[str, str]]:
    """Return the printed lines."""
    return rows_of(told_of(answer))


def rows_of(told: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return an answer as JSON holds it (`told_of`) in rows for a reader."""
    unit = told.get("unit", "")
    rows = [
        (f"{told['quantity']}: last stable", _value(told["stable"], unit)),
        ("first unstable", _value(told["unstable"], unit)),
        ("undecided between", ", ".join(_value(value, unit) for value in told["undecided"]) or "none"),
        ("limit analysis", told["limit_analysis"]["text"]),
    ]
    collapse = told["limit_analysis"].get("mechanism")
    if collapse is not None:
        rows.append(("blocks that must move beyond it", _extent(collapse)))
    fails = told["mechanism"]
    if fails is not None:
        rows.append(("blocks that fail", _extent(fails)))
        rows += [
            (
                f"at the last stable value: {name}",
                f"{100 * each['slipping']:.3g} % slips, {100 * each['open']:.3g} % open",
            )
            for name, each in fails["joints"].items()
        ]
    failed = next((trial for trial in told["trials"] if trial["value"] == told["unstable"]), None)
    if failed is not None:
        rows.append(("reason for failure", failed["reason"]))
    rows += [
        ("varied", told["changed"]),
        ("procedure", told["start"]),
        ("trials, processor time", f"{len(told['trials'])}, {told['seconds']:.3g} s"),
    ]
    return rows


def _extent(mechanism: Mapping[str, Any]) -> str:
    """Return the blocks of a mechanism in words: numbers, area or volume, and place."""
    at = place(round(x, 2) + 0.0 for x in mechanism["centre"])  # to the centimetre
    unit = "m2" if len(mechanism["centre"]) == 2 else "m3"
    size = f"{engineering(mechanism['area'], unit)}, {100 * mechanism['part']:.3g} % of all"
    return f"{numbered('block', mechanism['blocks'], 6)}: {size}, around {at} m"


def spread_rows(answer: Safety) -> list[tuple[str, ...]]:
    """Return the printed lines on the other starts."""
    return [(text, _value(each.stable), _value(each.unstable)) for text, each in answer.spread]


def told_of(answer: Safety) -> dict[str, Any]:
    """Return an answer as JSON holds it."""
    fails = answer.mechanism
    return {
        "quantity": answer.quantity,
        "unit": answer.unit,
        "stable": answer.stable,
        "unstable": answer.unstable,
        "undecided": list(answer.undecided),
        "closed": answer.is_closed,
        "limit_analysis": {
            "factor": answer.limit.factor if math.isfinite(answer.limit.factor) else None,
            "text": answer.limit.text,
            "proof": None if answer.limit.proof is None else answer.limit.proof.text,
            "mechanism": None if answer.collapse is None else _told_extent(answer.collapse),
        },
        "stage": answer.stage,
        "start": answer.start,
        "changed": answer.changed,
        "reference": answer.reference,
        "mechanism": None
        if fails is None
        else {
            **_told_extent(fails),
            "joints": {
                each.name: {"length": each.length, "slipping": each.slipping, "open": each.open}
                for each in fails.joints
            },
        },
        "spread": [{"start": text, "stable": each.stable, "unstable": each.unstable} for text, each in answer.spread],
        "trials": [
            {
                "value": trial.value,
                "verdict": trial.verdict.value,
                "movement": trial.moved,
                "reason": trial.reason,
                "seconds": trial.seconds,
            }
            for trial in answer.trials
        ],
        "seconds": answer.seconds,
        "answer": str(answer),
        "remarks": list(answer.notes),
    }


def _told_extent(mechanism: Mechanism) -> dict[str, Any]:
    """Return the blocks of a mechanism as JSON holds them."""
    return {
        "blocks": mechanism.blocks.tolist(),
        "area": mechanism.area,
        "part": mechanism.part,
        "centre": list(mechanism.centre),
    }
