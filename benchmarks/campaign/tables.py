"""Tables of a campaign, as text and as Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.campaign.oracles import HINTS, PROOFS
from benchmarks.campaign.outcome import ERROR, TIMEOUT, Record
from benchmarks.campaign.store import Key
from examples.numbers.pages import markdown

Row = list[str]
VERDICTS = ("stable", "unstable", "not_converged", TIMEOUT, ERROR)
SPREADS = ("steps", "factorizations", "seconds")
HEAD = [
    "family", "models", "stable", "unstable", "not conv.", "timeout", "error", "proofs", "hints",
    "steps", "factorizations", "processor s", "sum s", "methods",
]  # fmt: skip
ALL = "all"


def of_families(records: dict[Key, Record], limit: float) -> list[Row]:
    """Return a row a family, and one of all: counts, and of the others median / 95 % / greatest."""
    families = list(dict.fromkeys(family for family, _ in records))
    rows = [HEAD]
    for name in [*families, ALL]:
        chosen = [record for (family, _), record in records.items() if name in (family, ALL)]
        count = Counter(record["status"] for record in chosen)
        found = Counter(oracle_of(text) for record in chosen for text in contradictions(record))
        methods: Counter[str] = sum((Counter(record.get("methods", {})) for record in chosen), Counter())
        seconds = [seconds_of(record, limit) for record in chosen]
        rows.append(
            [
                name,
                str(len(chosen)),
                *(str(count[verdict]) for verdict in VERDICTS),
                str(sum(found[oracle] for oracle in PROOFS)),
                str(sum(found[oracle] for oracle in HINTS)),
                *(spread([record[key] for record in chosen if key in record], key) for key in SPREADS[:2]),
                spread(seconds, "seconds"),
                f"{sum(seconds):.0f}",
                ", ".join(f"{method} {times}" for method, times in methods.most_common()),
            ]
        )
    return rows


def of_oracles(records: dict[Key, Record]) -> list[Row]:
    """Return how many models each oracle judged, and how many contradict it."""
    judged: Counter[str] = Counter()
    found: Counter[str] = Counter()
    for record in records.values():
        facts, stable = record.get("facts", {}), record["status"] == "stable"
        twins = facts.get("twins", {})
        judged.update({"check": stable, "sense": record["status"] == "unstable", "end": "lack_at_end" in facts})
        judged.update({"start": "admissible" in facts, "programs": "lack_at_start" in facts})
        judged.update({"closed form": facts.get("judged", False), "friction": "stronger" in twins})
        judged.update({"symmetry": bool(set(twins) - {"stronger"})})
        found.update(oracle_of(text) for text in contradictions(record))
    kinds = {**dict.fromkeys(PROOFS, "proof"), **dict.fromkeys(HINTS, "hint")}
    return [["oracle", "", "models", "contradictions"]] + [
        [name, kind, str(judged[name]), str(found[name])] for name, kind in kinds.items()
    ]


def of_models(
    records: dict[Key, Record],
    limits: dict[Key, float],
    before: dict[Key, Record] | None = None,
    limits_before: dict[Key, float] | None = None,
) -> list[Row]:
    """Return a row a model, for campaigns of few and large ones; beside it what a former one made of it, if given."""
    rows = [["model", "blocks", "verdict", "steps", "factorizations", "processor s", "moved"]]
    former = ["verdict before", "steps before", "moved before", "s before", "now over before"]
    rows[0] += former if before is not None else []
    for key, record in records.items():
        numbers = [str(record.get(name, "")) for name in ("steps", "factorizations")]
        row = [key[0], str(record.get("blocks", "")), record["status"], *numbers, _taken(record, limits[key])]
        row.append(_moved(record))
        if before is not None:
            was, limit = before.get(key), (limits_before or {}).get(key, 0.0)
            row += [""] * len(former) if was is None else _beside(record, was, limit)
        rows.append(row)
    return rows if before is None else [*rows, _sum(records, before)]


def _sum(records: dict[Key, Record], before: dict[Key, Record]) -> Row:
    """Return the row of the sums of processor time, over the models with an end in both campaigns."""
    pairs = [(record, before[key]) for key, record in records.items() if key in before]
    pairs = [pair for pair in pairs if all("seconds" in record for record in pair)]
    now, then = (
        (sum(float(record["seconds"]) for record in side) for side in zip(*pairs, strict=True)) if pairs else (0, 0)
    )
    ratio = f"{now / then:.2f}" if then > 0 else ""
    return [f"sum of {len(pairs)}", *[""] * 4, f"{now:.1f}", *[""] * 4, f"{then:.1f}", ratio]


def _beside(record: Record, was: Record, limit: float) -> Row:
    """Return what a former campaign made of a model, and the processor time now over that."""
    decided = TIMEOUT not in (was["status"], record["status"])
    ratio = f"{record['seconds'] / was['seconds']:.2f}" if decided else ""
    return [was["status"], str(was.get("steps", "")), _moved(was), _taken(was, limit), ratio]


def _moved(record: Record) -> str:
    return f"{record['moved']:.2g}" if "moved" in record else ""


def _taken(record: Record, limit: float) -> str:
    return f"{'over ' if record['status'] == TIMEOUT else ''}{seconds_of(record, limit):.1f}"


def of_contradictions(records: dict[Key, Record]) -> list[Row]:
    """Return every contradiction with the model it is of: proofs first."""
    order = {name: number for number, name in enumerate((*PROOFS, *HINTS))}
    found = [(order[oracle_of(t)], key, t, r) for key, r in records.items() for t in contradictions(r)]
    rows = [["model", "blocks", "contradiction"]]
    for _, (family, seed), text, record in sorted(found, key=lambda item: item[:2]):
        rows.append([f"{family} {seed}", str(record["blocks"]), text])
    return rows


def of_undecided(records: dict[Key, Record], limit: float) -> list[Row]:
    """Return the models without a verdict."""
    rows = [["model", "blocks", "verdict", "factorizations", "processor s", "reason"]]
    for (family, seed), record in records.items():
        if record["status"] not in ("stable", "unstable"):
            numbers = [str(record.get(key, "")) for key in ("blocks",)]
            seconds = f"{seconds_of(record, limit):.1f}" if record["status"] != ERROR else ""
            rows.append(
                [
                    f"{family} {seed}",
                    *numbers,
                    record["status"],
                    str(record.get("factorizations", "")),
                    seconds,
                    record.get("reason", ""),
                ]
            )
    return rows


def contradictions(record: Record) -> list[str]:
    """Return what oracles found against a model."""
    return list(record.get("contradictions", []))


def oracle_of(text: str) -> str:
    """Return the name of the oracle that found a contradiction."""
    return text.partition(":")[0]


def seconds_of(record: Record, limit: float) -> float:
    """Return the processor seconds of a run; the limit, where it was exceeded."""
    return limit if record["status"] == TIMEOUT else float(record.get("seconds", 0.0))


def spread(values: Sequence[float], key: str = "") -> str:
    """Return median / 95 % / greatest."""
    if not values:
        return "-"
    form = "{:.2f}" if key == "seconds" else "{:.0f}"
    parts = (np.median(values), np.quantile(values, 0.95), np.max(values))
    return " / ".join(form.format(part) for part in parts)


def as_text(rows: Iterable[Row]) -> str:
    """Return a table for a terminal."""
    rows = list(rows)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = [
        "  ".join(
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines)


def as_markdown(rows: Iterable[Row]) -> str:
    """Return a table in Markdown."""
    head, *others = ([cell.replace("|", "\\|") for cell in line] for line in rows)
    return markdown(head, others)
