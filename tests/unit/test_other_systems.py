"""What only POSIX knows has a guard, and another way; files are text in UTF-8 on every system."""

from __future__ import annotations

import ast
import builtins
import errno
import os
import signal
import sys
import types
from collections.abc import Iterator
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh import files, heap, locks, processes
from bsm_mesh.commands import study
from tests.scenes.small_case import Case

ROOT = Path(__file__).parents[2]
SOURCES = [path for part in ("bsm_mesh", "converters", "geometries") for path in sorted((ROOT / part).rglob("*.py"))]
SOURCES = [
    path for path in SOURCES if not any((ROOT / "bsm_mesh" / n) in path.parents for n in ("converters", "geometries"))
]
POSIX_MODULES = {"fcntl", "grp", "pwd", "resource", "termios", "tty"}
POSIX_NAMES = {
    *("os.fork", "os.geteuid", "os.getpgid", "os.getuid", "os.kill", "os.killpg", "os.mkfifo", "os.sched_getaffinity"),
    *("os.setsid", "os.sysconf", "os.uname", "os.wait", "os.O_NOFOLLOW", "signal.SIGHUP", "signal.SIGKILL"),
    *("signal.SIGXCPU", "signal.alarm", "signal.setitimer", "signal.pthread_sigmask"),
}
OPENERS = {"read_text", "open", "fdopen"}  # `write_text` is the one writer's
OTHER_OPENERS = {"os.open", "Image.open", "archive.open"}
POSIX_WORDS = {name.rpartition(".")[2] for name in POSIX_MODULES | POSIX_NAMES}
GUARDS = ("os.name", "sys.platform", "hasattr(os", "except ImportError")


def unguarded(source: str) -> Iterator[str]:
    """Give what only POSIX knows, outside a function that asks for the system."""
    tree = ast.parse(source)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    for node in ast.walk(tree):
        name = posix_name(node)
        around = [f for f in functions if f.lineno <= getattr(node, "lineno", 0) <= (f.end_lineno or 0)] if name else []
        if name and not any(guard in ast.unparse(function) for guard in GUARDS for function in around):
            yield name


def posix_name(node: ast.AST) -> str:
    """Return what a node names, if only POSIX knows it."""
    if isinstance(node, ast.Import):
        return next((alias.name for alias in node.names if alias.name in POSIX_MODULES), "")
    if isinstance(node, ast.ImportFrom):
        return node.module if node.module in POSIX_MODULES else ""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        name = f"{node.value.id}.{node.attr}"
        return name if name in POSIX_NAMES else ""
    return ""


def without_encoding(source: str) -> Iterator[str]:
    """Give calls that open text in whatever encoding the system prefers."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in OPENERS and not any(keyword.arg == "encoding" for keyword in node.keywords):
            modes = [a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
            binary = any("b" in mode for mode in modes if set(mode) <= set("rwaxb+t"))
            named = name == "read_text" and node.args  # `path.read_text("utf-8")`, or a `read_text(file)` of ours
            if not binary and not named and ast.unparse(node.func) not in OTHER_OPENERS:
                yield ast.unparse(node)


def without_line_ends(source: str) -> Iterator[str]:
    """Give calls that write text with the line ends of the system."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and not any(keyword.arg == "newline" for keyword in node.keywords):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            modes = [a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
            opens = name in OPENERS and any(set(mode) <= set("wax+t") for mode in modes)
            ours = isinstance(node.func, ast.Name)  # the one writer
            if opens or (name == "write_text" and not ours):
                yield ast.unparse(node)


def found_in(search: object, words: set[str]) -> list[str]:
    """Return the findings in sources that hold one of these words."""
    assert callable(search)
    texts = {path.relative_to(ROOT): path.read_text(encoding="utf-8") for path in SOURCES}
    return [
        f"{path}: {found}"
        for path, text in texts.items()
        if any(word in text for word in words)
        for found in search(text)
    ]


def test_what_only_posix_knows_has_a_guard() -> None:
    assert found_in(unguarded, POSIX_WORDS) == []


@pytest.mark.heavy
def test_text_is_utf_8() -> None:
    assert found_in(without_encoding, OPENERS) == []


@pytest.mark.heavy
def test_line_ends_are_the_same_everywhere() -> None:
    assert found_in(without_line_ends, OPENERS | {"write_text"}) == []


def test_the_walks_find_what_they_look_for() -> None:
    assert list(unguarded("import fcntl\nx = os.getuid()")) == ["fcntl", "os.getuid"]
    assert list(unguarded("def f():\n    return os.getuid() if hasattr(os, 'getuid') else 0")) == []
    assert list(without_encoding("path.read_text()\nopen('a')\nopen('a', 'rb')\npath.read_text(encoding='utf-8')")) == [
        "path.read_text()",
        "open('a')",
    ]
    writing = "open('f', 'w')\npath.open('w', newline='')\np.write_text('a')\nwrite_text(p, 'a')\nopen('f', 'wb')"
    assert list(without_line_ends(writing)) == ["open('f', 'w')", "p.write_text('a')"]


def test_a_private_folder_without_users(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "getuid")
    assert files.private_folder() == files.temporary_place() / "bsm-mesh"


def test_as_many_runs_as_cores_where_none_are_assigned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 3)
    assert study._cores() == 3


def test_a_mesh_is_read_without_limits_where_there_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def missing(name: str, *rest: object) -> types.ModuleType:
        if name == "resource":
            raise ImportError(name)
        return real(name, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", missing)
    processes.limit_process(10, 1 << 30)


def test_two_folders_are_not_exchanged_where_the_system_cannot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    assert files.exchange(tmp_path / "a", tmp_path / "b") is False


def as_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take from our modules what Windows does not have; libraries stay what they are."""
    hidden = {"getuid", "sched_getaffinity", "O_NOFOLLOW", "kill", "sysconf"}
    names = {name: value for name, value in vars(os).items() if name not in hidden}
    windows = types.SimpleNamespace(**{**names, "name": "nt"})
    for module in (files, locks):
        monkeypatch.setattr(module, "os", windows)
    monkeypatch.setattr(files, "sys", types.SimpleNamespace(**{**vars(sys), "platform": "win32"}))
    monkeypatch.setitem(sys.modules, "msvcrt", types.SimpleNamespace(locking=lambda *_: None, LK_NBLCK=2))
    for name in ("fcntl", "resource"):
        monkeypatch.setitem(sys.modules, name, None)
    for name in ("SIGHUP", "SIGKILL", "SIGXCPU"):
        monkeypatch.delattr(signal, name, raising=False)


def test_a_run_and_the_next_one_where_posix_is_not_there(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """Locked, settled, exchanged and read again as on Windows, pictures and a foreign mesh apart."""
    as_windows(monkeypatch)
    for _ in range(2):
        outcome = case.run("run", "model.toml")
        assert outcome.code == 0, outcome.err
    assert bsm.Results.load(case.folder / "out" / "model").status.value == "stable"
    assert (case.folder / "out" / "model" / "summary.json").read_bytes().count(b"\r") == 0
    assert sorted(entry.name for entry in (case.folder / "out").iterdir()) == ["model"]  # nothing is left of the former


def test_what_has_no_answer_there_is_taken_as_safe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    as_windows(monkeypatch)
    assert files.is_alive(2**22 + 1)  # else the drafts of a running process would be removed
    files.settle(tmp_path)
    assert files.temporary_place().is_dir()
    monkeypatch.setattr(heap, "sys", types.SimpleNamespace(platform="win32"))
    heap._trim.cache_clear()
    heap.give_back()
    heap._trim.cache_clear()


def test_a_lock_by_the_functions_of_windows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    held: set[str] = set()

    def locking(descriptor: int, mode: int, length: int) -> None:
        assert (mode, length) == (2, 1)
        name = os.readlink(f"/proc/self/fd/{descriptor}") if sys.platform == "linux" else "lock"
        if name in held:
            raise OSError(errno.EACCES, "held")
        held.add(name)

    monkeypatch.setitem(sys.modules, "msvcrt", types.SimpleNamespace(locking=locking, LK_NBLCK=2))
    monkeypatch.setattr(locks, "os", types.SimpleNamespace(**{**vars(os), "name": "nt"}))  # pathlib asks for it too
    one = locks.take_lock(tmp_path / "lock")
    assert one is not None
    assert locks.take_lock(tmp_path / "lock") is None
    os.close(one)
