"""History of contacts that continue, end, or transfer it to another; rules on and off, as in test_contact_rules."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ActiveContacts
from tests.scenes.contacts import Scene, column, delaunay_triangles, random_wall
from tests.scenes.shapes import rectangle, square


@pytest.mark.heavy
@settings(max_examples=60, deadline=None)
@given(st.integers(min_value=0, max_value=2**32 - 1))
def test_history_is_continued_or_transferred_never_twice(seed):
    rng = np.random.default_rng(seed)
    scene = Scene.of(random_wall(rng, 4) if seed % 2 else delaunay_triangles(rng, 25))
    active = scene.activated(scene.detect())
    for _ in range(4):
        position = scene.position + rng.normal(0, 5e-4, scene.position.shape)
        scene = Scene(scene.outlines, position, scene.blocks)
        found = scene.detect(active)
        goes_on, taken = found.history[found.history >= 0], found.predecessor[found.predecessor >= 0]
        rows = np.concatenate([goes_on, taken])
        assert len(np.unique(rows)) == len(rows)
        assert ((found.history < 0) | (found.predecessor < 0)).all()
        assert (active.key[goes_on] == found.key[found.history >= 0]).all()
        assert (active.pair[taken] == found.pair[found.predecessor >= 0]).all()
        keys = list(zip(found.pair.tolist(), found.key.tolist(), strict=True))
        assert len(set(keys)) == len(keys)
        active = scene.activated(found)


@pytest.mark.parametrize("shift", [-5e-4, 5e-4, 2e-3])
def test_no_swapped_role_while_the_active_contact_is_in_range(shift):
    """Seen: the dual appeared in the same step with zero shear and halved the friction."""
    start = column()
    active = start.activated(start.detect())
    moved = start.moved(1, (shift, -1e-5))

    found = moved.detect(active)
    assert len(moved.within_tolerance(found)) == 2
    if abs(shift) < 1e-3:
        assert (found.history[moved.within_tolerance(found)] >= 0).all()
        off = moved.detect(active, rules=RULES._replace(dual_distance=0.0))
        assert sorted(off.history[moved.within_tolerance(off)]) == [-1, 0, 1]


def test_history_of_two_goes_to_one_from_the_nearer():
    scene = Scene.of([rectangle(0, 0, 3, 1), rectangle(1, 1, 2, 2)])
    found = scene.detect()
    row = int(np.argmin(scene.placed[found.corner, 0]))  # at (1, 1)
    for points in ([(1.05, 1), (1.02, 1)], [(1.02, 1), (1.05, 1)]):
        ended = active_on_top(found.pair[0], [4 << 32, (4 << 32) + 1], points)
        assert scene.detect(ended).predecessor[row] == [x for x, _ in points].index(1.02)
        assert (scene.detect(ended).predecessor >= 0).sum() == 1


@pytest.mark.parametrize("first", [0, 1])
def test_history_that_a_nearer_contact_displaces_goes_to_the_next_candidate(first):
    """Seen: it was lost where contacts were listed in one order and transferred in the other."""
    scene = Scene.of([rectangle(-1, -1, 0.05, 0), square(0, 0)])  # candidates at (0, 0) and (0.05, 0)
    found = scene.detect()
    points = np.array([(0.02, 0.0), (0.01, 0.0)])  # both nearer to the first
    order = [first, 1 - first]
    ended = active_on_top(found.pair[0], [4 << 32, (4 << 32) + 1], points[order])
    again = scene.detect(ended)
    at = scene.placed[again.corner, 0].round(6).tolist()
    assert {x: order[row] for x, row in zip(at, again.predecessor, strict=True)} == {0.0: 1, 0.05: 0}


def active_on_top(pair, keys, points):
    """Return active contacts of block 1 on the top of block 0 under keys that no candidate has."""
    return ActiveContacts(
        pair=np.full(len(keys), pair),
        key=(np.array([4] * len(keys)) << 32) | np.array(keys),
        pressure=np.ones(len(keys)),
        point=np.array(points),
        normal=np.tile([0.0, 1.0], (len(keys), 1)),
    )


def test_an_open_dual_waits_until_the_kept_contact_has_ended():
    start = column()
    active = start.activated(start.detect())
    found = start.moved(1, (0.03, -1e-5)).detect(active)
    left, right = np.sort(start.placed[found.corner, 0])[[0, -1]]
    assert left == pytest.approx(0.03, abs=1e-3) or left == pytest.approx(0.0, abs=1e-3)
    assert right == pytest.approx(1.0, abs=0.04)
    assert found.count == 2


def test_a_contact_ends_when_it_leaves_the_edge_and_its_dual_takes_over_the_history():
    start = column()
    active = start.activated(start.detect())
    inside, outside = start.moved(1, (0.9e-3, -1e-5)), start.moved(1, (1.1e-3, -1e-5))
    assert sorted(inside.detect(active).history) == [0, 1]
    assert sorted(inside.detect(active, rules=RULES._replace(detach_tol=0.0)).history) == [-1, 0], "it flickers"
    found = outside.detect(active)
    assert sorted(found.history) == [-1, 0] or sorted(found.history) == [-1, 1]
    (new,) = np.flatnonzero(found.history < 0)
    assert found.predecessor[new] == 1 - found.history.max()
    assert found.block_a[new] != found.block_a[1 - new], "corner and edge are swapped"
    assert (outside.detect(active, rules=RULES._replace(detach_tol=1.0)).history >= 0).all(), "it hangs in the air"


@pytest.mark.parametrize("off", [{"transfer_distance": 0.0}, {"min_cosine": 1.1}])
def test_without_near_and_aligned_contacts_no_history_is_transferred(off):
    start = column()
    active = start.activated(start.detect())
    outside = start.moved(1, (2e-3, -1e-5))
    assert (outside.detect(active).predecessor >= 0).sum() == 1
    assert (outside.detect(active, rules=RULES._replace(**off)).predecessor >= 0).sum() == 0


def test_history_is_not_transferred_round_a_corner():
    """A block that slips off the top and comes to lean on the side starts there without shear force."""
    start = Scene.of([square(0, 0), rectangle(0.9, 1, 1.9, 2)])
    active = start.activated(start.detect())
    assert len(active.key) == 2
    beside = start.moved(1, (0.1, -0.05))
    assert len(beside.within_tolerance(beside.detect(active))) == 2
    assert (beside.detect(active).predecessor < 0).all()
    assert (beside.detect(active, rules=RULES._replace(min_cosine=-1.0, transfer_distance=0.3)).predecessor >= 0).any()


def test_history_goes_along_an_outline_from_edge_to_edge():
    floor = np.array([(-2, -1), (2, -1), (2, 0), (0, 0), (-2, 0)], dtype=float)  # its top has a flat corner at x = 0
    start = Scene.of([floor, rectangle(-1, 0, -0.001, 1)], fixed=[0])
    active = start.activated(start.detect())
    found = start.moved(1, (0.02, -1e-5)).detect(active)
    rows = start.within_tolerance(found)
    assert len(rows) == 3, "the flat corner of the floor has come under the block"
    assert found.length[rows].sum() == pytest.approx(0.999)
    right = rows[start.placed[found.corner[rows], 0] > -0.01]
    assert sorted(found.history[rows]) == [-1, -1, found.history.max()]
    assert found.predecessor[rows].max() == 1 - found.history.max()
    assert found.predecessor[right].max() == found.predecessor[rows].max()


def test_an_active_contact_has_a_largest_penetration():
    start = Scene.of([rectangle(0, 0, 3, 1), rectangle(1, 1, 2, 2)])
    active = start.activated(start.detect())
    assert start.moved(1, (0.0, -0.24)).detect(active).count == 2
    assert start.moved(1, (0.0, -0.3)).detect(active).count == 0
    assert start.moved(1, (0.0, -0.3)).detect(active, rules=RULES._replace(max_penetration=0.5)).count == 2


def test_two_active_duals_at_one_point_become_one():
    start = column()
    every = start.detect(rules=RULES._replace(dual_distance=0.0))
    rows = start.within_tolerance(every)
    assert len(rows) == 4
    active = start.activated(every, rows, pressure=np.array([1.0, 2.0, 3.0, 4.0]))
    found = start.moved(1, (0.0, -1e-5)).detect(active)
    assert found.count == 2
    assert sorted(active.pressure[found.history]) == [3.0, 4.0], "those that carry more"


def test_contacts_without_pressure_are_not_active():
    start = column()
    active = start.activated(start.detect(), pressure=0.0)
    found = start.moved(1, (0.0, -1e-5)).detect(active)
    assert (found.history == -1).all()
    assert (found.predecessor == -1).all()
    without = start.moved(1, (0.0, -1e-5)).detect()
    for name in ("key", "length", "in_range", "opposing_candidate"):
        assert (getattr(found, name) == getattr(without, name)).all(), "they have no say in what is found"


def test_an_open_contact_is_recalled_over_its_edge_and_then_by_its_dual():
    start = column()
    opened = start.activated(start.detect(), pressure=0.0)
    above = start.moved(1, (0.0, 0.02)).detect(opened)
    again = above.recalled >= 0
    assert sorted(above.recalled[again]) == [0, 1]
    assert (opened.key[above.recalled[again]] == above.key[again]).all()
    beside = start.moved(1, (2e-3, 0.02)).detect(opened)
    again = beside.recalled >= 0
    assert sorted(beside.recalled[again]) == [0, 1]
    assert beside.in_range[again].all()
    assert len(set(beside.block_a[again])) == 2, "of one corner and edge are swapped"


def test_an_open_contact_is_recalled_no_farther_than_walls_face_each_other():
    start = column()
    opened = start.activated(start.detect(), pressure=0.0)
    assert (start.moved(1, (0.0, 0.08)).detect(opened).recalled == -1).all(), "beyond the band"
    assert (start.moved(1, (0.0, 0.02), degrees=30.0).detect(opened).recalled == -1).all(), "turned away"
    closed = start.activated(start.detect())
    assert (start.moved(1, (0.0, -1e-5)).detect(closed).recalled == -1).all(), "those have all of their history"
