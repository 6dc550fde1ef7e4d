"""A pool of processes that do the same work for many tasks: one that dies loses its task alone, which is begun anew."""

from __future__ import annotations

import os
import pickle
import queue
import struct
import subprocess
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from multiprocessing.spawn import get_preparation_data
from typing import IO, Any, TypeAlias

from bsm_mesh.errors import ModelError, one_line
from bsm_mesh.files import unnamed_file
from bsm_mesh.processes import python_command

ATTEMPTS = 3  # a task that kills its worker so many times is given up
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
WORKER = "bsm_mesh.pool_worker"
_LENGTH = struct.Struct("<Q")

Work: TypeAlias = "Callable[[int, Any], Any]"
"""Returns the answer to a numbered task."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finished:
    """A task at its end.

    Attributes
    ----------
    run : int
        Its number.
    answers : object
        The answer of the work; None: it was given up.
    error : str
        Why it was given up.
    """

    run: int
    answers: Any
    error: str = ""


@dataclass(eq=False)
class _Round:
    """Tasks that wait, and those at their end."""

    tasks: Mapping[int, Any]
    waiting: queue.SimpleQueue[tuple[int, int]] = field(default_factory=queue.SimpleQueue)
    ended: queue.SimpleQueue[Finished | Exception] = field(default_factory=queue.SimpleQueue)

    def __post_init__(self) -> None:
        for number in self.tasks:
            self.waiting.put((number, 1))


class WorkerPool:
    """Processes of this machine, one thread each; closed at the end of a ``with`` block.

    Every process is sent the work once, before its first task, and lives until the pool is closed.

    Parameters
    ----------
    work : callable
        Returns the answer to a task: of its number and the task. It is pickled, and so are tasks and answers.
    count : int
        How many processes at most.
    script : bool
        Whether the work may hold functions of the user's script: processes then import it, as those of
        `multiprocessing` do.
    """

    def __init__(self, work: Work, count: int, *, script: bool = False) -> None:
        self._work, self._count, self._script = work, count, script
        self._idle: list[_Worker] = []
        self._busy: set[_Worker] = set()
        self._closed = False
        self._lock = threading.Lock()

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def run(self, tasks: Mapping[int, Any]) -> Iterator[Finished]:
        """Return the tasks as they end, in any order, each once.

        Raises
        ------
        ModelError
            If a process cannot be started.
        """
        work = _Round(tasks)
        threads = [
            threading.Thread(target=self._serve, args=(work,), daemon=True) for _ in range(min(self._count, len(tasks)))
        ]
        left = len(tasks)
        try:
            for thread in threads:
                thread.start()
            while left:
                ended = work.ended.get()
                if isinstance(ended, Exception):
                    raise ended
                left -= 1
                yield ended
        finally:
            if left:  # an error, or nobody waits for the others
                self.close()
            for thread in threads:
                thread.join()

    def close(self) -> None:
        """End all processes, at once where they are at work."""
        with self._lock:
            self._closed = True
            for worker in self._busy:
                worker.kill()
            idle, self._idle = self._idle, []
        for worker in idle:
            worker.end()

    def _serve(self, work: _Round) -> None:
        """Have tasks done by one process after the other until none waits."""
        worker = None
        try:
            while (task := self._next(work)) is not None:
                number, attempt = task
                try:
                    worker = worker or self._take()
                    work.ended.put(Finished(run=number, answers=worker.ask(number, work.tasks[number])))
                except _DeathError as death:
                    if worker is not None:
                        self._forget(worker)
                        worker = None
                    if self._closed:
                        return
                    if attempt < ATTEMPTS:
                        work.waiting.put((number, attempt + 1))
                        continue
                    why = f"its process died {ATTEMPTS} times ({death})"
                    work.ended.put(Finished(run=number, answers=None, error=why))
        except OSError as error:
            work.ended.put(ModelError(f"a process for runs cannot be started: {error.strerror or error}"))
        except Exception as error:  # raised where the tasks are waited for
            work.ended.put(error)
        finally:
            if worker is not None:
                self._give_back(worker)

    def _next(self, work: _Round) -> tuple[int, int] | None:
        try:
            return None if self._closed else work.waiting.get_nowait()
        except queue.Empty:
            return None

    def _take(self) -> _Worker:
        with self._lock:
            if self._closed:
                raise _DeathError("closed")
            is_new = not self._idle
            worker = _Worker() if is_new else self._idle.pop()
            self._busy.add(worker)
        if is_new:
            try:
                worker.prepare(self._work, self._script)
            except BaseException:
                self._forget(worker)
                worker.end()
                raise
        return worker

    def _give_back(self, worker: _Worker) -> None:
        with self._lock:
            self._busy.discard(worker)
            if not self._closed:
                self._idle.append(worker)
                return
        worker.end()

    def _forget(self, worker: _Worker) -> None:
        with self._lock:
            self._busy.discard(worker)


class _DeathError(Exception):
    """A process has ended before its answer."""


class _Worker:
    """A process that does tasks; tasks and answers go through pipes."""

    def __init__(self) -> None:
        self._said = unnamed_file()
        self._process = subprocess.Popen(
            python_command(WORKER),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            env={**os.environ, **ONE_THREAD},
        )

    def prepare(self, work: Work, script: bool) -> None:
        """Wait until it takes tasks, and send the work; a process that does not start is no fault of a task."""
        assert self._process.stdout is not None
        if receive(self._process.stdout) is None:
            code = self._process.wait()
            if code == -9:
                raise _DeathError("signal 9")
            self._said.seek(0)
            last = (self._said.read().decode(errors="replace").strip().splitlines() or ["no message"])[-1]
            raise ModelError(f"a process for runs does not start (exit code {code}): {one_line(last)}")
        self._send(_of_script() if script else {})
        self._send(work)

    def ask(self, number: int, task: Any) -> Any:
        """Return the answer to a task; raise `_DeathError` if the process ends before."""
        assert self._process.stdout is not None
        self._send((number, task))
        try:
            answer = receive(self._process.stdout)
        except OSError:
            answer = None
        if answer is None:
            raise self._death()
        return answer

    def _send(self, thing: object) -> None:
        assert self._process.stdin is not None
        content = pickle.dumps(thing)
        try:
            send(self._process.stdin, content)
        except OSError:
            raise self._death() from None

    def _death(self) -> _DeathError:
        self._close_pipes()
        code = self._process.wait()
        return _DeathError(f"signal {-code}" if code < 0 else f"exit code {code}")

    def end(self) -> None:
        """Let it go: it ends when no tasks come any more."""
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


def _of_script() -> dict[str, Any]:
    """Return where a process finds the modules and functions of this one's script, as `multiprocessing` takes it."""
    known = get_preparation_data("")
    return {name: known[name] for name in ("sys_path", "init_main_from_name", "init_main_from_path") if name in known}


def send(stream: IO[bytes], content: bytes) -> None:
    """Send a pickled thing to the process at the other end of a pipe."""
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Return the message of the process at the other end of a pipe; None if it has ended, amid it or before."""
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    return pickle.loads(content) if len(content) == length else None
