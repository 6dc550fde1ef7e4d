"""The disk campaign: a disk that is full at an operation, from an operation on, at a file's size, or in all (tmpfs)."""

from __future__ import annotations

import contextlib
import errno
import os
import resource
import shutil
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.audited_operations import watched
from tests.scenes.model_folders import NAMES

from .inputs import random_of
from .scenes import OUT, Report, Scene, silent, workshop
from .state import State
from .struck import sample

NEEDS_NO_ROOM = (
    "os.remove",
    "os.rmdir",
    "os.chmod",
    "bsm_mesh.files remove",
    "bsm_mesh.files move",
    "bsm_mesh.files exchange",
    "os.rename",
)
Full = Callable[[Scene], "contextlib.AbstractContextManager[None]"]


def at_operation(number: int, stays: bool) -> Full:
    """Return a disk that is full at an operation, and where it stays so at those after it that need room."""

    @contextmanager
    def full(scene: Scene) -> Iterator[None]:
        def act(seen: int, told: str) -> None:
            if seen == number or (stays and seen > number and not told.startswith(NEEDS_NO_ROOM)):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), told)

        with watched(scene.root, act):
            yield

    return full


def at_size(most: int) -> Full:
    """Return a disk on which no file can be larger than so many bytes."""

    @contextmanager
    def full(scene: Scene) -> Iterator[None]:
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    return full


@contextmanager
def small_disk(place: Path) -> Iterator[bool]:
    """Mount a disk in memory at a place; give whether that may be done here."""
    place.mkdir(parents=True)
    mounted = os.geteuid() == 0 and _mount("-t", "tmpfs", "-o", "size=64m", "tmpfs", str(place))
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", "-l", str(place)], check=False, capture_output=True)


def _mount(*arguments: str) -> bool:
    try:
        return subprocess.run(["mount", *arguments], check=False, capture_output=True).returncode == 0
    except OSError:
        return False


def of_size(place: Path, kilobytes: int) -> Full:
    """Return the disk in memory with so much room beyond what is on it."""

    @contextmanager
    def full(scene: Scene) -> Iterator[None]:
        used = shutil.disk_usage(place).used // 1024
        _mount("-o", f"remount,size={used + kilobytes}k", str(place))
        try:
            yield
        finally:
            _mount("-o", "remount,size=64m", str(place))

    return full


def count_operations(scene: Scene) -> int:
    """Return how many operations on files a run of a scene does."""
    seen: list[int] = []
    scene.put()
    with watched(scene.root, lambda number, told: seen.append(number)):
        scene.run()
    return len(seen)


def one(scene: Scene, full: Full) -> tuple[int, list[tuple[str, str]]]:
    """Run a scene on a full disk; return the exit code and the fault then, and after the next run."""
    scene.put()
    before = scene.names()
    with full(scene):
        try:
            code, said = scene.run()
        except BaseException as error:
            code, said = -1, repr(error)
    faults = []
    if code not in (0, 2) or "Traceback" in said:
        faults.append((f"exit code {code}", said[-1500:]))
    if code == 2 and not said.startswith("error: "):
        faults.append(("no message", said[-1500:]))
    if code:
        left = [name for name in scene.names() if name not in before and name.startswith((f"{OUT}/", "tmp/"))]
        if left and scene.former:
            faults.append(("left behind by the failed run", str(left)))
    faults.extend(scene.faults())
    return code, faults


def disk(
    folder: Path, *, sizes: int = 40, every: int = 1, seed: int, names: tuple[str, ...] = NAMES, report: Report = silent
) -> State:
    """Do the rest of the campaign; return its state.

    Parameters
    ----------
    folder : Path
        Of the campaigns' states.
    sizes : int
        Sizes of file and of disk, each, a model.
    every : int
        1: the disk is full at every operation; n: at each n-th, and all where a run begins and ends.
    seed : int
        Of the sizes.
    names : tuple of str
        Models.
    report : callable
        Called with the progress.
    """
    state = State(folder.absolute(), "disk", seed)
    with workshop() as root, small_disk(root / "small") as mounted:
        for name in names:
            random = random_of(seed, name, 0)
            scene = Scene(name, root / name)
            last = count_operations(scene)
            blows: list[tuple[str, Scene, Full]] = []
            for number in sample(last, every):
                blows += [("at an operation", scene, at_operation(number, stays)) for stays in (False, True)]
            blows += [
                ("at a file's size", scene, at_size(int(random.uniform(0, 1) ** 3 * 60_000))) for _ in range(sizes)
            ]
            if mounted:
                there = Scene(name, root / "small" / name)
                blows += [("disk in memory", there, of_size(root / "small", 4 * k)) for k in range(sizes)]
            for number, (kind, where, full) in enumerate(blows):
                if number in state.part(name)["done"]:
                    continue
                begin = time.perf_counter()
                code, faults = one(where, full)
                counts = Counter([kind, "refused" if code == 2 else "finished" if code == 0 else "broken"])
                for signature, detail in faults:
                    counts["faults"] += 1
                    state.find(name, number, kind, signature, detail)
                state.add(name, number, counts, time.perf_counter() - begin)
                report(f"{name}: {number + 1} of {len(blows)}, {len(state.told['findings'])} findings")
    return state
