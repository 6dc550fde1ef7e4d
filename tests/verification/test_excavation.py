"""In-situ stress set directly, and excavation in stages, against what is known of both (Wang 4.5, METHOD of stages)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.results.check import block_residuals
from tests.scenes.models import LINEAR, framed
from tests.scenes.shapes import gmsh_triangles, grid, rectangle, running_bond, voronoi

EXACT_STRESS = 1e-9
EXACT_RESIDUAL = 1e-10  # of a block's weight
SAME = 1e-10
CONTINUATION = bsm.Options(scheme="continuation")
ROTATIONS = 1e-4  # of the movement: what finite rotations make of it
WIDTH, HEIGHT, GROUND, GAMMA = 12.0, 10.0, 60.0, 26e3
ROCK = bsm.Rock("rock", unit_weight=GAMMA, young=10e9, poisson=0.25)


@cache
def cells(kind):
    return {
        "triangles": lambda: list(gmsh_triangles(WIDTH, HEIGHT, 0.9)),
        "quads": lambda: grid(12, 10),
        "voronoi": lambda: voronoi(WIDTH, HEIGHT, 150),
        "bricks": lambda: running_bond(20, 12),
    }[kind]()


HARD = bsm.Rock("rock", unit_weight=GAMMA, young=100e9, poisson=0.25)


def ground(kind="quads", k0=0.5, stages=(), method="direct", **more):
    """Return a body deep under level ground: rollers left and below, the field's tractions right and above."""
    settings = {"rocks": [ROCK], "in_situ": bsm.InSitu(method=method, surface=GROUND, k0=k0), **more}
    return bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons(cells(kind), rock="rock"), WIDTH, HEIGHT),
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.InSituTraction(boundary="right"), bsm.InSituTraction(boundary="top")],
        stages=stages,
        **settings,
    )


OPENING = rectangle(4, 3, 8, 6)
PIECES = [
    rectangle(4, 3, 5, 6),
    rectangle(5, 3, 6, 6),
    rectangle(6, 3, 7, 6),
    rectangle(7, 3, 8, 5),
    rectangle(7, 5, 8, 6),
]
AT_ONCE = [bsm.Stage(name="all", excavate=[OPENING])]
IN_FIVE = [bsm.Stage(name=f"piece {k}", excavate=[piece]) for k, piece in enumerate(PIECES)]


@pytest.mark.parametrize("kind", ["triangles", "quads", "voronoi", "bricks"])
@pytest.mark.parametrize("scheme", ["linear", "continuation"])
@pytest.mark.parametrize("k0", [1 / 3, 2.0, "herget", "brown_hoek_lower"])
def test_the_direct_state_is_exact(kind, scheme, k0):
    model = ground(kind, k0)
    results = bsm.run(model, bsm.Options(scheme=scheme))
    stage = results.stages[0]
    assert stage.status == ("no_verdict" if scheme == "linear" else "stable")
    assert not stage.displacement.any()
    assert np.abs(block_residuals(results, stage)).max() <= EXACT_RESIDUAL * model.weights.min()
    depth = GROUND - model.blocks.moments.centroid[:, 1]
    vertical = GAMMA * depth
    ratio = {"herget": 267 / depth + 1.25, "brown_hoek_lower": 100 / depth + 0.3}.get(k0, k0)
    assert_allclose(stage.stress[:, 1, 1], -vertical, rtol=EXACT_STRESS)
    assert_allclose(stage.stress[:, 0, 0], -ratio * vertical, rtol=EXACT_STRESS)
    assert_allclose(stage.stress[:, 0, 1], 0, atol=EXACT_STRESS * vertical.max())


@pytest.mark.parametrize("scheme", ["linear", "continuation", "wang"])
def test_residuals_are_relative_to_what_contacts_carry_at_the_start_where_that_is_most(scheme):
    """Fifty metres down they carry ten times a block's weight; from zero stress the weight counts."""
    options = bsm.Options(scheme=scheme)
    stage = bsm.run(ground(k0=1.0), options).stages[0]
    forces = np.hypot(stage.contacts.normal_force, stage.contacts.shear_force)
    assert_allclose(stage.reference_weight, forces[forces > 0].mean(), rtol=1e-9)
    model = ground(k0=1.0).replace(in_situ=None, loads=())
    assert stage.reference_weight > 10 * model.weights.mean()
    assert_allclose(bsm.run(model, options).stages[0].reference_weight, model.weights.mean())


def test_rest_in_stressed_rock_is_told_by_the_reference_weight():
    joint = bsm.Joint("J", normal_stiffness=5e9, shear_stiffness=2e9, law=bsm.MohrCoulomb(friction=35.0))
    stages = [bsm.Stage(name="adit", excavate=[rectangle(5, 4, 7, 6)])]
    results = bsm.run(ground("voronoi", k0=1.0, stages=stages, joints=[joint], default_joint="J"), CONTINUATION)
    stage = results.stages[-1]
    assert stage.status == "stable"
    most = np.abs(block_residuals(results, stage)).max()
    assert_allclose(stage.residual, most / stage.reference_weight, rtol=1e-3)
    assert stage.residual < CONTINUATION.tolerance


@pytest.mark.parametrize("points", ["ends", "gauss"])
def test_the_direct_state_under_a_given_stress_field(points):
    """Without weight any field of constant components is in equilibrium, here with shear on all sides."""
    given = {"xx": -3e6, "yy": -1e6, "xy": 0.4e6}
    model = bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons(cells("triangles"), rock="rock"), WIDTH, HEIGHT),
        rocks=[bsm.Rock("rock", unit_weight=0, young=10e9, poisson=0.25)],
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.InSituTraction(boundary=side) for side in ("left", "right", "top")],
        in_situ=bsm.InSitu(stress=given),
        contact_points=points,
    )
    stage = bsm.run(model, LINEAR).stages[0]
    assert_allclose(stage.displacement, 0, atol=1e-18)
    assert_allclose(stage.stress, np.tile([[-3e6, 0.4e6], [0.4e6, -1e6]], (model.blocks.count, 1, 1)), rtol=1e-9)


@pytest.mark.parametrize("scheme", ["linear", "continuation"])
def test_the_direct_state_with_layers_a_surcharge_and_water(scheme):
    """Three layers of other weight: vertical stress from all above, joints carry it less the water's pressure."""
    weights = {"lower": 27e3, "middle": 22e3, "upper": 18e3}
    polygons = cells("quads")
    rock = ["lower" if p[:, 1].mean() < 4 else "middle" if p[:, 1].mean() < 7 else "upper" for p in polygons]
    table, surcharge, k0 = 8.25, 100e3, 0.7
    model = bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons(polygons, rock=rock), WIDTH, HEIGHT),
        rocks=[bsm.Rock(name, unit_weight=w, young=5e9, poisson=0.2) for name, w in weights.items()],
        supports=[bsm.NormalRoller(boundary="left"), bsm.NormalRoller(boundary="bottom")],
        loads=[bsm.InSituTraction(boundary="right"), bsm.InSituTraction(boundary="top")],
        in_situ=bsm.InSitu(surface=HEIGHT, surcharge=surcharge, k0=k0),
        water=bsm.Water(table=[(0, table)]),
    )
    results = bsm.run(model, bsm.Options(scheme=scheme))
    stage = results.stages[0]
    assert results.check().ok
    assert np.abs(stage.displacement).max() <= 1e-15
    y = model.blocks.moments.centroid[:, 1]
    total = surcharge + 18e3 * np.minimum(10 - y, 3) + 22e3 * np.clip(7 - y, 0, 3) + 27e3 * np.clip(4 - y, 0, None)
    low, high = y - 0.5, y + 0.5
    pore = 9810 * (np.maximum(table - low, 0) ** 2 - np.maximum(table - high, 0) ** 2) / 2  # mean over the block
    assert_allclose(stage.stress[:, 1, 1], -total, rtol=EXACT_STRESS)
    assert_allclose(stage.stress[:, 0, 0], -k0 * total, rtol=EXACT_STRESS)
    deep = high <= table
    assert_allclose(stage.stress_effective[deep, 1, 1], (-total + pore)[deep], rtol=EXACT_STRESS)


def test_ground_of_a_slope():
    """Under a sloping surface the vertical stress is the weight of the column above; the start must then settle."""
    line = [(0, 12.0), (6, 12.0), (12, 10.0)]
    model = ground(in_situ=bsm.InSitu(surface=line, k0=0.5))
    from bsm_mesh.model.stress_field import StressField

    points = np.array([(1.0, 5.0), (9.0, 5.0), (15.0, 9.0), (3.0, 12.0), (3.0, 13.0)])
    found = StressField(model).at(points, np.zeros(5, dtype=int))
    assert_allclose(found[:, 1], -GAMMA * np.array([7.0, 6.0, 1.0, 0.0, 0.0]), rtol=1e-12, atol=1e-6)
    assert_allclose(found[:, 0], found[:, 1] / 2)
    stage = bsm.run(model, LINEAR).stages[0]
    assert stage.start_residual > 1e-3
    assert stage.max_displacement > 0


@pytest.mark.parametrize("kind", ["triangles", "quads", "voronoi", "bricks"])
def test_gravity_then_excavated_is_the_hole_from_the_start(kind):
    whole = ground(kind, method="gravity", stages=AT_ONCE)
    after = bsm.run(whole, LINEAR).stages[-1]
    x, y = whole.blocks.moments.centroid.T
    kept = np.flatnonzero(~((x > 4) & (x < 8) & (y > 3) & (y < 6)))
    polygons = [whole.blocks.polygon(b) for b in kept]
    hole = ground(kind, method="gravity").replace(
        blocks=framed(bsm.Blocks.from_polygons(polygons, rock="rock"), WIDTH, HEIGHT)
    )
    before = bsm.run(hole, LINEAR).stages[0]
    assert_array_equal(after.present, np.isin(np.arange(whole.blocks.count), kept))
    scale = np.abs(before.stress).max()
    assert_allclose(after.stress[kept], before.stress, atol=SAME * scale)
    moved = bsm.run(whole, LINEAR).stages[0].displacement[kept] + after.displacement[kept]
    assert_allclose(moved, before.displacement, atol=SAME * np.abs(before.displacement).max())


@cache
def dug_at_once(options):
    return bsm.run(ground(stages=AT_ONCE, rocks=[HARD]), options).stages[-1]


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
@pytest.mark.parametrize(
    "stages",
    [
        IN_FIVE,
        IN_FIVE[::-1],
        [bsm.Stage(name="slowly", excavate=[OPENING], relaxation=[0.2, 0.5, 0.9, 1.0])],
        [bsm.Stage(name="half", excavate=[OPENING], relaxation=[0.5]), bsm.Stage(name="rest")],
        [*AT_ONCE, bsm.Stage(name="filled", fill=[OPENING]), bsm.Stage(name="again", excavate=[OPENING])],
    ],
    ids=["five", "backwards", "relaxed", "two factors", "filled"],
)
def test_the_elastic_answer_does_not_depend_on_the_order(options, stages):
    """Rock without strength limits; the small rest of the continuation is its finite rotations."""
    expected = dug_at_once(options)
    results = bsm.run(ground(stages=stages, rocks=[HARD]), options)
    assert results.check().ok
    last = results.stages[-1]
    tolerance = SAME if options is LINEAR else ROTATIONS
    assert_allclose(last.displacement, expected.displacement, atol=tolerance * expected.max_displacement)
    assert_allclose(last.stress, expected.stress, atol=tolerance * np.abs(expected.stress).max())


def test_displacements_of_stages_add_up():
    results = bsm.run(ground(stages=IN_FIVE), LINEAR)
    assert [stage.name for stage in results.stages] == ["initial", *(stage.name for stage in IN_FIVE)]
    last = results.stages[-1]
    total = sum(stage.stage_displacement for stage in results.stages[1:])
    assert_allclose(last.displacement[last.present], total[last.present], rtol=1e-12, atol=1e-18)
    assert not last.displacement[~last.present].any()


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_half_released_is_half_the_movement(options):
    half = [bsm.Stage(name="half", excavate=[OPENING], relaxation=[0.5])]
    moved = bsm.run(ground(stages=half), options).stages[-1].displacement
    whole = bsm.run(ground(stages=AT_ONCE), options).stages[-1].displacement
    assert_allclose(moved, whole / 2, atol=(SAME if options is LINEAR else ROTATIONS) * np.abs(whole).max())


def test_what_was_released_does_not_come_back():
    """A later stage that releases less of its own new surfaces leaves those of an earlier one as they are."""
    stages = [
        bsm.Stage(name="most", excavate=[OPENING], relaxation=[0.8]),
        bsm.Stage(name="less", relaxation=[0.3]),
        bsm.Stage(name="more", relaxation=[0.9]),
    ]
    most, less, more = bsm.run(ground(stages=stages), LINEAR).stages[1:]
    assert less.max_stage_displacement <= SAME * most.max_displacement
    assert_allclose(more.displacement, most.displacement * 0.9 / 0.8, atol=SAME * most.max_displacement)


@pytest.mark.parametrize("options", [LINEAR, pytest.param(CONTINUATION, marks=pytest.mark.heavy)])
def test_the_field_as_pressure_keeps_everything_in_place(options):
    """Deep, with the same stress all round, an internal pressure of that size holds the wall where it was."""
    p = 5e6
    model = bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons(cells("bricks"), rock="rock"), WIDTH, HEIGHT),
        rocks=[bsm.Rock("rock", unit_weight=0, young=10e9, poisson=0.25)],
        supports=[bsm.NormalRoller(boundary=side) for side in ("left", "bottom")],
        loads=[bsm.InSituTraction(boundary=side) for side in ("right", "top")],
        in_situ=bsm.InSitu(stress={"xx": -p, "yy": -p}),
        stages=[bsm.Stage(name="dug", excavate=[OPENING], pressure=p), bsm.Stage(name="nothing new")],
    )
    free = bsm.run(model.replace(stages=AT_ONCE), options).stages[-1]
    for stage in bsm.run(model, options).stages:
        assert stage.max_displacement <= 1e-9 * free.max_displacement
        assert_allclose(
            stage.stress[stage.present], np.tile(-p * np.eye(2), (stage.present.sum(), 1, 1)), rtol=1e-9, atol=1
        )


@pytest.mark.heavy
@pytest.mark.parametrize(("friction", "matters"), [(25.0, True), (45.0, False)])
def test_with_slip_the_order_matters(friction, matters):
    """High horizontal stress makes joints slip around the first of two openings; without slip the order is nothing."""
    law = bsm.MohrCoulomb(friction=friction)
    joint = bsm.Joint("J", normal_stiffness=5e9, shear_stiffness=2e9, law=law)
    left, right = rectangle(3, 4, 5, 6), rectangle(5, 4, 7, 6)

    def dug(*order):
        stages = [bsm.Stage(name=f"{k}", excavate=[part]) for k, part in enumerate(order)]
        results = bsm.run(ground(k0=2.0, stages=stages, joints=[joint], default_joint="J"), CONTINUATION)
        assert results.status == "stable"
        assert results.check().ok
        return results.stages[-1]

    one, other = dug(left, right), dug(right, left)
    apart = np.abs(one.displacement - other.displacement).max() / one.max_displacement
    assert apart > 0.05 if matters else apart < ROTATIONS


@pytest.mark.heavy
def test_the_stage_that_fails_is_the_answer():
    """A brick roof under little horizontal stress: 2 m wide it arches, at 4 m a triangle of it falls: the end.

    With 25 degrees it is at its limit: it sinks by .3 m, and stands or not by what its joints remember in situ (D0037).
    """
    joint = bsm.Joint("J", normal_stiffness=5e9, shear_stiffness=2e9, law=bsm.MohrCoulomb(friction=20.0))
    stages = [
        bsm.Stage(name="pilot", excavate=[rectangle(3.9, 4, 6.1, 6)]),
        bsm.Stage(name="full", excavate=[rectangle(5.9, 4, 8.1, 6)]),
        bsm.Stage(name="never", excavate=[rectangle(8.1, 4, 10.1, 6)]),
    ]
    results = bsm.run(ground("bricks", k0=0.2, stages=stages, joints=[joint], default_joint="J"), CONTINUATION)
    assert [stage.name for stage in results.stages] == ["initial", "pilot", "full"]
    assert [stage.status for stage in results.stages] == ["stable", "stable", "unstable"]
    x, y = results.blocks.moments.centroid[results.unstable_blocks].T
    assert results.unstable_blocks.size >= 4
    assert ((x > 4) & (x < 8) & (y > 6)).all()


@pytest.mark.heavy
def test_the_iteration_of_the_thesis_goes_through_stages_too():
    law = bsm.MohrCoulomb(friction=45.0)
    joint = bsm.Joint("J", normal_stiffness=5e9, shear_stiffness=2e9, law=law)
    model = ground(k0=1.0, stages=IN_FIVE[:2], joints=[joint], default_joint="J")
    expected = bsm.run(model, CONTINUATION).stages[-1]
    results = bsm.run(model, bsm.Options(scheme="wang", max_steps=2000))
    assert [stage.status for stage in results.stages] == ["stable"] * 3
    found = results.stages[-1].displacement
    assert_allclose(found, expected.displacement, atol=1e-3 * expected.max_displacement)


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_repeated_supports_share_the_reaction_of_the_field(options):
    """A corner block on two sides: statics leaves its four bars open, the field says what each carries."""
    model = ground("quads", k0=0.5)
    results = bsm.run(model, options)
    supports = results.stages[0].supports
    corner = supports.block == 0
    found = {
        tuple(point): force for point, force in zip(supports.point[corner], supports.reaction[corner], strict=True)
    }
    p, q = GAMMA * (GROUND - 0.0), GAMMA * (GROUND - 1.0)
    assert_allclose(found[0.0, 1.0], [0.5 * (2 * q + p) / 6, 0], rtol=1e-9, atol=1e-4)
    assert_allclose(found[1.0, 0.0], [0, p / 2], rtol=1e-9, atol=1e-4)
    assert_allclose(found[0.0, 0.0], [0.5 * (2 * p + q) / 6, p / 2], rtol=1e-9, atol=1e-4)
