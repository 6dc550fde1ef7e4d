"""The fuzz campaign: inputs drawn by number, done in chunks by watched workers."""

from __future__ import annotations

import contextlib
import io
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from .inputs import Input, random_of
from .place import Place
from .state import State
from .targets import TARGETS
from .watch import BLOCKS, HANGS, watch

CHUNK = {"calls": 1000, "traces": 2000, "meshes": 500, "models": 200, "bolts": 200, "results": 100, "commands": 50}


def draw(good: Path, target: str, seed: int, index: int) -> Input:
    """Return an input by its number."""
    return TARGETS[target].draw(random_of(seed, target, index), good)


def prepare(good: Path, targets: Iterable[str]) -> None:
    """Write the good inputs of targets, where they are not there yet."""
    for name in targets:
        mark = good / f"{name}.prepared"
        if not mark.exists():
            good.mkdir(parents=True, exist_ok=True)
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                TARGETS[name].prepare(good)
            mark.touch()


def chunks(
    state: State, targets: Sequence[str], inputs: int, seed: int, sizes: Mapping[str, int] = CHUNK
) -> Iterator[dict[str, Any]]:
    """Yield what is not done yet, the targets alternately, each up to its share of all inputs."""
    shares = sum(TARGETS[name].share for name in targets)
    queues = [_chunks_of(state, name, inputs * TARGETS[name].share / shares, seed, sizes[name]) for name in targets]
    for turn in itertools.zip_longest(*queues):
        yield from (chunk for chunk in turn if chunk is not None)


def _chunks_of(state: State, name: str, inputs: float, seed: int, size: int) -> Iterator[dict[str, Any]]:
    done = set(state.part(name)["done"])
    for first in range(0, max(1, round(inputs / size)) * size, size):
        if first not in done:
            yield {"target": name, "seed": seed, "first": first, "count": size}


def fuzz(
    folder: Path,
    *,
    inputs: int,
    seed: int,
    processes: int,
    targets: Sequence[str] = tuple(TARGETS),
    sizes: Mapping[str, int] = CHUNK,
    hangs: float = HANGS,
    blocks: float = BLOCKS,
    report: Callable[[str], None] = lambda text: None,
) -> State:
    """Do the rest of a campaign of so many inputs; return its state.

    Parameters
    ----------
    folder : Path
        Of the campaigns' states.
    inputs : int
        In all, shared out to the targets.
    seed : int
        Of the random numbers: the same inputs for the same seed and sources.
    processes : int
        At a time.
    targets : sequence of str
        Which doors.
    sizes : mapping of str to int
        Inputs of each in a chunk, the least that is done.
    hangs, blocks : float [s]
        See `watch`.
    report : callable
        Called with the progress.
    """
    state = State(folder.absolute(), "fuzz", seed)
    good = state.folder / "good"
    prepare(good, targets)

    def done(asked: dict[str, Any], answer: dict[str, Any]) -> None:
        name = asked["target"]
        for index, kind, signature, detail in answer["findings"]:
            kept = state.find(name, index, kind, signature, detail)
            if kept is not None:
                keep(kept, draw(good, name, seed, index))
        state.add(name, asked["first"], answer["counts"], answer["seconds"])
        total = sum(sum(part["counts"].values()) for part in state.told["parts"].values())
        report(f"{total} inputs, {len(state.told['findings'])} findings")

    watch(chunks(state, targets, inputs, seed, sizes), good, done, processes=processes, hangs=hangs, blocks=blocks)
    return state


def keep(folder: Path, given: Input) -> None:
    """Write an input into a finding's folder."""
    (folder / "told.txt").write_text(given.told + "\n", errors="backslashreplace")
    for name, data in given.files.items():
        path = folder / "files" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def again(there: Place, good: Path, target: str, seed: int, index: int) -> list[str]:
    """Do one input again; return what it is and the outcome of it."""
    prepare(good, [target])
    given = draw(good, target, seed, index)
    outcome = there.do(given)
    return [given.told, f"{outcome.kind}: {outcome.signature}", outcome.detail]
