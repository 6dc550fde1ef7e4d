"""One campaign beside a former one: verdicts lost and gained, model by model, and times, family by family."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.campaign.oracles import PROOFS
from benchmarks.campaign.outcome import DECIDED, Record
from benchmarks.campaign.store import Key
from benchmarks.campaign.tables import Row, contradictions, oracle_of, seconds_of

SHORTEST = 0.02  # processor seconds: ratios of shorter runs are noise
PAIRED = ("lost", "gained", "changed", "new proof", "new hint", "proof gone", "hint gone")


@dataclass(frozen=True, eq=False, kw_only=True)
class Pair:
    """A model in both campaigns."""

    key: Key
    before: Record
    now: Record

    @property
    def name(self) -> str:
        """Family and seed."""
        return f"{self.key[0]} {self.key[1]}"


def pairs_of(before: dict[Key, Record], now: dict[Key, Record]) -> tuple[list[Pair], int]:
    """Return the models that are in both, and how many have the same name but are others now."""
    both = [Pair(key=key, before=before[key], now=record) for key, record in now.items() if key in before]
    same = [pair for pair in both if pair.before.get("digest", "") == pair.now.get("digest", "") or _no_digest(pair)]
    return same, len(both) - len(same)


def _no_digest(pair: Pair) -> bool:
    """Return whether a run gave no results, so that nothing says whether the model is the same."""
    return "digest" not in pair.before or "digest" not in pair.now


def differences(pairs: list[Pair]) -> list[Row]:
    """Return every model that is judged otherwise than before."""
    rows = [["what", "model", "before", "now"]]
    for pair in pairs:
        was, is_now = pair.before["status"], pair.now["status"]
        if was != is_now:
            kinds = {(True, False): "lost", (False, True): "gained", (True, True): "changed"}
            kind = kinds.get((was in DECIDED, is_now in DECIDED), "undecided")
            rows.append([kind, pair.name, was, is_now])
        old, new = ({oracle_of(text): text for text in contradictions(r)} for r in (pair.before, pair.now))
        for oracle in sorted(set(old) ^ set(new)):
            weight = "proof" if oracle in PROOFS else "hint"
            kind = f"new {weight}" if oracle in new else f"{weight} gone"
            rows.append([kind, pair.name, old.get(oracle, ""), new.get(oracle, "")])
    rank = {name: number for number, name in enumerate(PAIRED)}
    return [rows[0], *sorted(rows[1:], key=lambda row: (rank.get(row[0], len(rank)), row[1]))]


def ratios(pairs: list[Pair], limits: tuple[float, float]) -> list[Row]:
    """Return times over former times and the like, family by family: of the sums, and the median and spread of each."""
    head = [
        "family",
        "models",
        "lost",
        "gained",
        "changed",
        "sum s",
        "median s",
        "5 to 95 %",
        "steps",
        "factorizations",
    ]
    rows = [head]
    for family in [*dict.fromkeys(pair.key[0] for pair in pairs), "all"]:
        chosen = [pair for pair in pairs if family in (pair.key[0], "all")]
        seconds = np.array([(seconds_of(p.before, limits[0]), seconds_of(p.now, limits[1])) for p in chosen])
        long = seconds[seconds.max(axis=1) > SHORTEST]
        each = long[:, 1] / np.maximum(long[:, 0], 1e-9)
        verdicts = [(p.before["status"] in DECIDED, p.now["status"] in DECIDED, p) for p in chosen]
        rows.append(
            [
                family,
                str(len(chosen)),
                str(sum(was and not now for was, now, _ in verdicts)),
                str(sum(now and not was for was, now, _ in verdicts)),
                str(sum(was and now and p.before["status"] != p.now["status"] for was, now, p in verdicts)),
                _over(seconds[:, 1].sum(), seconds[:, 0].sum()),
                f"{np.median(each):.2f}" if each.size else "-",
                f"{np.quantile(each, 0.05):.2f} to {np.quantile(each, 0.95):.2f}" if each.size else "-",
                *(_over(*(sum(r.get(key, 0) for r in side) for side in _sides(chosen))) for key in COUNTS),
            ]
        )
    return rows


COUNTS = ("steps", "factorizations")


def _sides(pairs: list[Pair]) -> tuple[list[Record], list[Record]]:
    """Return the records of now and of before, of runs that ended in both."""
    ended = [pair for pair in pairs if "steps" in pair.before and "steps" in pair.now]
    return [pair.now for pair in ended], [pair.before for pair in ended]


def _over(now: float, before: float) -> str:
    return f"{now / before:.2f}" if before > 0 else "-"
