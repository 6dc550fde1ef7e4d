"""What a verdict hangs on where two twins disagree: copies of the model that differ from it by rounding alone.

The same model in other units. Lengths times 4 and stresses times 16 change no digit of a number, so that a tolerance
that depends on units shows, and nothing else. Other factors change the last digits, and where a verdict changes with
these, rounding alone is enough to change it. Whether an order or an orientation has a part in it too is not asked.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

from benchmarks.campaign import outcome
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.outcome import Record
from benchmarks.campaign.scene import Scene
from benchmarks.campaign.store import Key
from benchmarks.campaign.tables import Row, contradictions, oracle_of
from benchmarks.campaign.transforms import scaled
from benchmarks.campaign.trial import generator_of, trial_of

EXACT = 4.0, 16.0  # powers of four, whose roots too are of two
CLOSE = 1e-3  # of the movement: factors of a matrix may round otherwise, for pivots are chosen by size
HEAD = [
    "model",
    "blocks",
    "as given",
    "twin",
    "in units of 4 and 16",
    "copies: stable",
    "unstable",
    "moved, of a block",
]


def of_twins(records: dict[Key, Record], copies: int, tell: Callable[[str], None]) -> list[Row]:
    """Return a row for every model whose twin has another verdict: its verdict in other units, and in many copies."""
    rows = [HEAD]
    for (family, seed), record in records.items():
        for text in contradictions(record):
            if oracle_of(text) == "symmetry":
                tell(f"{family} {seed}")
                rows.append(_row(family, seed, record, copies))
    return rows


def _row(family: str, seed: int, record: Record, copies: int) -> Row:
    scene = trial_of(FAMILIES[family], seed).scene
    here, exact = _run(scene), _run(scaled(scene, *EXACT))
    close = abs(exact["moved"] - here["moved"]) <= CLOSE * here["moved"]
    generator = generator_of("copies", family, seed)
    factors = [tuple(10 ** generator.uniform(-1, 1, 2)) for _ in range(copies)]
    others = [_run(scaled(scene, float(length), float(length * density))) for length, density in factors]
    count = Counter(other["status"] for other in others)
    return [
        f"{family} {seed}",
        str(scene.count),
        here["status"],
        _twins(record),
        f"{exact['status']}, {'the same movement' if close else 'rounds otherwise'}",
        str(count["stable"]),
        str(count["unstable"]),
        _range(other["moved"] for other in (here, *others)),
    ]


def _run(scene: Scene) -> Record:
    return outcome.record_of(scene, *outcome.run(scene))


def _twins(record: Record) -> str:
    return ", ".join(f"{kind} {status}" for kind, status in record["facts"]["twins"].items() if kind != "stronger")


def _range(values: Iterable[float]) -> str:
    found = sorted(values)
    return f"{found[0]:.2g} to {found[-1]:.2g}"
