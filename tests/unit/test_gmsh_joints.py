"""Joint sets fragmented into surfaces of a user's own Gmsh model, and curves found in it."""

from __future__ import annotations

from pathlib import Path

import gmsh
import numpy as np
import pytest

from bsm_mesh.converters import read_mesh
from bsm_mesh.geometries import (
    Fault,
    GeometryError,
    JointSet,
    Region,
    RockMass,
    cut_blocks,
    find_curves,
    fragment_by_joints,
    gmsh_session,
    name_groups,
    rectangle,
    write_mesh,
)
from tests.scenes.networks import areas

SETS = [JointSet(name="J1", dip=35, spacing=2.5, start=(0, 0)), JointSet(name="J2", dip=110, spacing=3.0, start=(1, 0))]


ENDED = [SETS[0], JointSet(name="J2", dip=110, density=0.8, length=5.0, abuts=["J1"])]


@pytest.mark.parametrize("sets", [SETS, ENDED])
def test_the_blocks_are_those_of_our_cutter(tmp_path: Path, sets: list[JointSet]) -> None:
    with gmsh_session("own"):
        rock = gmsh.model.occ.addRectangle(-6, -5, 0, 12, 10)
        (pieces,), joints = fragment_by_joints([rock], sets)
        assert set(joints) == {"joint:J1", "joint:J2"}
        bottom = find_curves(along=[(-6, -5), (6, -5)])
        name_groups({"rock:gneiss": pieces, **joints, "boundary:bottom": bottom})
        gmsh.option.setNumber("Mesh.MeshSizeMax", 2)
        gmsh.model.mesh.generate(2)
        write_mesh(tmp_path / "a.msh")
    blocks, _ = read_mesh(tmp_path / "a.msh", blocks="regions")
    cut = cut_blocks(RockMass(regions=[Region(outline=rectangle(-6, -5, 6, 5), rock="gneiss")], joints=sets))
    assert blocks.count == cut.count == len(pieces)
    np.testing.assert_allclose(np.sort(blocks.moments.area), np.sort(areas(cut)), atol=1e-6)
    edges = blocks.boundaries["bottom"]
    assert np.hypot(*blocks.edge_vectors[edges].T).sum() == pytest.approx(12)


def test_a_geo_file_is_cut_as_well(tmp_path: Path) -> None:
    """As docs/own_mesh.md says: merged, its surfaces asked for; an arc between two crossings is no joint."""
    (tmp_path / "rock.geo").write_text(
        'SetFactory("OpenCASCADE");\nRectangle(1) = {-10, -10, 0, 20, 20};\nDisk(2) = {0, 0, 0, 2.5};\n'
        "BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };\n"
    )
    sets = [JointSet(name="J1", dip=55, spacing=4, start=(0, 4)), JointSet(name="J2", dip=122, spacing=5, start=(0, 4))]
    with gmsh_session("geo"):
        gmsh.merge(str(tmp_path / "rock.geo"))
        pieces, joints = fragment_by_joints([tag for _, tag in gmsh.model.getEntities(2)], sets)
        for one in sets:
            curves = joints[f"joint:{one.name}"]
            assert find_curves(dip=one.dip, among=curves) == curves
    assert [len(piece) for piece in pieces] == [33]


def test_curves_by_direction_box_and_line() -> None:
    with gmsh_session("curves"):
        rock = gmsh.model.occ.addRectangle(0, 0, 0, 4, 4)
        gmsh.model.occ.addDisk(10, 0, 0, 1, 1)
        _, joints = fragment_by_joints([rock], [Fault(name="F", lines=[[(-1, 0), (5, 6)], [(0, 2), (4, 2)]])])
        everything = {tag for _, tag in gmsh.model.getEntities(1)}
        assert set(find_curves()) == everything
        oblique = find_curves(dip=45)
        assert set(oblique) == set(find_curves(dip=-135)) <= set(joints["joint:F"])
        assert set(find_curves(dip=0, among=joints["joint:F"])) | set(oblique) == set(joints["joint:F"])
        assert len(find_curves(box=[(9, -1), (11, 1)])) == 1  # the circle
        assert find_curves(box=[(9, -1), (11, 1)], dip=0) == []
        assert len(find_curves(along=[(0, 0), (4, 0)])) == 1


def test_joints_that_end_beyond_the_rock_leave_its_rim_straight(tmp_path: Path) -> None:
    """Their ends lay on Open CASCADE's padded box, and the rim went out to them by 1e-7 m."""
    with gmsh_session("rim"):
        rock = gmsh.model.occ.addRectangle(0, 0, 0, 4, 4)
        (pieces,), joints = fragment_by_joints([rock], [Fault(name="F", lines=[[(-1, 1.1), (5, 2.3)]])])
        name_groups({"rock:a": pieces, **joints})
        assert set(find_curves()) == {tag for _, tag in gmsh.model.getEntities(1)}
        gmsh.model.mesh.generate(2)
        write_mesh(tmp_path / "rim.msh")
    blocks, _ = read_mesh(tmp_path / "rim.msh", blocks="regions")
    assert blocks.count == 2
    np.testing.assert_allclose(blocks.vertices.min(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(blocks.vertices.max(axis=0), 4, rtol=1e-12)


def test_loose_pieces_outside_the_rock_are_not_found() -> None:
    """A line fragmented by hand leaves pieces beyond the rock; one that ends in the rock is part of its mesh."""
    with gmsh_session("loose"):
        occ = gmsh.model.occ
        rock = occ.addRectangle(0, 0, 0, 4, 4)
        through, ending = (
            occ.addLine(occ.addPoint(*a, 0), occ.addPoint(*b, 0)) for a, b in [((-1, 0), (5, 6)), ((-1, 1), (2, 1))]
        )
        _, (_, pieces, parts) = occ.fragment([(2, rock)], [(1, through), (1, ending)])
        occ.synchronize()
        assert (len(pieces), len(parts)) == (3, 2)  # of each one piece is in the rock; the second one's is a dead end
        middles = [gmsh.model.occ.getCenterOfMass(1, tag)[:2] for tag in find_curves(dip=45) + find_curves(dip=0)]
        assert all(0 <= x <= 4 and 0 <= y <= 4 for x, y in middles)
        assert sum(y == pytest.approx(1) for _, y in middles) == 1
        assert len(find_curves(dip=45, among=[tag for _, tag in pieces])) == 3


def test_what_cannot_be_fragmented() -> None:
    with gmsh_session("nothing"):
        with pytest.raises(GeometryError, match="there are no surfaces"):
            fragment_by_joints([], SETS)
        rock = gmsh.model.occ.addRectangle(0, 0, 0, 4, 4)
        with pytest.raises(GeometryError, match="no joint crosses the surfaces"):
            fragment_by_joints([rock], [Fault(name="F", lines=[[(7, 0), (8, 0)]])])
