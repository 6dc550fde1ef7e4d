"""Newmark's displacement against closed forms: Newmark (1965), Geotechnique 15, 139-160.

A rectangular pulse a for t0 over a yield acceleration y: (a - y) t0^2 / 2 (a / y). A sine: each half period by itself.
A block on a plane of dip b with friction f yields at tan(f - b) downhill, at tan(f + b) uphill.
"""

import csv
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.model.sliding_block import slide
from bsm_mesh.safety.earthquake import _sliding_side
from bsm_mesh.text.newmark_text import HEADER, side_rows
from bsm_mesh.text.tables import print_table
from tests.scenes.known_factors import incline, tan
from tests.scenes.shaken import STAGE, block_on_plane, quake

PULSE = bsm.Shaking(waveform="pulse", frequency=1, cycles=0.3, amplitude=0.5 * GRAVITY, duration=1.0)
EXACT = (0.5 - 0.2) * GRAVITY * 0.3**2 / 2 * 0.5 / 0.2


def test_a_pulse():
    found = slide(BaseMotion(PULSE), 1.0, 0.2 * GRAVITY)
    assert_allclose(found.permanent, EXACT, rtol=1e-6)
    assert_allclose(found.velocity.max(), 0.3 * 0.3 * GRAVITY, rtol=1e-6)
    assert_allclose(found.time[-1], 0.3 * 0.5 / 0.2, rtol=1e-6)
    assert slide(BaseMotion(PULSE), -1.0, 0.2 * GRAVITY).permanent == 0


def test_a_sine_record_of_coarse_values_and_both_signs():
    a, y, omega, cycles = 4.0, 1.5, 2 * np.pi * 1.5, 4

    def gained(t, t1):
        return a / omega * (np.cos(omega * t1) - np.cos(omega * t)) - y * (t - t1)

    begins = np.arcsin(y / a) / omega
    ends = brentq(gained, begins + 0.1, begins + 2 * np.pi / omega, args=(begins,))
    exact = cycles * quad(gained, begins, ends, args=(begins,))[0]
    time = np.linspace(0, cycles / 1.5, 1601)
    base = BaseMotion(bsm.Shaking(record=(time, a * np.sin(omega * time))))
    assert_allclose(slide(base, 1.0, y).permanent, exact, rtol=1e-4)
    waves = BaseMotion(bsm.Shaking(waveform="sine", frequency=1.5, cycles=cycles, amplitude=a))
    assert_allclose(slide(waves, 1.0, y).permanent, exact, rtol=1e-6)


def test_nothing_is_certain_to_slide_where_no_acceleration_was_found_unstable():
    """Trials above the last stable acceleration that end without a verdict leave the least displacement open: 0."""
    limit = SimpleNamespace(stable=0.2, unstable=None, trials=())
    side = _sliding_side("right", limit, BaseMotion(PULSE), 0.5)
    assert_allclose(max(side.sliding.permanent, side.turned.permanent), EXACT, rtol=1e-6)
    assert side.least == side.turned_least == 0


def test_trials_without_a_verdict_give_no_yield_acceleration():
    model = block_on_plane(PULSE, friction=0.2)
    with pytest.raises(bsm.ModelError, match="no acceleration to the left has a verdict; allow more trials"):
        bsm.newmark(model, trials=1, shaken=False)
    undecided = SimpleNamespace(stable=0.0, unstable=None, trials=(SimpleNamespace(value=-1.0, reason="why"),))
    with pytest.raises(bsm.ModelError, match="has a verdict: at -1 g why"):
        _sliding_side("left", undecided, BaseMotion(PULSE), 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1.0, -1.0])
def test_the_block_on_a_plane_beside_its_shaken_stage(scale):
    said = []
    model = block_on_plane(replace(PULSE, scale=scale), friction=0.2, kn=1e10)
    answer = bsm.newmark(model, tolerance=2e-4, report=said.append)
    assert any(line.startswith("stage 1, shaken for 0.5 s, displacement ") for line in said)
    assert answer.is_decided
    assert answer.stage == "initial"
    assert_allclose(answer.peak, 0.5, rtol=1e-3)
    slides, stays = answer.sides if scale > 0 else answer.sides[::-1]
    for side in answer.sides:
        low, high = abs(side.limit.stable), abs(side.limit.unstable)
        assert low - 1e-6 <= 0.2 <= high + 1e-6
        assert high - low <= 2.1e-4
    assert_allclose(slides.sliding.permanent, EXACT, rtol=3e-3)
    assert slides.least <= EXACT * (1 + 1e-5)
    assert slides.sliding.permanent >= EXACT * (1 - 1e-5)
    assert stays.sliding.permanent == 0
    assert_allclose(stays.turned.permanent, slides.sliding.permanent, rtol=3e-3)
    assert answer.shaken.status == "stable"
    assert_allclose(answer.shaken.moved[slides.side], (1, EXACT), rtol=3e-3)
    assert answer.shaken.moved[stays.side][1] < 1e-3 * EXACT


@pytest.mark.slow
def test_an_incline_yields_at_the_difference_of_friction_and_dip():
    """`incline` falls to the left; uphill it yields beyond the peak of the record, so nothing slides there."""
    time, values = quake(6.0, 4.0)
    answer = bsm.newmark(incline(40.0, 30.0), bsm.Shaking(record=(time, values)), tolerance=0.005)
    left, right = answer.sides
    assert abs(left.limit.stable) - 1e-6 <= tan(10.0) <= abs(left.limit.unstable) + 1e-6
    assert left.sliding.permanent > left.least > 0
    assert right.sliding is None
    assert right.yields is None
    assert answer.shaken is None


@pytest.mark.heavy
def test_a_shaken_block_on_an_incline_slides_further_by_the_slope():
    """Along the plane it gains cos(f - b) / cos(f) times what a block on a level plane of the same yield gains."""
    friction, dip = 40.0, 30.0
    shaking = bsm.Shaking(record=quake(4.0, 4.0), contact_damping=0.2, every=0.05)
    model = incline(friction, dip).replace(stages=[bsm.Stage(name=STAGE, shaking=shaking)])
    base, resists = BaseMotion(shaking), GRAVITY * tan(friction - dip)
    level = slide(base, float(base.axis[0]), resists).permanent
    moved = np.hypot(*bsm.run(model).stages[-1].stage_displacement[1, :2])
    assert_allclose(moved, level * np.cos(np.radians(friction - dip)) / np.cos(np.radians(friction)), rtol=1e-2)


@pytest.fixture(scope="module")
def commanded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("newmark")
    model = block_on_plane(PULSE, friction=0.2, kn=1e10)
    bsm.run(model.replace(stages=())).save(folder / "run")
    (folder / "quake.csv").write_text("time [s],acceleration [g]\n0,0.5\n0.3,0.5\n0.301,0\n1,0\n")
    out = folder / "out"
    words = [
        "newmark",
        folder / "run" / "model.toml",
        "--record",
        folder / "quake.csv",
        "--side",
        "left",
        "--tolerance",
        0.01,
        "-o",
        out,
    ]
    done = CliRunner().invoke(cli, [*map(str, words), "-q"])
    assert done.exit_code == 0, done.stderr
    return done.stdout, out, folder


def test_every_column_has_room_at_80_columns(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    limit = SimpleNamespace(stable=-0.17578, unstable=-0.17676)
    slides, turned = (SimpleNamespace(permanent=0.0028712), SimpleNamespace(permanent=0.00043238))
    side = SimpleNamespace(
        side="left", limit=limit, sliding=slides, turned=turned, least=0.0027841, turned_least=4.056e-4
    )
    moved = SimpleNamespace(moved={"left": (3, 0.0069683)})
    print_table("Newmark", HEADER, side_rows(SimpleNamespace(sides=(side,), shaken=moved)))
    (row,) = [line for line in capsys.readouterr().out.splitlines() if "0.1758" in line]
    assert row.split() == [
        "left",
        "0.1758",
        "to",
        "0.1768",
        "2.784",
        "to",
        "2.871",
        "mm",
        "0.4056",
        "to",
        "0.4324",
        "mm",
        "6.968",
        "mm",
    ]


def test_no_displacement_has_its_unit_in_every_column():
    """Where the record is below the yield acceleration: 0 m by both signs, as of the shaken stage."""
    limit = SimpleNamespace(stable=-0.5, unstable=None)
    side = SimpleNamespace(side="left", limit=limit, sliding=None, turned=None)
    ((_, _, *moved),) = side_rows(SimpleNamespace(sides=(side,), shaken=SimpleNamespace(moved={"left": (3, 0.0)})))
    assert moved == ["0 m", "0 m", "0 m"]


@pytest.mark.slow
def test_the_command_prints_a_table_and_writes_files(commanded):
    shown, out, _ = commanded
    words = " ".join(shown.split())
    assert "Greatest horizontal acceleration of the record: 0.5 g" in words
    assert "written to" in words
    told = json.loads((out / "newmark.json").read_text(encoding="utf-8"))
    side = told["sides"][0]
    assert side["decided"]
    assert side["blocks"] == [1]
    assert told["shaken"] is None
    low, high = side["displacement"]
    assert low < 1.01 * EXACT  # the pulse of the file ends within 1 ms
    assert EXACT < high < 1.15 * low
    with (out / "newmark.csv").open(encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    assert_allclose(float(last["displacement left [m]"]), high, rtol=1e-9)
    assert (out / "newmark.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"stages": ()}, "no stage of the model is shaken"),
        ({"stages": [bsm.Stage(name=STAGE, shaking=replace(PULSE, direction=90))]}, "is vertical"),
        pytest.param({"gravity_horizontal": 0.3}, "no yield acceleration", marks=pytest.mark.heavy),
    ],
)
def test_what_is_refused(change, says):
    with pytest.raises(bsm.ModelError, match=says):
        bsm.newmark(block_on_plane(PULSE, friction=0.2).replace(**change))
    with pytest.raises(bsm.ModelError, match="must be 'left', 'right'"):
        bsm.newmark(block_on_plane(PULSE, friction=0.2), sides=["up"])
