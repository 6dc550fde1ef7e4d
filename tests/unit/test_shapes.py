"""Outlines and patterns against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from bsm_mesh.geometries import (
    Excavation,
    GeometryError,
    JointSet,
    Opening,
    Region,
    RockMass,
    Voronoi,
    band,
    bricks,
    circle,
    cut_blocks,
    dam,
    horseshoe,
    rectangle,
    slope,
    stope,
    vaulted_box,
)
from bsm_mesh.geometries.spacings import Exponential, Lognormal, Normal
from tests.scenes.networks import areas, box, lengths

MANY = 4000  # spacings: the mean of lognormal ones is then known to 2 % at 99 %


def area(outline: object) -> float:
    polygon = shapely.Polygon(outline)
    assert polygon.is_valid
    assert polygon.exterior.is_ccw
    return float(polygon.area)


def test_areas_of_openings() -> None:
    assert area(circle(2, sides=60)) == pytest.approx(60 / 2 * 4 * np.sin(2 * np.pi / 60))
    assert area(horseshoe(6, 7, sides=200)) == pytest.approx(6 * 4 + np.pi * 9 / 2, rel=1e-4)
    assert area(stope(3, 20, 65)) == pytest.approx(60)
    radius, half = (10**2 / 4 + 2**2) / 4, np.arcsin(5 / 7.25)
    assert radius == 7.25
    segment = radius**2 * (half - np.sin(half) * np.cos(half))
    assert area(vaulted_box(10, 8, 2, sides=200)) == pytest.approx(60 + segment, rel=1e-5)


def test_areas_of_slopes_dams_and_zones() -> None:
    plain = area(slope(10, 45, ahead=5, behind=5, below=5))
    assert plain == pytest.approx(20 * 5 + 10 * 5 + 50)
    benched = area(slope(10, 90, benches=2, berm=3, ahead=5, behind=5, below=5))
    assert benched == pytest.approx(13 * 5 + 3 * 5 + 5 * 10)
    assert area(dam(30, 5, downstream=45)) == pytest.approx(30 * 5 + 30 * 30 / 2)
    assert area(band([(0, 0), (10, 0)], 2)) == pytest.approx(20)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: rectangle(1, 0, 0, 1), r"width = -1 must be above 0"),
        (lambda: horseshoe(6, 2), r"height - width / 2 = -1"),
        (lambda: vaulted_box(4, 8, 3), r"rise = 3 must be at most half the width"),
        (lambda: slope(10, 100), r"must be at most 90 degrees"),
        (lambda: circle(-1), r"radius = -1"),
        (lambda: circle("2 m"), r"circle: radius = '2 m' is not a finite number; give radius in m"),
        (lambda: circle(2, centre=(np.nan, 0)), r"centre = \(nan, 0\) must be two numbers \(x, y\) in m"),
        (lambda: slope(10, 60, benches=1.5), r"benches = 1.5 is not a whole number of at least 1"),
        (lambda: stope(3, 20, "steep"), r"dip = 'steep' is not a finite number; give dip in degrees"),
        (lambda: band([(0, 0)], 2), r"band: line = .* is no line of points"),
    ],
)
def test_impossible_shapes_are_said(make: object, says: str) -> None:
    with pytest.raises(GeometryError, match=says):
        make()  # type: ignore[operator]


def test_masonry_in_running_bond() -> None:
    cut = cut_blocks(RockMass(regions=[Region(outline=box(0, 0, 10, 4), rock="brick")], joints=bricks(2.0, 1.0)))
    assert cut.count == 5 + 6 + 5 + 6
    np.testing.assert_allclose(np.unique(areas(cut).round(9)), [1, 2])
    assert lengths(cut, dict(cut.joints)) == pytest.approx({"bed": 30, "head": 4 + 5 + 4 + 5})


@pytest.mark.heavy
def test_voronoi_cells_have_the_size_asked_for_and_grow_regular() -> None:
    region = [Region(outline=box(0, 0, 30, 30), rock="gneiss")]
    ragged, regular = (
        cut_blocks(RockMass(regions=region, joints=[Voronoi(name="V", size=1.0, rounds=rounds)])) for rounds in (0, 20)
    )
    for cut in (ragged, regular):
        assert areas(cut).sum() == pytest.approx(900, rel=1e-12)
        assert cut.count == pytest.approx(900 + 60, rel=0.1)  # cells cut by the frame are more
    whole = [np.sort(areas(cut))[100:] for cut in (ragged, regular)]
    assert whole[1].std() < 0.5 * whole[0].std()


def test_what_is_intact_is_not_cut() -> None:
    regions = [
        Region(outline=box(0, 0, 10, 5), rock="rock"),
        Region(outline=dam(5, 1, downstream=45, heel=(2, 5)), rock="concrete", border="contact", intact=True),
        Excavation(outline=box(8, 4, 9, 5), name="1"),
        Opening(outline=box(1, 1, 2, 2), boundary="gallery"),
    ]
    joints = [
        JointSet(name="J1", dip=90, spacing=1, start=(0.5, 0)),
        JointSet(name="bed", dip=0, spacing=2, start=(0, 1)),
    ]
    cut = cut_blocks(RockMass(regions=regions, joints=joints, boundaries={"upstream": [(2, 10), (2, 5)]}))
    assert (cut.rock == 1).sum() == 1
    assert lengths(cut, dict(cut.boundaries))["upstream"] == pytest.approx(5)
    assert lengths(cut, dict(cut.joints))["contact"] == pytest.approx(6)
    with pytest.raises(GeometryError, match="no outer edge lies along"):
        cut_blocks(RockMass(regions=regions, boundaries={"top": [(0, 20), (1, 20)]}))


def test_a_zone_drawn_beyond_the_frame_keeps_to_it() -> None:
    regions = [
        Region(outline=box(0, 0, 10, 10), rock="gneiss"),
        Opening(outline=box(4, 0, 6, 5), boundary="shaft"),
        Region(outline=band([(-5, 2), (15, 2)], 1.0), rock="shear_zone", border="wall", clipped=True),
    ]
    cut = cut_blocks(RockMass(regions=regions))
    assert areas(cut)[cut.rock == 1].sum() == pytest.approx(8)
    assert areas(cut).sum() == pytest.approx(90, rel=1e-12)
    assert lengths(cut, dict(cut.joints)) == pytest.approx({"wall": 16})
    assert lengths(cut, dict(cut.boundaries))["left"] == pytest.approx(10)
    beyond = cut_blocks(RockMass(regions=[*regions[:2], Region(outline=regions[2].outline, rock="shear_zone")]))
    assert areas(beyond).sum() == pytest.approx(90 + 10 + 2)


def test_random_spacings_have_the_moments_asked_for() -> None:
    generator = np.random.default_rng(5)
    for law, deviation in ((Normal(2, 0.3), 0.3), (Lognormal(2, 0.8), 0.8), (Exponential(2), 0.95 * 2)):
        drawn = law.draw(MANY, generator)
        assert drawn.mean() == pytest.approx(2, abs=4 * deviation / np.sqrt(MANY))
        assert drawn.std() == pytest.approx(deviation, rel=0.1)
        assert drawn.min() >= 0.05 * 2


def test_en_echelon_joints_stand_half_a_period_apart() -> None:
    joints = JointSet(name="J", dip=0, spacing=1, persistence=0.6, bridge=2.0, ends="en_echelon", start=(0, 0))
    traces = joints.traces(np.zeros(2), np.full(2, 20.0), 1)
    begins = [np.sort(traces[np.abs(traces[:, 0, 1] - y) < 1e-9, 0, 0]) for y in (8, 9, 10)]
    np.testing.assert_allclose(np.diff(begins[0]), 5.0)  # a bridge of 2 m is 0.4 of the period
    np.testing.assert_allclose((begins[1][0] - begins[0][0]) % 5, 2.5)
    np.testing.assert_allclose((begins[2][0] - begins[0][0]) % 5, 0, atol=1e-9)
    np.testing.assert_allclose(traces[:, 1, 0] - traces[:, 0, 0], 3.0)


def test_a_set_has_the_density_asked_for() -> None:
    low, high = np.zeros(2), np.full(2, 200.0)
    for spacing in (2.0, Lognormal(2.0, 0.5)):
        joints = JointSet(name="J", dip=37, spacing=spacing, persistence=0.6, bridge=1.0)
        square = shapely.box(0, 0, 200, 200)
        inside = shapely.length(shapely.intersection(shapely.linestrings(joints.traces(low, high, 1)), square)).sum()
        assert inside / 200**2 == pytest.approx(0.6 / 2.0, rel=0.03)  # length over area: persistence over spacing
