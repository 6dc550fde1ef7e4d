"""Where inputs are done: a folder of their own, in which nothing may be left behind."""

from __future__ import annotations

import fnmatch
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from .inputs import OK, REFUSED, Input, Outcome, judge


class Place:
    """A folder for inputs, and one for the temporary files of the program; the first is the current one.

    Parameters
    ----------
    root : Path
        It is made, and holds nothing else.
    """

    def __init__(self, root: Path) -> None:
        self.root, self.folder, self.temporary = root, root / "deep" / "work", root / "tmp"
        self.clean()

    def clean(self) -> None:
        """Empty the folder, and make it the current one."""
        os.chdir("/")
        shutil.rmtree(self.root, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.temporary.mkdir()
        os.chdir(self.folder)

    def put(self, files: Mapping[str, bytes]) -> None:
        """Write an input's files."""
        for name, data in files.items():
            path = self.folder / name
            if "/" in name:
                path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)

    def do(self, given: Input) -> Outcome:
        """Do an input and return the outcome of it, files left behind included."""
        self.put(given.files)
        outcome = judge(given)
        expected = {name.partition("/")[0] for name in given.files}
        left = [name for name in self._names() if name not in expected and not _allowed(name, given.leaves)]
        there = self._names()
        if left and outcome.kind in (OK, REFUSED):
            kind = "tmp" if left[0].startswith("tmp/") else "the folder"
            outcome = Outcome(
                "left behind", f"in {kind}: {''.join('#' if c.isdigit() else c for c in left[0])}", str(left)
            )
        if left or set(there) - expected or len(expected) < len(given.files):
            self.clean()
        else:
            for name in given.files:
                (self.folder / name).unlink(missing_ok=True)
        return outcome

    def _names(self) -> list[str]:
        beside = [f"../{name}" for name in os.listdir(self.folder.parent) if name != self.folder.name]
        return [*os.listdir(self.folder), *(f"tmp/{name}" for name in os.listdir(self.temporary)), *beside]


def _allowed(name: str, leaves: tuple[str, ...]) -> bool:
    return not name.startswith(("tmp/", "../", ".")) and any(fnmatch.fnmatch(name, leave) for leave in leaves)


@contextmanager
def place() -> Iterator[Place]:
    """Give a place in memory, if there is such a disk; all is as before when the block ends."""
    here, kept = Path.cwd(), tempfile.tempdir
    disk = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    root = Path(tempfile.mkdtemp(prefix="campaign-", dir=disk))
    try:
        made = Place(root)
        tempfile.tempdir = str(made.temporary)
        yield made
    finally:
        tempfile.tempdir = kept
        os.chdir(here)
        shutil.rmtree(root, ignore_errors=True)
