"""Results to a folder and back."""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.results import BoltForces, ContactForces, Results, StageResult, SupportForces
from bsm_mesh.results.evidence import Evidence
from tests.scenes import models, shapes


@pytest.fixture(scope="module")
def results() -> Results:
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(3, 2), rock=["gneiss", "schist"] * 3), 3, 2)
    return bsm.run(
        bsm.Model(
            title="Grid of Ümläut",
            blocks=blocks,
            rocks=[bsm.Rock(name, unit_weight=25e3, young=1e9, poisson=0.2) for name in ("gneiss", "schist")],
            joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=2e8, law=bsm.Patton(friction=30))],
            default_joint="J1",
            supports=[bsm.Fixed(boundary="bottom"), bsm.Roller(boundary="left", direction=10)],
            loads=[bsm.Pressure(boundary="top", pressure=1e5)],
            bolts=[
                bsm.Bolt(start=(0, 0.4), end=(2.8, 1.7), diameter=0.02, pretension=1e4, name="Bölt"),
                bsm.Bolt(start=(0.1, 0.1), end=(0.9, 0.2), diameter=0.02),  # in one block
                bsm.Bolt(start=(2.5, 2), end=(2.5, 0.2), diameter=0.03, bond_stiffness=1e9, spacing=1.5),
            ],
        )
    )


def assert_same(one: object, two: object) -> None:
    for field in fields(one):  # type: ignore[arg-type]
        a, b = getattr(one, field.name), getattr(two, field.name)
        if isinstance(a, BoltForces | ContactForces | Evidence | SupportForces):
            assert_same(a, b)
        else:
            np.testing.assert_array_equal(a, b, err_msg=field.name)


def test_round_trip(results: Results, tmp_path: Path) -> None:
    assert results.save(tmp_path / "deep" / "out") == tmp_path / "deep" / "out"
    read = Results.load(tmp_path / "deep" / "out")
    for name in ("joint_names", "scheme", "linear_solver", "tolerance", "model_digest", "title", "status"):
        assert getattr(read, name) == getattr(results, name)
    np.testing.assert_array_equal(read.blocks.vertices, results.blocks.vertices)
    np.testing.assert_array_equal(read.blocks.rock, results.blocks.rock)
    assert read.blocks.rock_names == results.blocks.rock_names
    assert len(read.stages) == len(results.stages)
    stage: StageResult
    for stage, again in zip(results.stages, read.stages, strict=True):
        assert_same(stage, again)
    assert str(read.check()) == str(results.check())


def test_saving_again_replaces(results: Results, tmp_path: Path) -> None:
    results.save(tmp_path)
    before = sorted(tmp_path.iterdir())
    results.save(tmp_path)
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    "name",
    ["summary.json", "blocks.pvd", "blocks_0000.vtu", "contacts.pvd", "supports_0000.vtu", "history.csv", "bolts.pvd"],
)
def test_an_incomplete_folder(results: Results, tmp_path: Path, name: str) -> None:
    results.save(tmp_path)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).unlink()
    with pytest.raises(ModelError, match=name.replace(".", r"\.")):
        Results.load(tmp_path)
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ModelError, match=name.replace(".", r"\.")):
        Results.load(tmp_path)


def test_bolts_of_an_earlier_run_go(results: Results, tmp_path: Path) -> None:
    results.save(tmp_path)
    rocks = [bsm.Rock(name, unit_weight=25e3, young=1e9, poisson=0.2) for name in ("gneiss", "schist")]
    unbolted = bsm.Model(blocks=results.blocks, rocks=rocks, supports=[bsm.Fixed(boundary="bottom")])
    assert {"bolts.pvd", "bolts.csv"} <= {file.name for file in tmp_path.iterdir()}
    bsm.run(unbolted, bsm.Options(scheme="continuation")).save(tmp_path)
    assert not {"bolts.pvd", "bolts.csv"} & {file.name for file in tmp_path.iterdir()}
    assert Results.load(tmp_path).stages[0].bolts.count == 0


def test_table_of_bolts(results: Results, tmp_path: Path) -> None:
    results.save(tmp_path)
    with (tmp_path / "bolts.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    bolts = results.stages[0].bolts
    assert len(rows) == len(bolts.block)
    assert rows[0]["name"] == "Bölt"
    axial = [float(row["axial_force [N]"]) for row in rows if row["axial_force [N]"]]
    np.testing.assert_array_equal(axial, bolts.axial_force)
    np.testing.assert_array_equal([float(row["bond_force [N]"]) for row in rows], bolts.bond_force)
