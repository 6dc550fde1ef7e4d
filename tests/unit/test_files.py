"""The one writer: files whole or not at all, whatever fails on the way."""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bsm_mesh import files
from tests import audited_operations
from tests.file_operations import names, watched


@pytest.fixture
def told() -> Iterator[list[tuple[str, str]]]:
    """Return the operations and the names of what they are about, as they happen."""
    found: list[tuple[str, str]] = []
    with watched(lambda operation, path, *_: found.append((operation, Path(path).name))):
        yield found


@pytest.fixture
def failing() -> Iterator[Callable[[str], None]]:
    """Return a function that makes an operation fail from now on, as on a full disk."""
    failed: set[str] = set()

    def hook(operation: str, path: str, *_: str) -> None:
        if operation in failed:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), path)

    with watched(hook):
        yield failed.add


def test_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("before")

    def write_half() -> None:
        with files.whole_file(path) as draft:
            draft.write_text("ha")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_half()
    assert names(tmp_path) == ["a.txt"]
    assert path.read_text() == "before"
    files.write_text(path, "after")
    assert names(tmp_path) == ["a.txt"]
    assert path.read_text() == "after"


@pytest.mark.parametrize("operation", ["write", "settle", "move"])
def test_what_fails_leaves_nothing(tmp_path: Path, failing: Callable[[str], None], operation: str) -> None:
    (tmp_path / "a.txt").write_text("before")
    failing(operation)
    with pytest.raises(OSError, match="No space left"):
        files.write_text(tmp_path / "a.txt", "after", settled=True)
    with (
        pytest.raises(OSError, match="No space left"),
        files.whole_file(tmp_path / "deep/er/b.txt", parents=True, settled=True) as draft,
    ):
        draft.write_text("b")
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "before"


def test_every_operation_is_told(tmp_path: Path, told: list[tuple[str, str]]) -> None:
    with files.whole_file(tmp_path / "new/a.vtu", parents=True, settled=True) as draft:
        draft.write_text("a")
        assert draft.suffix == ".vtu"  # libraries go by it
        assert files.is_draft(draft.name)
    written = draft.name
    assert told == [("make", "new"), ("write", written), ("settle", written), ("move", written)]
    told.clear()
    files.remove(tmp_path / "new/a.vtu")
    files.remove(tmp_path / "new/a.vtu")
    files.remove_tree(tmp_path / "new")
    assert told == [("remove", "a.vtu"), ("remove", "new")]


def test_drafts_of_killed_processes_go_with_the_next_file(tmp_path: Path) -> None:
    code = f"""
import os, pathlib
from bsm_mesh.files import whole_file
with whole_file(pathlib.Path({str(tmp_path / "a[1].txt")!r})) as draft:
    draft.write_text("half")
    os._exit(9)
"""
    root = str(Path(files.__file__).parents[1])
    subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": root}, check=False)
    (left,) = names(tmp_path)
    assert files.is_draft(left)
    mine = tmp_path / left.replace(left.split("-")[1], str(os.getpid()))
    mine.write_text("being written")
    files.write_text(tmp_path / "a[1].txt", "whole")
    assert names(tmp_path) == sorted([mine.name, "a[1].txt"])


def test_names_as_long_as_they_may_be(tmp_path: Path) -> None:
    files.write_text(tmp_path / ("x" * 251 + ".txt"), "a")
    assert len(names(tmp_path)) == 1


def test_a_scratch_folder_goes_and_takes_abandoned_ones_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with files.scratch_folder() as folder:
        assert folder.parent == tmp_path
        (folder / "mesh.msh").touch()
    assert names(tmp_path) == []
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    host = folder.name.split(".")[1].split("-")[0]
    for host_there, process in ((host, gone.pid), (host, os.getpid()), ("00000000", gone.pid)):
        (tmp_path / f"bsm-mesh.{host_there}-{process}-abc").mkdir()
    with files.scratch_folder():
        pass
    assert names(tmp_path) == sorted([f"bsm-mesh.{host}-{os.getpid()}-abc", f"bsm-mesh.00000000-{gone.pid}-abc"])


def test_a_scratch_folder_that_cannot_be_removed_ends_no_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[Path] = []

    def refused(path: Path) -> None:
        tried.append(path)
        if len(tried) < 3:  # the first folder both times, the second once
            raise OSError(errno.ENOSPC, "No space left on device")
        path.rmdir()

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(shutil, "rmtree", refused)
    for left in (1, 1):
        with files.scratch_folder():
            pass
        assert len(names(tmp_path)) == left
    assert len(tried) == 3


def test_a_second_name_for_files_folders_and_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a/b").mkdir(parents=True)
    (tmp_path / "a/b/c.txt").write_text("c")
    (tmp_path / "a/link").symlink_to("b/c.txt")
    files.keep(tmp_path / "a", tmp_path / "linked")
    assert (tmp_path / "linked/b/c.txt").samefile(tmp_path / "a/b/c.txt")
    assert os.readlink(tmp_path / "linked/link") == "b/c.txt"

    def no_links(*_: object) -> None:
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", no_links)
    files.keep(tmp_path / "a", tmp_path / "copied")
    assert (tmp_path / "copied/b/c.txt").read_text() == "c"
    with pytest.raises(FileExistsError):
        files.keep(tmp_path / "a", tmp_path / "copied")


@pytest.mark.skipif(sys.platform != "linux", reason="renameat2")
def test_folders_are_exchanged(tmp_path: Path) -> None:
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / name).touch()
    assert files.exchange(tmp_path / "one", tmp_path / "other")
    assert (names(tmp_path / "one"), names(tmp_path / "other")) == (["other"], ["one"])
    with pytest.raises(OSError, match="No such file"):
        files.exchange(tmp_path / "one", tmp_path / "nowhere")


def test_a_line_follows_one_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"first\nhal")
    files.append_line(path, "whole")
    assert [line for line in path.read_text().splitlines() if line] == ["first", "hal", "whole"]


def test_made_folders_are_told_and_go_only_while_empty(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    made = files.make_folder(tmp_path / "a/b/c")
    assert made == [tmp_path / "a/b", tmp_path / "a/b/c"]
    assert files.make_folder(tmp_path / "a/b/c") == []
    (tmp_path / "a/b/kept.txt").touch()
    files.remove_empty(made)
    assert names(tmp_path / "a/b") == ["kept.txt"]


def test_the_folder_for_temporary_files_is_found_without_writing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed between the two, Python's own search leaves the file that it writes to try the folder."""
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    done: list[str] = []
    with audited_operations.watched(tmp_path, lambda _, told: done.append(told)):
        assert files.temporary_place() == tmp_path
        with files.unnamed_file() as file:
            file.write(b"text")
            assert names(tmp_path) == []
        with files.scratch_folder():
            pass
    assert tempfile.tempdir is None
    own = {"os.mkdir", "os.rmdir", "bsm_mesh.files"}  # the scratch folder alone, and what its removal tells
    assert {told.split()[0] for told in done} <= own, done


def test_a_folder_for_temporary_files_that_is_not_there_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "none"))
    monkeypatch.setenv("TEMP", str(tmp_path))
    assert files.temporary_place() == Path(tempfile.gettempdir()) == tmp_path
