"""Runs of a study on processes of this machine; the interface of a scheduler, for others."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from bsm_mesh.studies.sampling import Value
from bsm_mesh.worker_pool import Finished, WorkerPool


class Work(Protocol):
    """The task of every run. It pickles small: parts that it can make again are made in the process, once.

    Attributes
    ----------
    key : str
        Equal work has equal keys; a worker keeps the first of each.
    """

    @property
    def key(self) -> str:
        """Key of the work."""

    def __call__(self, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
        """Return the outcome of a run, of plain values; a fault in it is an answer too."""


class Scheduler(Protocol):
    """Has runs done, several at a time."""

    def run(self, work: Work, tasks: Mapping[int, Mapping[str, Value]]) -> Iterator[Finished]:
        """Return the runs as they end, in any order, each once.

        Parameters
        ----------
        work : Work
            The task of a run.
        tasks : mapping of int to mapping
            Values by the number of the run.
        """


_kept: dict[str, Work] = {}
_one_at_a_time = threading.Lock()


def perform(work: Work, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
    """Return the outcome of a run, by the work that this process has kept, with its files and models."""
    with _one_at_a_time:  # a worker of Dask may have several threads, and Gmsh is of the whole process
        return _kept.setdefault(work.key, work)(run, values)


@dataclass(frozen=True, slots=True)
class Processes:
    """Runs on processes of their own on this machine, one thread each.

    A process that dies takes nothing along but its run, which is begun anew by the next one, as `WorkerPool` does.

    Attributes
    ----------
    count : int
        How many.
    """

    count: int

    def run(self, work: Work, tasks: Mapping[int, Mapping[str, Value]]) -> Iterator[Finished]:
        """Return the runs as they end."""
        with WorkerPool(work, self.count) as pool:
            yield from pool.run(tasks)
