"""The verdict oracle: no slip of the pen may make an unstable model stable without a word."""

from __future__ import annotations

import contextlib
import io
import json
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .inputs import random_of
from .place import Place, place
from .slips import slip
from .state import State
from .targets.models import written
from .unstable import Example, examples
from .worker import quiet

CLASSES = (
    "unstable",
    "refused",
    "not converged",
    "no verdict",
    "noted",
    "right",
    "came to rest elsewhere",
    "not judged",
)
FALSE, BROKEN = "false verdict", "traceback"
CHUNK = 20


def judge_slip(there: Place, seed: int, index: int) -> tuple[str, str, str]:
    """Run one slip; return its class, and for a fault a signature and what to do to see it."""
    random = random_of(seed, "verdict", index)
    example = random.choice(examples())
    tree, path, done = slip(random, example.tree)
    data = written(tree)
    told = f"{example.name}: {path}: {done}"
    try:
        code, said, words = run(there, example, data)
    except Exception as error:
        return BROKEN, f"{type(error).__name__}: {example.name}: {path}", f"{told}\n{error!r}\n{data.decode()}"
    if code == 2:
        return "refused", "", told
    if code == 3:
        return "not converged", "", told
    status = said.get("status", "")
    if status == "unstable":
        return "unstable", "", told
    if not status.startswith("stable"):
        return "no verdict", "", told
    stands = example.stands(tree)
    if stands:
        return "right", "", told
    if names(words, path):
        return "noted", "", told
    if names(words, "displacement_limit"):  # it fell and lies somewhere, and that is said
        return "came to rest elsewhere", "", told
    if stands is None:
        return "not judged", "", told
    key = re.sub(r"\.\d+", "", path)
    return FALSE, f"{example.name}: {key}: {done}"[:200], f"{told}\nverdict: {status}\n{words}\n\n{data.decode()}"


def run(there: Place, example: Example, data: bytes) -> tuple[int, dict[str, Any], str]:
    """Run a model file by the command; return the exit code, what the JSON says, and all words of it."""
    from bsm_mesh.app.cli import main

    there.clean()
    there.put({"model.toml": data, **example.files})
    out, err = io.StringIO(), io.StringIO()
    code: Any = 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(["run", "model.toml", "-o", "out", "--json"])
    except SystemExit as leaving:
        code = leaving.code or 0
    said: dict[str, Any] = json.loads(out.getvalue()) if code in (0, 3) else {}
    remarks = [*said.get("notes", []), *(note for stage in said.get("stages", []) for note in stage["notes"])]
    return code, said, "\n".join([*map(str, remarks), err.getvalue()])


def names(words: str, path: str) -> bool:
    """Return whether a message names a key of a path: the last one that is no number."""
    parts = [part for part in path.split(".") if not part.isdigit()]
    key = parts[-1] if parts else path
    return re.search(rf"\b{re.escape(key)}\b", words) is not None


def verdict(folder: Path, *, runs: int, seed: int, report: Callable[[str], None] = lambda text: None) -> State:
    """Do what is left of so many slips; return the state."""
    import time

    quiet()
    state = State(folder.absolute(), "verdict", seed)
    done = set(state.part("slips")["done"])
    with place() as there:
        for first in range(0, runs, CHUNK):
            if first in done:
                continue
            counts: Counter[str] = Counter()
            begin = time.perf_counter()
            for index in range(first, min(runs, first + CHUNK)):
                kind, signature, detail = judge_slip(there, seed, index)
                counts[kind] += 1
                if kind in (FALSE, BROKEN):
                    state.find("slips", index, kind, signature, detail)
            state.add("slips", first, counts, time.perf_counter() - begin)
            report(f"{min(runs, first + CHUNK)} slips, {len(state.told['findings'])} findings")
    return state


def demand_unstable(there: Place) -> list[str]:
    """Return the examples that are not unstable as they are, or of which statics says otherwise."""
    wrong = []
    for example in examples():
        code, said, _ = run(there, example, example.text.encode())
        if (code, said.get("status")) != (0, "unstable") or example.stands(example.tree) is not False:
            wrong.append(f"{example.name}: exit code {code}, {said.get('status')}, form {example.stands(example.tree)}")
    return wrong
