"""Faces between blocks: which contacts make one, what is apart, and where they are drawn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkCommonCore import vtkDataArray

import bsm_mesh as bsm
from bsm_mesh.converters.array_units import unit_of
from bsm_mesh.converters.result_files import BOLTS, SERIES, WATER
from bsm_mesh.converters.vtk_files import read_vtu
from bsm_mesh.folder.own_files import own_files
from bsm_mesh.results import Results
from bsm_mesh.results.joint_faces import joint_faces, status_of_shares
from bsm_mesh.results.joint_sets import joint_sets
from bsm_mesh.results.records import ContactStatus
from tests.scenes import models, shapes
from tests.scenes.models import model_of
from tests.unit.test_run_writer import staged
from tests.unit.test_snapshots import pushed

LINEAR, MOVING = bsm.Options(scheme="linear"), bsm.Options(scheme="continuation")
GUIDE = Path(__file__).parents[2] / "docs/arrays.md"


@pytest.fixture(scope="module")
def slid() -> Results:
    """Return a block that was pushed over 0.5 m of its base, against a wall."""
    return bsm.run(pushed(), MOVING)


def rows_between(results: Results, a: int, b: int) -> np.ndarray:
    faces = joint_faces(results, results.stages[-1])
    return np.flatnonzero(
        (np.minimum(faces.block_a, faces.block_b) == a) & (np.maximum(faces.block_a, faces.block_b) == b)
    )


@pytest.mark.parametrize("contact_points", ["ends", "gauss"])
def test_two_contacts_make_the_face_that_they_are_on(contact_points: str) -> None:
    """A grid of three by two blocks has seven faces of 1 m, whichever way the contacts lie on them."""
    results = bsm.run(staged().replace(contact_points=contact_points, stages=()), LINEAR)
    faces, contacts = joint_faces(results, results.stages[0]), results.stages[0].contacts
    assert len(faces.length) == 7
    np.testing.assert_allclose(faces.length, 1.0)
    ends = np.sort(np.round([faces.start, faces.end], 9).transpose(1, 0, 2).reshape(7, 4), axis=1)
    np.testing.assert_allclose(np.hypot(*(faces.end - faces.start).T), 1.0)
    np.testing.assert_allclose(ends, np.round(ends))
    np.testing.assert_allclose(np.sort(faces.pressure), np.sort(-contacts.normal_force.reshape(7, 2).sum(axis=1)))
    np.testing.assert_allclose(faces.pressure.sum() + contacts.normal_force.sum(), 0, atol=1e-6)


def test_a_block_on_a_base_with_corners_at_its_ends() -> None:
    """The face is 1 m long and closed: the base continues beyond it, the block does not."""
    base = [(-1, -1), (3, -1), (3, 0), (1, 0), (0, 0), (-1, 0)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([base, [(0, 0), (1, 0), (1, 1), (0, 1)]], rock="granite"),
        rocks=[bsm.Rock("granite", unit_weight=26e3)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))],
        default_joint="J1",
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.PointLoad(block=1, point=(0.5, 1.0), force=(2e3, 0))],
    )
    results = bsm.run(model, MOVING)
    faces = joint_faces(results, results.stages[-1])
    ends = np.sort([faces.start[0], faces.end[0]], axis=0)
    np.testing.assert_allclose(ends, [(0, 0), (1, 0)], atol=1e-4)
    assert faces.length == pytest.approx([1.0], rel=1e-4)
    assert faces.pressure == pytest.approx([26e3], rel=1e-4)
    assert faces.open.tolist() == [0.0]
    (joint,) = joint_sets(results, results.stages[-1])
    assert joint.length == pytest.approx(1.0, rel=1e-4)


@pytest.mark.parametrize("corner", [0.7, 1.1, 1.5, pytest.param(1.9, marks=pytest.mark.heavy)])
def test_a_block_that_slid_over_a_corner_of_its_base(corner: float) -> None:
    """From 0.5 m to the wall its face is 1 m long and has the state of its contacts, wherever the base has a corner."""
    model = pushed()
    base = [(0, -1), (4, -1), (4, 0), (corner, 0), (0, 0)]
    polygons = [base, *(model.blocks.polygon(block) for block in (1, 2))]
    results = bsm.run(model.replace(blocks=bsm.Blocks.from_polygons(polygons, rock="rock")), MOVING)
    faces, rows, contacts = (
        joint_faces(results, results.stages[0]),
        rows_between(results, 0, 1),
        results.stages[0].contacts,
    )
    under = np.maximum(contacts.block_a, contacts.block_b) == 1
    is_open = contacts.status[under] == ContactStatus.OPEN
    assert faces.length[rows].sum() == pytest.approx(1.0, rel=1e-3)
    assert (faces.length * faces.open)[rows].sum() == pytest.approx(contacts.length[under][is_open].sum(), abs=1e-3)
    assert (faces.length * faces.pressure)[rows].sum() == pytest.approx(-contacts.normal_force[under].sum())


def test_a_face_that_slid(slid: Results) -> None:
    """It lies under its block, has slid half a metre, and carries the block's weight and the push."""
    (row,) = rows_between(slid, 0, 1)
    faces = joint_faces(slid, slid.stages[0])
    np.testing.assert_allclose([faces.start[row], faces.end[row]], [(0.5, 0), (1.5, 0)], atol=1e-4)
    moved = faces.start[row] + faces.start_displacement[row]
    np.testing.assert_allclose(moved, (1.0, 0.0), atol=1e-3)
    assert abs(faces.slip[row]) == pytest.approx(0.5, abs=1e-3)
    assert faces.length[row] == pytest.approx(1.0, abs=1e-3)
    over = slid.stages[0].contacts
    on = (np.minimum(over.block_a, over.block_b) == 0) & (np.maximum(over.block_a, over.block_b) == 1)
    assert faces.pressure[row] == pytest.approx(-over.normal_force[on].sum() / over.length[on].sum())


def test_a_new_face_stands_where_the_blocks_met(slid: Results) -> None:
    """The block and the wall had no face in common: warped, the line is theirs; unwarped, it is on one of them."""
    (row,) = rows_between(slid, 1, 2)
    faces = joint_faces(slid, slid.stages[0])
    ends = np.array([faces.start[row] + faces.start_displacement[row], faces.end[row] + faces.end_displacement[row]])
    np.testing.assert_allclose(ends[np.argsort(ends[:, 1])], [(2, 0), (2, 1)], atol=1e-3)
    assert np.hypot(*(faces.end[row] - faces.start[row])) == pytest.approx(1.0, abs=1e-3)
    assert np.ptp([faces.start[row, 0], faces.end[row, 0]]) < 1e-3


def test_what_is_apart_is_open_and_drawn_where_the_rock_stays() -> None:
    """A block hangs from a roof by nothing and falls: the joint above it is open by as much as it fell."""
    polygons = [shapes.rectangle(0, 0, 3, 1), shapes.rectangle(1, -1, 2, 0)]
    model = model_of(polygons, friction=30)
    results = bsm.run(model, MOVING)
    assert results.status == "unstable"
    faces = joint_faces(results, results.stages[0])
    fallen = -results.stages[0].displacement[1, 1]
    assert fallen > 0.05
    assert (len(faces.length), faces.joint[0], faces.open[0], faces.status[0]) == (1, 0, 1.0, 2)
    assert faces.opening[0] == pytest.approx(fallen, rel=1e-9)
    np.testing.assert_array_equal(faces.start_displacement, 0)
    assert faces.pressure[0] == faces.shear_traction[0] == 0


def test_a_block_that_rocks_leaves_half_of_its_face(slid: Results) -> None:
    """One contact of a face is gone: its half stays with the contact that is left, the other is open."""
    (stage,) = slid.stages
    contacts = stage.contacts
    on = np.flatnonzero(
        (np.minimum(contacts.block_a, contacts.block_b) == 0) & (contacts.block_b + contacts.block_a == 1)
    )
    kept = np.setdiff1d(np.arange(len(contacts.length)), on[:1])
    fewer = replace(contacts, **{name: getattr(contacts, name)[kept] for name in contacts.__slots__})
    results = replace(slid, stages=(replace(stage, contacts=fewer),))
    rows, faces = rows_between(results, 0, 1), joint_faces(results, results.stages[0])
    np.testing.assert_allclose(faces.length[rows], 0.5, atol=1e-3)
    np.testing.assert_array_equal(faces.open[rows], [0, 1])
    ends = np.sort(np.concatenate([faces.start[rows, 0], faces.end[rows, 0]]))
    np.testing.assert_allclose(ends, [0.5, 1.0, 1.0, 1.5], atol=1e-3)


def test_a_corner_that_is_only_near_an_edge_is_no_face(slid: Results) -> None:
    """A contact that is open and alone, between blocks that never had a face in common, is left out."""
    (stage,) = slid.stages
    contacts = stage.contacts
    on = np.flatnonzero(np.minimum(contacts.block_a, contacts.block_b) == 1)
    kept = np.setdiff1d(np.arange(len(contacts.length)), on[:1])
    fewer = replace(contacts, **{name: getattr(contacts, name)[kept] for name in contacts.__slots__})
    assert len(rows_between(replace(slid, stages=(replace(stage, contacts=fewer),)), 1, 2)) == 1
    still = np.where(np.minimum(fewer.block_a, fewer.block_b) == 1, 2, fewer.status).astype(np.int8)
    alone = replace(stage, contacts=replace(fewer, status=still))
    assert len(rows_between(replace(slid, stages=(alone,)), 1, 2)) == 0


def test_blocks_that_are_held_have_no_open_joint(slid: Results) -> None:
    """The wall is on the base, and both are held: there is no contact, and nothing opened."""
    (row,) = rows_between(slid, 0, 2)
    faces = joint_faces(slid, slid.stages[0])
    assert (faces.open[row], faces.status[row], faces.pressure[row]) == (0, 0, 0)


def test_a_tall_block_on_a_face_of_many_corners() -> None:
    """Corners in the middle of a straight edge: the shares add up to the edge, whatever they are cut into."""
    base = np.array([(0.0, -1), (3, -1), (3, 0), (2, 0), (1, 0), (0, 0)])
    top = np.array([(0.0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (0, 1)])
    model = model_of([base, top], friction=30)
    results = bsm.run(model, MOVING)
    faces = joint_faces(results, results.stages[0])
    assert faces.length.sum() == pytest.approx(results.stages[0].contacts.length.sum())
    assert faces.length.sum() == pytest.approx(3.0, rel=1e-6)
    assert (faces.pressure * faces.length).sum() == pytest.approx(3 * 25e3, rel=1e-6)


def test_the_file_is_equal_for_pyvista_and_after_loading(slid: Results, tmp_path: Path) -> None:
    slid.save(tmp_path / "out")
    assert {"joints.pvd", "joints_0000.vtu"} <= own_files(tmp_path / "out")
    faces, grid = joint_faces(slid, slid.stages[0]), pyvista.read(tmp_path / "out/joints_0000.vtu")
    assert grid.n_cells == len(faces.length)
    for name in ("length", "slip", "opening", "pressure", "shear_traction", "utilisation", "status", "joint"):
        np.testing.assert_array_equal(grid.cell_data[name], getattr(faces, name), err_msg=name)
    assert {name: int(number[0]) for name, number in grid.field_data.items()} == {
        **{"status:sticking": 0, "status:slipping": 1, "status:open": 2},
        **{"joint:J": 0, "joint:unjointed rock": -1, "stage:initial": 0},
    }
    np.testing.assert_array_equal(grid.point_data["displacement"][::2, :2], faces.start_displacement)
    again = joint_faces(*(lambda back: (back, back.stages[0]))(Results.load(tmp_path / "out")))
    for name in faces.__slots__:
        np.testing.assert_array_equal(getattr(again, name), getattr(faces, name), err_msg=name)


def test_everything_warps_with_the_blocks(slid: Results, tmp_path: Path) -> None:
    """Contacts and supports: where they were given, plus their displacement, is where they are."""
    slid.save(tmp_path)
    for kind in ("contacts", "supports"):
        grid = read_vtu(tmp_path / f"{kind}_0000.vtu")
        now = grid.points + grid.point_data["displacement"][:, :2]
        np.testing.assert_allclose(now, grid.point_data["position"][:, :2], atol=1e-12)
    moved = read_vtu(tmp_path / "contacts_0000.vtu").point_data["displacement"]
    assert np.hypot(*moved[:, :2].T).max() == pytest.approx(0.5, abs=1e-3)


def test_stage_units_and_names_are_in_every_file_and_in_the_guide(tmp_path: Path) -> None:
    """Every array that is written has a unit, and is explained in the table of the guide."""
    results, guide = bsm.run(staged(), LINEAR), GUIDE.read_text(encoding="utf-8")
    results.save(tmp_path)
    for kind in (*SERIES, WATER, BOLTS):
        grid = pyvista.read(tmp_path / f"{kind}_0001.vtu")
        assert grid.field_data["stage:first"] == [1]
        for arrays in (grid.GetPointData(), grid.GetCellData()):
            for array in map(arrays.GetArray, range(arrays.GetNumberOfArrays())):
                told = array.GetInformation().Get(vtkDataArray.UNITS_LABEL())
                assert (told or "") == unit_of(kind, array.GetName())
        for name in (*grid.point_data, *grid.cell_data):
            unit = unit_of(kind, name)
            rows = [row for row in guide.splitlines() if row.startswith(f"| {kind} |") and f"`{name}`" in row]
            assert any(all(part in row for part in unit.split(", ")) for row in rows), (kind, name)
        assert "displacement" in grid.point_data


def test_names_of_joints_and_rock() -> None:
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(2, 1), rock=["gneiss", "schist"]), 2, 1)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock(name, unit_weight=25e3, young=1e9, poisson=0.2) for name in ("gneiss", "schist")],
        supports=[bsm.Fixed(boundary="bottom")],
    )
    results = bsm.run(model, LINEAR)
    assert list(results.to_pyvista("blocks").cell_data["rock_name"]) == ["gneiss", "schist"]
    assert list(results.to_pyvista("joints").cell_data["joint_name"]) == ["unjointed rock"]


@pytest.mark.parametrize(("part", "slips"), [(0.97, 0.0), (0.995, 1.0), (1.0 - 1e-6, 1.0)])
def test_what_is_just_below_its_strength_counts_as_slipping(part: float, slips: float) -> None:
    """Blocks that slid reach rest there: a block on an incline whose joint carries hardly more than its weight asks."""
    dip = 30.0
    polygons = [
        shapes.turned(polygon, dip) for polygon in (shapes.rectangle(-5, -1, 5, 0), shapes.rectangle(-2, 0, 2, 0.1))
    ]
    friction = float(np.degrees(np.arctan(np.tan(np.radians(dip)) / part)))
    results = bsm.run(models.model_of(polygons, friction=friction, kn=1e10))
    assert results.status == "stable"
    (joint,) = joint_sets(results, results.stages[-1])
    assert joint.slipping == pytest.approx(slips)


def test_rounding_of_shares_changes_no_state():
    """Faces of which all parts slip or are open, one by one summed, and one with a tenth that sticks."""
    slipping, is_open = np.array([[1 - 4e-16, 0], [0.7, 0.3 - 2e-16], [0, 1 - 4e-16], [0.9, 0]]).T
    states = [ContactStatus.SLIPPING, ContactStatus.SLIPPING, ContactStatus.OPEN, ContactStatus.STICKING]
    assert status_of_shares(slipping, is_open).tolist() == states
