"""Joint sets that end at others: fractopo's relations read, traces ended, T-junctions and no crossings."""

from __future__ import annotations

import numpy as np
import pytest

from bsm_mesh.geometries import GeometryError, JointSet, Region, RockMass, abutting_sets, cut_blocks
from bsm_mesh.geometries.abutting import end_at, ended
from tests.scenes.networks import box


def test_relations_of_fractopo_as_frame_and_as_csv() -> None:
    """Its own example: trace 1 ends at trace 2, in a row (1, 2) with y = 1; of few ends among many crossings none."""
    pandas = pytest.importorskip("pandas")
    row = {"name": "title", "sets": ("1", "2"), "x": 0, "y": 1, "y-reverse": 0, "error-count": 0}
    assert abutting_sets(pandas.DataFrame([row])) == {"1": ("2",)}
    rows = [{"sets": "('A', 'B')", "x": "10", "y": "2", "y-reverse": "1"}]
    rows += [
        {"sets": "('A', 'C')", "x": "1", "y": "0", "y-reverse": "9"},
        {"sets": ("B", "C"), "x": 0, "y": 0, "y-reverse": 0},
    ]
    assert abutting_sets(rows) == {"C": ("A",)}
    assert abutting_sets(rows, least=0.1) == {"A": ("B",), "C": ("A",)}
    assert abutting_sets([{"sets": ("A", "B"), "x": 0, "y": 1, "y-reverse": 1}]) == {}  # each at the other as often
    with pytest.raises(GeometryError, match=r"row 1 needs sets \(two names\) and the counts x, y, y-reverse; it is \{"):
        abutting_sets([{"sets": ("A", "B"), "x": 1}])


def test_a_trace_ends_at_the_nearest_on_both_sides_of_its_middle() -> None:
    trace = np.array([[(0.0, 0.0), (10.0, 0.0)], [(0.0, 5.0), (10.0, 5.0)]])
    others = np.array([[(x, -1.0), (x, 1.0)] for x in (1, 4, 7, 9)])
    np.testing.assert_allclose(end_at(trace, others), [[(4, 0), (7, 0)], [(0, 5), (10, 5)]])


def test_a_set_that_abuts_crosses_no_joint_of_the_other() -> None:
    region = [Region(outline=box(0, 0, 20, 20), rock="r")]
    through = JointSet(name="J1", dip=0, spacing=4, start=(0, 2))
    for abuts in ((), ("J1",)):
        short = JointSet(name="J2", dip=85, density=0.6, length=9.0, scatter=3, abuts=abuts)
        cut = cut_blocks(RockMass(regions=region, joints=[through, short], seed=3))
        degree = np.zeros(len(cut.points), dtype=int)
        edges = {name: np.concatenate([g[name] for g in (cut.joints, cut.dead) if name in g]) for name in ("J1", "J2")}
        np.add.at(degree, edges["J2"].ravel(), 1)
        on_first = np.unique(edges["J1"])
        assert (degree[on_first].max() == 1) == bool(abuts)  # it ends there, and continues without
    with pytest.raises(GeometryError, match="joint set 'J2': abuts on 'J9', which is no set of this rock"):
        cut_blocks(RockMass(regions=region, joints=[JointSet(name="J2", dip=0, density=1, length=2, abuts=["J9"])]))
    with pytest.raises(GeometryError, match="abuts belongs to a length"):
        JointSet(name="J2", dip=0, spacing=1, abuts=["J1"])
    for wrong in ("J1", ["J2"], [1], None):
        with pytest.raises(GeometryError, match="must be names of other sets"):
            JointSet(name="J2", dip=0, density=1, length=2, abuts=wrong)  # type: ignore[arg-type]


def test_a_set_ends_at_what_is_left_of_one_that_ends_at_a_third() -> None:
    """J3 would meet the stretch of J2 that was cut off at J1; in any order, it continues past it."""
    drawn = {
        "J1": np.array([[(0.0, 0.0), (0.0, 10.0)]]),
        "J2": np.array([[(-1.0, 5.0), (9.0, 5.0)]]),  # the rest: from J1 on
        "J3": np.array([[(-0.5, 0.0), (-0.5, 12.0)], [(4.0, 0.0), (4.0, 12.0)]]),
    }
    sets = [
        JointSet(name="J3", dip=90, density=1, length=2, abuts=["J2"]),
        JointSet(name="J2", dip=0, density=1, length=2, abuts=["J1"]),
        JointSet(name="J1", dip=90, density=1, length=2),
    ]
    for given in (sets, sets[::-1]):
        found = dict(zip((one.name for one in given), ended(given, [drawn[one.name] for one in given]), strict=True))
        np.testing.assert_array_equal(found["J2"], [[(0, 5), (9, 5)]])
        np.testing.assert_array_equal(found["J3"], [[(-0.5, 0), (-0.5, 12)], [(4, 5), (4, 12)]])
    sets[-1] = JointSet(name="J1", dip=90, density=1, length=2, abuts=["J3"])
    with pytest.raises(GeometryError, match=r"in a circle: 'J\d' on 'J\d' on 'J\d' on 'J\d'; leave one of these out"):
        ended(sets, [drawn[one.name] for one in sets])
