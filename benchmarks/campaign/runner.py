"""Running many models in processes of their own, with a limit of processor seconds each, one line of JSON a model."""

from __future__ import annotations

import json
import multiprocessing as mp
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, TextIO

from benchmarks.campaign.ablation import Ablation
from benchmarks.campaign.outcome import ERROR, TIMEOUT, Record

Task = tuple[str, int]
UNSEEN = 10**6  # seeds from here on are in no campaign
WARM_UP = {"slope+bolts": UNSEEN, "tunnel+water": UNSEEN + 1, "layers": UNSEEN + 1, "pile+stages": UNSEEN}
COMPLETE = Ablation()
JUDGING = 3  # limits of a run that judging may take: it runs twins


@dataclass(eq=False)
class Worker:
    """A process that runs models one after the other."""

    process: Any
    pipe: Connection
    task: Task | None = None
    record: Record | None = None  # of the run, before it is judged
    began: float = 0.0


def run_all(
    tasks: Sequence[Task],
    processes: int,
    limit: float,
    keep: Callable[[Record], None],
    *,
    judged: bool = True,
    ablation: Ablation = COMPLETE,
) -> None:
    """Run models and hand over a record of each as it comes.

    Parameters
    ----------
    tasks : sequence of (str, int)
        Family and seed.
    processes : int
        How many at a time.
    limit : float [processor s]
        For a run; a model that takes longer is recorded as ``timeout`` and its process ends.
    keep : callable
        Gets every record.
    judged : bool
        Whether oracles look at it.
    ablation : Ablation
        What the engine is to be without.
    """
    left = list(reversed(tasks))
    workers = [_start(limit, judged, ablation) for _ in range(min(processes, len(tasks)))]
    try:
        for worker in workers:
            _give(worker, left)
        while any(worker.task for worker in workers):
            ready = wait([worker.pipe for worker in workers if worker.task])
            for number, worker in enumerate(workers):
                if worker.pipe in ready:
                    workers[number] = _hear(worker, keep, lambda: _start(limit, judged, ablation))
                    if workers[number].task is None:
                        _give(workers[number], left)
    finally:
        for worker in workers:
            worker.process.terminate()


def _start(limit: float, judged: bool, ablation: Ablation) -> Worker:
    context = mp.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs, limit, judged, ablation), daemon=True)
    process.start()
    theirs.close()
    return Worker(process=process, pipe=ours)


def _give(worker: Worker, left: list[Task]) -> None:
    worker.task = left.pop() if left else None
    worker.record, worker.began = None, time.time()
    if worker.task:
        worker.pipe.send(worker.task)


def _hear(worker: Worker, keep: Callable[[Record], None], renew: Callable[[], Worker]) -> Worker:
    """Take what a worker says; if it is dead record why and return another."""
    assert worker.task is not None
    head = dict(zip(("family", "seed"), worker.task, strict=True))
    try:
        kind, said = worker.pipe.recv()
    except EOFError:
        worker.process.join()
        code = worker.process.exitcode
        late = code == -signal.SIGXCPU
        if worker.record is None:
            keep(head | ({"status": TIMEOUT} if late else {"status": ERROR, "reason": f"the process ended: {code}"}))
        else:
            why = "judging took too long" if late else f"the process ended while judging: {code}"
            keep(head | worker.record | {"facts": {"unjudged": why}, "contradictions": []})
        return renew()
    if kind == "ran":
        worker.record = said
        return worker
    keep(head | (worker.record or {}) | said)
    worker.task = None
    return worker


def _work(pipe: Connection, limit: float, judged: bool, ablation: Ablation) -> None:
    """Run models as they are asked for, until the pipe is closed."""
    from benchmarks.campaign.families import FAMILIES
    from benchmarks.campaign.trial import trial_of

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent sees to that
    ablation.apply()
    for family, seed in WARM_UP.items():  # compiled code
        _model(lambda record: None, trial_of(FAMILIES[family], seed), limit=None, judged=judged)
    from benchmarks.campaign.sizes import every_family

    families = every_family()
    while True:
        try:
            family, seed = pipe.recv()
        except EOFError:
            return
        last: Record
        try:
            trial = trial_of(families[family], seed)
            last = _model(lambda record: pipe.send(("ran", record)), trial, limit=limit, judged=judged)
        except Exception as error:  # a model that cannot be made or run: recorded, the campaign continues
            last = {"status": ERROR, "reason": _where(error)}
        pipe.send(("done", last))


def _model(say: Callable[[Record], None], trial: Any, *, limit: float | None, judged: bool) -> Record:
    """Run a model, say the result, and return what oracles add."""
    from benchmarks.campaign import outcome
    from benchmarks.campaign.oracles import Case, judge

    with _within(limit):
        results, seconds = outcome.run(trial.scene)
    record = outcome.record_of(trial.scene, results, seconds)
    say(record)
    if not judged:
        return {}
    began = time.process_time()
    try:
        with _within(None if limit is None else JUDGING * limit):
            found = judge(Case(trial=trial, record=record, results=results))
    except Exception as error:  # an oracle that fails is no verdict on the model
        found = {"facts": {"unjudged": _where(error)}, "contradictions": []}
    return found | {"judging": round(time.process_time() - began, 3)}


class _within:  # noqa: N801 - reads as a word of the with statement
    """A limit of processor seconds: the kernel ends the process that exceeds it."""

    def __init__(self, limit: float | None) -> None:
        self.limit = limit

    def __enter__(self) -> None:
        if self.limit is not None:
            used = resource.getrusage(resource.RUSAGE_SELF)
            _, most = resource.getrlimit(resource.RLIMIT_CPU)
            resource.setrlimit(resource.RLIMIT_CPU, (int(used.ru_utime + used.ru_stime + self.limit) + 1, most))

    def __exit__(self, *exception: object) -> None:
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))


def _where(error: Exception) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {str(error)[:200]} ({Path(frame.filename).name}:{frame.name})"


class Log:
    """A file of records, a line each, that is written on where it stopped.

    Parameters
    ----------
    path : Path
        The file.
    head : Record
        Its first line; of a file that is there it must be the same.

    Raises
    ------
    ValueError
        If the file is of another program or another campaign.
    """

    def __init__(self, path: Path, head: Record) -> None:
        self.path, self.done = path, set[Task]()
        if path.exists() and path.stat().st_size:
            text = path.read_text(encoding="utf-8")
            whole = text[: text.rfind("\n") + 1]  # a line that was being written when the campaign was stopped
            if whole != text:
                path.write_text(whole, encoding="utf-8")
            first, *lines = (json.loads(line) for line in whole.splitlines())
            different = [key for key in ("engine", "limit", "ablation") if first.get(key, "") != head.get(key, "")]
            if different:
                raise ValueError(f"{path} is of another {' and '.join(different)}; give another --file, or remove it")
            self.done = {(line["family"], line["seed"]) for line in lines}
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(head) + "\n", encoding="utf-8")
        self._file: TextIO = path.open("a", encoding="utf-8")

    def keep(self, record: Record) -> None:
        """Append a record."""
        self._file.write(json.dumps(record, separators=(",", ":"), default=float) + "\n")
        self._file.flush()


def in_turn(counts: dict[str, int]) -> Iterator[Task]:
    """Return all models, family by family in turn, so that a campaign that is stopped has some of each."""
    tasks = [((seed + 0.5) / count, family, seed) for family, count in counts.items() for seed in range(count)]
    for _, family, seed in sorted(tasks):
        yield family, seed


def progress(total: int) -> Callable[[Record], None]:
    """Return what tells on a terminal how far the campaign is."""
    began, done = time.time(), 0

    def tell(record: Record) -> None:
        nonlocal done
        done += 1
        if sys.stderr.isatty() or done % 100 == 0 or done == total:
            left = (time.time() - began) / done * (total - done)
            end = "\r" if sys.stderr.isatty() and done < total else "\n"
            print(f"  {done} of {total} models, {left / 60:.0f} minutes left  ", end=end, file=sys.stderr, flush=True)

    return tell
