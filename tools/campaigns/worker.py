"""A process that does inputs, as many as it is reported, and says the outcome of them.

It reads lines of JSON, ``{"target": ..., "seed": ..., "first": ..., "count": ..., "skip": [...]}``, and answers each
with one. The number of the input at hand is in a file, so that a watcher knows which one killed it or does not end.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import json
import mmap
import os
import resource
import signal
import sys
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

from .inputs import FAULTS, random_of
from .place import Place, place
from .targets import TARGETS

MEMORY = 12 * 2**30  # bytes of addresses: an input that wants more is reported so, and the machine lives on


def do_chunk(asked: dict[str, Any], good: Path, there: Place, mark: Any = None) -> dict[str, Any]:
    """Do the inputs of one line; return the count of each class, and what is a finding."""
    target = TARGETS[asked["target"]]
    counts: Counter[str] = Counter()
    findings = []
    begin = time.perf_counter()
    for index in range(asked["first"], asked["first"] + asked["count"]):
        if index in asked["skip"]:
            continue
        if mark is not None:
            mark[:8] = index.to_bytes(8, "little")
        outcome = there.do(target.draw(random_of(asked["seed"], target.name, index), good))
        counts[outcome.kind] += 1
        if outcome.kind in FAULTS:
            findings.append([index, outcome.kind, outcome.signature, outcome.detail])
    return {"counts": dict(counts), "findings": findings, "seconds": time.perf_counter() - begin}


def main(good: Path, mark_file: Path) -> None:
    """Answer lines of stdin on stdout until there are no more; what the program prints goes nowhere."""
    quiet()
    die_with_parent()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.fdopen(os.dup(1), "w")
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    faulthandler.disable()
    with mark_file.open("r+b") as file, mmap.mmap(file.fileno(), 8) as mark, place() as there:
        for line in sys.stdin:
            answer = do_chunk(json.loads(line), good, there, mark)
            answers.write(json.dumps(answer) + "\n")
            answers.flush()


def die_with_parent() -> None:
    """Have the system kill this process when the one that started it is gone, also in the middle of an input."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def quiet() -> None:
    """Keep warnings to ourselves; arithmetic that overflows is judged by the outcome of it."""
    import numpy as np

    warnings.simplefilter("ignore")
    np.seterr(all="ignore")


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main(Path(sys.argv[1]), Path(sys.argv[2]))
