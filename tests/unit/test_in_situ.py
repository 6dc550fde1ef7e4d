"""The in-situ field as it is given: what is refused, and the description of a field that the joints cannot carry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.contact_set import gather_contacts
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.search import Outlines
from bsm_mesh.contact.stage_transfer import in_situ_history
from bsm_mesh.converters.continuum import compare_stages
from bsm_mesh.model.stress_field import StressField
from tests.scenes.models import LINEAR, framed, model_of
from tests.scenes.shapes import gmsh_triangles, grid, square

GAMMA = 25e3


def model(in_situ, **more):
    return bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons(grid(3, 3), rock="rock"), 3, 3),
        rocks=[bsm.Rock("rock", unit_weight=GAMMA, young=1e9, poisson=0.2)],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        in_situ=in_situ,
        **more,
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, ["method = 'direct' needs the field", "surface"]),
        ({"method": "gravitational", "surface": 0.0}, ["'gravitational' is unknown", "did you mean 'gravity'"]),
        ({"surface": 3.0, "stress": {"xx": -1.0}}, ["surface and stress both"]),
        ({"surface": 3.0, "k0": "hergett"}, ["'hergett' is unknown", "did you mean 'herget'"]),
        ({"surface": 3.0, "k0": {"a": 1, "d": 2}}, ["K = a / h + b + c h"]),
        ({"surface": 3.0, "k0": {"a": np.inf}}, ["k0 a", "finite"]),
        ({"surface": 3.0, "k0": [1, 2]}, ["k0 = [1, 2]"]),
        ({"surface": [(1, 2), (0, 3)]}, ["from left to right"]),
        ({"surface": "ground"}, ["surface = 'ground'"]),
        ({"surface": 3.0, "surcharge": "much"}, ["surcharge", "finite number"]),
        ({"stress": {"xz": -1.0}}, ["no component 'xz'"]),
        ({"stress": {"xx": [1, 2]}}, ["stress xx", "three [c, a_x, a_y]"]),
        ({"stress": {"xx": 1.0}, "surcharge": 1.0}, ["a given stress has it already"]),
    ],
)
def test_what_is_no_field(given, words):
    with pytest.raises(bsm.ModelError) as caught:
        bsm.InSitu(**given)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_surface_needs_gravity_straight_down():
    for direction in (-80.0, np.nextafter(-90.0, 0.0)):
        with pytest.raises(bsm.ModelError, match=rf"gravity_direction is {float(direction)!r} degrees: give -90"):
            model(bsm.InSitu(surface=3.0), gravity_direction=float(direction))
    assert model(bsm.InSitu(surface=3.0), gravity_direction=270.0).gravity_vector.tolist() == [0.0, -1.0]


def test_tractions_need_a_field_and_a_boundary():
    with pytest.raises(bsm.ModelError, match="needs the field"):
        model(bsm.InSitu(method="gravity"), loads=[bsm.InSituTraction(boundary="top")])
    with pytest.raises(bsm.ModelError, match="no boundary 'topp'"):
        model(bsm.InSitu(surface=3.0), loads=[bsm.InSituTraction(boundary="topp")])


@pytest.mark.parametrize(
    ("k0", "ratio"),
    [
        (0.5, lambda h: 0.5),
        ("herget", lambda h: 267 / h + 1.25),  # Wang Eq. 4.15
        ("brown_hoek_upper", lambda h: 1500 / h + 0.5),  # Eq. 4.16
        ("brown_hoek_lower", lambda h: 100 / h + 0.3),  # Eq. 4.17
        ({"b": 0.4, "c": 0.01}, lambda h: 0.4 + 0.01 * h),
    ],
)
def test_ratios_of_horizontal_to_vertical_stress(k0, ratio):
    field = StressField(model(bsm.InSitu(surface=40.0, k0=k0)))
    y = np.linspace(0, 3, 7)
    xx, yy, xy = field.at(np.column_stack([np.ones(7), y]), np.ones(7, dtype=int)).T
    assert_allclose(yy, -GAMMA * (40 - y))
    assert_allclose(xx, ratio(40 - y) * yy)
    assert not xy.any()


def test_derived_tractions_are_those_of_the_field():
    given = model(bsm.InSitu(surface=10.0, surcharge=5e3, k0=2.0), loads=[bsm.InSituTraction(boundary="right")])
    (load,) = given.acting_loads
    ends = given.blocks.vertices[
        [given.blocks.boundaries["right"], given.blocks.following[given.blocks.boundaries["right"]]]
    ]
    expected = -2.0 * (GAMMA * (10 - ends[:, :, 1].T) + 5e3)
    assert_allclose(load.values[:, :, 0], expected, rtol=1e-12)
    assert_allclose(load.values[:, :, 1], 0, atol=1e-6)


@pytest.mark.parametrize("scheme", ["linear", pytest.param("continuation", marks=pytest.mark.heavy)])
def test_a_field_beyond_the_strength_of_the_joints_is_said(scheme):
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=20.0))
    shear = {"xx": -1e6, "yy": -1e6, "xy": 0.5e6}
    loads = [bsm.InSituTraction(boundary=side) for side in ("right", "top", "left")]
    given = model(bsm.InSitu(stress=shear), joints=[joint], default_joint="J", loads=loads)
    given = given.replace(rocks=[bsm.Rock("rock", unit_weight=0)], supports=[bsm.Fixed(boundary="bottom")])
    stage = bsm.run(given, bsm.Options(scheme=scheme, max_steps=20)).stages[0]
    note = next(text for text in stage.notes if "beyond the strength" in text)
    assert "beyond the strength of 24 of 24 contacts (24 in shear, 0 in tension" in note
    assert (stage.start_residual > 0.1) == (scheme == "continuation")


def test_the_start_says_how_far_it_was_from_equilibrium():
    """No tractions on the right: the field is not in equilibrium, and the blocks move until they are."""
    stage = bsm.run(model(bsm.InSitu(surface=3.0, k0=1.0)), LINEAR).stages[0]
    assert stage.start_residual > 0.1
    assert stage.residual < 1e-10
    assert stage.max_displacement > 1e-6


def test_a_joint_whose_closure_has_a_limit_fits_no_more_once_it_opened():
    """A block is pushed off the lower joint and back beyond where it was: the lower one carries K times its overlap."""
    p0, stiffness, limit = 1e5, 1e9, 5e-4
    joint = bsm.Joint("J", stiffness, stiffness, law=bsm.MohrCoulomb(friction=35.0), max_closure=limit)
    loads = [bsm.PointLoad(block=1, point=(0.5, 1.5), force=(0.0, force)) for force in (3 * p0, -5 * p0)]
    stages = [bsm.Stage(name=f"{k}", loads=[load]) for k, load in enumerate(loads)]
    given = model_of([square(0, 0), square(0, 1), square(0, 2)], fixed=(0, 2), gamma=0.0)
    given = given.replace(joints=[joint], in_situ=bsm.InSitu(stress={"yy": -p0}), stages=stages)
    results = bsm.run(given)
    lower = 1 / (stiffness / p0 + 1 / limit)  # the overlap under p0
    u = results.stages[-1].displacement[1, 1]
    upper = lower + u  # both overlaps, of which the upper joint never opened
    in_upper = stiffness * upper / (1 - upper / limit) if upper > 0 else 0.0
    assert u < 0
    assert_allclose(stiffness * (lower - u) - in_upper, 2 * p0, rtol=1e-6)
    compared = [stage.comparison for stage in compare_stages(given, results)]
    assert max(comparison.force_error.l2 for comparison in compared) < 1e-6


@pytest.mark.parametrize(("cycles", "stiffness"), [(1, 1e9), pytest.param(2, 1e9, marks=pytest.mark.heavy), (1, 2e8)])
def test_a_joint_that_opened_closes_again_where_it_opened(cycles, stiffness):
    """A block pressed between two others is pushed off one of them and let go: it ends where it was.

    Pushed by F = 3 p0 only the upper joint carries, F = p0 + K u.
    """
    p0 = 1e5
    push, back = (bsm.PointLoad(block=1, point=(0.5, 1.5), force=(0.0, sign * 3 * p0)) for sign in (1, -1))
    stages = [
        bsm.Stage(name=name, loads=[load])
        for number in range(cycles)
        for name, load in ((f"push {number}", push), (f"let go {number}", back))
    ]
    given = model_of([square(0, 0), square(0, 1), square(0, 2)], kn=stiffness, fixed=(0, 2), gamma=0.0)
    given = given.replace(in_situ=bsm.InSitu(stress={"yy": -p0}), stages=stages)
    results = bsm.run(given)
    moved = [stage.displacement[1, 1] for stage in results.stages]
    assert_allclose(moved, [0.0, *cycles * (2 * p0 / stiffness, 0.0)], atol=1e-9 * p0 / stiffness)
    compared = [stage.comparison for stage in compare_stages(given, results) if stage.comparison is not None]
    assert max(comparison.force_error.l2 for comparison in compared) < 1e-6


def test_walls_that_moved_away_are_those_of_the_given_geometry():
    """After an opening of half a per cent of a block the joint carries from the given gap on, p0 + K u = -K u."""
    p0, stiffness = 1e5, 2e7
    loads = [bsm.PointLoad(block=1, point=(0.5, 1.5), force=(0.0, force)) for force in (3 * p0, -3 * p0)]
    stages = [bsm.Stage(name=f"{k}", loads=[load]) for k, load in enumerate(loads)]
    given = model_of([square(0, 0), square(0, 1), square(0, 2)], kn=stiffness, fixed=(0, 2), gamma=0.0)
    results = bsm.run(given.replace(in_situ=bsm.InSitu(stress={"yy": -p0}), stages=stages))
    assert_allclose(results.stages[-1].displacement[1, 1], -p0 / (2 * stiffness), rtol=1e-6)


@pytest.mark.parametrize(("up", "offset"), [(0.0, 0.0), (5e-4, 5e-4), (2e-3, 1e-3)])
def test_what_is_open_never_presses_at_once(up, offset):
    """An open contact whose gap is smaller than its offset already, as where its dual takes over, closes from there."""
    given = model_of([square(0, 0), square(0, 1)], fixed=(0,), gamma=0.0)
    given = given.replace(in_situ=bsm.InSitu(stress={"yy": -1e5}))
    history, _ = in_situ_history(given)
    closed = history.active
    history = replace(history, active=replace(closed, pressure=0 * closed.pressure), offset=np.full(2, 1e-3))
    outlines, position = Outlines.of(given.blocks, np.array([True, False])), np.zeros((2, 3))
    position[1, 1] = up
    contacts = gather_contacts(given, outlines, JointCatalogue(given), history, position, 0.05, first=False)
    faces = contacts.candidates.parallel_edge >= 0
    assert_allclose(np.sort(contacts.offset[faces])[-2:], offset, atol=1e-15)
    assert not contacts.mated.any()


def column_weight(blocks, weights, point, surface):
    """Return the weight above a point by clipping a vertical line with every block; above them the topmost one."""
    import shapely

    ray = shapely.LineString([point, (point[0], surface)])
    total, top, end = 0.0, 0.0, point[1]
    for b in range(blocks.count):
        inside = shapely.intersection(ray, shapely.Polygon(blocks.polygon(b)))
        total += weights[b] * inside.length
        if inside.length > 0 and inside.bounds[3] > end:
            top, end = weights[b], inside.bounds[3]
    return total + top * (surface - end), top


@pytest.mark.parametrize("surface", [3.0, 4.5, 2.2])
def test_overburden_through_many_rocks(surface):
    """Triangles of three rocks without any order, points anywhere in them, a surface at, over and in the model."""
    pytest.importorskip("gmsh")
    triangles = gmsh_triangles(3.0, 3.0, 0.5)
    random = np.random.default_rng(3)
    names = [f"rock {k}" for k in random.integers(0, 3, len(triangles))]
    blocks = bsm.Blocks.from_polygons(list(triangles), rock=names)
    rocks = [bsm.Rock(f"rock {k}", unit_weight=w) for k, w in enumerate((20e3, 26e3, 31e3))]
    k0 = {"a": 2.0, "b": 0.5}
    given = bsm.Model(blocks=blocks, rocks=rocks, in_situ=bsm.InSitu(surface=surface, surcharge=7e3, k0=k0))
    centroid = blocks.moments.centroid
    chosen = np.flatnonzero(centroid[:, 1] < surface - 0.1)
    points = centroid[chosen] + random.uniform(-0.02, 0.02, (len(chosen), 2))
    found = StressField(given).at(points, chosen)
    expected = np.array([column_weight(blocks, given.unit_weights, p, surface) for p in points])
    assert_allclose(found[:, 1], -expected[:, 0] - 7e3, rtol=1e-9)
    assert_allclose(found[:, 0], -2.0 * expected[:, 1] - 0.5 * (expected[:, 0] + 7e3), rtol=1e-9)
