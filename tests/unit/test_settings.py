"""The numeric settings of the solver: how many there are, and that each says what it is."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.settings import FORMATS, SOLVER, settings_of, solver_settings

# No more than there are: what brings a number takes one away, or measures what it is worth. Limit analysis is not of
# the engine: of its numbers nothing depends but how far a linear program is solved. Nor are zones, which have finite
# elements of their own: their numbers were counted nowhere while they belonged to the comparison. The last to come,
# `HOLDS` of Wang's iteration, is worth a verdict: with 2 a block that falls between two others is followed for ever
# where its joints keep 1e-4 of their shear stiffness. The implicit integrator of shaken stages is a second opinion on
# a few blocks: no verdict of statics depends on its numbers. Two of the zones' belong to plastic collapse as a
# verdict; docs/zones_yield.md has the table behind them. Five are of zones in large displacement: two say how far a
# correction goes, one is the neutral stiffness of rigid blocks, and two say how faces slide
# (docs/experiments/sliding_zones.md). Three are of zones that are shaken: what single precision leaves, and two that
# end the motion after the record. Two are of blocks with zones that meet: how near they get points, and how stiff their
# rock is in motion (docs/experiments/sliding_zones.md).
MAX_SETTINGS, MAX_OF_LIMIT, MAX_OF_ZONES, MAX_OF_INTEGRATOR = 58, 20, 49, 3
INTEGRATOR = "continuation/implicit_motion.py"
MIN_WORDS = 4  # that say less name it once more


def test_there_are_no_more_settings_than_there_were():
    rooms = Counter(s.place if s.place == INTEGRATOR else s.place.split("/")[0] for s in solver_settings())
    of_limit, of_zones, of_integrator = (rooms.pop(room) for room in ("limit", "zones", INTEGRATOR))
    assert rooms.total() <= MAX_SETTINGS
    assert of_limit <= MAX_OF_LIMIT
    assert of_zones <= MAX_OF_ZONES
    assert of_integrator <= MAX_OF_INTEGRATOR


def test_every_setting_says_what_it_is():
    silent = [f"{s.place}: {s.name}" for s in solver_settings() if len(s.explained.split()) < MIN_WORDS]
    assert silent == []


def test_what_is_no_setting_is_there():
    for place, names in FORMATS.items():
        text = (SOLVER / place).read_text(encoding="utf-8")
        assert [name for name in names if name not in text] == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("A = 3  # of its size", [("A", "3", "of its size")]),
        ("# Of a size\n# and more.\nA = -3.0", [("A", "-3.0", "Of a size and more.")]),
        ("A, B = 1e-3, 2", [("A", "0.001", ""), ("B", "2", "")]),
        ("A = (B, 1, 2)", [("A", "1", ""), ("A", "2", "")]),
        ("A = 'word'\nB = True\nb = 3\nC = f(3)", []),
        ("A = 1 - 1e-9", [("A", "1 - 1e-09", "")]),
        ("A = SomeSettings(b=2, c=True)", [("A", "b=2", "")]),
        (
            'class SomeSettings:\n    """It.\n\n    Attributes\n    ----------\n    a, b : int\n        Both\n'
            '        of them.\n    """\n\n    a: int = 1\n    b: tuple = (2, 3, C)\n    c: int\n',
            [(f"SomeSettings.{name}", value, "int Both of them.") for name, value in ("a1", "b2", "b3")],
        ),
        ("class Other:\n    a: int = 1", []),
    ],
)
def test_the_walk_finds_settings(text, found):
    assert [(s.name, s.value, s.explained) for s in settings_of(text, "place.py")] == found
