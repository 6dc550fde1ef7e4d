"""The models of the kill and disk campaigns, and what is demanded of a folder of results after a run was struck."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from tests.scenes.model_folders import content, put_model

from .inputs import without_numbers

if TYPE_CHECKING:
    from bsm_mesh.results import StepRecord

OUT = "out"
KEPT_BESIDE = (f"{OUT}.interrupted",)  # what the program may leave on purpose: the finished stages of the struck run


@dataclass
class Scene:
    """A model in a folder of its own: the results of a former run, and those that a new run gives.

    Attributes
    ----------
    name : str
        Of the model.
    root : Path
        The folder; the program's temporary files go into ``tmp`` in it.
    former : bool
        Whether there are former results.
    """

    name: str
    root: Path
    former: bool = True

    @cached_property
    def _prepared(self) -> tuple[str, str, list[str]]:
        """Return the fingerprints of the former and the new results, and all names after a run that nothing struck.

        What its files hold and how many steps it took is kept too.
        """
        self._write("The former run", "12 kN/m^3")
        self.run()
        shutil.copytree(self.root / OUT, self._kept)
        old = fingerprint(self.root / OUT)
        self._write("The new run", "26 kN/m^3")
        self.run()
        self._content = content(self.root / OUT)
        self._steps = len(self._content["history.csv"]) - 1
        return old, fingerprint(self.root / OUT), self.names()

    @property
    def _kept(self) -> Path:
        return self.root.with_name(f"{self.root.name}.former")

    def _write(self, title: str, unit_weight: str) -> None:
        (self.root / "tmp").mkdir(parents=True, exist_ok=True)
        put_model(self.root, self.name, title=title, unit_weight=unit_weight)

    def put(self) -> None:
        """Bring the folder to where it is before a new run."""
        _ = self._prepared
        for entry in self.root.iterdir():
            if entry.name not in ("model.toml", "mesh.msh", "bolts.csv"):
                shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
        (self.root / "tmp").mkdir()
        if self.former:
            shutil.copytree(self._kept, self.root / OUT)

    @property
    def arguments(self) -> list[str]:
        """The command."""
        return ["run", str(self.root / "model.toml"), "-o", str(self.root / OUT), "--json"]

    def resumed(self, steps: int) -> tuple[str, list[tuple[str, str]]]:
        """Go on with a run that was struck, bring the folder back, and return how it went and the fault.

        Parameters
        ----------
        steps : int
            Steps that had ended: all but the last must not be done again, for a checkpoint follows each.
        """
        _, new, clean = self._prepared
        aside = self.root.with_name(f"{self.root.name}.struck")
        shutil.copytree(self.root, aside, symlinks=True)
        faults, end = [], "resumed"
        with counted_steps() as seen:
            code, said = self.run("--resume")
        if code == 2 and "there is nothing to continue with" in said and fingerprint(self.root / OUT) == new:
            end = "was finished"
        elif code:
            faults.append(("resuming fails", said))
        else:
            end = end if len(seen) < self._steps else "begins at the start"
            if content(self.root / OUT) != self._content:
                faults.append(("a resumed run ends otherwise", said))
            if len(seen) > self._steps - max(0, steps - 1):
                faults.append(("more than a step is lost", f"{steps} of {self._steps} were done, then {len(seen)}"))
            if left := [name for name in self.names() if name not in clean]:
                faults.append((f"left after the resumed run: {without_numbers(left[0])}", str(left)))
        shutil.rmtree(self.root)
        aside.rename(self.root)
        return end, faults

    def run(self, *more: str) -> tuple[int, str]:
        """Run the command in this process, with more arguments; return its exit code and what it says on stderr."""
        from bsm_mesh.commands.cli import main

        err = io.StringIO()
        kept, tempfile.tempdir = tempfile.tempdir, str(self.root / "tmp")
        try:
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err):
                main([*self.arguments, *more])
        except SystemExit as leaving:
            return int(leaving.code or 0), err.getvalue()
        finally:
            tempfile.tempdir = kept
        return 0, err.getvalue()

    def names(self) -> list[str]:
        """Return all names in the folder."""
        return sorted(str(path.relative_to(self.root)) for path in self.root.rglob("*"))

    def faults(self, finished: int = 0) -> Iterator[tuple[str, str]]:
        """Yield the fault after a run was struck, then run again and yield the fault then.

        Parameters
        ----------
        finished : int
            Stages that were finished.
        """
        _, new, clean = self._prepared
        yield from self.reader_faults()
        if finished and self.most_stages() < finished:
            yield (
                "a finished stage is not on disk",
                f"{finished} finished, {self.most_stages()} readable: {self.names()}",
            )
        code, said = self.run()
        if code:
            yield "the next run fails", said
        elif fingerprint(self.root / OUT) != new:
            yield "the next run gives other results", said
        left = [name for name in self.names() if name not in clean and not name.startswith(KEPT_BESIDE)]
        if left:
            yield f"left after the next run: {without_numbers(left[0])}", str(left)

    def reader_faults(self) -> Iterator[tuple[str, str]]:
        """Yield what a reader finds wrong: neither the former results nor the new ones, whole."""
        old, new, _ = self._prepared
        try:
            found = fingerprint(self.root / OUT)
        except Exception as error:
            if self.former or (self.root / OUT / "summary.json").exists():
                yield f"the reader finds neither: {type(error).__name__}", f"{error}\n{self.names()}"
            return
        if found not in ((old, new) if self.former else (new,)):
            yield "the reader finds a mixture", str(self.names())

    def most_stages(self) -> int:
        """Return how many stages can be read, from the results or from what is compared with them."""
        import bsm_mesh as bsm

        found = 0
        for entry in self.root.iterdir():
            if entry.name.startswith((OUT, f".{OUT}")) and entry.is_dir():
                with contextlib.suppress(Exception):
                    results = bsm.Results.load(entry)
                    if results.title == "The new run":
                        found = max(found, len(results.stages))
        return found


@contextmanager
def counted_steps() -> Iterator[list[int]]:
    """Give a list to which the command adds the stage of every step."""
    from bsm_mesh.text.progress import Progress

    seen: list[int] = []
    step = Progress.step

    def counted(self: Progress, record: StepRecord) -> None:
        seen.append(record.stage)
        step(self, record)

    Progress.step = counted  # type: ignore[method-assign]
    try:
        yield seen
    finally:
        Progress.step = step  # type: ignore[method-assign]


def fingerprint(folder: Path) -> str:
    """Return a digest of what results say, times aside; they are checked as well."""
    import hashlib

    import numpy as np

    import bsm_mesh as bsm

    results = bsm.Results.load(folder)
    results.check()
    told = hashlib.sha256(f"{results.title} {results.status} {len(results.stages)}".encode())
    for stage in results.stages:
        for part in (stage, stage.contacts, stage.supports, stage.bolts):
            for name in sorted(part.__dataclass_fields__):
                value = getattr(part, name)
                if isinstance(value, np.ndarray):
                    told.update(np.ascontiguousarray(value).tobytes())
    return told.hexdigest()


@contextmanager
def workshop() -> Iterator[Path]:
    """Give a temporary folder for scenes."""
    here = Path.cwd()
    root = Path(tempfile.mkdtemp(prefix="campaign-"))
    try:
        yield root
    finally:
        os.chdir(here)
        shutil.rmtree(root, ignore_errors=True)


Report = Callable[[str], None]


def silent(text: str) -> None:
    """Report nothing."""
