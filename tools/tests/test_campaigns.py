"""The campaigns' own machinery, and a short seeded slice of each (docs/campaigns.md)."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenes.good_calls import good_calls
from tools.campaigns import counts, disk, fuzz, kill
from tools.campaigns.inputs import FAULTS, AcceptedError, Input, Outcome
from tools.campaigns.place import place
from tools.campaigns.scenes import Scene
from tools.campaigns.state import State
from tools.campaigns.targets import TARGETS, calls
from tools.campaigns.unstable import examples
from tools.campaigns.verdict import BROKEN, FALSE, PARTS, demand_unstable, drawn, judge_change
from tools.campaigns.watch import watch

pytestmark = pytest.mark.robust

SEED = 29
SLICE = {"calls": 400, "traces": 200, "meshes": 5, "models": 10, "bolts": 3, "results": 8, "commands": 3}


def _told(state: State) -> str:
    return "\n".join(state.lines())


@pytest.mark.slow
def test_a_slice_of_faulty_inputs(tmp_path: Path) -> None:
    done = fuzz.fuzz(tmp_path, inputs=1, seed=SEED, processes=1, targets=list(SLICE), sizes=SLICE)
    assert {name: sum(part["counts"].values()) for name, part in done.told["parts"].items()} == SLICE
    assert done.told["findings"] == {}, _told(done)
    again = fuzz.fuzz(tmp_path, inputs=1, seed=SEED, processes=1, targets=list(SLICE), sizes=SLICE)
    assert again.told == done.told  # what is done is not done again


@pytest.mark.slow
def test_unstable_models_are_so_by_the_program_and_by_statics() -> None:
    with place() as there:
        assert demand_unstable(there) == []


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
def test_a_slice_of_changes_of_unstable_models(part: str) -> None:
    with place() as there:
        found = [judge_change(there, drawn(part, SEED, index)) for index in range(6)]
    assert [detail for kind, _, detail in found if kind in (FALSE, BROKEN)] == []


@pytest.mark.parametrize("part", [0.5, pytest.param(1.0, marks=pytest.mark.slow)])
def test_a_slice_of_kills(tmp_path: Path, part: float) -> None:
    """Amid the run's operations on files, and before the third last, where its stages are finished."""
    scene = Scene("staged", tmp_path / "scene")
    scene.put()
    whole = kill.strike(scene, kill.Strike("none"))
    assert (whole.code, whole.finished) == (0, 2), whole.err
    scene.put()
    operation = int(part * whole.operations) if part < 1 else whole.operations - 3
    done = kill.strike(scene, kill.Strike("SIGKILL", operation=operation))
    assert done.code == -9
    assert scene.resumed(done.steps) == ("resumed" if part < 1 else "was finished", [])
    assert list(scene.faults(done.finished)) == []


def test_a_slice_of_full_disks(tmp_path: Path) -> None:
    scene = Scene("bolted", tmp_path / "scene")
    last = disk.count_operations(scene)
    for full in (disk.at_operation(last // 2, stays=True), disk.at_operation(last, stays=False), disk.at_size(500)):
        code, faults = disk.one(scene, full)
        assert code in (0, 2)
        assert list(faults) == []


def test_good_calls_are_taken() -> None:
    for name, function, arguments, part in good_calls():
        if name not in ("bsm.InSituTraction", "bsm.load", "bsm.Results.load"):  # these need more than the call
            calls.call(function, arguments, part, runs=False)


def test_an_input_is_the_same_for_its_number(tmp_path: Path) -> None:
    for name in ("traces", "models", "bolts", "calls"):
        one, other = (fuzz.draw(tmp_path, name, SEED, 7) for _ in range(2))
        assert (one.told, one.files) == (other.told, other.files)
        assert one.told + str(one.files) != fuzz.draw(tmp_path, name, SEED, 8).told


def test_a_worker_that_dies_or_hangs_is_noticed(tmp_path: Path) -> None:
    found = []
    chunks = [{"target": "x", "seed": 0, "first": first, "count": 10} for first in (0, 10)]
    watch(
        chunks,
        tmp_path,
        lambda asked, answer: found.append(answer),
        hangs=0.4,
        blocks=5,
        module="tools.campaigns.faulty_worker",
    )
    assert sorted(answer["counts"].get("ok") for answer in found) == [8, 10]
    assert sorted(fault[:3] for answer in found for fault in answer["findings"]) == [
        [3, "crash", "signal 11"],
        [5, "hang", "hang"],
    ]


def _raise(error: BaseException) -> None:
    raise error


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (Input("", lambda: None), Outcome("ok")),
        (
            Input("", lambda: Path("left.tmp").touch()),
            Outcome("left behind", "in the folder: left.tmp", "['left.tmp']"),
        ),
        (Input("", lambda: _raise(AcceptedError("nan taken"))), Outcome("accepted", "nan taken", "nan taken")),
    ],
)
def test_what_comes_of_an_input_is_classed(given: Input, expected: Outcome) -> None:
    with place() as there:
        assert there.do(given) == expected
        assert there.do(Input("", lambda: None)) == Outcome("ok")  # nothing of it is left for the next one


def test_other_exceptions_are_findings() -> None:
    with place() as there:
        outcome = there.do(Input("", lambda: _raise(KeyError("x"))))
    assert outcome.kind == "traceback"
    assert outcome.kind in FAULTS
    assert outcome.signature.startswith("KeyError")


def test_statics_knows_larger_friction_and_flatter_planes() -> None:
    slides = next(example for example in examples() if example.name == "incline/slides.toml")
    for key, value, stands in (
        ("friction", 45.0, True),
        ("friction", "39 deg", False),
        ("cohesion", "1 MPa", True),
        ("cohesion", "50 kPa", None),
    ):
        tree = slides.tree
        tree["joint"]["joint"][key] = value
        assert slides.stands(tree) is stands
    tree = slides.tree
    tree["mesh"]["parameters"]["dip"] = 19.0
    assert slides.stands(tree) is True


def test_the_tables_of_the_page_are_those_of_the_counts() -> None:
    text = counts.PAGE.read_text(encoding="utf-8")
    assert counts.page(text, counts.stored()) == text


def test_every_target_has_its_share() -> None:
    assert sum(target.share for target in TARGETS.values()) == pytest.approx(1)
