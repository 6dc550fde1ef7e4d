"""Trials in this process, or in several that each hold the model."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Protocol, TypeAlias

from bsm_mesh.errors import ModelError
from bsm_mesh.safety.criterion import Ended

RunAll: TypeAlias = "Callable[[Sequence[tuple[float, float | None]]], list[Ended]]"


class Trials(Protocol):
    """What runs a model at a value; picklable where several processes share the work."""

    def run(self, value: float, limit: float | None) -> Ended:
        """Return how the model ends; a block that has moved farther than `limit` [m] has failed."""


_HELD: list[Trials] = []  # of a process that runs trials


def _hold(trials: Trials) -> None:
    _HELD[:] = [trials]


def _run_held(task: tuple[float, float | None]) -> Ended:
    return _HELD[0].run(*task)


@contextmanager
def pool_of(trials: Trials, processes: int) -> Iterator[RunAll]:
    """Give what runs several values, at the same time where there are several processes."""
    if processes == 1:
        yield lambda tasks: [trials.run(*task) for task in tasks]
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context, initializer=_hold, initargs=(trials,)) as pool:

        def run_all(tasks: Sequence[tuple[float, float | None]]) -> list[Ended]:
            try:
                return list(pool.map(_run_held, tasks))
            except BrokenProcessPool as error:
                raise ModelError(
                    "safety: a process that ran a trial has died (out of memory?); try --processes 1"
                ) from error

        yield run_all
