"""Trials in this process, or in several that each hold the model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from bsm_mesh.errors import ModelError
from bsm_mesh.safety.criterion import Ended
from bsm_mesh.worker_pool import WorkerPool

Task: TypeAlias = "tuple[float, float | None]"
RunAll: TypeAlias = "Callable[[Sequence[Task]], list[Ended]]"


class Trials(Protocol):
    """A model to be run at a value; picklable where several processes share the work."""

    def run(self, value: float, limit: float | None) -> Ended:
        """Return how the model ends; a block that moves by more than `limit` [m] has failed."""


@dataclass(frozen=True, slots=True)
class _Trial:
    """The work of a process: an error of the model is an answer, which is raised where it is waited for."""

    trials: Trials

    def __call__(self, number: int, task: Task) -> Ended | Exception:
        try:
            return self.trials.run(*task)
        except Exception as error:
            return error


@contextmanager
def pool_of(trials: Trials, processes: int) -> Iterator[RunAll]:
    """Give what runs several values, at the same time where there are several processes."""
    if processes == 1:
        yield lambda tasks: [trials.run(*task) for task in tasks]
        return
    with WorkerPool(_Trial(trials), processes, script=True) as pool:

        def run_all(tasks: Sequence[Task]) -> list[Ended]:
            found: dict[int, Ended] = {}
            for each in pool.run(dict(enumerate(tasks))):
                if each.error:
                    raise ModelError(f"safety: a trial was given up: {each.error} (out of memory?); try --processes 1")
                if isinstance(each.answers, Exception):
                    raise each.answers
                found[each.run] = each.answers
            return [found[number] for number in range(len(tasks))]

        yield run_all
