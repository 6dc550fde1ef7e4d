"""The one writer: every file that the project makes, moves or removes goes through here, whole or not at all.

A file is written under a name of its own in the same folder and renamed when it is complete. Before each operation
the audit event `EVENT` tells the operation's name and its paths (`sys.addaudithook`): tests count, fail and kill
there. Nothing of the project is imported here, so that all three packages may use it.
"""

from __future__ import annotations

import errno
import itertools
import os
import platform
import re
import shutil
import stat
import sys
import tempfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

EVENT = "bsm_mesh.files"
LONGEST = 80  # characters of a name that are kept in its draft's
NO_LINKS = (errno.EPERM, errno.EXDEV, errno.EMLINK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EACCES)
NO_EXCHANGE = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP, errno.EXDEV)

_NUMBERS = itertools.count(1)
_HERE = f"{zlib.crc32(platform.node().encode()):08x}"  # this machine, in the names of drafts
_OWNER = re.compile(r"\.(?P<host>[0-9a-f]{8})-(?P<process>\d+)-")


def tell(operation: str, *paths: Path) -> None:
    """Raise the audit event of an operation that is about to be done."""
    sys.audit(EVENT, operation, *map(str, paths))


@contextmanager
def whole_file(path: Path, *, parents: bool = False, settled: bool = False) -> Iterator[Path]:
    """Give a draft next to `path`, of the same ending, to write to; it is renamed when the block ends.

    If the block raises, the draft is removed and the former file stays. Drafts of `path` that a killed process left
    are removed.

    Parameters
    ----------
    path : Path
        The file.
    parents : bool
        Make its folder if it is missing; it goes again if the block raises.
    settled : bool
        Have it on the disk itself, and not only in the system's memory, before it is renamed.
    """
    made = make_folder(path.parent) if parents else []
    stem = f".{path.stem[:LONGEST]}"
    for entry in path.parent.glob(f"{_literally(stem)}.*.draft{_literally(path.suffix)}"):
        if _is_abandoned(entry.name):
            remove(entry)
    draft = path.with_name(f"{stem}.{_HERE}-{os.getpid()}-{next(_NUMBERS)}.draft{path.suffix}")
    try:
        tell("write", draft)
        yield draft
        if settled:
            settle(draft)
        move(draft, path)
    except BaseException:
        with suppress(OSError):
            remove(draft)
        remove_empty(made)
        raise


def write_text(path: Path, text: str, *, settled: bool = False) -> None:
    """Write a text file in UTF-8 with Unix line ends, whole or not at all."""
    with whole_file(path, settled=settled) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


def is_draft(name: str) -> bool:
    """Return whether a file's name is that of a draft."""
    return name.startswith(".") and ".draft" in name and _OWNER.search(name) is not None


def temporary_place() -> Path:
    """Return the folder for temporary files.

    Python finds it by writing a file of another name there (`tempfile.gettempdir`), which a process that is killed
    meanwhile leaves for ever; where it can be asked for, nothing is written.
    """
    if tempfile.tempdir is None and os.name != "nt":  # on Windows the system does not say what may be written to
        told = (os.environ.get(name) for name in ("TMPDIR", "TEMP", "TMP"))
        for place in filter(None, (*told, "/tmp", "/var/tmp", "/usr/tmp")):  # Python's own order
            if os.path.isdir(place) and os.access(place, os.W_OK | os.X_OK) and shutil.disk_usage(place).free:
                return Path(place).absolute()
    return Path(tempfile.gettempdir())


def unnamed_file() -> IO[bytes]:
    """Return a temporary file that is gone with the process, killed or not: it has no name."""
    return tempfile.TemporaryFile(dir=temporary_place())


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Give a temporary folder that is removed when the block ends; those that killed processes left are removed."""
    place = temporary_place()
    for left in place.glob(f"bsm-mesh.{_HERE}-*"):
        if _is_abandoned(left.name):
            with suppress(OSError):  # another user's
                remove_tree(left)
    tell("make", place)
    folder = Path(tempfile.mkdtemp(prefix=f"bsm-mesh.{_HERE}-{os.getpid()}-", dir=place))
    try:
        yield folder
    finally:
        _clear_away(folder)


@contextmanager
def given_alone(files: Mapping[str, Path]) -> Iterator[Path]:
    """Give a scratch folder that holds these files and no others, each by the name it is given here.

    For readers that look at names (as addresses, as the format, as scripts) and at what lies beside a file.
    """
    with scratch_folder() as folder:
        for name, file in files.items():
            keep(Path(os.path.realpath(file)), folder / name)
        yield folder


def _clear_away(folder: Path) -> None:
    """Remove a scratch folder, at the second try if need be: the remainder must not end a run that is done."""
    for _ in range(2):
        with suppress(OSError):
            remove_tree(folder)
            return


def private_folder() -> Path | None:
    """Return a folder among temporary files that nobody but this user can write to; None if there is none.

    It stays: the kept part there may hold code.
    """
    if not hasattr(os, "getuid"):  # on Windows temporary files are the user's own
        return temporary_place() / "bsm-mesh"
    try:
        folder = temporary_place() / f"bsm-mesh-{os.getuid()}"
        tell("make", folder)
        with suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        status = folder.lstat()
    except OSError:
        return None
    mine = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o077
    return folder if mine else None


def make_folder(path: Path) -> list[Path]:
    """Make a folder and those above it that are missing; return the new folders, the topmost first."""
    made: list[Path] = []
    try:
        for place in [place for place in (path, *path.parents) if not place.is_dir()][::-1]:
            tell("make", place)
            try:
                place.mkdir()
                made.append(place)
            except FileExistsError:  # another process was quicker
                if not place.is_dir():
                    raise
    except BaseException:
        remove_empty(made)
        raise
    return made


def move(source: Path, target: Path) -> None:
    """Give a file or folder another name; a file of that name is replaced, an empty folder too."""
    tell("move", source, target)
    source.replace(target)


def exchange(one: Path, other: Path) -> bool:
    """Exchange two names in one step; return False where the system or the file system cannot."""
    tell("exchange", one, other)
    if sys.platform != "linux":
        return False
    import ctypes

    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except (AttributeError, OSError):  # an old C library, or another one
        return False
    here, by_exchange = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
    if rename(here, os.fsencode(one), here, os.fsencode(other), by_exchange) == 0:
        return True
    code = ctypes.get_errno()
    if code in NO_EXCHANGE:
        return False
    raise OSError(code, os.strerror(code), str(one))


def keep(source: Path, target: Path) -> None:
    """Give a file, or a folder with all that is in it, a second name; a copy where there are no links.

    Raises
    ------
    FileExistsError
        If `target` is there.
    """
    tell("keep", source, target)
    if source.is_symlink():
        target.symlink_to(os.readlink(source))
    elif source.is_dir():
        target.mkdir()
        for entry in sorted(source.iterdir()):
            keep(entry, target / entry.name)
        shutil.copystat(source, target)
    else:
        try:
            os.link(source, target)
        except OSError as error:
            if error.errno not in NO_LINKS:
                raise
            shutil.copy2(source, target)


def remove(path: Path) -> None:
    """Remove a file, if it is there."""
    if os.path.lexists(path):
        tell("remove", path)
        path.unlink(missing_ok=True)


def remove_abandoned(folder: Path) -> None:
    """Remove the drafts that processes which are gone left in a folder."""
    for entry in folder.glob(".*"):
        if is_draft(entry.name) and _is_abandoned(entry.name):
            remove(entry)


def remove_tree(path: Path, last: str = "") -> None:
    """Remove a folder with all that is in it, if it is there.

    Parameters
    ----------
    path : Path
        The folder; a link to one is refused, and those in it are removed as links.
    last : str
        Name of a file in it that goes when all else is gone: it identifies the rest.
    """
    if not os.path.lexists(path):
        return
    tell("remove", path)
    if path.is_symlink():
        raise OSError(errno.ELOOP, "not removed, because it is a symbolic link", str(path))
    if last:
        for entry in [entry for entry in os.scandir(path) if entry.name != last]:
            if entry.is_dir(follow_symlinks=False):
                shutil.rmtree(entry.path)
            else:
                os.unlink(entry.path)
    shutil.rmtree(path)


def remove_empty(folders: list[Path]) -> None:
    """Remove folders that are empty, the last first: what `make_folder` made."""
    for folder in reversed(folders):
        with suppress(OSError):
            tell("remove", folder)
            folder.rmdir()


def append_line(path: Path, line: str) -> None:
    """Add a line to a text file, never through a link; one that a killed process left unfinished is ended first."""
    tell("append", path)
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    with os.fdopen(os.open(path, flags, 0o666), "ab") as file:
        file.write(f"\n{line}\n".encode())
        file.flush()
        os.fsync(file.fileno())


def settle(path: Path) -> None:
    """Wait until a file, or the list of names in a folder, is on the disk itself."""
    tell("settle", path)
    folder = path.is_dir()
    if folder and os.name == "nt":  # Windows opens no folders
        return
    descriptor = os.open(path, os.O_RDONLY if folder else os.O_RDWR)
    try:
        os.fsync(descriptor)
    except OSError:
        if not folder:  # some file systems have nothing to settle in a folder
            raise
    finally:
        os.close(descriptor)


def copy_mode(source: Path, target: Path) -> None:
    """Give a folder the permissions of another one, as far as that is allowed."""
    with suppress(OSError):
        tell("mode", target)
        target.chmod(stat.S_IMODE(source.stat().st_mode))


def is_alive(process: int) -> bool:
    """Return whether a process of this machine is there; of what cannot be asked it is assumed."""
    if os.name == "nt":  # there is no harmless signal to ask with
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


def _is_abandoned(name: str) -> bool:
    """Return whether a draft's or scratch folder's process ran on this machine and is gone."""
    owner = _OWNER.search(name)
    return owner is not None and owner["host"] == _HERE and not is_alive(int(owner["process"]))


def _literally(text: str) -> str:
    """Return a text for `Path.glob` that is complete."""
    return re.sub(r"([*?[])", r"[\1]", text)
