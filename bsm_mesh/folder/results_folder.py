"""A results folder: where a run may write, and how a finished one takes the place of the former results.

A folder of a run is in one of the four states of `State`, and the ending of its name says which. The file next to it,
``.NAME.lock``, is locked while a run writes. Every change of state is one renaming (`docs/architecture.md` draws them).
A process may be killed between any two of them: `ResultsFolder.recover` of the next run ends the change.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.files import exchange, make_folder, move, remove, remove_empty, remove_tree, settle, write_text
from bsm_mesh.folder.own_files import (
    HEADER,
    MARKER,
    OF_A_RUN,
    SUMMARY,
    foreign_files,
    has_marker,
    is_left_by_a_run,
    is_same,
    keep_in,
    own_files,
    read_json,
    retire,
    run_number,
)
from bsm_mesh.locks import free_lock, holder, take_lock
from bsm_mesh.modelfile.reach import BESIDE

CURE = "choose a new or an empty folder"


class State(StrEnum):
    """State of a folder of a run, and the ending of its name."""

    RUNNING = ".running"
    """Finished stages and the checkpoint of a run that is under way or was killed."""
    INTERRUPTED = ".interrupted"
    """The same of a run that ended early."""
    FINISHED = ""
    """Complete results."""
    FORMER = ".former"
    """Complete results that newer ones replace."""


def refuse_unwritable(folder: Path, what: str = "results") -> None:
    """Raise `ModelError` where a folder cannot be made or written to: better before a long run than after it.

    Nothing is made; a disk that fills up later is found out later.
    """
    try:
        os.path.realpath(folder).encode()
    except UnicodeEncodeError:  # VTK and Gmsh write to no such place, nor does a model file name it
        raise ModelError(
            f"cannot write {what} to {folder}: a name in its path ({os.path.realpath(folder)!a}) is no text in UTF-8 "
            "(Latin-1, perhaps?); rename that folder, or choose another one"
        ) from None
    there = next((place for place in (folder, *folder.absolute().parents) if os.path.lexists(place)), folder)
    if not there.is_dir():
        raise ModelError(f"cannot write {what} to {folder}: {there} is not a folder; choose another folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise ModelError(f"cannot write {what} to {folder}: {there} is not writable; choose another folder")


@dataclass(frozen=True, slots=True)
class ResultsFolder:
    """The folder of a model's results.

    Attributes
    ----------
    path : Path
        As its user calls it.
    """

    path: Path

    def __post_init__(self) -> None:
        if "\0" in str(self.path):
            raise ModelError(f"{str(self.path)!r} is no name of a folder; give another one")

    @property
    def place(self) -> Path:
        """The folder itself, links resolved: it is renamed, and what leads to it is not."""
        return Path(os.path.realpath(self.path))

    def at(self, state: State) -> Path:
        """Return the folder of a run in a state."""
        return self.place.with_name(f"{self.place.name}{state}")

    @property
    def running(self) -> Path:
        """The folder that a run writes into until it is finished."""
        return self.at(State.RUNNING)

    @property
    def interrupted(self) -> Path:
        """The folder of an interrupted run."""
        return self.at(State.INTERRUPTED)

    @property
    def former(self) -> Path:
        """The former results, while new ones take their place."""
        return self.at(State.FORMER)

    @property
    def lock(self) -> Path:
        """The file whose lock a run holds."""
        return self.place.with_name(f".{self.place.name}.lock")

    def told(self, beside: Path) -> Path:
        """Return a folder next to this one as the user would call it."""
        return self.path.with_name(beside.name) if self.path.name == self.place.name else beside

    @property
    def is_own(self) -> bool:
        """Whether the folder exists and has the marker."""
        return has_marker(self.place)

    @property
    def is_free(self) -> bool:
        """Whether the folder is not there yet, or empty."""
        return not os.path.lexists(self.place) or (self.place.is_dir() and not any(self.place.iterdir()))

    def refuse(self, inputs: Iterable[Path] = ()) -> None:
        """Raise where a run may not write: nothing that bsm-mesh did not write is ever replaced.

        Parameters
        ----------
        inputs : iterable of Path
            Files that the run reads. Those in the folder stay; they must not have the name of a result.

        Raises
        ------
        ModelError
            With every fault found.
        """
        refuse_unwritable(self.path)
        if self.place.name.endswith(BESIDE):
            raise ModelError(
                f"{self.path}: names that end in {', '.join(BESIDE)} are kept for runs on their way; give another one"
            )
        if self.place.is_dir() and (not self.place.name or self.place.is_mount()):
            raise ModelError(f"{self.path} cannot be replaced as a whole (a disk is mounted there); {CURE} in it")
        self.refuse_foreign()
        raise_faults(self.strange())
        if Path.cwd().is_relative_to(self.place):
            raise ModelError(
                f"{self.path}: a run replaces its results folder as a whole, and the current folder is in it; "
                "run from the folder above, or choose another one"
            )
        if self.is_free:
            return
        refuse_unwritable(self.place.parent)  # where the folder is replaced
        kept = self.inside(inputs)
        faults = [
            f"{self.path / name} is read by this model, and a run writes a file of that name; keep it elsewhere"
            for name in kept
            if OF_A_RUN.fullmatch(name) and name != "model.toml"
        ]
        faults += [
            f"{self.path / name} is not from a run and would be replaced; move it, or choose another folder"
            for name in foreign_files(self.place)
            if OF_A_RUN.fullmatch(name) and name not in kept
        ]
        raise_faults(faults)

    def refuse_foreign(self) -> None:
        """Raise if the folder holds anything but is no results folder."""
        if not self.is_own and not self.is_free:
            raise ModelError(
                f"{self.path} holds files and is no results folder of bsm-mesh (there is no {MARKER} in it); {CURE}"
            )

    def strange(self) -> list[str]:
        """Return the faults of the folders next to this one: only a run's own folder counts as such."""
        beside = [place for place in (self.running, self.interrupted, self.former) if not is_left_by_a_run(place)]
        found = [
            f"{self.told(place)} is {'a link' if place.is_symlink() else f'not from a run (no {MARKER} in it)'}, and a "
            "folder of that name is kept for runs on their way; rename or remove it"
            for place in beside
        ]
        if self.lock.is_symlink():
            found.append(f"{self.told(self.lock)} is a link, and a run keeps its lock there; remove it")
        return found

    def inside(self, files: Iterable[Path]) -> list[str]:
        """Return the names, relative to the folder, of those files that lie in it."""
        real = [Path(os.path.realpath(file)) for file in files]
        return sorted({file.relative_to(self.place).as_posix() for file in real if file.is_relative_to(self.place)})

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other runs from the folder, repair the folders of a killed one, and give the folder above it.

        Raises
        ------
        ModelError
            If another run holds it; the message says who.
        """
        made = make_folder(self.place.parent)
        try:
            descriptor = take_lock(self.lock)
            if descriptor is None:
                raise ModelError(
                    f"{self.path}: another run writes there ({holder(self.lock)}); wait for its end, or choose another "
                    "folder"
                )
            try:
                self.recover()
                yield
            finally:
                free_lock(self.lock, descriptor)
        finally:
            remove_empty(made)

    def recover(self) -> None:
        """Complete the change begun by a killed run: finished results take their place, or the former ones come back.

        Where one of the other folders is a link, or has no marker of a run, nothing is touched.
        """
        if self.strange():
            return
        new, now = run_number(self.running), run_number(self.place)
        if new is not None and (now is None or new > now) and (self.is_own or self.is_free):
            self.put_in_place()
        elif not os.path.lexists(self.place) and self.former.is_dir():
            move(self.former, self.place)
        elif new is not None and now is not None:  # the names were exchanged already: these are the former results
            retire(self.running, self.place)
        if os.path.lexists(self.place):
            retire(self.former, self.place)

    def set_aside(self) -> None:
        """Keep the finished stages of a run that did not reach its end, in place of older ones."""
        raise_faults(self.strange())
        retire(self.interrupted, self.running)
        move(self.running, self.interrupted)

    def put_in_place(self) -> None:
        """Let the folder of the run take the place of the former results, in one step where the system can.

        Files of others go along. If a process dies in between, `recover` ends it.

        Raises
        ------
        ModelError
            If a folder next to it is not a run's.
        """
        raise_faults(self.strange())
        self._remove_unlisted()
        self.carry_over()
        if self.is_free:
            if os.path.lexists(self.place):
                remove_empty([self.place])
            move(self.running, self.place)
        else:
            remove_tree(self.former, last=MARKER)
            if exchange(self.running, self.place):
                move(self.running, self.former)
            else:
                move(self.place, self.former)
                move(self.running, self.place)
        settle(self.place.parent)
        with suppress(OSError):  # held open by another program; the next run removes it
            retire(self.former, self.place)
            retire(self.interrupted, self.place)

    def _remove_unlisted(self) -> None:
        """Remove what finished results do not list: the checkpoint and its files, and pictures of another state.

        Not before they are finished: a run that ends while it completes them resumes from its checkpoint.
        """
        for name in sorted(own_files(self.running) - set(read_json(self.running / SUMMARY)["files"])):
            if name not in (MARKER, SUMMARY):
                remove(self.running / name)
        if (self.running / MARKER).read_text(encoding="utf-8") != HEADER:
            write_text(self.running / MARKER, HEADER, settled=True)

    def carry_over(self) -> None:
        """Give the folder of the run all files of the present one that bsm-mesh did not write.

        Raises
        ------
        ModelError
            If the run wrote a file of the same name.
        """
        if not self.place.is_dir():
            return
        self.refuse_foreign()
        written = own_files(self.running)
        for name in foreign_files(self.place):
            if name in written and not is_same(self.running / name, self.place / name):
                raise ModelError(
                    f"{self.path / name} is not from a run and would be replaced; move it. The new results are in "
                    f"{self.told(self.running)}"
                )
            keep_in(self.place, self.running, name)


def told_fault(error: OSError) -> str:
    """Return the reason why a disk refuses writing, and the cure."""
    full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    cure = "free space there, or choose a folder on another disk" if full else "choose another folder"
    return f"{error.strerror or error}; {cure}"
