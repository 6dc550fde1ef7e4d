"""A value of a wrong kind, anywhere in a model: one fault that says what, where and the cure."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import as_given
from bsm_mesh.model.values import is_number, parts_of
from tests.scenes.good_calls import good_calls

WRONG = [5, -1.5, True, "x", "", [], [None], {}, {1: 2}, object(), np.array(3.0), np.array(["a", "b"]), np.ones((2, 3))]
STRANGE = [*WRONG, np.array([]), np.nan, 10**5000, 10**400, b"x", [1, range(3)], np.array([None, 1]), float]
FILES = ("bsm.load", "bsm.Results.load")


@pytest.mark.parametrize("number", range(len(good_calls())))
def test_a_wrong_kind_is_refused_in_words(number: int) -> None:
    """Every argument of every public call in turn, alone and in a model: taken, or one `ModelError`."""
    from bsm_mesh.geometries.errors import GeometryError

    name, function, good, part = good_calls()[number]
    if name in FILES:
        pytest.skip("its argument is a path")
    for key in good:
        for value in STRANGE:
            try:
                made = function(**{**good, key: value})
                if part in ("rocks", "joints", "supports", "loads", "bolts", "stages", "water", "in_situ"):
                    several = part not in ("water", "in_situ")
                    _model().replace(**{part: [made] if several and not isinstance(made, list) else made})
            except (bsm.ModelError, GeometryError) as error:
                for fault in error.faults:
                    assert "\n" not in fault
                    assert len(fault) < 700


@cache
def _model() -> bsm.Model:
    return next(
        function(**good) for name, function, good, part in good_calls() if part == "model" and not good["bolts"]
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bsm.Rock(np.array([1, 2]), unit_weight=0), "rock: the name must be a non-empty text"),
        (
            lambda: bsm.Rock("r", unit_weight=0, stiffness="wong"),
            "rock 'r': stiffness = 'wong' is unknown; did you mean 'wang'?",
        ),
        (
            lambda: bsm.Options(scheme=np.array(["a"])),
            "solver: scheme = array(['a'], dtype='<U1') is unknown (known: co",
        ),
        (
            lambda: bsm.MohrCoulomb(friction="35 deg"),  # type: ignore[arg-type]
            "friction = '35 deg' is not a finite number [degrees]; only a model file takes texts with units",
        ),
        (lambda: _model().replace(rocks=5), "model: rocks = 5 must be a list of bsm.Rock(...)"),
        (
            lambda: _model().replace(rocks=bsm.Rock("gneiss", unit_weight=0)),
            "must be a list of bsm.Rock(...); put it in brackets",
        ),
        (
            lambda: _model().replace(supports=["x"]),
            "model: supports: number 1 is 'x'; it must be bsm.Fixed(...) or bsm.Roller(...)",
        ),
        (lambda: _model().replace(blocks=None), "model: blocks = None must be bsm.Blocks(...)"),
        (lambda: _model().replace(water=[]), "model: water = [] must be bsm.Water(...), or None"),
        (lambda: _model().replace(options="wang"), "model: options = 'wang' must be bsm.Options(...), or None"),
        (lambda: bsm.Water(joint_pressure=None), "water: joint_pressure = None must be a mapping by names"),
        (lambda: bsm.Pressure(boundary={}, pressure=1.0), "load: boundary = {} must be a text, in quotes"),
        (lambda: bsm.Blocks.from_polygons(5, rock="r"), "polygons = 5 must be a list of outlines"),
        (
            lambda: bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1)]], rock=True),
            "Blocks.from_polygons: rock = True must be a list of texts",
        ),
        (lambda: bsm.Fixed(blocks=[1, range(3)]), "blocks must be block numbers"),
        (lambda: bsm.Fixed(blocks=[2**40]), "support Fixed: blocks = 1099511627776 must be a whole number"),
        (lambda: bsm.Rock("r", unit_weight=10**5000), "unit_weight = a number of thousands of digits is not a finite"),
        (lambda: bsm.bolt_patterns.bolts_on_curves("x"), "bolts on curves: pieces: not an array of float64 numbers"),
        (lambda: bsm.library.joint(0), "library: the name of a joint = 0 must be a text"),
        (lambda: bsm.limit_analysis("m"), "limit analysis: model = 'm' must be bsm.Model(...)"),
        (
            lambda: bsm.limit_analysis(_model(), [5]),
            "limit analysis: live: number 1 is 5; it must be bsm.PointLoad(...)",
        ),
        (lambda: bsm.Stage(name="s", excavate=[10**40]), "stage 's': excavate = 1000"),
        (lambda: bsm.load(True), "load: path is of the kind bool; it must be a path"),
        (
            lambda: bsm.Blocks(**{**next(g for n, _, g, _ in good_calls() if n == "bsm.Blocks"), "rock": [2**40] * 4}),
            "Blocks.rock: not an array of int32 numbers",
        ),
    ],
)
def test_the_fault_says_what_where_and_the_cure(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(bsm.ModelError) as caught:
        call()
    assert message in str(caught.value)


def test_all_wrong_kinds_are_told_at_once() -> None:
    with pytest.raises(bsm.ModelError) as caught:
        _model().replace(rocks=5, water=[], default_joint=3)
    assert len(caught.value.faults) == 3


def test_what_is_a_number_and_what_has_parts() -> None:
    assert [is_number(value) for value in (1, 2.5, np.float32(1), True, np.nan, 10**400, "1", None)] == [True] * 3 + [
        False
    ] * 5
    assert parts_of(np.array([1, 2])) == [1, 2]
    assert [parts_of(value) for value in ("ab", b"ab", 3, np.array(3.0))] == [None] * 4
    assert as_given("x" * 100) == "'" + "x" * 56 + "..."
