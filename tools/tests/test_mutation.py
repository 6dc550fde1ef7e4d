"""tools.mutation: every room of the engine has its tests, and the operators left out are those meant."""

import re

import pytest

from tools import mutation


def test_rooms_are_those_of_the_engine():
    engine = mutation.ROOT / "bsm_mesh"
    folders = [path for path in (engine / "solve").iterdir() if (path / "__init__.py").exists()]
    assert set(mutation.ROOMS) == {"contact", *(f"solve/{path.name}" for path in folders)}


@pytest.mark.parametrize("room", mutation.ROOMS)
def test_tests_of_a_room_exist(room):
    assert [name for name in mutation.test_files(room) if not (mutation.ROOT / name).exists()] == []


@pytest.mark.parametrize(
    ("operator", "excluded"),
    [
        ("ReplaceBinaryOperator_Add_Sub", False),
        ("ReplaceBinaryOperator_BitAnd_BitOr", False),
        ("ReplaceComparisonOperator_Lt_LtE", False),
        ("ReplaceUnaryOperator_Delete_USub", False),
        ("NumberReplacer", False),
        ("ReplaceBinaryOperator_BitOr_BitAnd", True),  # X | None in an annotation
        ("ReplaceBinaryOperator_Mul_LShift", True),
        ("ReplaceComparisonOperator_Eq_IsNot", True),
        ("ReplaceUnaryOperator_USub_UAdd", True),
        ("RemoveDecorator", True),
    ],
)
def test_operators_whose_mutants_say_nothing_are_excluded(operator, excluded):
    found = any(re.match(pattern, f"core/{operator}") for pattern in mutation.EXCLUDED)
    assert found is excluded
