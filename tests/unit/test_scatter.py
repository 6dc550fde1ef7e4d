"""Scatter of a joint's strength from face to face: classes, both sides of a face, seeds, water in joints."""

from __future__ import annotations

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.studies.scatter import Scatter, scatter_joint
from tests.scenes.shapes import grid

FRICTION = Scatter(joint="J1", strength="friction", deviation=2.0)
STIFF = {"normal_stiffness": 1e9, "shear_stiffness": 1e9}


def wall(law: bsm.MohrCoulomb | None = None, **changes: object) -> bsm.Model:
    """Return a wall of 6 x 6 blocks whose level joints are J1, the others the default joint J2."""
    blocks = bsm.Blocks.from_polygons(grid(6, 6), rock="a")
    level = np.abs(blocks.edge_vectors[:, 1]) < 1e-9
    blocks = blocks.with_edge_joints(np.where(level, 0, -1).astype(np.int32), ("J1",))
    given: dict[str, object] = {
        "blocks": blocks,
        "rocks": [bsm.Rock("a", unit_weight=26e3)],
        "joints": [
            bsm.Joint("J1", law=law or bsm.MohrCoulomb(friction=30.0, cohesion=1e3, residual_friction=25.0), **STIFF),
            bsm.Joint("J2", law=bsm.MohrCoulomb(friction=20.0), **STIFF),
        ],
        "default_joint": "J2",
        "supports": [bsm.Fixed(blocks=[0, 1, 2, 3, 4, 5])],
    }
    return bsm.Model(**{**given, **changes})  # type: ignore[arg-type]


def frictions(model: bsm.Model) -> np.ndarray:
    """Return the friction of every edge; NaN where it has no joint."""
    by_name = {joint.name: joint.law.friction for joint in model.joints}  # type: ignore[union-attr]
    names = np.array([by_name[name] for name in model.blocks.joint_names])
    return np.where(model.blocks.edge_joint < 0, np.nan, names[model.blocks.edge_joint])


def test_classes_have_the_deviation_that_is_given() -> None:
    for classes in (2, 9):
        offsets = Scatter(joint="J1", strength="friction", deviation=2.0, classes=classes).offsets
        assert (offsets.mean(), offsets.std()) == pytest.approx((0, 2))
        assert (np.diff(offsets) > 0).all()


def test_every_face_has_its_own_and_both_sides_the_same() -> None:
    model = scatter_joint(wall(), FRICTION, (1, 0))
    assert [joint.name for joint in model.joints] == ["J2", *(f"J1~{k}" for k in range(1, 10))]
    assert [joint.law.residual_friction for joint in model.joints[1:]] == pytest.approx(25 + FRICTION.offsets)  # type: ignore[union-attr]
    found = frictions(model)
    assert np.isnan(found).tolist() == (wall().blocks.edge_joint < 0).tolist()
    one, other = model.blocks.edge_table.pairs()
    np.testing.assert_array_equal(found[one], found[other])
    assert len(np.unique(found[np.isfinite(found)])) == 9


def test_a_seed_draws_the_same() -> None:
    one, same, other = (frictions(scatter_joint(wall(), FRICTION, seed)) for seed in ((1, 0), (1, 0), (1, 1)))
    np.testing.assert_array_equal(one, same)
    assert (one != other)[np.isfinite(one)].any()


def test_the_default_joint_scatters_where_no_edge_bears_one() -> None:
    model = scatter_joint(wall(), Scatter(joint="J2", strength="friction", deviation=1.0), (1, 0))
    found = frictions(model)
    level = wall().blocks.edge_joint == 0
    assert (found[level] == 30).all()
    assert (np.abs(found[~level] - 20) > 0).any()
    assert model.default_joint == "J2"  # for contacts that arise


@pytest.mark.heavy
def test_it_decides_where_faces_slip() -> None:
    """A pile on a tilt just below its friction is at rest; where some faces have less they slip."""
    pile = bsm.Blocks.from_polygons(grid(1, 8), rock="a")
    level = np.abs(pile.edge_vectors[:, 1]) < 1e-9
    model = wall(
        bsm.MohrCoulomb(friction=6.0),
        blocks=pile.with_edge_joints(np.where(level, 0, -1).astype(np.int32), ("J1",)),
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-90.0 + 5.0,
    )
    assert bsm.run(model).status == "stable"
    scattered = scatter_joint(model, Scatter(joint="J1", strength="friction", deviation=2.0), (1, 0))
    weakest = min(frictions(scattered)[np.isfinite(frictions(scattered))])
    assert weakest < 5
    assert bsm.run(scattered).status == "unstable"


def test_pressure_in_a_joint_is_that_in_its_classes() -> None:
    model = scatter_joint(wall(water=bsm.Water(joint_pressure={"J1": 1e3, "J2": 2e3})), FRICTION, (1, 0))
    assert model.water is not None
    assert dict(model.water.joint_pressure) == {"J2": 2e3, **{f"J1~{k}": 1e3 for k in range(1, 10)}}


@pytest.mark.parametrize(
    ("scatter", "says"),
    [
        (Scatter(joint="J3", strength="friction", deviation=1.0), "no joint 'J3'; did you mean"),
        (Scatter(joint="J1", strength="friction", deviation=40.0), "joint.J1.friction"),
        (Scatter(joint="J1", strength="cohesion", deviation=1e4), "cohesion"),
    ],
)
def test_what_cannot_scatter(scatter: Scatter, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        scatter_joint(wall(), scatter, (1, 0))


def test_an_elastic_joint_has_nothing_to_scatter() -> None:
    model = wall(joints=[bsm.Joint("J1", **STIFF), bsm.Joint("J2", **STIFF)])
    with pytest.raises(ModelError, match="the joint has no friction; give it a law"):
        scatter_joint(model, FRICTION, (1, 0))


@pytest.mark.parametrize("joint", ["J1", "J2"])
def test_what_a_stage_leaves_of_a_joint_is_left_of_all_its_classes(joint: str) -> None:
    model = wall(stages=[bsm.Stage(name="rain", strength={joint: 0.5})])
    scattered = scatter_joint(model, Scatter(joint=joint, strength="friction", deviation=1.0, classes=3), (1, 0))
    ((name, strength),) = [(stage.name, dict(stage.strength)) for stage in scattered.stages]
    kept = {joint: 0.5} if joint == "J2" else {}  # the default joint stays for contacts that arise
    assert (name, strength) == ("rain", {**kept, **{f"{joint}~{k}": 0.5 for k in (1, 2, 3)}})
