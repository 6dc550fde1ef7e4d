"""Cells that joints will cut, estimated: many single planes are drawn together."""

import numpy as np
import pytest

from bsm_mesh.geometries.three_d import JointPlane, JointSet, RockMass, crowding, cut_cells


def test_single_planes_count_as_sets_do(monkeypatch):
    """Three sets of nine planes, and the same 27 planes one by one: 1000 cells, by as few draws."""
    low, high = np.zeros(3), np.full(3, 10.0)
    sets = [JointSet(name="J", dip=dip, dip_direction=d, spacing=1.0) for dip, d in ((0, 0), (90, 0), (90, 90))]
    planes = [s.planes(low, high, 0) for s in sets]
    singles = [
        crowding.Planes(normal=p.normal[k : k + 1], point=p.point[k : k + 1], radius=p.radius[k : k + 1])
        for p in planes
        for k in range(len(p.normal))
    ]
    drawn = []
    meet = crowding._points_meet
    monkeypatch.setattr(crowding, "_points_meet", lambda *given: drawn.append(1) or meet(*given))
    estimates = [crowding.expected_cells([(p, 1.0) for p in group], low, high) for group in (planes, singles)]
    assert estimates[1] == pytest.approx(estimates[0], rel=0.05)
    assert len(drawn) == 10 + 1
    cells = cut_cells(RockMass(box=(low, high), joints=sets)).count
    assert estimates[0] == pytest.approx(cells, rel=0.5)  # planes on the sides of the box count, and cut nothing


def test_a_single_plane_with_a_set_adds_what_it_cuts():
    low, high = np.zeros(3), np.full(3, 10.0)
    joints = [
        JointSet(name="J", dip=0, dip_direction=0, spacing=1.0),
        JointPlane(name="F", dip=90, dip_direction=0, point=(5, 5, 5)),
    ]
    found = crowding.expected_cells([(joint.planes(low, high, 0), 1.0) for joint in joints], low, high)
    assert found == pytest.approx(cut_cells(RockMass(box=(low, high), joints=joints)).count, rel=0.1)
