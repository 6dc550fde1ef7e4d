"""Joints and outlines cut to blocks: what is closed-form, and what goes wrong elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pytest
import shapely

from bsm_mesh.geometries import (
    Excavation,
    Fault,
    GeometryError,
    JointSet,
    Opening,
    Region,
    RockMass,
    band,
    cut_blocks,
    mesh_blocks,
    rectangle,
    write_blocks,
)
from bsm_mesh.geometries.cutting.cut import Engine
from tests.scenes.networks import areas, box, circle, lengths, rock

AREA = 1e-12  # of the region: rounding alone
ENGINES = ("shapely", "gmsh")


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    found: Engine = request.param
    return found


def test_a_grid_of_joints(engine: Engine) -> None:
    joints = [
        JointSet(name="bed", dip=0, spacing=2, start=(0, 1)),
        JointSet(name="cross", dip=90, spacing=2.5, start=(0, 0)),
    ]
    cut = cut_blocks(RockMass(regions=[Region(outline=box(0, 0, 10, 10), rock="gneiss")], joints=joints), engine)
    assert cut.count == 6 * 4
    np.testing.assert_allclose(np.unique(areas(cut).round(9)), [2.5, 5.0])
    assert lengths(cut, dict(cut.joints)) == pytest.approx({"bed": 50, "cross": 30}, rel=1e-9)
    assert lengths(cut, dict(cut.boundaries)) == pytest.approx(dict.fromkeys(("left", "right", "bottom", "top"), 10))


def test_joints_through_one_point(engine: Engine) -> None:
    angles = np.radians([0, 25, 50, 90, 135, 160])
    lines = [np.array([[5, 5]] * 2) + np.outer([-20, 20], [np.cos(a), np.sin(a)]) for a in angles]
    cut = cut_blocks(rock(*lines), engine)
    assert cut.count == 12
    assert areas(cut).sum() == pytest.approx(100, rel=AREA)
    assert len(cut.joints) == 6


@pytest.mark.parametrize("gap", [1e-9, -1e-9, 1e-7, -1e-7, 0.0])
def test_a_joint_that_ends_on_another_within_rounding(engine: Engine, gap: float) -> None:
    end = np.array([5.0, 5.0]) + gap * np.array([1, -1]) / np.sqrt(2)
    cut = cut_blocks(rock([(0, 0), (10, 10)], [(9.0, 1.0), tuple(end - [0, 0])]), engine)
    dead = [(a.dead, a.dead_ends) for a in cut.accounts]
    assert dead == [(0.0, 0), (pytest.approx(4 * np.sqrt(2)), 1)]  # its other end is in the rock
    cut = cut_blocks(rock([(0, 0), (10, 10)], [(10.0, 0.0), tuple(end)]), engine)
    assert cut.count == 3
    assert sorted(areas(cut)) == pytest.approx([25, 25, 50], rel=1e-9)


def test_coincident_joints_are_told(engine: Engine) -> None:
    cut = cut_blocks(rock([(-1, 5), (11, 5)], [(2, 5), (7, 5)], [(0, 5 + 1e-9), (10, 5)]), engine)
    assert cut.count == 2
    first, second, third = cut.accounts
    assert first.bounding == pytest.approx(10, abs=1e-4)
    assert second.coincident == pytest.approx(5, abs=1e-4)
    assert third.coincident == pytest.approx(10, abs=1e-4)
    assert list(cut.joints) == ["J0"]


@pytest.mark.parametrize("offset", [1e-3, 1e-4, 3e-5, 1e-5, 1e-6])
def test_nearly_parallel_joints(engine: Engine, offset: float) -> None:
    lines = [[(-1, 5), (11, 5 + k * offset)] for k in (-2, -1, 0, 1, 2)]
    cut = cut_blocks(rock(*lines, [(3, -1), (4, 11)]), engine)
    assert areas(cut).min() > 0
    assert areas(cut).sum() == pytest.approx(100, rel=AREA)
    # Edges between joints nearer than the tolerance may count for both: nothing is missing.
    assert all(a.bounding + a.coincident > a.in_rock - 1e-3 for a in cut.accounts)


@pytest.mark.heavy
def test_joints_nearly_through_one_point_leave_no_edge_without_length() -> None:
    """Three lines, the third past the crossing of the others by less than the tolerance of 1.4e-5 m."""
    generator = np.random.default_rng(4)
    for angles, gap in zip(generator.uniform(0, 180, (150, 3)), generator.normal(0, 5e-6, 150), strict=True):
        lines = []
        for angle, off in zip(np.radians(angles), (0.0, 0.0, gap), strict=True):
            along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
            lines.append(np.array([3.1, 4.2]) + off * across + np.outer([-20, 20], along))
        cut = cut_blocks(rock(*lines))
        ends = cut.points[np.concatenate(list(cut.joints.values()))]
        assert np.hypot(*(ends[:, 1] - ends[:, 0]).T).min() > 0.04e-6 * np.hypot(10, 10)
        assert areas(cut).sum() == pytest.approx(100, rel=AREA)


def test_joints_tangent_to_a_tunnel_and_across_its_border(engine: Engine) -> None:
    regions = [
        Region(outline=box(-10, -10, 10, 10), rock="gneiss"),
        Opening(outline=circle(3, 64), boundary="tunnel"),
    ]
    lines = [[(-11, 3), (11, 3)], [(3 + 1e-9, -11), (3 + 1e-9, 11)], [(-11, -1), (11, 1)], [(0, 0), (0, 9)]]
    mass = RockMass(regions=regions, joints=[Fault(name=f"J{k}", lines=[line]) for k, line in enumerate(lines)])
    cut = cut_blocks(mass, engine)
    assert areas(cut).min() > 0
    assert areas(cut).sum() == pytest.approx(mass.domain().area, rel=AREA)
    assert cut.count == 8  # above 2; right 2; between the tangents and the tunnel 2, by J2; the rest 2, by J2
    assert lengths(cut, dict(cut.boundaries))["tunnel"] == pytest.approx(2 * 64 * 3 * np.sin(np.pi / 64))


def test_stages_divide_blocks_and_make_groups(engine: Engine) -> None:
    regions = [
        Region(outline=box(0, 0, 10, 10), rock="gneiss"),
        Excavation(outline=box(4, 4, 6, 6), name="1"),
        Excavation(outline=box(4, 2, 6, 4), name="2"),
    ]
    joints = [JointSet(name="J1", dip=0, spacing=1, start=(0, 0.5))]
    cut = cut_blocks(RockMass(regions=regions, joints=joints), engine)
    assert areas(cut)[cut.excavations["1"]].sum() == pytest.approx(4)
    assert areas(cut)[cut.excavations["2"]].sum() == pytest.approx(4)
    assert lengths(cut, dict(cut.joints)) == pytest.approx({"J1": 100})


def test_a_shear_zone_is_a_rock_with_joints_along_it(engine: Engine) -> None:
    band = [(0, 2), (10, 4), (10, 5), (0, 3)]
    regions = [
        Region(outline=box(0, 0, 10, 10), rock="gneiss"),
        Region(outline=band, rock="shear_zone", border="wall"),
    ]
    cut = cut_blocks(RockMass(regions=regions), engine)
    assert cut.count == 3
    assert cut.rock_names == ("gneiss", "shear_zone")
    assert areas(cut)[cut.rock == 1] == pytest.approx([10])
    assert lengths(cut, dict(cut.joints)) == pytest.approx({"wall": 2 * np.hypot(10, 2)})


def test_dead_ends_kept_extended_and_cut(engine: Engine) -> None:
    lines = [[(-1, 2), (11, 2)], [(-1, 8), (11, 8)]]
    stub = [(5, 4), (5, 6)]
    kept = cut_blocks(rock(*lines, stub), engine)
    assert kept.count == 3
    assert lengths(kept, dict(kept.dead)) == pytest.approx({"J2": 2})
    assert kept.accounts[2].dead_ends == 2
    cut = cut_blocks(rock(*lines, stub, dead_ends="cut"), engine)
    assert (cut.count, dict(cut.dead)) == (3, {})
    assert cut.accounts[2].dead == pytest.approx(2)
    longer = cut_blocks(rock(*lines, stub, dead_ends="extend"), engine)
    assert longer.count == 4
    assert longer.accounts[2].extended == pytest.approx(4)
    assert longer.accounts[2].bounding == pytest.approx(6)


def test_two_ends_in_line_reach_for_each_other_once(engine: Engine) -> None:
    cut = cut_blocks(rock([(-1, 5), (4, 5)], [(6, 5), (11, 5)], dead_ends="extend"), engine)
    assert cut.count == 2
    assert sum(a.extended for a in cut.accounts) == pytest.approx(2)
    assert sum(a.coincident for a in cut.accounts) == pytest.approx(0, abs=1e-4)


def test_the_same_seed_gives_the_same_blocks() -> None:
    joints = [JointSet(name="J1", dip=30, spacing=0.7, scatter=3, persistence=0.7, bridge=0.4, ends="t_ended")]
    joints.append(JointSet(name="J2", dip=100, spacing=0.9, scatter=3))
    region = [Region(outline=box(0, 0, 10, 10), rock="gneiss")]
    one, two = (cut_blocks(RockMass(regions=region, joints=joints, seed=7)) for _ in range(2))
    other = cut_blocks(RockMass(regions=region, joints=joints, seed=8))
    for name in ("points", "corners", "rings", "faces"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert one.points.shape != other.points.shape or not np.array_equal(one.points, other.points)


def test_a_further_set_leaves_the_others_as_they_are() -> None:
    one = JointSet(name="J1", dip=30, spacing=1, scatter=3)
    low, high = np.zeros(2), np.full(2, 10.0)
    np.testing.assert_array_equal(one.traces(low, high, 3), one.traces(low, high, 3))
    assert not np.array_equal(one.traces(low, high, 3), one.traces(low, high, 4))


def test_faults_of_a_description_are_collected() -> None:
    with pytest.raises(GeometryError) as caught:
        RockMass(regions=[Opening(outline=[(0, 0), (1, 1), (1, 0), (0, 1)])], tolerance=-1.0)
    assert [fault.partition(": ")[2].partition(";")[0].partition(":")[0] for fault in caught.value.faults] == [
        "region 0 (Opening)",
        "there is no rock",
        "tolerance = -1.0 is not a positive number",
    ]
    with pytest.raises(GeometryError, match=r"persistence = 0\.5 needs a bridge"):
        JointSet(name="J1", dip=0, spacing=1, persistence=0.5)
    with pytest.raises(GeometryError, match=r"gives 1.41e\+07 joints"):
        cut_blocks(
            RockMass(
                regions=[Region(outline=box(0, 0, 10, 10), rock="r")], joints=[JointSet(name="J", dip=0, spacing=1e-6)]
            )
        )
    with pytest.raises(GeometryError, match="there is no engine 'occ'"):
        cut_blocks(rock(), "occ")  # type: ignore[arg-type]


def test_bridges_too_short_for_the_model_are_refused_though_no_line_crosses_it():
    far_off = JointSet(name="J", dip=0.0, spacing=1e3, start=(0.0, 500.0), persistence=0.5, bridge=1e-12)
    with pytest.raises(GeometryError, match="too many bridges"):
        far_off.traces(np.zeros(2), np.full(2, 10.0), 1)


def test_bands_that_cross_have_one_outline() -> None:
    """Two shear zones that cross are one block between four of rock, of the area of their union; no slivers."""
    ground = Region(outline=rectangle(0, 0, 20, 10), rock="gneiss")
    zones = [
        Region(outline=band(line, 1.0), rock="sz", border="SZ", clipped=True)
        for line in ([(-1, 2.8), (21, 6.2)], [(-1, 6.2), (21, 2.8)], [(-1, 2.9), (21, 6.3)])
    ]
    cut = cut_blocks(RockMass(regions=[ground, *zones]))
    assert np.bincount(cut.rock).tolist() == [4, 1]
    union = shapely.union_all([shapely.Polygon(zone.outline) for zone in zones])
    inside = shapely.intersection(union, shapely.box(0, 0, 20, 10))
    length = cut.accounts[0].bounding
    assert length == pytest.approx(shapely.length(shapely.intersection(union.exterior, shapely.box(0, 0, 20, 10))))
    assert shapely.area(inside) > 30
    other = Region(outline=rectangle(9, 0, 10, 1), rock="sill")  # between them in the list: they stay apart
    assert cut_blocks(RockMass(regions=[ground, zones[0], other, zones[1]])).count > 6


def test_regions_that_only_touch_keep_their_border() -> None:
    halves = [Region(outline=rectangle(x, 0, x + 5, 5), rock="gneiss", border="B") for x in (0, 5)]
    cut = cut_blocks(RockMass(regions=halves))
    assert cut.count == 2
    assert cut.accounts[0].bounding == pytest.approx(5)


def test_gmsh_cuts_few_joints_and_the_cutter_very_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same blocks with the same numbers, to the last bit; the report says which it was and why."""
    lines = [[(x, -1), (x + 3, 11)] for x in (1, 3, 5)] + [[(-1, y), (11, y + 1)] for y in (2, 4, 6)]
    few = cut_blocks(rock(*lines))
    assert few.report()[0] == f"{few.count} blocks, cut by Gmsh: lines meet at 25 places (Gmsh takes up to 5000)"
    monkeypatch.setattr("bsm_mesh.geometries.cutting.cut.MOST_MEETINGS", 24)
    many = cut_blocks(rock(*lines))
    assert (
        many.report()[0] == f"{many.count} blocks, cut by our own cutter: lines meet at 25 places (Gmsh takes up to 24)"
    )
    np.testing.assert_array_equal(few.points, many.points)
    np.testing.assert_array_equal(few.corners, many.corners)
    assert {name: edges.tolist() for name, edges in few.joints.items()} == {
        name: edges.tolist() for name, edges in many.joints.items()
    }


def test_without_gmsh_the_cutter_cuts_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks can be counted, drawn and corrected on a machine that cannot write a mesh; Gmsh asked for is an error."""
    monkeypatch.setitem(sys.modules, "gmsh", None)
    cut = cut_blocks(rock([(-1, 4), (11, 4)]))
    assert cut.report()[0].startswith("2 blocks, cut by our own cutter: Gmsh is not installed (")
    assert cut.report()[0].endswith("pip install gmsh")
    with pytest.raises(GeometryError, match="Gmsh is not installed"):
        cut_blocks(rock([(-1, 4), (11, 4)]), "gmsh")


def test_a_sliver_is_joined_to_the_block_beside_it_and_told(engine: Engine) -> None:
    """Two joints 2e-5 m apart, tolerance 1.4e-5 m: one block between them the less, and its side on another joint."""
    cut = cut_blocks(rock([(-1, 4), (11, 4)], [(-1, 4 + 2e-5), (11, 4 + 2e-5)], [(-1, 7), (11, 7)]), engine)
    assert sorted(areas(cut)) == pytest.approx([30, 30, 40], abs=1e-3)
    assert cut.report()[-1] == "1 sliver thinner than two tolerances joined to the adjacent block"
    assert sum(a.coincident for a in cut.accounts) == pytest.approx(10)
    assert sum(a.snapped for a in cut.accounts) == pytest.approx(0, abs=1e-4)


SQUARE = Region(outline=box(0, 0, 4, 4), rock="r")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Region(outline=box(0, 0, 1, 1), rock=""), "Region: rock = '' cannot name a group"),
        (lambda: Region(outline=box(0, 0, 1, 1), rock="r", border=3), "Region: border = 3 cannot name a group"),
        (lambda: Region(outline=box(0, 0, 1, 1), rock="r", clipped="no"), "clipped = 'no' is not known"),
        (lambda: Opening(outline=box(0, 0, 1, 1), boundary=None), "Opening: boundary = None cannot name a group"),
        (lambda: Excavation(outline=box(0, 0, 1, 1), name="a\nb"), r"name = 'a\\nb' cannot name a group"),
        (lambda: RockMass(regions=SQUARE), "regions = Region.* must be a list, in brackets, of Region"),
        (lambda: RockMass(regions=[None]), r"regions = \[None\] must be a list"),
        (lambda: RockMass(regions=[SQUARE], joints="J1"), "joints = 'J1' must be a list"),
        (lambda: RockMass(regions=[SQUARE], seed=-1), "seed = -1 is not a whole number of at least 0"),
        (lambda: RockMass(regions=[SQUARE], tolerance="1 mm"), "tolerance = '1 mm' is not a positive number"),
        (lambda: RockMass(regions=[SQUARE], boundaries=[(0, 0), (1, 0)]), "boundaries = .* must be a mapping by names"),
        (lambda: RockMass(regions=[SQUARE], boundaries={"b": [(0, 0)]}), "boundary 'b' = .* is no line of points"),
        (lambda: cut_blocks([SQUARE]), "cut_blocks: mass = .* must be a RockMass of geometries$"),
        (lambda: write_blocks(RockMass(regions=[SQUARE]), "m.msh"), "cut = .* must be a BlockCut of geometries"),
        (lambda: mesh_blocks(cut_blocks(RockMass(regions=[SQUARE])), "m.msh", size=0), "size = 0 is not a positive"),
    ],
)
def test_what_is_no_rock_mass_is_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        make()
