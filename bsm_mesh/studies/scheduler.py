"""Runs of a study on processes of this machine; what a scheduler is, for others that take their place."""

from __future__ import annotations

import os
import pickle
import queue
import struct
import subprocess
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import IO, Any, Protocol

from bsm_mesh.errors import ModelError, one_line
from bsm_mesh.files import unnamed_file
from bsm_mesh.processes import python_command
from bsm_mesh.studies.sampling import Value

ATTEMPTS = 3  # a run that kills its worker so many times is given up
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
WORKER = "bsm_mesh.studies.worker"
_LENGTH = struct.Struct("<Q")


class Work(Protocol):
    """What is done in every run. It pickles small: what it can make again is made where it arrives, once.

    Attributes
    ----------
    key : str
        Equal work has equal keys; a worker keeps the first of each.
    """

    @property
    def key(self) -> str:
        """What the work is known by."""

    def __call__(self, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
        """Return what comes of a run, of plain values; what goes wrong in it is an answer too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finished:
    """A run at its end.

    Attributes
    ----------
    run : int
        Its number, from 0.
    answers : mapping or None
        What the work returned; None: it was given up.
    error : str
        Why it was given up.
    """

    run: int
    answers: Mapping[str, Any] | None
    error: str = ""


class Scheduler(Protocol):
    """Has runs done, several at a time."""

    def run(self, work: Work, tasks: Mapping[int, Mapping[str, Value]]) -> Iterator[Finished]:
        """Return the runs as they come to their end, in any order, each once.

        Parameters
        ----------
        work : Work
            What is done.
        tasks : mapping of int to mapping
            Values by the number of the run.
        """


_kept: dict[str, Work] = {}
_one_at_a_time = threading.Lock()


def perform(work: Work, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
    """Return what comes of a run, by the work that this process has kept: what it has read and built is there."""
    with _one_at_a_time:  # a worker of Dask may have several threads, and Gmsh is of the whole process
        return _kept.setdefault(work.key, work)(run, values)


@dataclass(frozen=True, slots=True)
class Processes:
    """Runs on processes of their own on this machine, one thread each.

    A process that dies takes nothing along but its run, which is begun anew by the next one, up to `ATTEMPTS` times.

    Attributes
    ----------
    count : int
        How many.
    """

    count: int

    def run(self, work: Work, tasks: Mapping[int, Mapping[str, Value]]) -> Iterator[Finished]:
        """Return the runs as they come to their end."""
        pool = _Pool(work, tasks)
        threads = [threading.Thread(target=pool.serve, daemon=True) for _ in range(min(self.count, len(tasks)))]
        try:
            for thread in threads:
                thread.start()
            for _ in tasks:
                told = pool.ended.get()
                if isinstance(told, Exception):
                    raise told
                yield told
        finally:
            pool.close()
            for thread in threads:
                thread.join()


@dataclass(eq=False)
class _Pool:
    """The runs that wait, and the processes that do them; a thread serves each."""

    work: Work
    tasks: Mapping[int, Mapping[str, Value]]
    ended: queue.SimpleQueue[Finished | Exception] = field(default_factory=queue.SimpleQueue)

    def __post_init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[int, int]] = queue.SimpleQueue()
        for run in self.tasks:
            self._waiting.put((run, 1))
        self._workers: set[_Worker] = set()
        self._closed = False
        self._lock = threading.Lock()

    def serve(self) -> None:
        """Have runs done by one process after the other until none waits."""
        worker = None
        try:
            while (task := self._next()) is not None:
                run, attempt = task
                try:
                    worker = worker or self._start()
                    self.ended.put(Finished(run=run, answers=worker.ask(self.work, run, self.tasks[run])))
                except _DeathError as death:
                    worker = None
                    if self._closed:
                        return
                    if attempt < ATTEMPTS:
                        self._waiting.put((run, attempt + 1))
                        continue
                    why = f"its process died {ATTEMPTS} times ({death})"
                    self.ended.put(Finished(run=run, answers=None, error=why))
        except OSError as error:
            self.ended.put(ModelError(f"a process for runs cannot be started: {error.strerror or error}"))
        except Exception as error:  # raised where the runs are waited for
            self.ended.put(error)
        finally:
            if worker is not None:
                worker.end()

    def close(self) -> None:
        """End all processes at once, whatever they do."""
        with self._lock:
            self._closed = True
            workers = list(self._workers)
        for worker in workers:
            worker.kill()

    def _next(self) -> tuple[int, int] | None:
        try:
            return None if self._closed else self._waiting.get_nowait()
        except queue.Empty:
            return None

    def _start(self) -> _Worker:
        with self._lock:
            if self._closed:
                raise _DeathError("closed")
            worker = _Worker()
            self._workers.add(worker)
        worker.await_ready()
        return worker


class _DeathError(Exception):
    """A process has ended before its answer."""


class _Worker:
    """A process that does runs; tasks and answers go through pipes."""

    def __init__(self) -> None:
        self._said = unnamed_file()
        self._process = subprocess.Popen(
            python_command(WORKER),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            env={**os.environ, **ONE_THREAD},
        )

    def await_ready(self) -> None:
        """Wait until it takes tasks; one that never comes to that is no fault of a run."""
        assert self._process.stdout is not None
        if receive(self._process.stdout) is None:
            code = self._process.wait()
            if code == -9:
                raise _DeathError("signal 9")
            self._said.seek(0)
            last = (self._said.read().decode(errors="replace").strip().splitlines() or ["no message"])[-1]
            raise ModelError(f"a process for runs does not start (exit code {code}): {one_line(last)}")

    def ask(self, work: Work, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
        """Return what comes of a run; raise `_DeathError` if the process ends before."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            send(self._process.stdin, (work, run, values))
            answers: dict[str, Any] | None = receive(self._process.stdout)
        except OSError:
            answers = None
        if answers is None:
            self._close_pipes()
            code = self._process.wait()
            raise _DeathError(f"signal {-code}" if code < 0 else f"exit code {code}")
        return answers

    def end(self) -> None:
        """Let it go: it ends when it is told that no tasks come any more."""
        self._close_pipes()
        self._process.wait()

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def _close_pipes(self) -> None:
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            try:
                pipe.close()
            except OSError:  # what it still held cannot be sent any more
                continue
        self._said.close()


def send(stream: IO[bytes], thing: object) -> None:
    """Send a thing to the process at the other end of a pipe."""
    content = pickle.dumps(thing)
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Return what the process at the other end of a pipe sends; None if it has ended, amid it or before."""
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    return pickle.loads(content) if len(content) == length else None
