"""Random combinations of features on a small wall: each has an answer that holds, or a message.

``python -m benchmarks.combinations -n N``. Even seeds are in the plane, odd ones in space. Rocks, zones, joint laws,
supports, loads, water, flow, in-situ stress, bolts, histories and stages are drawn at random. Each result is checked,
saved, verified, read back, run again and drawn. A combination fails that ends with another error than
`bsm.ModelError`, or whose stable stages do not hold.
"""

from __future__ import annotations

import sys

from benchmarks.combinations.judge import in_turn, table
from benchmarks.pages import seeds_command

if __name__ == "__main__":
    sys.exit(seeds_command("python -m benchmarks.combinations", __doc__, 300, in_turn, table))
