"""Joint sets: how much slips and is open, in the table of a run and as CSV."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.folder.own_files import own_files
from bsm_mesh.results import Results
from bsm_mesh.results.joint_sets import joint_sets
from bsm_mesh.text.tables import joint_rows
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import JOINT, LINEAR, MODEL, Case
from tests.unit.test_snapshots import MOVING, pushed

NAMES = ("contacts.csv", "supports.csv", "joints.csv")  # and blocks.csv


@pytest.fixture(scope="module")
def hanging() -> Results:
    """Return a slab on two columns, 1 m and 2 m wide, and a stone that lost the slab's lower side above it."""
    polygons = [rectangle(0, 0, 1, 1), rectangle(3, 0, 5, 1), rectangle(0, 1, 5, 2), rectangle(1.5, 0, 2.5, 1)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock")
    blocks = blocks.with_joint("roof", lambda x, y: (y == 1) & (x >= 1.5) & (x <= 2.5))
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=25e3)],
        joints=[
            bsm.Joint("bed", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30)),
            bsm.Joint("roof", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30)),
            bsm.Joint("glue", 1e9, 1e9),
        ],
        default_joint="bed",
        supports=[bsm.Fixed(blocks=[0, 1])],
        stages=[bsm.Stage(name="none")],
    )
    return bsm.run(model, MOVING)


def test_length_and_pressure_are_those_of_the_faces(hanging: Results) -> None:
    """The columns carry the slab on 3 m; the stone falls off the slab, and its joint is open."""
    sets = {one.name: one for one in joint_sets(hanging, hanging.stages[-1])}
    assert set(sets) == {"bed", "roof"}
    bed, roof = sets["bed"], sets["roof"]
    assert (bed.length, roof.length) == (pytest.approx(3.0, rel=1e-3), pytest.approx(1.0, rel=1e-6))
    assert (roof.open, roof.slipping, roof.pressure) == (1.0, 0.0, 0.0)
    assert roof.greatest_opening == pytest.approx(-hanging.stages[-1].displacement[3, 1], abs=1e-4)  # the slab settles
    assert bed.open == pytest.approx(0, abs=1e-3)
    assert bed.pressure * bed.length == pytest.approx(5 * 25e3, rel=1e-3)


def test_the_share_that_slips() -> None:
    """A block that is pushed beyond its friction slides on and on: its 1 m of base slips, the wall's does not."""
    model = pushed().replace(supports=[bsm.Fixed(blocks=[0])], blocks=pushed().blocks)
    seen: list[tuple[float, float]] = []

    def look(record: object, state: object) -> None:
        now = state()  # type: ignore[operator]
        (one,) = joint_sets(now, now.stages[-1])
        seen.append((one.length, one.slipping))

    bsm.run(model, bsm.Options(scheme="continuation", max_steps=3), snapshot=look)
    assert seen[0][0] == pytest.approx(2.0, rel=1e-3)
    assert seen[0][1] == pytest.approx(0.5, rel=1e-3)


def test_only_joints_that_can_slip_are_told(hanging: Results) -> None:
    assert [row[0] for row in joint_rows(hanging)] == ["bed", "roof"]
    assert joint_rows(hanging)[1][:5] == ("roof", "1 m", "0 %", "100 %", "0 Pa")
    assert hanging.model is not None
    without = hanging.model.replace(joints=[bsm.Joint(name, 1e9, 1e9) for name in ("bed", "roof")])
    assert joint_rows(bsm.run(without.replace(supports=[bsm.Fixed(blocks=[0, 1, 3])]), MOVING)) == []
    linear = bsm.run(hanging.model.replace(supports=[bsm.Fixed(blocks=[0, 1, 3])]), bsm.Options(scheme="linear"))
    assert joint_rows(linear) == []


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_tables_hold_what_the_results_hold(hanging: Results, tmp_path: Path) -> None:
    hanging.save(tmp_path, tables=True)
    assert set(NAMES) <= own_files(tmp_path)
    stage = hanging.stages[-1]
    contacts, supports, joints = (read(tmp_path / name) for name in NAMES)
    np.testing.assert_array_equal([float(row["normal_force [N/m]"]) for row in contacts], stage.contacts.normal_force)
    np.testing.assert_array_equal([float(row["y [m]"]) for row in contacts], stage.contacts.point[:, 1])
    assert {row["joint"] for row in contacts} <= {"bed", "roof", "glue"}
    assert {row["status"] for row in contacts} <= {"sticking", "slipping", "open"}
    np.testing.assert_array_equal([float(row["force_y [N/m]"]) for row in supports], stage.supports.reaction[:, 1])
    assert [(row["stage_name"], row["joint"]) for row in joints] == [("initial", "bed"), ("initial", "roof")]
    assert float(joints[1]["open_share"]) == 1.0
    assert Results.load(tmp_path).status == "unstable"
    hanging.save(tmp_path)
    assert not set(NAMES) & {path.name for path in tmp_path.iterdir()}


@pytest.mark.heavy
def test_on_request(case: Case) -> None:
    """The command prints the table of joints; the files come with --tables, or where [output] says so."""
    case.write("model.toml", MODEL)
    plain = case.run("run", "model.toml")
    assert "mean pressure" in plain.out
    assert "J1" in plain.out
    at = plain.out.splitlines().index(next(line for line in plain.out.splitlines() if "mean pressure" in line))
    assert max(map(len, plain.out.splitlines()[at - 2 : at + 3])) <= 80
    assert not any((case.folder / "out/model" / name).exists() for name in NAMES)
    asked = case.run("run", "model.toml", "--tables")
    assert "blocks.csv, contacts.csv, supports.csv, joints.csv" in asked.out
    assert all((case.folder / "out/model" / name).exists() for name in NAMES)
    assert 'tables = "csv"' in (case.folder / "out/model/model.toml").read_text(encoding="utf-8")
    case.write("model.toml", MODEL + "\n[output]\ntables = true\n")
    told = json.loads(case.run("run", "model.toml", "-o", "other", "--json").out)
    assert all((case.folder / "other" / name).exists() for name in NAMES)
    assert [one["name"] for one in told["joints"]] == ["J1", "unjointed rock"]
    case.write("model.toml", MODEL.replace(JOINT, JOINT.replace("friction = 35\n", "")) + LINEAR)
    assert "mean pressure" not in case.run("run", "model.toml").out


@pytest.mark.parametrize("direction", [0, 180])
def test_a_face_slips_as_far_as_its_block_whichever_corners_carry_it(direction: int) -> None:
    """A block 8 m long is pushed 20 mm along a plane: the contact at one end passes on to the other block's corner."""
    base, block = [(-30, -6), (30, -6), (30, 0), (6, 0), (-2, 0), (-30, 0)], rectangle(-2, 0, 6, 3)
    push = bsm.PrescribedDisplacement(blocks=[1], direction=direction, displacement=0.02)
    supports = [bsm.Fixed(blocks=[0]), push]
    model = model_of([base, block], gamma=28e3, friction=12, kn=2e9, ks=1e9, supports=supports)
    stage = bsm.run(model).stages[-1]
    right, _, turn = stage.displacement[1]
    assert abs(right) == pytest.approx(0.02)
    assert stage.contacts.slip == pytest.approx([-(right + 1.5 * turn)] * 2, abs=1e-9)  # of its base, left positive
