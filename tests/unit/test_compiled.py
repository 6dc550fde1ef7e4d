"""Compiled kernels on disk: known by what went into them, in one folder, and no run stops for their sake."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from numba import types
from numba.core.dispatcher import Dispatcher

from bsm_mesh import kernel_files
from bsm_mesh.commands.precompile import kernel_of, listed, name_of
from bsm_mesh.compiled import VERSIONS, called_by, compiled_into
from bsm_mesh.contact.narrow_phase import facing_rows
from bsm_mesh.solve.bolts.chain import solve_chain
from bsm_mesh.solve.bolts.kernels import add_bolt_forces
from bsm_mesh.solve.motion.kernels import advance
from bsm_mesh.text.progress import Progress
from docs.code_blocks import python_blocks
from tests.scenes.small_case import ROOT, environment

pytestmark = pytest.mark.robust

PACKAGE = (
    "__init__",
    "arrays",
    "compiled",
    "errors",
    "files",
    "kernel_files",
    "reading",
    "run",
    "lazy",
    "solving",
    "version",
)  # of the package
KERNELS = """
from bsm_mesh.compiled import njit

@njit()
def first(x):
    return x + 1

@njit(error_model="numpy")
def second(x):
    return first(x) + 1
"""
AT_ONCE = 10  # processes
CALL = "import kernels, bsm_mesh.kernel_files as files; print(kernels.second(1), files._compiled, files.places().write)"


def settings(folder: Path, **told: str) -> dict[str, str]:
    """Return an environment without a home, in which Python finds a folder's modules first."""
    known = {key: value for key, value in environment().items() if key != "NUMBA_CACHE_DIR"}
    nowhere = {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", "TMPDIR": str(folder)}
    return {**known, **nowhere, "PYTHONPATH": f"{folder}{os.pathsep}{known['PYTHONPATH']}", **told}


def call(folder: Path, code: str = CALL, **told: str) -> tuple[str, str]:
    """Return what a process in a folder writes."""
    command = [sys.executable, "-B", "-c", code]
    done = subprocess.run(
        command, env=settings(folder, **told), cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip(), done.stderr


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Return a folder with a part of the package, and a module with kernels."""
    (tmp_path / "bsm_mesh").mkdir()
    for name in PACKAGE:
        shutil.copy(ROOT / f"bsm_mesh/{name}.py", tmp_path / "bsm_mesh")
    (tmp_path / "kernels.py").write_text(KERNELS)
    return tmp_path


def read_only(copy: Path) -> None:
    """Have nothing kept in the package: not even a superuser makes a folder there."""
    (copy / "bsm_mesh/_kernels").touch()


def test_kernels_are_kept_in_the_package_and_read_from_there(copy: Path) -> None:
    there = copy / "bsm_mesh/_kernels"
    assert call(copy) == (f"3 2 {there}", "")
    assert {path.name.partition("-")[0] for path in there.rglob("*.nbc")} == {"kernels.first", "kernels.second"}
    assert call(copy)[0].startswith("3 0 ")


@pytest.mark.heavy
def test_a_kernel_read_from_its_file_needs_nothing_of_the_compiler(copy: Path) -> None:
    """The modules in which Numba keeps Python's and NumPy's functions are a fifth of the time of a small run."""
    third = "@njit(allocates=True)\ndef third(x):\n    return np.full(x, second(x)).sum()\n"
    (copy / "kernels.py").write_text(f"import numpy as np\n{KERNELS}\n\n{third}")
    code = "import sys, kernels; print(kernels.third(2), 'numba.np.arrayobj' in sys.modules)"
    assert call(copy, code)[0] == "8 True"
    assert call(copy, code)[0] == "8 False"


def test_kernels_in_a_package_that_cannot_be_written_to_are_read(copy: Path) -> None:
    """A wheel that carries them, installed by somebody else."""
    call(copy)
    (copy / "kernels.py").write_text(f"{KERNELS}\n\n@njit()\ndef third(x):\n    return second(x) + 1\n")
    place = "import bsm_mesh.kernel_files as files; files._is_writable = lambda folder: False;"
    said, _ = call(copy, f"{place} import kernels; print(kernels.third(1), files._compiled, files.places().write)")
    assert said == f"4 1 {copy / f'bsm-mesh-{os.getuid()}'}"
    assert not list((copy / "bsm_mesh/_kernels").rglob("*third*"))


def test_a_user_s_own_cache_serves_where_the_package_cannot_be_written_to(copy: Path) -> None:
    read_only(copy)
    said, warned = call(copy, HOME=str(copy / "home"), XDG_CACHE_HOME=str(copy / "home/.cache"))
    assert said == f"3 2 {copy}/home/.cache/bsm-mesh/kernels"
    assert warned == ""


def test_where_nothing_can_be_kept_a_folder_of_ones_own_serves(copy: Path) -> None:
    read_only(copy)
    said, warned = call(copy)
    (own,) = copy.glob("bsm-mesh-*")
    assert own.stat().st_mode & 0o077 == 0
    assert said == f"3 2 {own}"
    assert warned.count("CacheWarning: ") == 1
    assert "NUMBA_CACHE_DIR" in warned
    assert call(copy)[0].startswith("3 0 ")


def test_what_others_can_write_to_is_no_place_for_code(copy: Path) -> None:
    read_only(copy)
    own = copy / f"bsm-mesh-{os.getuid()}"
    own.mkdir()
    own.chmod(0o777)
    said, warned = call(copy)
    assert said == "3 2 None"
    assert warned.count("CacheWarning: there is no folder for compiled code") == 1
    assert not list(own.iterdir())


@pytest.mark.slow
def test_a_folder_that_is_named_replaces_all_others(copy: Path) -> None:
    call(copy)
    assert call(copy, NUMBA_CACHE_DIR=str(copy / "kept"))[0] == f"3 2 {copy / 'kept'}"
    assert call(copy, NUMBA_CACHE_DIR=str(copy / "kept"))[0] == f"3 0 {copy / 'kept'}"


def test_damaged_compiled_code_is_made_anew(copy: Path) -> None:
    call(copy)
    kept = [*(copy / "bsm_mesh").rglob("*.nbc")]
    whole = [path.stat().st_size for path in kept]
    for path in kept:
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    said, warned = call(copy)
    assert said.startswith("3 2 ")
    assert warned == ""
    assert [path.stat().st_size for path in kept] == whole


def test_settings_in_the_current_folder_do_not_say_where_code_is_kept(copy: Path) -> None:
    (copy / "yaml.py").write_text("def safe_load(file):\n    return {'cache_dir': 'evil'}\n")
    (copy / ".numba_config.yaml").touch()
    assert "evil" not in call(copy)[0]
    assert not (copy / "evil").exists()


CALLER = """
from bsm_mesh.compiled import njit
from called import PART, called

@njit()
def kernel(x):
    return called(x) + PART
"""
CALLED = """
from bsm_mesh.compiled import njit

PART = {part}

@njit()
def called(x):
    "{words}"
    return x + {more}

@njit()
def beside(x):
    return x + {beside}
"""
ASK = "from caller import kernel; import bsm_mesh.kernel_files as files; print(kernel(0), files._compiled)"


@pytest.mark.slow
def test_a_kernel_is_compiled_anew_exactly_where_something_changes_that_goes_into_it(copy: Path) -> None:
    """Its own file is the same; going back compiles nothing."""
    (copy / "caller.py").write_text(CALLER)
    said = []
    for part, more, beside in [(10, 1, 1), (10, 2, 1), (20, 2, 1), (20, 2, 2), (10, 1, 1)]:
        words = f"Words count for nothing: {beside}."
        (copy / "called.py").write_text(CALLED.format(part=part, more=more, beside=beside, words=words))
        said.append(call(copy, ASK)[0])
    assert said == ["11 2", "12 2", "22 1", "22 0", "11 0"]


TUPLES = """
from typing import NamedTuple
from bsm_mesh.compiled import njit

class Given(NamedTuple):
    {one}: float
    {other}: float

@njit()
def kernel(given):
    return given.a - given.b
"""


def test_the_fields_of_named_tuples_count(copy: Path) -> None:
    """Numba's own text of their types leaves them out."""
    said = []
    for one, other in ("ab", "ba"):
        (copy / "tuples.py").write_text(TUPLES.format(one=one, other=other))
        said.append(call(copy, "from tuples import Given, kernel; print(kernel(Given(a=3.0, b=1.0)))")[0])
    assert said == ["2.0", "2.0"]


def test_what_is_compiled_into_a_kernel() -> None:
    found = compiled_into(advance)
    assert add_bolt_forces in found
    assert solve_chain in found  # one through the other, from other files
    assert facing_rows not in found


def test_no_kernel_gets_an_array_whose_references_it_does_not_count() -> None:
    """Nobody would free it. The compiler refuses the other faults: to make an array there, to return a new one."""
    kernels = {part for line in listed() for part in compiled_into(kernel_of(line)[0])}
    uncounted = [kernel for kernel in kernels if not kernel.targetoptions["_nrt"]]
    assert len(uncounted) > len(kernels) / 2
    lost = [
        f"{kernel.py_func.__name__} calls {called.py_func.__name__}"
        for kernel in uncounted
        for called in called_by(kernel)
        if called.targetoptions["_nrt"] and "Array" in called.py_func.__annotations__["return"]
    ]
    assert not lost


def test_first_runs_at_once_end_alike(copy: Path) -> None:
    """From an empty folder; a kernel that calls another."""
    command = [sys.executable, "-B", "-c", CALL]
    begin = partial(subprocess.Popen, env=settings(copy), cwd=copy, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    runs = [begin(command) for _ in range(AT_ONCE)]
    said = [run.communicate() for run in runs]
    assert [run.returncode for run in runs] == [0] * AT_ONCE, said
    assert {err for _, err in said} == {b""}
    assert {out.split()[0] for out, _ in said} == {b"3"}
    kept = {path.name.partition("-")[0] for path in (copy / "bsm_mesh/_kernels").rglob("*") if path.is_file()}
    assert kept == {"kernels.first", "kernels.second"}  # and no draft
    assert call(copy)[0].startswith("3 0 ")


def test_the_word_compiling_comes_with_the_first_kernel(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kernel_files, "_compiled", 0)  # whatever ran before in this process
    with Progress() as progress:
        progress.report("contacts")
        kernel_files.compiling()
    kernel_files.compiling()  # nobody is reported any more
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2
    assert "contacts; compiling" in said[1]


def test_the_list_names_kernels_and_types() -> None:
    found = [kernel_of(line) for line in listed()]
    assert len(set(found)) == len(found) > 40
    assert all(isinstance(kernel, Dispatcher) for kernel, _ in found)
    assert all(isinstance(one, types.Type) for _, arguments in found for one in arguments)


RUNS = """
from bsm_mesh.solve.algebra import pardiso
pardiso.is_available = lambda: False
import bsm_mesh.kernel_files as files
from bsm_mesh.commands.cli import main
for words in (["new", "slope", "s"], ["run", "s/model.toml", "-q"]):
    try:
        main(words)
    except SystemExit:
        pass
exec(open("readme.py").read())
print(files._compiled)
"""


def test_first_runs_after_set_up_compile_nothing(tmp_path: Path) -> None:
    """The starter and the README's model; `python -m tools.kernels` writes the list anew.

    Kernels that are compiled here already are copied, but for the last of the list.
    """
    (tmp_path / "kernels" / VERSIONS).mkdir(parents=True)
    for name in [name_of(*kernel_of(line)) for line in listed()][:-1]:
        if content := kernel_files.read(name):
            (tmp_path / "kernels" / name).write_bytes(content)
    told = {**environment(), "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    fill = [sys.executable, "-m", "bsm_mesh.commands.precompile"]
    done = subprocess.run(fill, env=told, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "compiling kernels" in done.stderr
    kept = sorted(path.name for path in tmp_path.rglob("*.nbc"))
    assert len(kept) == len(listed())
    (tmp_path / "readme.py").write_text(python_blocks()[0], encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", RUNS], env=told, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-1] == "0", done.stderr
    assert "compiling" not in done.stderr
    (tmp_path / "kernels" / VERSIONS / "other.nbc").touch()
    done = subprocess.run([*fill, "--only"], env=told, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert sorted(path.name for path in tmp_path.rglob("*.nbc")) == kept
