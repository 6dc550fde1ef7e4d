"""What runs where the system is no POSIX: modules, calls and signals that Windows lacks are taken away."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.scenes.small_case import LINEAR, MODEL, Case, environment

AS_ON_WINDOWS = """
import asyncio, multiprocessing, shutil, subprocess, tempfile  # the standard library keeps its own system
import importlib, os, pkgutil, signal, sys, types

for name in ("fcntl", "pwd", "grp", "termios", "resource"):  # to import one of these fails
    sys.modules[name] = None
LACKS = set(
    "chown fchmod fchown fork forkpty getegid geteuid getgid getpgid getuid killpg lchown mkfifo mknod nice openpty "
    "pathconf posix_fallocate posix_spawn sched_getaffinity sched_setaffinity setsid statvfs fstatvfs sync sysconf "
    "uname wait3 wait4 O_CLOEXEC O_DIRECTORY O_NOFOLLOW O_NONBLOCK O_SYNC WNOHANG SIGALRM SIGCHLD SIGCONT SIGHUP "
    "SIGKILL SIGPIPE SIGQUIT SIGSTOP SIGTSTP SIGUSR1 SIGUSR2 SIGWINCH".split()
)


class Msvcrt(types.ModuleType):
    LK_NBLCK, LK_UNLCK = 2, 0
    locks = []

    def locking(self, descriptor, mode, count):
        self.locks.append(descriptor)


class Windows:
    name = "nt"

    def __init__(self, module):
        self.module = module

    def __getattr__(self, name):
        if name in LACKS:
            raise AttributeError(f"Windows has no {name}")
        return getattr(self.module, name)


sys.modules["msvcrt"] = Msvcrt("msvcrt")
import bsm_mesh

for found in pkgutil.walk_packages(bsm_mesh.__path__, "bsm_mesh.", onerror=lambda name: None):
    if not found.name.endswith("__main__"):
        importlib.import_module(found.name)
for module in [m for name, m in sys.modules.items() if name.partition(".")[0] == "bsm_mesh"]:
    for name, whole in (("os", os), ("signal", signal)):
        if getattr(module, name, None) is whole:
            setattr(module, name, Windows(whole))
from bsm_mesh.commands.cli import main

for arguments in COMMANDS:
    try:
        main(arguments)
    except SystemExit as end:
        assert not end.code, arguments
assert Msvcrt.locks
"""


@pytest.mark.slow
def test_a_model_is_checked_run_twice_verified_and_drawn(case: Case) -> None:
    case.write("model.toml", MODEL)
    plot = ["plot", "out/model", "--only", "final_position"]
    commands = [["check", "model.toml"], ["run", "model.toml"], ["run", "model.toml"], ["verify", "out/model"], plot]
    script = AS_ON_WINDOWS.replace("COMMANDS", repr(commands))
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=case.folder, env=environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert (case.folder / "out/model/blocks.pvd").is_file()
    assert (case.folder / "out/model/pictures/final_position.png").is_file()


@pytest.mark.heavy
def test_texts_are_utf_8_whatever_the_system_s_encoding(case: Case) -> None:
    case.write("model.toml", MODEL.replace("Two by two", "Über München") + LINEAR)
    command = [sys.executable, "-X", "utf8=0", "-m", "bsm_mesh", "run", "model.toml"]
    given = environment() | {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"}
    done = subprocess.run(command, cwd=case.folder, env=given, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads((case.folder / "out/model/summary.json").read_text(encoding="utf-8"))["title"] == "Über München"
    assert "Über München" in (case.folder / "out/model/model.toml").read_text(encoding="utf-8")
