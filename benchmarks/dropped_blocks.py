"""Random convex blocks that fall onto each other in space (``python -m benchmarks.dropped_blocks``).

A block begins a millimetre above a fixed one, turned at random: it falls with corners and edges first.
"""

from __future__ import annotations

import sys
from collections import Counter
from typing import Any

from benchmarks.pages import seeds_command
from examples.numbers.pages import markdown
from tests.scenes.dropped_blocks import KINDS, judged

MAKER = "python -m benchmarks.dropped_blocks"
MOST = 0.01  # of the smallest free block's volume


def table(records: list[dict[str, Any]]) -> str:
    """Return the models by kind: verdicts, and how many blocks overlap on the way and at the end."""
    rows = []
    for kind in KINDS:
        chosen = [r for r in records if r["kind"] == kind]
        verdicts = Counter(r["verdict"] for r in chosen)
        deep = [sum(r[name] > MOST for r in chosen) for name in ("worst", "last")]
        counts = [len(chosen), *(verdicts[name] for name in ("stable", "unstable", "not_converged")), *deep]
        rows.append((kind, *map(str, counts)))
    shares = "overlap above 1 % on the way", "at the end"
    return markdown(("blocks", "models", "stable", "unstable", "not converged", *shares), rows)


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, 120, judged, table))
