"""The mesh of Dupont Circle Station, and the two steps that make it: short sides closed, blocks quartered."""

import math

import meshio
import numpy as np
import pytest

from bsm_mesh.geometries import JointSet, Region, RockMass, cut_blocks, rectangle
from bsm_mesh.geometries.dupont_station import build, drawn_layout
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.quarters import quarter_blocks
from bsm_mesh.geometries.short_sides import close_short_sides

pytest.importorskip("gmsh")
shapely = pytest.importorskip("shapely")

SMALL = {"width": 30.0, "below": 12.0}


def read(path):
    """Return the corners of every element, and the number of elements in each group."""
    mesh = meshio.read(path)
    corners = [mesh.points[row, :2] for block in mesh.cells if block.type in ("triangle", "quad") for row in block.data]
    sizes = {name: sum(map(len, rows)) for name, rows in mesh.cell_sets.items() if ":" in name and "gmsh:" not in name}
    return corners, sizes


def area(corners):
    x, y = corners.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def sides_of(corners):
    """Return how often each side occurs."""
    ends = np.round(np.concatenate([np.stack([c, np.roll(c, -1, axis=0)], axis=1) for c in corners]), 6) + 0.0
    ends = np.sort(ends.view([("x", float), ("y", float)]).reshape(len(ends), 2), axis=1)
    return np.unique(ends, axis=0, return_counts=True)


@pytest.mark.parametrize("change", [{}, {"dip": 50.0, "cross_dip": -40.0}, {"zone_offset": 3.3}, {"cross_dip": 0.0}])
def test_station_is_filled_with_quadrilaterals(tmp_path, change):
    corners, groups = read(build(tmp_path / "s.msh", **SMALL, **change))
    assert sum(area(c) for c in corners) == pytest.approx(30.0 * (12.0 + 9.0), rel=1e-9)
    assert min(area(c) for c in corners) > 1e-3
    assert np.mean([len(c) == 4 for c in corners]) > 0.95
    assert {"rock:rock", "rock:shear_zone", "excavation:1", "joint:J1", "joint:J2", "joint:SZ"} <= set(groups)
    assert {"boundary:left", "boundary:right", "boundary:bottom", "boundary:top"} <= set(groups)
    opening = shapely.box(-3, -8, 3, 0)
    inside = [c for c in corners if opening.contains(shapely.Point(c.mean(axis=0)))]
    assert sum(area(c) for c in inside) == pytest.approx(48.0, rel=1e-9)
    assert len(inside) == groups["excavation:1"]
    sides, count = sides_of(corners)
    once = shapely.union_all([shapely.LineString([tuple(a), tuple(b)]) for a, b in sides[count == 1]])
    assert count.max() == 2  # conforming: a side of two elements, or on the frame
    assert once.length == pytest.approx(2 * (30 + 21), abs=1e-4)


def test_a_zone_leaves_the_opening_at_the_foot_of_the_right_wall(tmp_path):
    mesh = meshio.read(build(tmp_path / "s.msh", **SMALL))
    kinds = mesh.cell_sets["rock:shear_zone"]
    cells = [block.data[rows] for block, rows in zip(mesh.cells, kinds, strict=True) if len(rows)]
    zone = shapely.union_all([shapely.Polygon(mesh.points[row, :2]) for block in cells for row in block])
    above = shapely.Point(3.0 + 6.0 / math.tan(math.radians(60)), -2.0)  # on the line through (3, -8) at 60 degrees
    assert shapely.distance(zone, above) == 0
    assert shapely.distance(zone, shapely.Point(3.0, -8.0)) < 0.6


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"zone_width": 12.0}, "leaves no rock"),
        ({"width": 5.0}, "larger than the opening"),
        ({"dip": 95.0, "spacing": 1}, "no parameter 'spacing'"),
    ],
)
def test_bad_parameters(tmp_path, parameters, words):
    with pytest.raises(GeometryError, match=words):
        build(tmp_path / "s.msh", **parameters)
    assert not (tmp_path / "s.msh").exists()


def square(*joints, **fields):
    return RockMass(regions=[Region(outline=rectangle(0, 0, 4, 4), rock="rock")], joints=joints, **fields)


def test_short_sides_are_closed_and_the_area_stays():
    mass = square(
        JointSet(name="A", dip=0, spacing=9, start=(0, 2)), JointSet(name="B", dip=45, spacing=9, start=(0.1, 0))
    )
    cut = cut_blocks(mass)
    closed = close_short_sides(cut, 0.3, shapely.box(0, 0, 4, 4))
    lengths = [np.hypot(*(closed.points[e[:, 1]] - closed.points[e[:, 0]]).T).min() for e in closed.joints.values()]
    assert min(lengths) > 0.3
    assert closed.count == cut.count == 4
    corners = np.split(closed.points[closed.corners], closed.rings[1:-1])
    assert sum(area(c) for c in corners) == pytest.approx(16.0)
    assert sum(area(c) for c in corners[:1]) > 0
    assert any(np.allclose(p, (0, 0)) for p in closed.points[closed.joints["B"]].reshape(-1, 2))


def test_a_sliver_goes_with_its_joint_on_the_next_one():
    mass = square(
        JointSet(name="A", dip=0, spacing=9, start=(0, 2)), JointSet(name="B", dip=0, spacing=9, start=(0, 2.1))
    )
    closed = close_short_sides(cut_blocks(mass), 0.3, shapely.box(0, 0, 4, 4))
    assert closed.count == 2
    assert sum(map(len, closed.joints.values())) == 1


def test_quarters_of_a_block_with_a_corner_to_the_right(tmp_path):
    """An L is seen whole from its centroid if thick, and cut into triangles if thin."""
    for legs, whole in ((1.4, True), (0.3, False)):
        outline = [(0, 0), (2, 0), (2, legs), (legs, legs), (legs, 2), (0, 2)]
        cut = cut_blocks(RockMass(regions=[Region(outline=outline, rock="rock")]))
        corners, _ = read(quarter_blocks(cut, tmp_path / "l.msh"))
        assert sum(area(c) for c in corners) == pytest.approx(4 - (2 - legs) ** 2)
        assert min(area(c) for c in corners) > 0
        assert sum(len(c) == 4 for c in corners) == (5 if whole else 0)


def test_a_seed_draws_a_layout_from_the_ranges(tmp_path):
    """Zones 3 to 15 m apart and 0.5 to 3 m wide, joints across 1 to 3 m apart; another seed, another layout."""
    layouts = [drawn_layout(80.0, seed) for seed in range(20)]
    for layout in layouts:
        for stations, low, high in ((layout.zones, 3, 15), (layout.cross_joints, 1, 3)):
            assert low <= np.diff(stations).min() <= np.diff(stations).max() <= high
            assert stations.min() < -60
            assert stations.max() > 60
        assert layout.widths.min() >= 0.5
        assert layout.widths.max() <= 3
        inside = np.searchsorted(layout.zones, layout.joints)
        assert (layout.joints > layout.zones[inside - 1] + layout.widths[inside - 1] / 2).all()
    assert len({layout.zones[0] for layout in layouts}) == 20
    corners, groups = read(build(tmp_path / "s.msh", **SMALL, seed=1))
    assert sum(area(c) for c in corners) == pytest.approx(30.0 * (12.0 + 9.0), rel=1e-9)
    assert {"joint:J1", "joint:J2", "joint:SZ", "excavation:1"} <= set(groups)


def test_a_seed_and_a_regular_layout_are_too_much(tmp_path):
    with pytest.raises(GeometryError, match="leave out spacings"):
        build(tmp_path / "s.msh", seed=1, joint_spacing=1.0)
