"""Models for other programs: Abaqus read back, UDEC parsed, scripts as they are; run where the programs are there."""

from __future__ import annotations

import ast
import csv
import dataclasses
import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.commands.exporting import ENDINGS
from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.exports import PROGRAMS, export
from bsm_mesh.errors import ModelError
from tests.scenes.arch import arch
from tests.scenes.models import model_of
from tests.scenes.shapes import SQUARE, rectangle
from tests.scenes.small_case import MODEL, Case
from tests.unit.test_run_writer import staged

L_SHAPE = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], dtype=float)


def test_abaqus_read_back_is_the_same_mesh(tmp_path: Path) -> None:
    """Blocks, areas, rocks, joints on both sides, boundaries; what it cannot say is listed."""
    model = staged()
    remarks = export(model, "abaqus", tmp_path / "a.inp")
    blocks, report = read_mesh(tmp_path / "a.inp")
    assert (blocks.count, blocks.rock_names) == (6, ("gneiss",))
    assert_allclose(blocks.moments.area, model.blocks.moments.area, rtol=1e-12)
    assert_allclose(blocks.moments.centroid, model.blocks.moments.centroid, atol=1e-12)
    assert report.groups["joint:J1"] == 14
    assert {name: ids.tolist() for name, ids in blocks.excavations.items()} == {"one": [5], "two": [4]}
    assert {n: len(e) for n, e in blocks.boundaries.items()} == {n: len(e) for n, e in model.blocks.boundaries.items()}
    assert [text for text in remarks if "stage" in text or "bolt" in text or "water" in text] == [
        *("2 stages (first, second)", "1 bolt", "groundwater")
    ]
    text = (tmp_path / "a.inp").read_text()
    loads = [line.split(", ") for line in text.partition("*CLOAD\n")[2].partition("*")[0].splitlines()]
    assert sum(float(value) for _, axis, value in loads if axis == "2") == pytest.approx(-3e5)
    assert {axis for _, axis, _ in loads} == {"2"}


def test_concave_blocks_become_triangles_and_junctions_are_told(tmp_path: Path) -> None:
    model = model_of([L_SHAPE, rectangle(1, 1, 2, 2)])
    remarks = export(model, "abaqus", tmp_path / "a.inp")
    blocks, _ = read_mesh(tmp_path / "a.inp", blocks="elements")
    assert_allclose(blocks.moments.area.sum(), 5 + 1)
    assert any("T-junctions" in text for text in remarks)
    with pytest.raises(ModelError, match="block 0: concave, which this program does not take; mesh finer"):
        export(model, "lmgc90", tmp_path / "a.py")


def test_udec_has_every_block_joint_and_load(tmp_path: Path) -> None:
    model = arch(5, 0.3, friction=40)
    export(model, "udec", tmp_path / "a.dat")
    lines = (tmp_path / "a.dat").read_text().splitlines()
    outlines = [
        np.array([point.split(",") for point in line.split()[1:]], dtype=float)
        for line in lines
        if line.startswith("block ")
    ]
    blocks = model.blocks
    assert len(outlines) == blocks.count
    assert_allclose(np.concatenate(outlines), blocks.vertices, atol=1e-8)
    assert 'prop jmat=2 jkn=1e+10 jks=1e+10 jfric=40 jcoh=0 jten=0 ; joint "J"' in lines
    assert sum(line.startswith("change jmat=2 range ") for line in lines) == 6  # joints of five stones
    assert sum(line.startswith("fix range ") for line in lines) == 2
    assert "gravity 0 -9.81" in lines


@pytest.mark.parametrize(("program", "ending"), [("abaqus", "inp"), ("udec", "dat"), ("3dgrid", "3dgrid")])
def test_a_title_of_two_lines_is_no_command(tmp_path: Path, program: str, ending: str) -> None:
    export(arch(3, 0.3, friction=40).replace(title="an arch\n*STEP"), program, tmp_path / f"a.{ending}")
    for path in tmp_path.iterdir():
        lines = path.read_text().splitlines()
        assert any("an arch\\n*STEP of bsm-mesh, in m, N, Pa, kg/m^3" in line for line in lines)
        assert not any(line.startswith("*STEP of") for line in lines)


def test_udec_is_told_of_a_short_joint_after_the_long_one_around_it(tmp_path: Path) -> None:
    """The box of an oblique face holds faces of other joints; the last command on a contact is the one that holds."""
    polygons = [[(0, 0), (8, 8), (7, 8), (0, 1)], [(0, 0), (1, 0), (8, 7), (8, 8)]]  # along the diagonal, and two above
    polygons += [[(1, 6), (2, 6), (2, 7), (1, 7)], [(2, 6), (3, 6), (3, 7), (2, 7)]]
    for order in ([0, 1, 2, 3], [2, 3, 0, 1]):
        blocks = bsm.Blocks.from_polygons([np.array(polygons[k], dtype=float) for k in order], rock="stone")
        upright = np.abs(blocks.edge_vectors[:, 0]) < 1e-9
        blocks = dataclasses.replace(
            blocks, joint_names=("A", "B"), edge_joint=np.where(upright, 1, 0).astype(np.int32)
        )
        model = bsm.Model(
            blocks=blocks,
            rocks=[bsm.Rock("stone", unit_weight=25e3)],
            joints=[bsm.Joint(name, 1e10, 1e10, law=bsm.MohrCoulomb(friction=30)) for name in "AB"],
            supports=[bsm.Fixed(blocks=[0])],
        )
        remarks = export(model, "udec", tmp_path / "a.dat")
        text = (tmp_path / "a.dat").read_text().splitlines()
        told = [line for line in text if "range" in line and "jmat" in line and "angle" not in line]
        assert [line.split()[1] for line in told] == ["jmat=2", "jmat=3"]
        assert told[1] == "change jmat=3 range 1.999,2.001 5.999,7.001"
        assert sum("where different joints meet" in text for text in remarks) == 1
        # The oblique face's box holds the short one: the contacts of each are distinguished by angle, in any half
        # circle.
        angles = [line.split(" angle ")[1] for line in text if line.startswith("change") and " angle " in line]
        assert angles == ["-135.5,-134.5", "44.5,45.5", "224.5,225.5"]


def test_a_grid_of_3dec_has_closed_prisms_joints_and_commands(tmp_path: Path) -> None:
    """Faces clockwise from outside: by the divergence theorem each block's volume is its area times 1 m, negative."""
    model = arch(5, 0.3, friction=40)
    remarks = export(model, "3dgrid", tmp_path / "a.3dgrid")
    rows = [line.split() for line in (tmp_path / "a.3dgrid").read_text().splitlines() if not line.startswith("*")]
    points = {int(row[1]): np.array(row[2:], dtype=float) for row in rows if row[0] == "G"}
    faces = {int(row[1]): [points[int(word)] for word in row[2:]] for row in rows if row[0] == "F"}
    volumes = []
    for row in (row for row in rows if row[0] == "B"):
        assert row[2:4] == ["1", "F"]
        fans = [(f[0], f[k], f[k + 1]) for f in (faces[int(word)] for word in row[4:]) for k in range(1, len(f) - 1)]
        volumes.append(sum(np.linalg.det(fan) for fan in fans) / 6)
    assert_allclose(volumes, -model.blocks.moments.area)
    assert [pair for row in rows if row[0] == "JS" for pair in row[2:]] == ["1-2", "1-6", "2-3", "3-4", "4-5", "5-7"]
    lines = (tmp_path / "a.dat").read_text().splitlines()
    assert "block import 'a.3dgrid'" in lines
    assert sum(line.startswith("block group 'b") for line in lines) == model.blocks.count
    assert "block fix range group 'bsm=b6'" in lines
    told = "block contact property stiffness-normal 1e+10 stiffness-shear 1e+10 friction 40 cohesion 0 tension 0"
    assert f"{told} range group-intersection 'bsm=b1' 'bsm=b6'" in lines
    assert "model gravity 0 0 -9.81" in lines
    assert remarks == ("blocks are prisms of 1 m that nothing holds out of the plane but their own contacts",)
    with pytest.raises(ModelError, match=r"give a name that ends in \.3dgrid"):
        export(model, "3dgrid", tmp_path / "a.txt")


def test_udec_tells_crossing_joints_apart_by_their_angle(tmp_path: Path) -> None:
    """Four squares, joints A level and B upright: contacts at the crossing are in boxes of both, at other angles."""
    blocks = bsm.Blocks.from_polygons([rectangle(x, y, x + 1, y + 1) for x in (0, 1) for y in (0, 1)], rock="stone")
    level = np.abs(blocks.edge_vectors[:, 1]) < 1e-9
    blocks = dataclasses.replace(blocks, joint_names=("A", "B"), edge_joint=np.where(level, 0, 1).astype(np.int32))
    joints = [bsm.Joint(name, 1e10, 1e10, law=bsm.MohrCoulomb(friction=30)) for name in "AB"]
    rock, held = bsm.Rock("stone", unit_weight=25e3), bsm.Fixed(blocks=[0])
    remarks = export(bsm.Model(blocks=blocks, rocks=[rock], joints=joints, supports=[held]), "udec", tmp_path / "a.dat")
    told = [
        (line.split()[1], line.split(" angle ")[1])
        for line in (tmp_path / "a.dat").read_text().splitlines()
        if line.startswith("change") and " angle " in line
    ]
    assert sorted(set(told)) == [
        *(("jmat=2", "-0.5,0.5"), ("jmat=2", "-180.5,-179.5"), ("jmat=2", "179.5,180.5")),
        *(("jmat=3", "-90.5,-89.5"), ("jmat=3", "269.5,270.5"), ("jmat=3", "89.5,90.5")),
    ]
    assert len(told) == 3 * 4
    assert "where different joints meet: a contact of two corners there takes the joint of the shorter face" in remarks


@pytest.mark.parametrize("program", ["compas_dem", "lmgc90"])
def test_scripts_hold_the_model(tmp_path: Path, program: str) -> None:
    model = arch(5, 0.3, friction=40).replace(loads=[bsm.PointLoad(block=2, point=(0, 1.0), force=(1e3, -2e3))])
    remarks = export(model, program, tmp_path / "a.py")
    tree = ast.parse((tmp_path / "a.py").read_text())
    (data,) = (
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "DATA"
    )
    assert_allclose(np.concatenate(data["blocks"]), model.blocks.vertices)
    assert_allclose(data["density"], 25e3 / 9.81)
    assert data["fixed"] == [5, 6]
    assert data["friction"] == pytest.approx(np.tan(np.radians(40)))
    x, y, moment = data["loads"]["2"]
    assert (x, y) == (1e3, -2e3)
    assert moment == pytest.approx(-1e3 * (1.0 - model.blocks.moments.centroid[2, 1]))
    assert "stiffness of joints: contacts are rigid" in remarks
    assert any("RBE and CRA take weights alone" in text for text in remarks) == (program == "compas_dem")


def test_one_friction_for_all_is_the_lowest(tmp_path: Path) -> None:
    model = model_of([rectangle(-1, -1, 2, 0), SQUARE])
    second = bsm.Joint("K", 1e9, 1e9, law=bsm.MohrCoulomb(friction=20, cohesion=1e3))
    model = model.replace(joints=[*model.joints, second])
    remarks = export(model, "lmgc90", tmp_path / "a.py")
    assert "one coefficient of friction for all contacts: that of joint 'K', the lowest" in remarks
    assert "joint 'K': cohesion and tensile strength" in remarks


def test_a_law_without_friction_is_refused_but_by_elastic_joints(tmp_path: Path) -> None:
    law = bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=28)
    model = model_of([rectangle(-1, -1, 2, 0), SQUARE], law=law)
    for program in ("udec", "lmgc90", "compas_dem"):
        with pytest.raises(ModelError, match="the law BartonBandis has no friction and cohesion to export"):
            export(model, program, tmp_path / "a.py")
    assert any(
        "strength; its cohesive elements are elastic" in text for text in export(model, "abaqus", tmp_path / "a")
    )


def test_names_that_are_refused(tmp_path: Path) -> None:
    model = arch(5, 0.3)
    with pytest.raises(ModelError, match=r"no export to 'flac'; known: 3dgrid, abaqus, compas_dem, lmgc90, udec"):
        export(model, "flac", tmp_path / "a")
    with pytest.raises(ModelError, match=r"give a name that ends in \.py"):
        export(model, "lmgc90", tmp_path / "a.txt")
    with pytest.raises(ModelError, match="would replace the package of that name"):
        export(model, "compas_dem", tmp_path / "compas_dem.py")
    with pytest.raises(ModelError, match=r"cannot write .*choose another folder"):
        export(model, "udec", tmp_path / "nowhere" / "a.dat")


def test_the_command(case: Case) -> None:
    assert set(ENDINGS) == set(PROGRAMS)
    case.write("model.toml", MODEL)
    done = case.run("export", "model.toml", "--to", "abaqus")
    assert done.code == 0
    assert "written to model_abaqus.inp" in done.out
    told = json.loads(case.run("export", "model.toml", "--to", "udec", "-o", "a.dat", "--json").out)
    assert (told["file"], told["blocks"]) == ("a.dat", 4)
    assert case.run("export", "model.toml", "--to", "flac").code == 2


@pytest.mark.slow
@pytest.mark.parametrize(("program", "package", "first"), [("lmgc90", "lmgc90", "400"), ("compas_dem", "cra", "RBE")])
def test_others_find_the_forces_of_an_arch(tmp_path: Path, program: str, package: str, first: str) -> None:
    """Statics alone does not give them: rigid contacts and stiff springs agree to a thousandth of the weight."""
    if find_spec(f"compas_{package}") is None:
        pytest.skip(f"pip install compas_dem compas_{package}")
    model = arch(9, 0.2)
    export(model, program, tmp_path / "a.py")
    subprocess.run([sys.executable, "a.py", first], cwd=tmp_path, check=True, capture_output=True)
    weight = 25e3 * model.blocks.moments.area[:9].sum()
    with (tmp_path / "forces.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    theirs = {frozenset((int(r["block_a"]), int(r["block_b"]))): abs(float(r["force_y [N/m]"])) for r in rows}
    contacts = bsm.run(model).stages[-1].contacts
    for pair in {frozenset(p) for p in zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)}:
        mine = [{a, b} == pair for a, b in zip(contacts.block_a, contacts.block_b, strict=True)]
        assert abs(contacts.force[mine].sum(axis=0)[1]) == pytest.approx(theirs[pair], abs=2e-3 * weight)
    if program == "lmgc90":  # a table of corners, block after block: supports stay, stones settle
        with (tmp_path / "movements.csv").open(newline="") as file:
            block, x, y, *moved = np.array([list(map(float, row.values())) for row in csv.DictReader(file)]).T
        assert_allclose(np.column_stack([x, y]), model.blocks.vertices)
        size = np.hypot(*moved)
        assert size[np.isin(block, [9, 10])].max() < 1e-9 < size.max() < 1e-3


@pytest.mark.parametrize(
    ("law", "left"),
    [
        (bsm.Patton(friction=30), False),  # the law of a joint with friction alone
        (bsm.Patton(friction=30, residual_friction=30), False),
        (bsm.Patton(friction=30, dilation=10, cohesion=1e5), True),
        (bsm.MohrCoulomb(friction=30, cohesion=1e5), False),
        (bsm.MohrCoulomb(friction=30, cohesion=1e5, residual_cohesion=0), True),
    ],
)
def test_a_law_of_friction_and_cohesion_is_exported_as_a_whole(law: object, left: bool, tmp_path: Path) -> None:
    model = model_of([SQUARE, rectangle(0, 1, 1, 2)])
    joint = dataclasses.replace(model.joints[0], law=law)
    remarks = export(model.replace(joints=[joint, *model.joints[1:]]), "udec", tmp_path / "a.dat")
    assert any("beyond friction and cohesion" in remark for remark in remarks) == left
