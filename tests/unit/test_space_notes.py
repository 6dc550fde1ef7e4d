"""Notes on models in space whose verdict says less than it seems to: what never fails, ground that does not fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import bsm_mesh as bsm
from bsm_mesh.model.notes import notes_of
from tests.scenes.polyhedra import box, model_in_space

GROUND = {"surface": 2.0, "k0": 0.5}
BALANCED = {name: (0.0, 0.0, 0.0, 26e3) for name in ("xx", "yy", "zz")}


def column(**changes: Any) -> bsm.Model:
    """Return two cubes on each other, the lower one held."""
    model = model_in_space([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))])
    return model.replace(**changes)


def with_top(model: bsm.Model) -> bsm.Model:
    return model.replace(blocks=model.blocks.with_boundary("crest", lambda x, y, z: z > 1.99))


ELASTIC = bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9)
NOTED = {
    "joint 'J1' has no law (friction)": {"joints": [ELASTIC]},
    "joint 'J1': aperture has no effect: flow in joints is for the plane": {
        "joints": [replace(ELASTIC, law=bsm.MohrCoulomb(friction=30), aperture=1e-4)]
    },
    "1 bolt without yield_strength": {"bolts": [bsm.Bolt(start=(0.5, 0.5, 1.9), end=(0.5, 0.5, 0.2), diameter=0.02)]},
    "bolt 1 from (0.5, 0.5, 2.9) to (0.5, 0.5, 0.2) crosses 1 m without rock": {
        "blocks": model_in_space([box((0, 0, k), (1, 1, k + 1)) for k in range(3)]).blocks,
        "bolts": [bsm.Bolt(start=(0.5, 0.5, 2.9), end=(0.5, 0.5, 0.2), diameter=0.02, yield_strength=5e8, stage="cut")],
        "stages": [bsm.Stage("cut", excavate=[1])],
    },
    "in_situ: the surface lies 3 m above the top": {"in_situ": bsm.InSitu(surface=5.0)},
    "in_situ: 1 block above the surface": {"in_situ": bsm.InSitu(surface=1.0)},
    "in_situ: stress does not balance the weights": {"in_situ": bsm.InSitu(stress={"zz": -1e6, "xx": 0, "yy": 0})},
}


@pytest.mark.parametrize("text", NOTED)
def test_a_model_that_says_less_than_it_seems_to_is_noted(text: str) -> None:
    others = [notes_of(column(**changes)) for name, changes in NOTED.items() if name != text]
    assert sum(note.startswith(text) for note in notes_of(column(**NOTED[text]))) == 1
    assert not any(note.startswith(text) for notes in others for note in notes)


@pytest.mark.parametrize("field", [GROUND, {"stress": BALANCED}])
def test_ground_that_fits_has_no_note(field: dict[str, Any]) -> None:
    assert not any("in_situ" in note for note in notes_of(column(in_situ=bsm.InSitu(**field))))


@pytest.mark.parametrize("of", [{"loads": [bsm.Pressure(boundary="crest", pressure=78e3)]}, {"supports": None}])
def test_a_top_that_is_loaded_or_held_bears_the_ground_above(of: dict[str, Any]) -> None:
    model = with_top(column(in_situ=bsm.InSitu(surface=5.0)))
    given = of if of.get("loads") else {"supports": [*model.supports, bsm.Fixed(boundary="crest")]}
    (noted,) = [note for note in notes_of(model) if "above the top" in note]
    assert 'boundary = "crest", pressure = 7.8e+04' in noted
    assert not any("above the top" in note for note in notes_of(model.replace(**given)))


def test_faces_of_rock_without_a_joint_are_counted_where_nothing_limits_them() -> None:
    blocks = bsm.Polyhedra.from_solids([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))], rock="rock")
    rock = bsm.Rock("rock", unit_weight=26e3, young=20e9, poisson=0.25)
    strong = bsm.Rock("rock", unit_weight=26e3, young=20e9, poisson=0.25, friction=40, cohesion=1e6)
    text = "1 face of rock without a joint and without strength"
    noted = [
        any(note.startswith(text) for note in notes_of(bsm.Model(blocks=blocks, rocks=[each], **given)))
        for each, given in ((rock, {}), (strong, {}), (rock, {"joints": [ELASTIC], "default_joint": "J1"}))
    ]
    assert noted == [True, False, False]


def test_a_plane_of_water_that_slopes_above_the_ground() -> None:
    """The middle of the top lies at 2 m; level water above it is a lake."""
    plane = bsm.HeadPlane(point=(0.5, 0.5, 2.25), dip=10, dip_direction=90)
    (note,) = [note for note in notes_of(column(water=bsm.Water(plane=plane))) if "slopes" in note]
    says = "water: the plane slopes and lies up to 0.25 m above the ground, most at (0.5, 0.5, 2): it presses there"
    assert note.startswith(says)
    level, lower = (bsm.HeadPlane(point=(0.5, 0.5, z), dip=dip, dip_direction=90) for z, dip in ((2.25, 0), (2.0, 10)))
    for fine in (level, lower):
        assert not [note for note in notes_of(column(water=bsm.Water(plane=fine))) if "slopes" in note]


def test_a_joint_that_ends_in_a_block_is_noted_and_bounds_none() -> None:
    """Three cubes in a row of which two are one block: half of J1 is within it, or J2 as a whole."""
    apart = bsm.Polyhedra.from_solids([box((0, 0, k), (1, 1, k + 1)) for k in range(3)], rock="rock", joint="J1")
    one = replace(apart, cell_block=[0, 0, 1], rock=[0, 0])
    kept = {"joints": [ELASTIC, bsm.Joint("J2", 1e9, 1e9)], "supports": [bsm.Fixed(blocks=[0])]}
    model = bsm.Model(blocks=one, rocks=[bsm.Rock("rock", unit_weight=26e3)], **kept)
    within = int(one.face_joint.argmax())
    both = replace(
        one, joint_names=("J1", "J2"), face_joint=[*one.face_joint[:within], 1, *one.face_joint[within + 1 :]]
    )
    assert (
        "1 m2 of the 2 m2 of joint 'J1' end in the rock with the same block on both sides and bound none (near ("
        in ("\n".join(notes_of(model)))
    )
    assert "joint 'J2' is used by no face; did you mean 'J1'? (known: J1)" in notes_of(model.replace(blocks=both))
