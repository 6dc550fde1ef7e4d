"""A run says of blocks at rest that they cannot rest where they were given, and which contacts hold them."""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import place
from bsm_mesh.results.evidence import Proof
from bsm_mesh.results.records import Status
from bsm_mesh.solve.stages.given_position import notes_on_given_position
from bsm_mesh.text.tables import joint_rows
from tests.scenes.shapes import rectangle, turned

CONTINUATION = bsm.Options(scheme="continuation")
PROVED = "limit analysis proves that block 1 cannot be at rest where given"
GAP = 0.008  # m, between the block and the stop


def on_a_plane(friction: float, gap: float | None = GAP, cohesion: float | None = None) -> bsm.Results:
    """Return a block on a joint at 40 degrees, with a stop of unjointed rock so far below it, or without."""
    base, block, stop = rectangle(-4, -1, 4, 0), rectangle(0, 0, 2, 1), rectangle(-2 - (gap or 0), 0, -(gap or 0), 1)
    polygons = [turned(each, 40.0) for each in ([base, block, stop] if gap is not None else [base, block])]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock")
    along = np.radians(40.0)
    blocks = blocks.with_joint("bed", lambda x, y: abs(y * np.cos(along) - x * np.sin(along)) < 1e-9)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=25e3, young=20e9, poisson=0.25, cohesion=cohesion)],
        joints=[bsm.Joint("bed", 1e9, 1e9, law=bsm.MohrCoulomb(friction=friction))],
        supports=[bsm.Fixed(blocks=[0, 2] if gap is not None else [0])],
    )
    return bsm.run(model, CONTINUATION)


def notes(results: bsm.Results) -> list[str]:
    return [note for note in results.stages[-1].notes if "cannot be at rest where given" in note]


def test_a_block_that_slides_to_a_stop_of_rock():
    """Friction of 20 degrees at 40: it slides 8 mm, and a stop of unjointed rock takes over."""
    results = on_a_plane(20.0)
    stage = results.stages[-1]
    assert stage.status == "stable"
    (note,) = notes(results)
    assert PROVED in note
    assert f"before rest came a movement of up to {stage.max_displacement:.3g} m" in note
    assert "2 contacts outside of the joints hold them without a limit of strength. The most stressed" in note
    assert "between blocks 1 and 2" in note
    c = stage.contacts
    stop = c.joint < 0
    assert f"carries {(-c.normal_force / c.length)[stop].max() / 1e6:.3g} MPa of pressure" in note
    assert [row[0] for row in joint_rows(results)] == ["bed", "unjointed rock"]


def onto_a_free_face(rock: bsm.Rock) -> bsm.Model:
    """Return a slab at 40 degrees above ground at 25. Only faces of the upper ground have a joint, with friction 15."""
    along = np.array([np.cos(np.radians(40)), np.sin(np.radians(40))])
    foot = 14 * np.tan(np.radians(25))
    low, high = [(-14, -foot), (-14, -14), (0, -14), (0, 0)], [(0, 0), (0, -14), (8 * along[0], -14), tuple(8 * along)]
    blocks = bsm.Blocks.from_polygons([low, high, turned(rectangle(1, 0, 3, 0.8), 40.0)], rock="rock")
    blocks = blocks.with_joint("bed", lambda x, y: abs(y * along[0] - x * along[1]) < 1e-9)
    blocks = blocks.with_joint("bed", lambda x, y: abs(x) < 1e-9)
    return bsm.Model(
        blocks=blocks.with_edge_joints(np.where(blocks.owner == 1, blocks.edge_joint, -1), blocks.joint_names),
        rocks=[rock],
        joints=[bsm.Joint("bed", 1e9, 1e9, law=bsm.MohrCoulomb(friction=15))],
        supports=[bsm.Fixed(blocks=[0, 1])],
    )


@pytest.mark.heavy
def test_a_block_whose_own_faces_have_no_joint_is_held_on_a_free_face_without_a_limit():
    """Its foot sticks to the face, as both have elastic rock; with a joint of all faces it slides on."""
    model = onto_a_free_face(bsm.Rock("rock", unit_weight=25e3, young=20e9, poisson=0.25))
    (note,) = notes(bsm.run(model, CONTINUATION))
    assert "1 contact outside of the joints holds them without a limit of strength" in note
    assert "between blocks 0 and 2" in note
    assert "give these faces a joint (default_joint)" in note
    assert bsm.run(model.replace(default_joint="bed"), CONTINUATION).status == "unstable"


def test_rigid_blocks_cannot_meet_where_neither_has_a_joint():
    with pytest.raises(bsm.ModelError, match="meet without a joint and their rocks are rigid"):
        bsm.run(onto_a_free_face(bsm.Rock("rock", unit_weight=25e3)), CONTINUATION)


def test_blocks_that_cannot_meet_in_a_stage_are_named_by_their_places():
    """The excavation of the first block gives all others other numbers in that stage."""
    model = onto_a_free_face(bsm.Rock("rock", unit_weight=25e3))
    given = model.blocks
    shapes = np.split(given.vertices, given.offsets[1:-1])
    blocks = bsm.Blocks.from_polygons([rectangle(20, 0, 21, 1), *shapes], rock="rock")
    joints = np.concatenate([np.full(4, -1, np.int32), given.edge_joint])
    law = bsm.MohrCoulomb(friction=45)
    staged = model.replace(
        blocks=blocks.with_edge_joints(joints, given.joint_names),
        joints=[bsm.Joint("bed", 1e9, 1e9, law=law)],
        supports=[bsm.Fixed(blocks=[0, 1, 2])],
        stages=[bsm.Stage("wet", excavate=[0], strength={"bed": 0.27})],
    )
    with pytest.raises(bsm.ModelError) as refused:
        bsm.run(staged, CONTINUATION)
    low, _, slab = given.moments.centroid
    assert f"the blocks at {place(low)} and {place(slab)} m meet without a joint" in str(refused.value)


def test_without_a_stop_or_with_strength_nothing_is_told_of_contacts():
    """Friction of 45 degrees holds the block; rock with strength has a limit, and no contact is named."""
    assert notes(on_a_plane(45.0)) == []
    assert [row[0] for row in joint_rows(on_a_plane(45.0))] == ["bed"]
    (note,) = notes(on_a_plane(20.0, cohesion=5e6))
    assert "outside of the joints" not in note
    assert "before rest came a movement" in note


def test_limit_analysis_is_asked_only_where_blocks_moved_or_slipped():
    def never(blocks: object) -> Proof:
        raise AssertionError(f"asked about {blocks}")

    held = on_a_plane(45.0)
    assert held.model is not None
    assert list(notes_on_given_position(held.model, held.stages[-1], never)) == []
    sliding = on_a_plane(20.0)
    assert sliding.model is not None
    moving = replace(sliding.stages[-1], status=Status.UNSTABLE)
    assert list(notes_on_given_position(sliding.model, moving, never)) == []
    asked = list(notes_on_given_position(sliding.model, sliding.stages[-1], lambda blocks: Proof(text="none")))
    assert asked == []


def weakened(bolt_stage: str | None, zones: bsm.Zones | None = None) -> bsm.Results:
    """Return the block at 40 degrees on a joint of 45, of 20 in the stage 'weak': a stop or a bolt then holds it."""
    base, block, stop = rectangle(-4, -1, 4, 0), rectangle(0, 0, 2, 1), rectangle(-2 - GAP, 0, -GAP, 1)
    head, tip = turned(np.array([(1.0, 1.0), (2.5, -0.5)]), 40.0)
    bolt = bsm.Bolt(start=tuple(head), end=tuple(tip), kind="end_anchored", diameter=0.02, stiffness=5e6)
    polygons = [base, block] if bolt_stage is None else [base, block, stop]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([turned(each, 40.0) for each in polygons], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=25e3, young=20e9, poisson=0.25, zones=zones)],
        joints=[bsm.Joint("bed", 1e9, 1e9, law=bsm.MohrCoulomb(friction=45))],
        default_joint="bed",
        supports=[bsm.Fixed(blocks=[0, 2] if bolt_stage else [0])],
        bolts=[replace(bolt, stage=bolt_stage)],
        stages=[bsm.Stage("weak", strength={"bed": np.tan(np.radians(20))}), bsm.Stage("bolted")],
    )
    return bsm.run(model, CONTINUATION)


def test_bolts_of_a_later_stage_do_not_hide_the_movement():
    """It slides to the stop in the stage 'weak', before the bolt is there; of the next stage nothing is asked."""
    results = weakened("bolted")
    given = [[note for note in stage.notes if PROVED in note] for stage in results.stages]
    assert [len(each) for each in given] == [0, 1, 0]


@pytest.mark.heavy
def test_zones_that_a_bolt_holds_are_not_proved_to_move():
    """The model of a stage that changes strength has no bolts of its own: those of the whole model count."""
    stage = weakened(None, bsm.Zones(size=1.0, displacement="large")).stages["weak"]
    assert stage.status == "stable"
    assert stage.max_stage_displacement > GAP
    assert [note for note in stage.notes if "cannot be at rest" in note] == []
