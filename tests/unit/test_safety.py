"""Factors of safety: what counts as failure, which trials are run, what is refused, what is handed out."""

import re
from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.results.evidence import Proof
from bsm_mesh.results.records import Status
from bsm_mesh.safety.answer import Settings
from bsm_mesh.safety.bound import Limit
from bsm_mesh.safety.bracket import Bracket, Range, Verdict
from bsm_mesh.safety.criterion import Ended, Failure
from bsm_mesh.safety.driver import Search
from bsm_mesh.safety.factor import beside, factor_of_safety
from bsm_mesh.safety.pool import pool_of
from bsm_mesh.solve.limit import strength_factor
from bsm_mesh.solve.stages.as_built import counted_blocks
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.study_works import Dying

DIP, FRICTION = 30.0, 40.0
EXACT = np.tan(np.radians(FRICTION)) / np.tan(np.radians(DIP))


def incline(**given):
    polygons = [turned(p, DIP) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5))]
    return model_of(polygons, friction=FRICTION, kn=1e10, **given)


class Made:
    """Trials of two blocks whose second moves as told, has no verdict, or falls."""

    def __init__(self, moved, undecided=(), falls=()):
        self.moved, self.undecided, self.falls, self.values = moved, undecided, falls, []
        self.results = bsm.run(incline())

    def run(self, value, limit):
        self.values.append(value)
        status = Status.NOT_CONVERGED if any(a < value < b for a, b in self.undecided) else Status.STABLE
        if any(a < value < b for a, b in self.falls):
            status = Status.UNSTABLE
        moved = np.array([[0.0, 0.0, 0.0], [self.moved(value), 0.0, 0.0]])
        nobody = np.zeros(0, dtype=np.int32)
        return Ended(
            value=value, status=status, reason="", displacement=moved, down=nobody, seconds=0.0, results=self.results
        )


def searched(made, bound=None, first=1.0, most=40):
    within = Range(good=0.05, bad=20.0, first=first, bound=bound, tolerance=0.005, is_factor=True)
    return Search(
        made, within, Failure(movement=0.05), made.results.blocks, np.array([False, True]), lambda text: None
    ).run(most)


def test_a_block_that_moves_far_and_rests_has_failed():
    """The block has the size 1: it moves by .05 at the factor 1.5."""
    found = searched(Made(lambda value: 0.1 * max(0.0, value - 1)))
    assert found.bracket.stable < 1.5 <= found.bracket.unstable
    assert found.is_closed
    assert found.reference == 1.0
    bad = next(trial for trial in found.trials if trial.value == found.bracket.unstable)
    assert bad.blocks.tolist() == [1]
    assert "5.02 % of its size" in bad.reason
    assert "more than 5 % counts as failure" in bad.reason


def test_a_bound_is_printed_in_one_line():
    assert repr(Limit(factor=2.0, text="upper bound 2", mechanism=np.ones((40, 3)))) == "Limit: upper bound 2"


def test_undecided_trials_keep_the_bracket_open():
    found = searched(Made(lambda value: 0.1 * max(0.0, value - 1), undecided=[(1.45, 1.52)]))
    assert not found.is_closed
    assert found.bracket.undecided
    assert all(1.45 < value < 1.52 for value in found.bracket.undecided)
    assert all(trial.verdict is Verdict.UNDECIDED for trial in found.trials if 1.45 < trial.value < 1.52)


def test_a_budget_ends_the_search():
    made = Made(lambda value: 0.1 * max(0.0, value - 1))
    assert not searched(made, most=4).is_closed
    assert len(made.values) == 4


def test_movement_counts_from_a_stronger_state_where_blocks_have_given_way():
    """At 1 the block moved by .35 and rests; below .65 it does not move: the limit is where it moves by .05."""
    found = searched(Made(lambda value: max(0.0, value - 0.65)))
    assert found.reference < 0.7
    assert found.reference_moved < 0.05
    assert found.bracket.stable < 0.7 <= found.bracket.unstable
    assert found.is_closed


def test_movement_counts_from_a_stronger_state_beyond_those_that_fall():
    """Blocks reach rest lower down at 1, fall at .6 to .9, and stay where they are at more strength."""
    found = searched(Made(lambda value: 0.0 if value < 0.6 else 2.0, falls=[(0.6, 0.9)]))
    assert found.bracket.stable < 0.6 <= found.bracket.unstable
    assert found.is_closed
    assert found.reference < 0.6


def test_soft_joints_are_no_failure():
    """The block moves by half its size at any strength."""
    found = searched(Made(lambda value: 0.5 + 0.1 * max(0.0, value - 1)))
    assert found.reference == pytest.approx(0.8)
    assert found.reference_moved == pytest.approx(0.5)
    assert found.bracket.stable < 1.5 <= found.bracket.unstable


def test_what_is_proved_is_not_stable():
    """Blocks that must move where they were given, and reach rest a little further, have failed."""
    made = Made(lambda value: 0.0)
    found = searched(made, bound=1.3)
    assert found.bracket.unstable == 1.3
    assert found.bracket.stable == pytest.approx(1.3, rel=0.005)
    assert "limit analysis proves that no equilibrium exists in the initial geometry" in found.trials[-1].reason
    assert "moved by less than 0.1 % of their size" in found.trials[-1].reason


@pytest.mark.heavy
def test_factor_of_an_incline_with_all_that_is_told():
    heard = []
    found = factor_of_safety(incline(), report=heard.append)
    assert found.stable < EXACT <= found.unstable * (1 + 1e-4)
    assert found.factor == found.stable
    assert found.is_closed
    assert found.undecided == ()
    assert found.states.keys() == {found.stable, found.unstable}
    assert found.states[found.stable].status == "stable"
    assert found.states[found.unstable].status == "unstable"
    assert found.limit.factor == pytest.approx(EXACT, rel=1e-4)
    fails = found.mechanism
    assert fails.blocks.tolist() == [1]
    assert fails.area == pytest.approx(1.0)
    (joint,) = fails.joints
    assert (joint.name, joint.length) == ("J", pytest.approx(2.0))
    assert 0 < joint.slipping <= 1
    assert (found.stage, found.reference, found.changed) == ("initial", 1.0, "all joints, rock faces")
    assert str(found) == f"factor of safety {found.stable:.4g}: stable there, unstable at {found.unstable:.4g}"
    assert heard[0] == "limit analysis"
    assert any(text.startswith("trial at 1: stable") for text in heard)
    assert repr(fails).startswith(f"Mechanism at {found.unstable:.4g}: block")


@pytest.mark.slow
def test_several_processes_find_the_same_limit():
    found = factor_of_safety(incline(), processes=2)
    assert found.stable < EXACT <= found.unstable * (1 + 1e-4)


@pytest.mark.robust
def test_a_trial_whose_process_dies_is_run_again(tmp_path):
    with pool_of(Dying(tmp_path, always=False), 2) as run_all:
        assert run_all([(1.0, None), (2.0, None), (0.5, None)]) == [1.0, 2.0, 0.5]
        with pytest.raises(bsm.ModelError, match="of the model"):
            run_all([(3.0, None)])
    with (
        pool_of(Dying(tmp_path, always=True), 2) as run_all,
        pytest.raises(bsm.ModelError, match=r"given up: its process died 3 times \(signal 9\)"),
    ):
        run_all([(2.0, None)])


@pytest.mark.heavy
def test_a_model_that_fails_as_it_is():
    weak = incline()
    found = factor_of_safety(weak.replace(joints=[replace(weak.joints[0], law=bsm.MohrCoulomb(friction=20.0))]))
    assert found.stable < np.tan(np.radians(20.0)) / np.tan(np.radians(DIP)) <= found.unstable * (1 + 1e-4)


@pytest.mark.heavy
def test_the_movement_at_which_a_trial_ends_has_its_parts():
    """The mean block size is that of the block on the incline, 1 m; the reference state is that at 1."""
    found = factor_of_safety(incline())
    (reason,) = {trial.reason for trial in found.trials if trial.value == found.unstable}
    told = re.fullmatch(
        r"a block moved more than (\S+) m: (.*) \((\S+) m\) beyond the displacement at 1 \((\S+) m\)", reason
    )
    assert told is not None, reason
    limit, more, moved = (float(told[k]) for k in (1, 3, 4))
    assert (more, told[2]) == (0.05, "5 % of the mean block size")
    assert limit == pytest.approx(moved + more, rel=0.01)


def test_nothing_that_fails_is_no_limit():
    """A block on level ground."""
    found = factor_of_safety(model_of([rectangle(-5, -1, 5, 0), rectangle(-1, 0, 1, 1)]))
    assert (found.stable, found.unstable) == (pytest.approx(20.0), None)
    assert str(found) == "factor of safety: beyond 20; no trial failed"
    assert found.mechanism is None


@pytest.mark.slow
def test_other_starts_and_stiffer_joints():
    found = factor_of_safety(incline(), spread=True)
    names = [text for text, _ in found.spread]
    assert names == ["strength reduced after stage 'initial' is at rest", "joints 10 times as stiff"]
    assert all(each.stable == pytest.approx(EXACT, rel=0.006) for _, each in found.spread)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"joints": ["K"]}, "there is no joint 'K'"),
        ({"stage": "dig"}, "there is no stage 'dig'"),
        ({"tolerance": 0.0}, "tolerance = 0 must be 1e-4 to 0.2"),
        ({"trials": 0}, "trials = 0 must be"),
        ({"start": "soon"}, "start"),
        ({"options": bsm.Options(scheme="linear")}, "in scheme = 'linear' nothing can fail"),
        ({"failure": 5}, "failure"),
    ],
)
def test_what_is_refused(given, says):
    with pytest.raises(bsm.ModelError, match=says):
        factor_of_safety(incline(), **given)


def test_joints_without_strength_are_refused():
    elastic = incline()
    elastic = elastic.replace(joints=[replace(elastic.joints[0], law=None)])
    with pytest.raises(bsm.ModelError, match="nothing has a strength to reduce"):
        factor_of_safety(elastic)
    with pytest.raises(bsm.ModelError, match="joint 'J' has no law"):
        factor_of_safety(elastic, joints=["J"])


@pytest.mark.heavy
def test_a_sliver_that_is_too_small_to_count_is_no_bound():
    """A chip on the plane, steeper than the block, falls first, in statics as in the runs, and is left out in both."""
    chip = np.array([(3.0, 0.0), (3.03, 0.0), (3.0, 0.03)])
    polygons = [turned(p, DIP) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5), chip)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock")
    joint = np.where(blocks.owner == 2, 0, -1).astype(np.int32)
    model = model_of(polygons, friction=FRICTION, kn=1e10)
    model = model.replace(
        blocks=replace(blocks, edge_joint=joint, joint_names=("slick",)),
        rocks=[bsm.Rock("rock", unit_weight=25e3)],
        joints=[*model.joints, bsm.Joint("slick", 1e10, 1e10, law=bsm.MohrCoulomb(friction=31.0))],
    )
    found = factor_of_safety(model)
    assert found.limit.factor == pytest.approx(EXACT, rel=1e-4)
    assert found.stable < EXACT <= found.unstable * (1 + 1e-4)


@pytest.mark.heavy
def test_where_no_strength_is_enough_there_is_no_factor():
    """A block over an edge, its weight beyond it: it tips at any strength."""
    polygons = [rectangle(-5, -2, 0, 0), rectangle(-0.4, 0, 0.6, 0.5)]
    found = factor_of_safety(model_of(polygons))
    assert found.limit.factor == 0.0
    assert "at any strength" in found.limit.text
    assert found.stable is None
    assert str(found) == "factor of safety: none found; no trial was stable"
    assert [trial.value for trial in found.trials] == [found.unstable]  # one run shows what fails


def test_movement_is_told_of_what_is_proved_to_move_and_rests_again():
    """No state in which blocks are at rest elsewhere is one to count from."""
    made = Made(lambda value: 0.8)
    found = searched(made, bound=0.05, first=0.05)
    assert made.values == [0.05]
    assert (found.reference, found.bracket.stable) == (None, None)
    assert found.trials[0].verdict is Verdict.UNSTABLE
    assert found.trials[0].moved == pytest.approx(0.8)
    assert found.trials[0].blocks.tolist() == [1]


@pytest.mark.parametrize(
    ("limit", "says"),
    [
        pytest.param(
            Limit(factor=1.3652, text=""),
            "upper bound by limit analysis: 1.365 (initial geometry)",
            marks=pytest.mark.heavy,
        ),
        (
            Limit(factor=np.inf, text="", unproved=1.3652),
            "upper bound by limit analysis: 1.365 (initial geometry, without proof)",
        ),
        (Limit(factor=1.148, text=""), ""),
        (Limit(factor=np.inf, text=""), ""),
    ],
)
def test_a_bound_beyond_the_bracket_is_in_the_last_line(limit, says):
    """By more than the tolerance."""
    assert beside(Bracket(1.1464, 1.1484), limit, Settings()) == says
    if says:
        found = replace(factor_of_safety(incline()), beside=says)
        assert str(found).endswith(f"; {says}")


@pytest.mark.slow
def test_a_bound_without_proof_is_told(monkeypatch):
    """Forces that no proof excludes are those of another criterion: movement alone."""
    monkeypatch.setattr(strength_factor._Search, "proof", lambda search: Proof(text="rounding spoils the proof"))
    found = factor_of_safety(incline())
    assert found.limit.unproved == pytest.approx(EXACT, rel=1e-4)
    assert np.isinf(found.limit.factor)
    assert any("without a proof: failure is judged by movement alone" in note for note in found.notes)
    assert found.stable < EXACT <= found.unstable * (1 + 1e-4)


def test_a_block_on_rollers_counts_and_a_fixed_one_does_not():
    model = model_of([rectangle(-5, -1, 5, 0), rectangle(-1, 0, 1, 1), rectangle(1, 0, 3, 1)], fixed=(0,))
    model = model.replace(supports=[*model.supports, bsm.Roller(blocks=[1], direction=0.0)])
    assert counted_blocks(model, bsm.Options().falls).tolist() == [False, True, True]


def test_nothing_that_could_fail_is_no_error():
    model = model_of([rectangle(-5, -1, 5, 0), rectangle(-1, 0, 1, 1)], fixed=(0, 1))
    model = model.replace(loads=[bsm.PointLoad(block=1, point=(0, 0.5), force=(0.0, -1.0))])
    assert factor_of_safety(model).unstable is None


@pytest.mark.slow
def test_another_start_that_has_no_answer_leaves_the_answer():
    """The block slides as it is given, so that nothing can be weakened after it is at rest."""
    weak = incline().replace(joints=[replace(incline().joints[0], law=bsm.MohrCoulomb(friction=20.0))])
    found = factor_of_safety(weak, spread=True)
    assert found.stable == pytest.approx(np.tan(np.radians(20.0)) / np.tan(np.radians(DIP)), rel=0.006)
    assert [text for text, _ in found.spread] == ["joints 10 times as stiff"]
    assert any(note.startswith("not in the spread: strength reduced after") for note in found.notes)


@pytest.mark.heavy
def test_a_bound_of_where_blocks_were_given_is_none_after_they_have_moved():
    """The block is let down by the excavation of what it leans on, and slides to the next one."""
    polygons = [
        turned(p, DIP)
        for p in (
            rectangle(-20, -5, 5, 0),
            rectangle(-1, 0, 1, 0.5),
            rectangle(-2, 0, -1, 0.5),
            rectangle(-4, 0, -2, 0.5),
        )
    ]
    model = model_of(polygons, friction=20.0, kn=1e10, fixed=(0, 2, 3)).replace(
        stages=[bsm.Stage(name="dig", excavate=[2]), bsm.Stage(name="later", loads=[])]
    )
    found = factor_of_safety(model, bsm.Options(displacement_limit=50.0))
    assert any("blocks moved in earlier stages" in note for note in found.notes)
