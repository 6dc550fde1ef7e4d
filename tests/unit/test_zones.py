"""Zones: model file, messages, results of a stage, files, pictures, and what they do not know."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.converters import compare
from bsm_mesh.model.zones import Zones
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.results.movement import greatest_displacement
from bsm_mesh.results.records import ContactStatus
from bsm_mesh.solve.zones.zone_mesh import zone_mesh
from bsm_mesh.text.tables import describe, engineering
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import MODEL, ROCK

GNEISS = bsm.Rock("gneiss", unit_weight=26e3, young=1e9, poisson=0.2, zones=bsm.Zones(size=0.4))
RIGID = bsm.Rock("rigid", unit_weight=26e3)
JOINT = bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))
WATER = bsm.Water(table=[(0, 1.4), (3, 1.7)])


def wall(rocks=(GNEISS, RIGID), names=("gneiss", "rigid", "rigid", "gneiss"), **given):
    """Return a wall of four blocks in bond, two of them with zones, on a floor and against a side."""
    polygons = [rectangle(0, 0, 2, 1), rectangle(2, 0, 3, 1), rectangle(0, 1, 1, 2), rectangle(1, 1, 3, 2)]
    blocks = (
        bsm.Blocks.from_polygons(polygons, rock=list(names))
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("left", lambda x, y: x < 1e-9)
        .with_boundary("top", lambda x, y: y > 2 - 1e-9)
    )
    usual = {
        "joints": [JOINT],
        "default_joint": "J1",
        "supports": [bsm.Fixed(boundary="bottom"), bsm.NormalRoller(boundary="left")],
        "loads": [
            bsm.Pressure(boundary="top", pressure=1e5),
            bsm.PointLoad(block=3, point=(2.5, 1.5), force=(-1e4, 0)),
        ],
    }
    return bsm.Model(blocks=blocks, rocks=rocks, **{**usual, **given})


SOFTENS = bsm.MohrCoulomb(friction=35, residual_friction=25, softening_slip=1e-3)
BOLT = bsm.Bolt(start=(2.8, 1.9), end=(2.2, 0.1), diameter=0.025, young=2e11, pretension=1e4)
CASES = {
    "joints": {},
    "whole rock": {"default_joint": None},
    "water": {"water": WATER},
    "water in whole rock": {"default_joint": None, "water": WATER},
    "water in a joint": {"water": bsm.Water(table=[(0, 1.4), (3, 1.7)], joint_pressure={"J1": 3e4})},
    "bolt": {"bolts": [BOLT]},
    "joint that softens": {
        "joints": [dataclasses.replace(JOINT, law=SOFTENS)],
        "loads": [bsm.Traction(boundary="top", traction=(3e4, -1e5))],
    },
    "history of a bolt": {"bolts": [BOLT], "water": WATER, "histories": [bsm.History(name="pull", bolt="bolt 1")]},
    "in situ": {"in_situ": bsm.InSitu(stress={"yy": [-1e6, 0, 0], "xx": [-5e5, 0, 0], "xy": [0, 0, 0]})},
    "support of a block": {"supports": [bsm.Fixed(blocks=[0]), bsm.Fixed(blocks=[1])]},
    "stages": {
        "stages": [
            bsm.Stage(name="part", excavate=[3], relaxation=[0.5], water=WATER, pressure=2e4),
            bsm.Stage(name="whole"),
            bsm.Stage(name="back", fill=[3], loads=[bsm.Pressure(boundary="top", pressure=1e5)]),
        ],
    },
}


WHOLE = [("water in whole rock", law) for law in ("elastic", "mohr_coulomb")]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("case", CASES)
def test_every_block_is_in_balance_and_the_certificate_holds(case, order, tmp_path, capsys):
    """By the forces of contacts, supports, bolts, water and loads alone: within blocks nothing is asked."""
    zoned = dataclasses.replace(GNEISS, zones=Zones(size=0.5, order=order))
    results = bsm.run(wall(rocks=[zoned, RIGID], **CASES[case]))
    assert results.status == "stable", results.stages[-1].reason
    check = results.check()
    assert check.ok
    assert check.block_residual < 1e-8
    assert verify_certificate.main(results.save(tmp_path / "out")) == 0, capsys.readouterr().out


@pytest.mark.parametrize("order", [1, 2])
def test_bolts_that_resist_shear_balance_the_moments_of_a_block(order):
    """A block that tilts away from a wall pulls its bolt out by more than a tenth of a millimetre."""
    blocks = bsm.Blocks.from_polygons(
        [rectangle(-3, -1, 5, 0), rectangle(-2, 0, 0, 3), rectangle(0, 0, 1, 3)], rock="r"
    )
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=25e3, young=2e9, poisson=0.2, zones=Zones(size=1.0, order=order))],
        joints=[bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=45))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 1])],
        bolts=[bsm.Bolt(start=(-1, 2.5), end=(0.5, 2.5), diameter=0.025, bond_strength=5e5, bearing_stiffness=2e8)],
        gravity_horizontal=0.4,
    )
    results = bsm.run(model)
    assert abs(results.stages[0].bolts.shear_force[0]) > 100
    assert results.check().block_residual < 1e-8


@pytest.mark.parametrize(("case", "law"), [("in situ", "mohr_coulomb"), ("stages", "mohr_coulomb"), *WHOLE])
def test_blocks_of_rock_with_strength_are_in_balance(case, law):
    """Rock that yields, and faces that break between soft and rigid rock."""
    zones = Zones(size=0.5, law=law, dilation=10.0 if law == "mohr_coulomb" else 0.0)
    strong = dataclasses.replace(GNEISS, cohesion=6e4, friction=30.0, tensile_strength=3e4, zones=zones)
    results = bsm.run(wall(rocks=[strong, RIGID], **CASES[case]))
    assert results.status == "stable", results.stages[-1].reason
    check = results.check()
    assert check.ok
    assert check.block_residual < 1e-8
    assert bool(results.stages[-1].zones.yielded.any()) == (law == "mohr_coulomb")


@pytest.mark.heavy
def test_what_is_written_is_read_back(tmp_path):
    results = bsm.run(wall())
    results.save(tmp_path / "out")
    found = bsm.Results.load(tmp_path / "out")
    assert found.scheme == "zones"
    ours, theirs = results.stages[0].zones, found.stages[0].zones
    for field in dataclasses.fields(ours):
        assert_array_equal(getattr(ours, field.name), getattr(theirs, field.name))
    assert (tmp_path / "out/zones.pvd").is_file()
    mesh = found.to_meshio("zones")
    assert mesh.cells[0].type == "triangle6"
    assert set(mesh.cell_data) >= {"stress", "sigma_1", "sigma_3", "block_id"}
    for picture in ("zones_sigma_1", "zones_sigma_3"):
        assert found.plot(picture).axes


@pytest.mark.heavy
def test_pictures_of_zones_are_of_zones_only():
    rigid = [dataclasses.replace(GNEISS, zones=None), RIGID]
    with pytest.raises(bsm.ModelError, match="nothing to show"):
        bsm.run(wall(rocks=rigid)).plot("zones_sigma_1")


@pytest.mark.parametrize(("order", "unit_weight"), [(1, 0.0), (2, 26e3)])
def test_points_of_histories_move_with_their_zones(order: int, unit_weight: float, tmp_path: Path) -> None:
    """A column of 2 m under pressure and its weight, without a Poisson effect: E v = -p y - w (h y - y^2 / 2)."""
    rock = dataclasses.replace(GNEISS, unit_weight=unit_weight, poisson=0.0, zones=Zones(size=0.6, order=order))
    heights, pressure, high = (2.0, 0.7, 1.3), 1e6, 2.0
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 1, high)], rock="gneiss")
    results = bsm.run(
        bsm.Model(
            blocks=blocks.with_boundary("bottom", lambda x, y: y < 1e-9).with_boundary("top", lambda x, y: y > 1.999),
            rocks=[rock],
            joints=[],
            supports=[bsm.Fixed(boundary="bottom")],
            loads=[bsm.Pressure(boundary="top", pressure=pressure)],
            histories=[
                *(bsm.History(name=f"y_{y}", point=(0.3, y)) for y in heights),
                bsm.History(name="line", line=[(0.5, 0.0), (0.5, high)]),
            ],
        )
    )
    v = {y: -(pressure * y + unit_weight * (high * y - y**2 / 2)) / 1e9 for y in heights}
    for y in heights:
        assert results.histories[f"y_{y}"]["v"][-1] == pytest.approx(v[y], rel=1e-6)
    assert results.histories["line"]["extension_1"][-1] == pytest.approx(v[high], rel=1e-6)
    (stage,) = results.stages
    assert greatest_displacement(stage) == pytest.approx(-v[high], rel=1e-6)
    assert stage.max_displacement < 0.7 * greatest_displacement(stage)  # the mean of the block
    told = dict(describe(results))["greatest displacement"]
    assert told.startswith(f"{engineering(-v[high], 'm')} at a node of the zones; mean of a block ")
    stressed = dict(describe(results))["most compressive stress (sigma_1)"]
    lowest = float(stage.zones.stress[:, 1, 1].min())  # near the base the weight of the column adds to the pressure
    assert lowest <= -(pressure + unit_weight) * (1 - 1e-9)
    assert stressed.startswith(f"{engineering(lowest, 'Pa')} in a zone; mean of a block ")
    assert results.plot("zones_displacement").axes
    results.save(tmp_path / "out")
    summary = json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))
    assert summary["stages"][0]["max_zone_displacement"] == greatest_displacement(stage)


def test_block_means_are_those_of_the_zones():
    stage = bsm.run(wall()).stages[0]
    zones = stage.zones
    a, b, c = np.moveaxis(zones.points[zones.cells[:, :3]], 1, 0)
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert (area > 0).all()
    for block in range(4):
        mine = zones.block == block
        mean = (zones.stress[mine] * area[mine, None, None]).sum(axis=0) / area[mine].sum()
        assert_allclose(stage.stress[block], mean, rtol=1e-12)


def test_stress_of_blocks_follows_from_their_contacts():
    """Wang Eq. 3.45, the sum of x_i F_j of what acts on a block, and the mean of its zones are the same."""
    weightless = [dataclasses.replace(rock, unit_weight=0.0) for rock in (GNEISS, RIGID)]
    stage = bsm.run(wall(rocks=weightless, loads=[bsm.Pressure(boundary="top", pressure=1e5)])).stages[0]
    contacts, block = stage.contacts, 3
    total = np.zeros((2, 2))
    for side, sign in ((contacts.block_b, 1.0), (contacts.block_a, -1.0)):
        mine = side == block
        total += np.einsum("ki,kj->ij", contacts.point[mine], sign * contacts.force[mine])
    total += np.einsum("i,j->ij", (2.0, 2.0), (0.0, -1e5 * 2))
    assert_allclose((total + total.T) / 4, stage.stress[block], atol=1e-6 * 1e5)


def test_zones_are_no_larger_than_asked_and_neighbours_share_sides():
    mesh = zone_mesh(wall())
    sides = mesh.mesh.p[:, mesh.mesh.facets]
    length = np.hypot(*(sides[:, 1] - sides[:, 0]))
    of_gneiss = np.unique(mesh.mesh.t2f[:, np.isin(mesh.block, [0, 3])])
    assert length[of_gneiss].max() <= 0.4 * (1 + 1e-9)
    edges = np.concatenate([mesh.piece_facet[mesh.piece_start[e] : mesh.piece_start[e + 1]] for e in range(4)])
    assert length[edges].sum() == pytest.approx(2 + 1 + 2 + 1)
    inner = (mesh.mesh.f2t[1] >= 0).sum()
    assert inner == (3 * mesh.mesh.t.shape[1] - (mesh.mesh.f2t[1] < 0).sum()) / 2


@pytest.mark.heavy
def test_model_file_and_python_build_the_same(small_folder):
    text = MODEL.replace(ROCK, ROCK + 'zones = { size = "50 cm", order = 1 }\n')
    (small_folder / "model.toml").write_text(text, encoding="utf-8")
    model = bsm.load(small_folder / "model.toml")
    assert model.rocks[0].zones == bsm.Zones(size=0.5, order=1)
    results = bsm.run(small_folder / "model.toml")
    assert results.status == "stable"
    written = bsm.load(bsm.run(model).save(small_folder / "again") / "model.toml")
    assert written == model
    assert written.digest != model.replace(rocks=[dataclasses.replace(model.rocks[0], zones=None)]).digest


@pytest.fixture
def small_folder(tmp_path):
    from tests.scenes.square_mesh import msh

    (tmp_path / "mesh.msh").write_text(msh(), encoding="utf-8")
    return tmp_path


def collapsing(kind):
    """Return a model that collapses, and the blocks that do."""
    bottom = {"joints": [JOINT], "default_joint": "J1", "supports": [bsm.Fixed(boundary="bottom")]}

    def built(polygons, **given):
        blocks = bsm.Blocks.from_polygons(polygons, rock="gneiss").with_boundary("bottom", lambda x, y: y < 1e-9)
        return bsm.Model(blocks=blocks, rocks=[GNEISS], **{**bottom, **given})

    column = [rectangle(0, y, 1, y + 1) for y in range(3)]
    smooth = dataclasses.replace(JOINT, law=bsm.MohrCoulomb(friction=5))
    return {
        "apart": (built([rectangle(0, 0, 1, 1), rectangle(3, 0.5, 4, 1.5)]), [1]),
        "undercut": (built(column, stages=[bsm.Stage(name="dig", excavate=[1])]), [2]),
        "may slide": (wall(supports=[bsm.NormalRoller(boundary="left")]), [0, 1, 2, 3]),
        "wedge": (built([[(0, 0), (2, 0), (2, 2)], [(0, 0), (2, 2), (0, 2)]], joints=[smooth]), [1]),
        "in two parts": (
            built(column, stages=[bsm.Stage(name="dig", excavate=[1], relaxation=[0.5, 1.0])]),
            [2],
        ),
    }[kind]


@pytest.mark.heavy
@pytest.mark.parametrize("kind", ["apart", "undercut", "may slide", "wedge", "in two parts"])
def test_a_collapse_is_an_answer(kind, tmp_path, capsys):
    """Blocks that nothing holds, and a wedge on a smooth plane: unstable, named, and proved by virtual work.

    Displacements are those of the last equilibrium; an iteration that finds none went 14 Mm.
    """
    model, down = collapsing(kind)
    results = bsm.run(model)
    stage = results.stages[-1]
    assert results.status == "unstable"
    assert stage.unstable_blocks.tolist() == down
    assert np.abs(stage.displacement).max() < 1e-3
    assert stage.proof.witness is not None
    code, said = verify_certificate.main(results.save(tmp_path / "out")), capsys.readouterr().out
    assert code == 0, said
    assert "proved" in said


def test_parts_that_no_load_moves_are_refused():
    """Any place of a free part without load is as good as another."""
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1), rectangle(3, 0, 4, 1)], rock=["gneiss", "light"])
    light = dataclasses.replace(GNEISS, name="light", unit_weight=0.0)
    model = bsm.Model(blocks=blocks, rocks=[GNEISS, light], supports=[bsm.Fixed(blocks=[0])])
    with pytest.raises(bsm.ModelError, match=r"about \(3.5, 0.5\) is free to move"):
        bsm.run(model)


def test_large_movements_are_refused():
    soft = dataclasses.replace(JOINT, normal_stiffness=1e6, shear_stiffness=1e6)
    results = bsm.run(wall(joints=[soft]))
    assert results.status == "not_converged"
    assert "for larger ones give zones displacement" in results.stages[0].reason


REFUSED = [
    (lambda: bsm.Rock("r", unit_weight=0, zones=bsm.Zones()), "give young and poisson"),
    (lambda: dataclasses.replace(GNEISS, stiffness="rigid"), "leave stiffness out"),
    (lambda: bsm.Zones(order=3), "order = 3"),
    (lambda: bsm.Zones(size=-1.0), "size = -1"),
    (lambda: bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2, zones=0.5), "must be"),
    (lambda: wall(rocks=[GNEISS, dataclasses.replace(RIGID, young=1e9, poisson=0.2)]), "has no zones, but"),
    (
        lambda: wall(rocks=[GNEISS, dataclasses.replace(GNEISS, name="rigid", zones=bsm.Zones(order=1))]),
        "different order",
    ),
    (lambda: bsm.run(wall(), bsm.Options(scheme="linear")), "is of rigid blocks"),
    (lambda: bsm.run(wall(), bsm.Options(linear_solver="pardiso")), "does not solve zones"),
    (lambda: bsm.run(wall(rocks=[dataclasses.replace(GNEISS, zones=bsm.Zones(size=1e-5)), RIGID])), "triangles"),
    (lambda: bsm.run(wall(supports=[])), "free to move"),
    (lambda: bsm.spread(bsm.run(wall())), "spread: zones"),
    (lambda: compare(wall(), bsm.run(wall())), "finite elements already"),
]


@pytest.mark.parametrize(("make", "words"), REFUSED)
def test_what_zones_do_not_know_is_refused(make, words):
    with pytest.raises(bsm.ModelError, match=words):
        make()


@pytest.mark.parametrize("default_joint", ["J1", None])
@pytest.mark.parametrize("order", [1, 2])
def test_faces_of_joints_are_covered_without_gap(order, default_joint):
    """Every face is as long as it is given, and as much of it is open as its contacts say."""
    zoned = dataclasses.replace(GNEISS, zones=Zones(size=0.3, order=order))
    results = bsm.run(wall(rocks=[zoned, RIGID], default_joint=default_joint))
    faces = joint_faces(results, results.stages[0])
    length = np.hypot(*(faces.end - faces.start).T)
    assert_allclose(length, faces.length, rtol=1e-9)
    assert length.sum() == pytest.approx(1 + 1 + 1 + 1 + 1)  # two upright faces, and three pieces of the bed
    contacts = results.stages[0].contacts
    open_length = contacts.length[contacts.status == ContactStatus.OPEN].sum()
    assert (faces.length * faces.open).sum() == pytest.approx(open_length, abs=1e-12)


def test_the_evidence_of_a_stage_has_its_reduced_strength():
    results = bsm.run(wall(stages=[bsm.Stage(name="weak", strength={"J1": 0.8})]))
    found = [stage.evidence.laws[0]["friction"] for stage in results.stages]
    assert_allclose(np.tan(np.radians(found)), np.tan(np.radians(JOINT.law.friction)) * np.array([1.0, 0.8]))
