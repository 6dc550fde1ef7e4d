"""The campaigns' counts: kept in a file, and as tables in docs/campaigns.md, which are never typed."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from .inputs import FAULTS, ROOT

FILE = Path(__file__).with_name("counts.json")
PAGE = ROOT / "docs" / "campaigns.md"
BEGIN, END = "<!-- counts: python -m tools.campaigns counts -->\n", "<!-- end of counts -->\n"
TITLES = {
    "fuzz": "Faulty inputs",
    "verdict": "Slips of the pen and changes of meaning in unstable models",
    "kill": "Runs that are killed",
    "disk": "Full disks",
}


def gather(folder: Path, date: str) -> dict[str, Any]:
    """Return the counts of the latest run of each campaign, which say of what sources; others stay as they were."""
    known = stored()
    for name in TITLES:
        for path in sorted(folder.glob(f"{name}-*/state.json"), key=os.path.getmtime)[-1:]:
            told = json.loads(path.read_text())
            known[name] = {
                "date": date,
                "seed": told["seed"],
                "sources": told["sources"],
                "parts": {part: {"counts": dict(sorted(of["counts"].items()))} for part, of in told["parts"].items()},
                "findings": sorted(
                    (
                        {name: of[name] for name in ("part", "kind", "signature", "count")}
                        | {"input": of["examples"][0]}
                        for of in told["findings"].values()
                    ),
                    key=lambda of: (of["part"], of["kind"], -of["count"], of["signature"]),
                ),
            }
    return known


def stored() -> dict[str, Any]:
    """Return the counts that are kept, by campaign."""
    known: dict[str, Any] = json.loads(FILE.read_text()) if FILE.exists() else {}
    return known


def tables(known: dict[str, Any]) -> str:
    """Return the tables of all campaigns as Markdown."""
    lines: list[str] = []
    for name, title in TITLES.items():
        if name not in known:
            continue
        told = known[name]
        parts = {part: of["counts"] for part, of in told["parts"].items()}
        kinds = _kinds(name, parts)
        lines += [f"### {title}", "", f"{told['date']}, seed {told['seed']}, sources {told['sources']}.", ""]
        lines += [f"| {' | '.join(['', 'all', *kinds])} |", f"|---|{'---:|' * (len(kinds) + 1)}"]
        rows = [(part, *_row(name, counts, kinds)) for part, counts in parts.items()]
        total = tuple(sum(row[k] for row in rows) for k in range(1, len(kinds) + 2))
        for part, *numbers in [*rows, ("**all**", *total)] if len(rows) > 1 else rows:
            lines.append(f"| {part} | {' | '.join(f'{number:,}'.replace(',', ' ') for number in numbers)} |")
        lines += ["", *_findings(told["findings"])]
    return "\n".join(lines)


def _findings(findings: list[dict[str, Any]]) -> list[str]:
    """Return the table of what a campaign found."""
    if not findings:
        return ["Nothing was found.", ""]
    lines = [f"Found ({len(findings)}):", "", "| where | what | signature | times | for example input |"]
    lines.append("|---|---|---|---:|---:|")
    for of in findings:
        signature = of["signature"].replace("|", "\\|")[:120]
        lines.append(f"| {of['part']} | {of['kind']} | `{signature}` | {of['count']} | {of['input']} |")
    return [*lines, ""]


def _kinds(name: str, parts: dict[str, dict[str, int]]) -> list[str]:
    """Return the columns of a campaign: what there was, and all that must not be."""
    there = list(dict.fromkeys(kind for counts in parts.values() for kind in counts))
    if name == "fuzz":
        return ["ok", "refused", *FAULTS]
    if name == "verdict":
        from .verdict import BROKEN, CLASSES, FALSE

        return [*CLASSES, FALSE, BROKEN]
    return [*(kind for kind in there if kind != "faults"), "faults"]


RESUMED = ("resumed", "begins at the start", "was finished")  # what became of a run that was killed, continued with


def _row(name: str, counts: dict[str, int], kinds: list[str]) -> list[int]:
    """Return the numbers of a part; in the kill and disk campaigns a strike has a kind, and an end."""
    ends = ("struck", "ended before it was struck", "refused", "finished", "broken", "faults", *RESUMED)
    counted = counts if name in ("fuzz", "verdict") else {k: n for k, n in counts.items() if k not in ends}
    return [sum(counted.values()), *(counts.get(kind, 0) for kind in kinds)]


def write(folder: Path, date: str) -> None:
    """Store the counts and put the tables into the page."""
    known = gather(folder, date)
    FILE.write_text(json.dumps(known, indent=1) + "\n")
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), known), encoding="utf-8")


def page(text: str, known: dict[str, Any]) -> str:
    """Return a page with the tables between its marks."""
    before, _, rest = text.partition(BEGIN)
    return f"{before}{BEGIN}\n{tables(known)}\n{END}{rest.partition(END)[2]}"
