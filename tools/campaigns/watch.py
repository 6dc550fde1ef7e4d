"""Workers watched from outside: one that dies or hangs is replaced, and its input is a finding."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import psutil

from .inputs import ROOT

LOOKS = 0.5  # seconds between two looks
HANGS = 10.0  # seconds of a processor that an input may take
BLOCKS = 60.0  # seconds that it may take in all: waiting for a file that never comes needs no processor


class Worker:
    """A worker process, and what is known of the input that it is at."""

    def __init__(self, good: Path, module: str) -> None:
        handle, name = tempfile.mkstemp(prefix="campaign-mark-")
        os.write(handle, bytes(8))
        os.close(handle)
        self.mark = Path(name)
        paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        threads = dict.fromkeys(
            ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
        )
        self.process = subprocess.Popen(
            [sys.executable, "-m", module, str(good), str(self.mark)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **threads, "PYTHONPATH": os.pathsep.join(paths)},
            text=True,
            start_new_session=True,
        )
        self.asked: dict[str, Any] | None = None
        self._seen = (-1, 0.0, 0.0)

    def ask(self, asked: dict[str, Any]) -> None:
        """Give it a chunk of inputs to do."""
        assert self.process.stdin is not None
        self.asked = asked
        self._seen = (-1, 0.0, 0.0)
        self.mark.write_bytes(bytes(8))
        self.process.stdin.write(json.dumps(asked) + "\n")
        self.process.stdin.flush()

    @property
    def index(self) -> int:
        """The input that it is at."""
        return int.from_bytes(self.mark.read_bytes(), "little")

    def hangs(self, hangs: float, blocks: float) -> bool:
        """Return whether it has been at one input for too long."""
        index, now = self.index, time.monotonic()
        try:
            used = psutil.Process(self.process.pid).cpu_times()
        except psutil.Error:
            return False
        cpu = used.user + used.system
        if index != self._seen[0]:
            self._seen = (index, cpu, now)
            return False
        return cpu - self._seen[1] > hangs or now - self._seen[2] > max(hangs, blocks)

    def end(self) -> None:
        """Kill it, and all that it started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, 9)
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                stream.close()
        self.mark.unlink(missing_ok=True)


def watch(
    chunks: Iterable[dict[str, Any]],
    good: Path,
    done: Callable[[dict[str, Any], dict[str, Any]], None],
    *,
    processes: int = 1,
    hangs: float = HANGS,
    blocks: float = BLOCKS,
    module: str = "tools.campaigns.worker",
) -> None:
    """Have chunks of inputs done by workers.

    Parameters
    ----------
    chunks : iterable of dict
        ``target``, ``seed``, ``first``, ``count``.
    good : Path
        Folder of the good inputs.
    done : callable
        Called with every chunk and its answer, as it comes.
    processes : int
        Workers at a time.
    hangs, blocks : float [s]
        An input that takes more of a processor, or more time in all, hangs.
    module : str
        The worker's.
    """
    waiting = deque({**chunk, "skip": [], "lost": []} for chunk in chunks)
    workers: list[Worker] = []
    with selectors.DefaultSelector() as selector:
        try:
            while waiting or any(worker.asked for worker in workers):
                while len(workers) < processes and waiting:
                    worker = Worker(good, module)
                    workers.append(worker)
                    selector.register(worker.process.stdout, selectors.EVENT_READ, worker)  # type: ignore[arg-type]
                for worker in workers:
                    if worker.asked is None and waiting:
                        worker.ask(waiting.popleft())
                ready = {key.data for key, _ in selector.select(LOOKS)}
                for worker in list(workers):
                    if worker.asked is None:
                        continue
                    answer = _answer_of(worker) if worker in ready else ""
                    if answer is None or (not answer and worker.hangs(hangs, blocks)):
                        waiting.appendleft(_lost(worker, hang=answer is not None))
                        selector.unregister(worker.process.stdout)  # type: ignore[arg-type]
                        worker.end()
                        workers.remove(worker)
                    elif answer:
                        asked, worker.asked = worker.asked, None
                        done(asked, _with_lost(asked, json.loads(answer)))
        finally:
            for worker in workers:
                worker.end()


def _answer_of(worker: Worker) -> str | None:
    assert worker.process.stdout is not None
    return worker.process.stdout.readline() or None


def _lost(worker: Worker, *, hang: bool) -> dict[str, Any]:
    """Return the chunk again, without the input that its worker died of."""
    assert worker.asked is not None
    index = worker.index
    if hang:
        kind, signature = "hang", "hang"
    else:
        code = worker.process.wait()
        kind, signature = "crash", f"signal {-code}" if code < 0 else f"exit code {code}"
    asked = worker.asked
    asked["skip"].append(index)
    asked["lost"].append([index, kind, signature, ""])
    if len(asked["skip"]) > asked["count"]:
        raise RuntimeError(f"workers die without doing anything: {kind}, {signature}")
    return asked


def _with_lost(asked: dict[str, Any], answer: dict[str, Any]) -> dict[str, Any]:
    for finding in asked["lost"]:
        answer["counts"][finding[1]] = answer["counts"].get(finding[1], 0) + 1
        answer["findings"].append(finding)
    return answer
