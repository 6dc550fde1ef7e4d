"""Spread: several routes to an equilibrium, and by how much they differ; the verdict stays that of the usual one."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.folder.summary import summary
from bsm_mesh.results.records import Status
from bsm_mesh.results.spread import RouteEnd, spread_text
from bsm_mesh.text.headings import heading
from tests.scenes.large import jointed_slope
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.small_case import LINEAR, MODEL


def on_incline(friction, **given):
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    return model_of(polygons, friction=friction, **given)


def end(route, status, difference=None, block=None, same_loads=True):
    return RouteEnd(
        route=route,
        status=status,
        stage="initial",
        max_displacement=1.0,
        unstable_blocks=(),
        difference=difference,
        block=block,
        same_loads=same_loads,
    )


def test_routes_to_one_equilibrium_differ_by_rounding():
    results = bsm.run(on_incline(35.0))
    ends = bsm.spread(results).spread
    assert [one.route for one in ends] == ["usual", "relaxation first", "four parts"]
    assert {one.status for one in ends} == {Status.STABLE}
    assert max(one.difference for one in ends) < 1e-3 * results.stages[0].max_displacement


@pytest.mark.heavy
def test_relaxation_is_repeated_with_half_the_damping():
    """Where relaxation decided, and nowhere else; the other damping rounds otherwise and leads near, not there."""
    slope = bsm.spread(bsm.run(jointed_slope(150, 36.0).model(1.0))).spread
    assert [one.route for one in slope][2:] == ["four parts", "half the damping"]
    assert slope[-1].status is Status.STABLE
    assert 0 < slope[-1].difference < 0.1 * slope[0].max_displacement


def test_different_verdicts_are_near_the_limit():
    results = bsm.run(on_incline(35.0))
    for other, near in ((Status.STABLE, False), (Status.UNSTABLE, True)):
        told = summary(replace(results, spread=(end("usual", Status.STABLE, 0.0, 0), end("half the damping", other))))
        assert told["near_limit"] is near
        assert ("near its limit" in heading(told)) is near


def test_another_verdict_under_another_load_is_no_limit():
    others = end("time step / 2", Status.STABLE), end("record turned over", Status.UNSTABLE, same_loads=False)
    ends = (end("usual", Status.STABLE, 0.0, 0), *others)
    assert spread_text(ends) == "2 routes, one verdict; another load, record turned over: unstable"
    told = summary(replace(bsm.run(on_incline(35.0)), spread=ends))
    assert told["near_limit"] is False
    assert "near its limit" not in heading(told)


@pytest.mark.slow
def test_blocks_that_come_down_have_no_difference():
    ends = bsm.spread(bsm.run(on_incline(25.0))).spread
    assert {one.status for one in ends} == {Status.UNSTABLE}
    assert {one.difference for one in ends} == {None}


@pytest.mark.heavy
def test_an_excavation_is_released_in_parts():
    stop = turned(rectangle(-1.5, 0, -0.5, 0.5), 30.0)
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    stages = [bsm.Stage(name="later", excavate=[2], relaxation=[0.5, 1.0])]
    model = model_of([*polygons, stop], friction=35.0, fixed=(0, 2), stages=stages)
    ends = bsm.spread(bsm.run(model)).spread
    assert [one.stage for one in ends] == ["later"] * 3


def test_what_has_no_other_routes_is_told(tmp_path):
    model = on_incline(35.0)
    with pytest.raises(bsm.ModelError, match="only 'continuation' has others"):
        bsm.spread(bsm.run(model, bsm.Options(scheme="linear")))
    with pytest.raises(bsm.ModelError, match="were read back, without their model"):
        bsm.spread(bsm.Results.load(bsm.run(model).save(tmp_path / "out")))
    with pytest.raises(bsm.ModelError, match=r"Model is no bsm\.Results; give what bsm\.run returned"):
        bsm.spread(model)


@pytest.mark.parametrize(
    ("others", "words"),
    [
        ([end("b", Status.STABLE, 0.5, 7)], "2 routes, one verdict; equilibria differ by up to 0.5 m (block 7, b)"),
        ([end("b", Status.UNSTABLE)], "near its limit: the verdict depends on the route: stable (usual), unstable (b)"),
    ],
)
def test_words(others, words):
    assert words in spread_text((end("usual", Status.STABLE, 0.0, 0), *others))


@pytest.mark.heavy
def test_the_command_tells_it(tmp_path):
    model = bsm.run(on_incline(35.0)).save(tmp_path / "first") / "model.toml"
    out = CliRunner().invoke(cli, ["run", str(model), "-o", str(tmp_path / "out"), "-q", "--spread"])
    assert out.exit_code == 0, out.output
    assert "spread: 3 routes, one verdict" in out.stdout
    told = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["spread"]
    assert [one["route"] for one in told] == ["usual", "relaxation first", "four parts"]
    assert len(bsm.Results.load(tmp_path / "out").spread) == 3


def test_the_command_refuses_one_route_before_it_solves(case):
    case.write("model.toml", MODEL + LINEAR)
    case.refuses(
        "run", "model.toml", "--spread", says=["scheme = 'linear' has one route; only 'continuation' has others"]
    )
