"""The kill campaign: real runs that end by kill -9, at random moments and before every operation on files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from random import Random

import psutil

from tests.scenes.model_folders import NAMES

from .inputs import ROOT, random_of
from .scenes import Report, Scene, silent, workshop
from .state import State
from .struck import sample

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
LONGEST = 600.0  # seconds of a run that is not struck
INTERRUPTED = 130


@dataclass(frozen=True)
class Strike:
    """What ends a run: a signal, and when: before an operation on files, or at a part of the run's processor time."""

    signal: str
    operation: int = 0
    part: float = 0.0

    def __str__(self) -> str:
        return f"{self.signal} " + (
            f"at operation {self.operation}" if self.operation else f"at {self.part:.4f} of the run"
        )


@dataclass(frozen=True)
class Struck:
    """How a run went: its end, the log of `struck`, and the processor time that it took [s]."""

    code: int
    err: str
    log: list[str]
    seconds: float

    @property
    def finished(self) -> int:
        """Stages that were finished: those before the last one that began."""
        return max([int(line.split()[1]) for line in self.log if line.startswith("stage ")], default=0)

    @property
    def steps(self) -> int:
        """Steps that had ended, of all stages."""
        return self.log.count("step")

    @property
    def operations(self) -> int:
        """Operations on files."""
        return sum(line.split()[0].isdigit() for line in self.log)


def strike(scene: Scene, blow: Strike, seconds: float = 0.0) -> Struck:
    """Run a scene in a process of its own, struck; `seconds` is the processor time of a whole run."""
    log = scene.root.with_name(f"{scene.root.name}.log")
    log.unlink(missing_ok=True)
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "tools.campaigns.struck",
            str(blow.operation),
            str(scene.root),
            str(log),
            *scene.arguments,
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join(paths),
            "TMPDIR": str(scene.root / "tmp"),
            "NUMBA_NUM_THREADS": "1",
        },
    )
    used = _watch(process, log, blow, seconds)
    err = process.communicate()[1]
    return Struck(process.returncode, err, log.read_text().splitlines() if log.exists() else [], used)


def _watch(process: subprocess.Popen[str], log: Path, blow: Strike, seconds: float) -> float:
    """Send the signal when it is time; return the processor time since the program began."""
    began, used, last = -1.0, 0.0, time.monotonic() + LONGEST
    watched = psutil.Process(process.pid)
    while process.poll() is None:
        try:
            times = watched.cpu_times()
        except psutil.Error:
            break
        now = times.user + times.system
        if began < 0 and log.exists() and log.stat().st_size:
            began = now
        if began >= 0:
            used = now - began
            if blow.part and used >= blow.part * seconds:
                process.send_signal(getattr(signal, blow.signal))
                break
        if time.monotonic() > last:
            process.kill()
        time.sleep(0.003)
    process.wait()
    return used


def strikes(scene: Scene, whole: Struck, random: Random, moments: int, every: int) -> list[Strike]:
    """Return the strikes of a scene: every (or each second, third ...) operation, random moments, other signals."""
    wait = [line.split()[0] for line in whole.log].index("1") if whole.operations else 0
    late = wait / max(1, len(whole.log))
    blows = [Strike("SIGKILL", operation=n) for n in sample(whole.operations, every)]
    for k in range(moments):
        low = 0.0 if k % 2 else min(late, 0.9)  # half of them while something is written
        blows.append(Strike("SIGKILL", part=max(1e-3, random.uniform(low, 1.02))))
    return blows + [
        Strike(name, part=random.uniform(0.05, 0.98)) for name in SIGNALS for _ in range(max(1, moments // 8))
    ]


def kill(
    folder: Path,
    *,
    moments: int = 60,
    every: int = 1,
    seed: int,
    names: tuple[str, ...] = NAMES,
    report: Report = silent,
) -> State:
    """Do the rest of the campaign; return its state.

    Parameters
    ----------
    folder : Path
        Of the campaigns' states.
    moments : int
        Kills at random moments, of all models together.
    every : int
        1: before every operation; n: before each n-th, and all where a run begins and ends.
    seed : int
        Of the moments.
    names : tuple of str
        Models.
    report : callable
        Called with the progress.
    """
    state = State(folder.absolute(), "kill", seed)
    cases = [(name, former) for name in names for former in (True, False)]
    with workshop() as root:
        for name, former in cases:
            scene = Scene(name, root / f"{name}-{former}", former)
            scene.put()
            whole = strike(scene, Strike("none"))
            part = name if former else f"{name}, first run"
            if whole.code:
                raise RuntimeError(f"{part}: the run fails without a strike: {whole.err}")
            blows = strikes(scene, whole, random_of(seed, part, 0), -(-moments // len(cases)), every)
            for number, blow in enumerate(blows):
                if number not in state.part(part)["done"]:
                    _one(state, scene, part, number, blow, whole.seconds)
                    report(f"{part}: {number + 1} of {len(blows)}, {len(state.told['findings'])} findings")
    return state


def _one(state: State, scene: Scene, part: str, number: int, blow: Strike, seconds: float) -> None:
    begin = time.perf_counter()
    scene.put()
    done = strike(scene, blow, seconds)
    kind = "operations" if blow.operation else "moments" if blow.signal == "SIGKILL" else blow.signal
    counts = Counter([kind, "ended before it was struck" if done.code == 0 else "struck"])
    faults = []
    if blow.signal in SIGNALS:
        if done.code not in (0, INTERRUPTED) or "Traceback" in done.err:
            faults.append(
                (f"exit code {done.code}" + (", a traceback" if "Traceback" in done.err else ""), done.err[-1500:])
            )
    elif done.code not in (0, -signal.SIGKILL):
        faults.append((f"exit code {done.code}", done.err[-1500:]))
    if done.code:
        kind_of_end, found = scene.resumed(done.steps)
        counts[kind_of_end] += 1
        faults.extend(found)
    faults.extend(scene.faults(0 if done.code == 0 else done.finished))
    for signature, detail in faults:
        counts["faults"] += 1
        at = done.log[-1] if done.log else "before it began"
        state.find(part, number, kind, signature, f"{blow}, at: {at}\n{detail}")
    state.add(part, number, counts, time.perf_counter() - begin)
