"""The mutation command: what it changes, what it leaves alone, which kernels and tests a change concerns."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from bsm_mesh.solve.bolts.chain import solve_chain
from bsm_mesh.solve.bolts.kernels import add_bolt_forces, own_coupling
from bsm_mesh.solve.motion.kernels import advance
from tests.mutation import mutants, rooms
from tests.mutation.chosen import BESIDE, COMPILING, SLOWER, Watched, function_at
from tests.mutation.equivalent import EQUIVALENT
from tests.mutation.mutants import Mutant
from tests.mutation.place import SURVIVED, Ran
from tests.mutation.report import interval, markdown
from tests.mutation.watch import _functions

pytestmark = pytest.mark.robust

SOURCE = '''
"""A module."""
MOST = 12


class SomeSettings:
    """Settings."""

    share: float = 0.5


@njit(nogil=True)
def area(a: float | None, b: int) -> float:
    """Return it."""
    return a * b if a > 0 else b + 1
'''


@pytest.mark.parametrize(
    ("old", "new", "matters"),
    [
        ("a * b", "a / b", True),
        ("a > 0", "a >= 0", True),
        ("float | None", "float & None", False),
        ("nogil=True", "nogil=False", False),
        ("MOST = 12", "MOST = 13", False),
        ("share: float = 0.5", "share: float = 1.5", False),
        ("b + 1", "b + +", False),
    ],
)
def test_what_a_mutant_must_change(old, new, matters):
    assert mutants.matters(SOURCE, SOURCE.replace(old, new)) is matters


def test_a_mutant_is_shown_by_its_lines():
    assert mutants.diff(SOURCE, SOURCE.replace("b + 1", "b - 1")) == [
        "- return a * b if a > 0 else b + 1",
        "+ return a * b if a > 0 else b - 1",
    ]


def test_operators_make_mutants_of_every_place():
    pytest.importorskip("cosmic_ray")
    found = list(mutants.mutants_of("a.py", SOURCE))
    texts = {mutants.mutated(SOURCE, mutant) for mutant in found}
    assert SOURCE.replace("a * b", "a / b") in texts
    assert SOURCE.replace("a > 0", "a <= 0") in texts
    assert SOURCE not in texts


def test_function_around_a_line():
    decorator = SOURCE.splitlines().index("@njit(nogil=True)") + 1
    inside = function_at(SOURCE, decorator + 3)
    assert (inside.begin, inside.is_kernel) == (decorator, True)
    assert function_at(SOURCE, decorator - 3) is None  # of a class


class Seen:
    """A place in which tests have been seen to take some seconds, and to call some functions."""

    root = mutants.ROOT

    def __init__(self, **tests):
        self.tests = tests

    def watch(self, files, limit):
        return Ran(SURVIVED, 1.0), {f"{file}::{name}": row for file in files for name, row in self.tests.items()}


def test_tests_that_call_the_function_come_fastest_first(tmp_path):
    file, test = "bsm_mesh/contact/broad_phase.py", "tests/unit/test_broad_phase.py"
    lines = mutants.read(file).splitlines()
    line = next(n for n, text in enumerate(lines, 1) if text.startswith("@njit()"))
    called, other = f"{file}:{line}", f"{file}:{line - 1}"
    place = Seen(slow=(2.0, [called]), fast=(1.0, [called]), idle=(0.0, [other]))
    limits = Watched(tmp_path, place).limits(Mutant(file, "any", 0, line + 1, 0), [test])
    assert limits == {f"{test}::{name}": SLOWER * s + BESIDE + COMPILING for name, s in (("fast", 1.0), ("slow", 2.0))}
    kept = Watched(tmp_path, SimpleNamespace(root=mutants.ROOT))  # which is not asked again
    assert len(kept.limits(Mutant(file, "any", 0, 1, 0), [test])) == 3  # done while the module is imported


def run_pytest(folder, text, *arguments):
    (folder / "test_some.py").write_text(text)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(mutants.ROOT), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


TIMED = """
def test_first(): assert False
def test_second(): pass
def test_endless():
    while True: pass
"""


@pytest.mark.parametrize(
    ("order", "code", "said"),
    [
        (["second", "first"], 1, "1 failed, 1 passed"),
        (["second"], 0, "1 passed"),
        (["endless", "first"], -signal.SIGXCPU, ""),
    ],
)
def test_tests_run_in_order_and_within_limits(tmp_path, order, code, said):
    (tmp_path / "order.json").write_text(json.dumps({f"test_some.py::test_{name}": 1.0 for name in order}))
    done = run_pytest(tmp_path, TIMED, "-p", "tests.mutation.ordered", "--ordered", "order.json")
    assert done.returncode == code
    assert said in done.stdout


WATCHED = """
import numpy as np
from bsm_mesh.solve.bolts.kernels import own_coupling
def test_calls(): own_coupling(np.zeros(1, np.int32), np.zeros(0))
def test_calls_not(): pass
"""


def line_of(kernel):
    code = kernel.py_func.__code__
    return f"{Path(code.co_filename).relative_to(mutants.ROOT)}:{code.co_firstlineno}"


def test_called_kernels_are_seen(tmp_path):
    done = run_pytest(tmp_path, WATCHED, "-p", "tests.mutation.watch", "--watched", "seen.json")
    assert done.returncode == 0, done.stdout
    seen = json.loads((tmp_path / "seen.json").read_text(encoding="utf-8"))
    assert line_of(own_coupling) in seen["test_some.py::test_calls"][1]
    assert line_of(own_coupling) not in seen["test_some.py::test_calls_not"][1]


def test_a_kernel_that_is_called_calls_what_is_compiled_into_it():
    code = advance.py_func.__code__
    found = _functions({id(code): code}, {id(code): advance})
    assert {line_of(kernel) for kernel in (advance, add_bolt_forces, solve_chain)} <= found


def test_interval_of_a_share():
    """Newcombe (1998, Statistics in Medicine 17, 857), table I, method 3."""
    assert interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert interval(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert interval(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)


ROW = {"room": "contact", "file": "bsm_mesh/contact/a.py", "line": 3, "seconds": 2.0, "tests": 1, "failed": ""}


def test_report_counts_and_explains(monkeypatch):
    same = ROW | {"outcome": "survived", "first": "survived", "diff": ["- a + 0", "+ a - 0"]}
    killed = ROW | {"outcome": "killed", "first": "killed", "diff": []}
    rows = [same, same | {"diff": ["- a + b", "+ a - b"]}, killed | {"first": "survived"}, *7 * [killed]]
    monkeypatch.setitem(EQUIVALENT, ("bsm_mesh/contact/a.py", "a + 0", "a - 0"), "nothing is added")
    text = markdown(rows, 20, 7)
    assert "10 of 20 mutants tried: at the first try tests noticed 7 of 10, 70%" in text
    assert "for its survivors they notice 8 of 10, 80%" in text  # which says nothing of other mutants
    assert "without these 8 of 9, 89%" in text
    assert "| contact | 10 | 8 | 0 | 2 | 1 | 80% |" in text
    assert "| `bsm_mesh/contact/a.py:3` | `a + 0` | `a - 0` | nothing is added |" in text
    assert "| `bsm_mesh/contact/a.py:3` | `a + b` | `a - b` | open |" in text


@pytest.mark.parametrize(("file", "old", "new"), EQUIVALENT)
def test_equivalent_mutants_are_of_the_program_as_it_is(file, old, new):
    assert old in [line.strip() for line in mutants.read(file).splitlines()]
    assert new != old


@pytest.mark.parametrize("file", mutants.files())
def test_every_file_has_tests(file):
    found = [name for group in rooms.tests_of(file) for name in group]
    assert found
    assert len(set(found)) == len(found)
    assert all((mutants.ROOT / name).exists() for name in found)


def test_every_test_that_a_room_names_is_there():
    names = {
        f"tests/{'' if '/' in n else 'unit/'}{n.replace('/', '/test_') if '/' in n else f'test_{n}'}.py"
        for room in rooms.ROOMS.values()
        for n in room.replace("|", "").split()
    }
    assert [name for name in sorted(names) if not (mutants.ROOT / name).exists()] == []
