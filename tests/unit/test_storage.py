"""Results to a folder and back."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import scenes

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.results import ContactForces, Results, StageResult, SupportForces


@pytest.fixture(scope="module")
def results() -> Results:
    blocks = scenes.framed(bsm.Blocks.from_polygons(scenes.grid(3, 2), rock=["gneiss", "schist"] * 3), 3, 2)
    return bsm.run(
        bsm.Model(
            title="Grid of Ümläut",
            blocks=blocks,
            rocks=[bsm.Rock(name, unit_weight=25e3, young=1e9, poisson=0.2) for name in ("gneiss", "schist")],
            joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=2e8, law=bsm.Patton(friction=30))],
            default_joint="J1",
            supports=[bsm.Fixed(boundary="bottom"), bsm.Roller(boundary="left", direction=10)],
            loads=[bsm.Pressure(boundary="top", pressure=1e5)],
        )
    )


def assert_same(one: object, two: object) -> None:
    for field in fields(one):  # type: ignore[arg-type]
        a, b = getattr(one, field.name), getattr(two, field.name)
        if isinstance(a, ContactForces | SupportForces):
            assert_same(a, b)
        else:
            np.testing.assert_array_equal(a, b, err_msg=field.name)


def test_round_trip(results: Results, tmp_path: Path) -> None:
    assert results.save(tmp_path / "deep" / "out") == tmp_path / "deep" / "out"
    read = Results.load(tmp_path / "deep" / "out")
    for name in ("joint_names", "scheme", "linear_solver", "model_digest", "title", "status"):
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
    "name", ["summary.json", "blocks.pvd", "blocks_0000.vtu", "contacts.pvd", "supports_0000.vtu", "history.csv"]
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
