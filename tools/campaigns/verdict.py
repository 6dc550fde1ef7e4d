"""The verdict oracle: no slip of the pen or change of meaning makes an unstable model stable without a message."""

from __future__ import annotations

import contextlib
import io
import json
import re
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .fuzz import keep
from .inputs import Input, random_of
from .meaning import changed
from .place import Place, place
from .slips import slip
from .state import State
from .targets.models import written
from .unstable import examples
from .worker import quiet

CLASSES = (
    "unstable",
    "refused",
    "not converged",
    "no verdict",
    "noted",
    "right",
    "reached rest elsewhere",
    "not judged",
)
FALSE, BROKEN = "false verdict", "traceback"
CHUNK = 20
SLIPS, MEANING = PARTS = ("slips", "meaning")


@dataclass(frozen=True)
class Change:
    """A changed model: its files, what was done, words of a message that says so, and what statics says of it."""

    example: str
    files: Mapping[str, bytes]
    done: str
    words: tuple[str, ...]
    stands: Callable[[], bool | None]


def drawn(part: str, seed: int, index: int) -> Change:
    """Return a change by its number: a slip of the pen, or one of meaning."""
    random = random_of(seed, part, index)
    example = random.choice(examples())
    if part == MEANING:
        made = changed(random, example)
        files = {**example.files, **made.files, "model.toml": written(made.tree)}
        return Change(example.name, files, "; ".join(made.done), tuple(made.words), lambda: made.stands)
    tree, path, done = slip(random, example.tree)
    files = {**example.files, "model.toml": written(tree)}
    return Change(example.name, files, f"{path}: {done}", (last_key(path),), lambda: example.stands(tree))


def judge_change(there: Place, given: Change) -> tuple[str, str, str]:
    """Run a changed model; return its class, and for a fault a signature and what to do to see it."""
    told = f"{given.example}: {given.done}"
    model = given.files["model.toml"].decode()
    kind_of = re.sub(r"[-+]?\d[\d.e+-]*", "#", given.done)
    try:
        code, said, words = run(there, given.files)
    except Exception as error:
        return BROKEN, f"{type(error).__name__}: {given.example}: {kind_of}"[:200], f"{told}\n{error!r}\n{model}"
    if code == 2:
        return "refused", "", f"{told}\n{words}"
    if code == 3:
        return "not converged", "", told
    status = said.get("status", "")
    if status == "unstable":
        return "unstable", "", told
    if not status.startswith("stable"):
        return "no verdict", "", told
    stands = given.stands()
    if stands:
        return "right", "", told
    if names(words, given.words):
        return "noted", "", told
    if names(words, ("displacement_limit",)):  # it fell and lies somewhere, and that is said
        return "reached rest elsewhere", "", told
    if stands is None:
        return "not judged", "", told
    return FALSE, f"{given.example}: {kind_of}"[:200], f"{told}\nverdict: {status}\n{words}\n\n{model}"


def run(there: Place, files: Mapping[str, bytes]) -> tuple[int, dict[str, Any], str]:
    """Run ``model.toml`` of some files by the command; return the exit code, what the JSON says, and all words."""
    from bsm_mesh.commands.cli import main

    there.clean()
    there.put(files)
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


def last_key(path: str) -> str:
    """Return the last key of a path that is no number."""
    parts = [part for part in path.split(".") if not part.isdigit()]
    return parts[-1] if parts else path


def names(messages: str, words: Sequence[str]) -> bool:
    """Return whether messages name one of these words."""
    return any(re.search(rf"(?<!\w){re.escape(word)}(?!\w)", messages) for word in words)


def verdict(folder: Path, *, runs: int, seed: int, report: Callable[[str], None] = lambda text: None) -> State:
    """Do the rest of so many changes; return the state."""
    quiet()
    state = State(folder.absolute(), "verdict", seed)
    each = -(-runs // len(PARTS))
    with place() as there:
        for first in range(0, each, CHUNK):
            for part in PARTS:
                if first not in state.part(part)["done"]:
                    _do_chunk(state, there, part, seed, range(first, min(each, first + CHUNK)))
            report(f"{len(PARTS) * min(each, first + CHUNK)} changes, {len(state.told['findings'])} findings")
    return state


def _do_chunk(state: State, there: Place, part: str, seed: int, indices: range) -> None:
    counts: Counter[str] = Counter()
    begin = time.perf_counter()
    for index in indices:
        given = drawn(part, seed, index)
        kind, signature, detail = judge_change(there, given)
        counts[kind] += 1
        if kind in (FALSE, BROKEN):
            kept = state.find(part, index, kind, signature, detail)
            if kept is not None:
                keep(kept, Input(detail, lambda: None, given.files))
    state.add(part, indices.start, counts, time.perf_counter() - begin)


def demand_unstable(there: Place) -> list[str]:
    """Return the examples that are not unstable as they are, or of which statics says otherwise."""
    wrong = []
    for example in examples():
        code, said, _ = run(there, {**example.files, "model.toml": example.text.encode()})
        if (code, said.get("status")) != (0, "unstable") or example.stands(example.tree) is not False:
            wrong.append(f"{example.name}: exit code {code}, {said.get('status')}, form {example.stands(example.tree)}")
    return wrong
