"""Models built in Python, written as model.toml beside their results, and read back."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.model.joint_laws import JointResponse
from bsm_mesh.model.strength import with_strength
from bsm_mesh.modelfile.model_text import content_of, files_of_model
from bsm_mesh.results import Results
from tests.scenes import models, shapes

LINEAR = bsm.Options(scheme="linear", threads=1)


def everything() -> bsm.Model:
    """Return a model with one of everything that a model file can say."""
    blocks = models.framed(bsm.Blocks.from_polygons(shapes.grid(4, 3), rock=["gneiss", "mica schist"] * 6), 4, 3)
    blocks = blocks.with_joint("J1", lambda x, y: np.abs(y - 1) < 1e-9).with_joint("Störung", lambda x, y: x == 2)
    blocks = replace(blocks, excavations={"first heading": np.array([5], np.int32), "2": np.array([9, 10], np.int32)})
    return bsm.Model(
        title='One of "everything"\nÜ',
        blocks=blocks,
        rocks=[
            bsm.Rock(
                "gneiss", unit_weight=25e3, young=1e9, poisson=0.2, cohesion=1e6, friction=40, stiffness="triangle"
            ),
            bsm.Rock("mica schist", unit_weight=np.float64(24123.456789), young=2e9, poisson=0.1),
            bsm.Rock("unused", unit_weight=0),
        ],
        joints=[
            bsm.Joint("J1", 1e9, 2e8, law=bsm.Patton(friction=30, dilation=5, cohesion=1e4, residual_friction=28)),
            bsm.Joint("Störung", filling=bsm.Filling(thickness=0.1, young=1e8, poisson=0.3)),
            bsm.Joint("J3", 1e9, 1e8, law=bsm.MohrCoulomb(friction=35, cohesion=2e5), tensile_strength=1e3),
        ],
        default_joint="J3",
        supports=[
            bsm.Fixed(boundary="bottom"),
            bsm.NormalRoller(boundary="left"),
            bsm.Roller(point=(4, 1.5), direction=10),
            bsm.PrescribedDisplacement(blocks=[11], direction=90, displacement=-1e-5),
        ],
        loads=[
            bsm.Pressure(boundary="top", pressure=1e5),
            bsm.Pressure(boundary="right", pressure=(1e5, 0, -1e3)),
            bsm.Traction(boundary="top", traction=((1, 2, 3), 4)),
            bsm.InSituTraction(boundary="right"),
            bsm.PointLoad(block=1, point=(1.5, 0.5), force=(1, 2)),
        ],
        bolts=[
            bsm.Bolt(start=(0, 0.4), end=(2.8, 1.7), diameter=0.02, pretension=1e4, name="Bölt", stage="dug"),
            bsm.Bolt(
                start=(2.5, 2.9), end=(2.5, 0.2), diameter=0.03, kind="end_anchored", anchor_capacity=1e5, spacing=1.5
            ),
            bsm.Bolt(start=(0.2, 0.2), end=(0.2, 1.8), diameter=0.02, bond_stiffness=1e9, spacing=1.5, plate=1e5),
        ],
        gravity_direction=-90,
        gravity_horizontal=0.15,
        gravity_vertical=-0.05,
        contact_points="gauss",
        in_situ=bsm.InSitu(surface=[(0, 3), (4, 3.5)], k0="herget", surcharge=1e4),
        water=bsm.Water(table=[(0, 1.5), (3, 1.0)], head="parallel", joint_pressure={"J1": 1e3}),
        stages=[
            bsm.Stage(
                name="dug",
                excavate=["first heading", 9, ((2.2, 2.2), (2.8, 2.2), (2.5, 2.9))],
                relaxation=[0.4, 1.0],
                pressure=1e3,
                loads=[
                    bsm.Pressure(boundary="top", pressure=10.0),
                    bsm.EarthPressure(
                        boundary="right",
                        state="active",
                        unit_weight=19e3,
                        friction=32,
                        surface=((4, 3), (9, 3.5)),
                        theory="coulomb",
                        wall_friction=20,
                        surcharge=1e4,
                        factor=1.35,
                    ),
                ],
            ),
            bsm.Stage(name="filled", fill=[9], water=bsm.Water(), gravity=(0.0, 0.0)),
            bsm.Stage(name="rain", strength={"J1": 0.8, "*": 0.9, "rock:gneiss": 0.5}, gravity=(-0.1, 0.05)),
        ],
    )


@pytest.mark.heavy
def test_what_was_run_is_read_back_equal(tmp_path: Path) -> None:
    model = everything()
    results = bsm.run(model, LINEAR)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        results.save(tmp_path / "out")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.MeshWarning)
        read = bsm.load(tmp_path / "out/model.toml")
    assert read == model
    assert (read.title, read.digest) == (model.title, results.model_digest)
    again = bsm.run(read, LINEAR)
    np.testing.assert_array_equal(again.stages[-1].displacement, results.stages[-1].displacement)
    again.save(tmp_path / "out")  # over the mesh from which it was read
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.MeshWarning)
        assert bsm.load(tmp_path / "out/model.toml") == model


def test_the_options_are_in_it_too() -> None:
    options = bsm.Options(scheme="wang", tolerance=1e-5, displacement_limit=3.0, sliding_stiffness=0.1, threads=2)
    content = content_of(everything(), options)["solver"]
    assert bsm.Options(**content) == options
    assert "displacement_limit" not in content_of(everything(), LINEAR)["solver"]


LAWS = (
    bsm.BartonBandis(jrc=8, jcs=80e6, residual_friction=28, joint_length=2.0, roughness_wears=True),
    bsm.LadanyiArchambault(friction=30, dilation=12, jcs=60e6),
    bsm.MohrCoulomb(friction=40, cohesion=1e5, residual_friction=30, residual_cohesion=0.0, softening_slip=5e-3),
)


def test_every_law_is_read_as_it_was_written(tmp_path: Path) -> None:
    model = everything()
    stiff = {"normal_stiffness": 5e9, "shear_stiffness": 1e9, "filling": None}
    joints = [replace(j, law=law, max_closure=2e-4, **stiff) for j, law in zip(model.joints, LAWS, strict=False)]
    assert len(joints) == len(LAWS)
    changed = model.replace(joints=[*joints, *model.joints[len(joints) :]])
    bsm.run(changed, LINEAR).save(tmp_path / "out")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.MeshWarning)
        assert bsm.load(tmp_path / "out/model.toml") == changed


@pytest.mark.heavy
def test_an_unusual_unit_weight_is_written_with_its_unit(tmp_path: Path) -> None:
    """A model file refuses a plain number below the usual ones."""
    blocks = bsm.Blocks.from_polygons(shapes.grid(1, 2), rock="rock")
    rock, joint = bsm.Rock("rock", unit_weight=26.0), bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30))
    model = bsm.Model(blocks=blocks, rocks=[rock], joints=[joint], default_joint="J", supports=[bsm.Fixed(blocks=[0])])
    folder = bsm.run(model).save(tmp_path / "out")
    assert 'unit_weight = "26.0 N/m^3"' in (folder / "model.toml").read_text()
    again = bsm.run(folder / "model.toml", output=tmp_path / "again")
    assert again.model is not None
    assert again.model.rocks[0].unit_weight == 26.0
    assert bsm.load(tmp_path / "again" / "model.toml").rocks[0].unit_weight == 26.0


@pytest.mark.heavy
def test_given_stress(tmp_path: Path) -> None:
    model = everything()
    loads = [load for load in model.loads if not isinstance(load, bsm.InSituTraction)]
    stress = bsm.InSitu(stress={"xx": (-1e5, 0, 2), "yy": -1e5})
    for in_situ in (stress, bsm.InSitu(method="gravity"), None):
        changed = model.replace(in_situ=in_situ, loads=loads, water=None)
        bsm.run(changed, LINEAR).save(tmp_path / "out")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", bsm.MeshWarning)
            assert bsm.load(tmp_path / "out/model.toml") == changed


def test_blocks_whose_corners_differ_by_rounding(tmp_path: Path) -> None:
    """They touch, and are one point in the mesh; the file says so."""
    corners = [np.array(corners) + 1e-13 * number for number, corners in enumerate(shapes.grid(3, 2))]
    blocks = bsm.Blocks.from_polygons(corners, rock="gneiss")
    model = bsm.Model(blocks=blocks, rocks=[bsm.Rock("gneiss", 25e3, 1e9, 0.2)], supports=[bsm.Fixed(blocks=[0, 1, 2])])
    bsm.run(model, LINEAR).save(tmp_path / "out")
    assert "# Corners that touch within rounding are one point in mesh.vtu" in (tmp_path / "out/model.toml").read_text()
    read = bsm.load(tmp_path / "out/model.toml")
    np.testing.assert_allclose(read.blocks.vertices, model.blocks.vertices, atol=1e-12)
    assert len(set(read.blocks.nodes)) == len(set(model.blocks.nodes))


class Own:
    """A law of a user's own."""

    def respond(self, *given: Any) -> JointResponse:
        return bsm.Patton(friction=30).respond(*given)


def test_what_a_model_file_cannot_say_is_told_at_once(tmp_path: Path) -> None:
    model = everything()
    edges = len(model.blocks.boundaries["top"])
    strange = model.replace(
        joints=[*model.joints[:2], replace(model.joints[2], law=Own())],
        loads=[*model.loads, bsm.EdgeTractions(boundary="top", values=np.zeros((edges, 2, 2)))],
        bolts=[replace(model.bolts[2], plate=math.inf, name="P")],
    )
    with pytest.raises(bsm.ModelError) as caught:
        files_of_model(strange, LINEAR)
    words = (
        "joint 'J3': its law is Own",
        "load 6: EdgeTractions has no form",
        "bolt 'P': a plate of unlimited capacity",
    )
    assert len(caught.value.faults) == 3
    for fault, word in zip(sorted(caught.value.faults), sorted(words), strict=True):
        assert word in fault
    results = bsm.run(model.replace(loads=strange.loads), LINEAR)
    with pytest.warns(bsm.ResultsWarning, match=r"model\.toml is not written: load 6: EdgeTractions"):
        results.save(tmp_path / "out")
    assert Results.load(tmp_path / "out").status == "no_verdict"
    assert not (tmp_path / "out/model.toml").exists()


def test_a_text_that_no_file_can_hold() -> None:
    with pytest.raises(bsm.ModelError, match=r"title = .*ud800.*: half a character"):
        files_of_model(everything().replace(title="half a character: \ud800"), LINEAR)


def test_names_that_a_mesh_cannot_keep() -> None:
    model = everything()
    blocks = replace(model.blocks, boundaries={**model.blocks.boundaries, "a\xa0b": np.array([0], np.int32)})
    with pytest.raises(bsm.ModelError, match=r"boundary 'a\\xa0b': a mesh file keeps no such name"):
        files_of_model(model.replace(blocks=blocks), LINEAR)


@pytest.mark.heavy
def test_results_that_were_read_back_do_not_hold_their_model(tmp_path: Path) -> None:
    bsm.run(everything(), LINEAR).save(tmp_path / "out")
    with pytest.warns(bsm.ResultsWarning, match="were read from a folder"):
        Results.load(tmp_path / "out").save(tmp_path / "again")
    assert Results.load(tmp_path / "again").model_digest == everything().digest


def test_a_law_at_part_of_its_strength_has_no_form() -> None:
    """Its name alone is one that a model file knows."""
    model = everything()
    law = bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28)
    curved = model.replace(joints=[*model.joints[:2], replace(model.joints[2], law=law)])
    with pytest.raises(bsm.ModelError, match=r"its law is BartonBandis, its shear forces over 2; a model file knows"):
        files_of_model(with_strength(curved, {"J3": 0.5}), LINEAR)
