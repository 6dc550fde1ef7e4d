"""The mutation command: what it changes, what it leaves alone, which kernels and tests a change concerns."""

import pytest

from tests.mutation import mutants, rooms
from tests.mutation.place import importers

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


def test_kernels_that_hold_others_are_compiled_anew():
    found = importers("bsm_mesh/solve/bolts/kernels.py")
    assert "bsm_mesh/solve/motion/bolt_kernels.py" in found
    assert "bsm_mesh/solve/motion/kernels.py" in found  # which calls those
    assert "bsm_mesh/contact/search.py" not in found


@pytest.mark.parametrize("file", mutants.files())
def test_every_file_has_tests(file):
    found = rooms.tests_of(file)
    assert found
    assert all((mutants.ROOT / name).exists() for name in found)


def test_every_test_that_a_room_names_is_there():
    names = {
        f"tests/{'' if '/' in n else 'unit/'}{n.replace('/', '/test_') if '/' in n else f'test_{n}'}.py"
        for room in rooms.ROOMS.values()
        for n in room.split()
    }
    assert [name for name in sorted(names) if not (mutants.ROOT / name).exists()] == []
