"""Contact history of an accepted step: which are kept, and as intact or failed."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.contact.history import History, commit
from bsm_mesh.contact.rules import CONTACT_TOLERANCE, RULES
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, square

KN = 1e9


def block_on_a_base(tensile_strength=0.0):
    """Return a square metre on a base, with cohesion."""
    joint = bsm.Joint("J", KN, KN, law=bsm.MohrCoulomb(friction=30.0, cohesion=1e5), tensile_strength=tensile_strength)
    model = model_of([rectangle(-1, -1, 2, 0), square(0, 0)], joint=joint)
    return BlockSystem(model)


def after_lifting(moving, height):
    """Return the history of a first step in which the block is lifted, and how many contacts failed in it."""
    contacts = moving.gather(History.none(), moving.start, first=True)
    position = moving.start + np.array([(0, 0, 0), (0, height, 0)])
    return commit(contacts, moving.evaluate(contacts, position), position, moving.outlines.size)


@pytest.mark.parametrize(("height", "kept"), [(0.0, 2), (0.5 * RULES.rounding, 2), (3 * RULES.rounding, 0)])
def test_contacts_that_touch_without_force_keep_their_strength(height, kept):
    moving = block_on_a_base()
    history, changed = after_lifting(moving, height)
    assert changed == 0
    assert_array_equal(history.failed, [False] * kept)
    again = moving.gather(history, moving.start, first=False)
    pushed = moving.start + np.array([(0, 0, 0), (1.0, -1e-6, 0)]) * (1e-3, 1, 1)
    at = moving.evaluate(again, pushed)
    cohesion = 1e5 if kept else 0.0
    assert_allclose(at.strength.sum(), cohesion + np.tan(np.radians(30.0)) * KN * 1e-6, rtol=1e-6)


@pytest.mark.parametrize(("part", "kept"), [(0.9, 2), (1.1, 0)])
def test_contacts_pulled_past_their_tensile_strength_are_not_kept(part, kept):
    """Though open by less than contacts that carry nothing may be."""
    strength = 0.1 * RULES.rounding * KN
    history, _ = after_lifting(block_on_a_base(strength), part * strength / KN)
    assert len(history.failed) == kept


@pytest.mark.parametrize("gap", [0.5, 2.5])
def test_contacts_closed_over_a_gap_overhang_the_ends_of_their_edges(gap):
    """In situ they carry at gap 0 and on, `offset` wide: a corner at the very end of an edge must not lose it all."""
    moving = block_on_a_base()
    near = CONTACT_TOLERANCE * moving.outlines.size
    contacts = moving.gather(History.none(), moving.start, first=True)
    contacts = replace(contacts, offset=np.full(contacts.count, 3 * near))
    lifted = moving.start + np.array([(0, 0, 0), (0, gap * near, 0)])
    history, _ = commit(contacts, moving.evaluate(contacts, lifted), lifted, moving.outlines.size)
    again = moving.gather(history, lifted, first=False)
    closed = moving.evaluate(again, lifted).closed
    assert closed.sum() == 2
    assert again.within_tolerance[closed].all()
    assert (again.edge_overhang[closed] > 0).all()


@pytest.mark.heavy
@pytest.mark.parametrize(
    "rock",
    [
        bsm.Rock("r", unit_weight=25e3, young=20e9, poisson=0.25),
        bsm.Rock("r", unit_weight=25e3, young=20e9, poisson=0.25, cohesion=1e7, friction=40, tensile_strength=5e6),
    ],
)
@pytest.mark.parametrize(("push", "status"), [(0.34, "stable"), (0.39, "unstable")])
def test_rock_beyond_the_end_of_a_joint_holds_nothing_that_slides_off_it(
    rock: bsm.Rock, push: float, status: str
) -> None:
    """A block on two others is pushed, friction 20 degrees; it slides at 0.364 of its weight.

    After 5 cm its joint has left the corner of the first block for a face of rock, which had the strength of intact
    rock there: the block hung on it.
    """
    polygons = (
        [(0, -1), (1, -1), (1, 0), (0, 0)],
        [(1.2, -1), (4, -1), (4, 0), (1.2, 0)],
        [(0.95, 0), (3, 0), (3, 1), (0.5, 1), (0.5, 0.2)],
    )
    blocks = bsm.Blocks.from_polygons([np.array(polygon, dtype=float) for polygon in polygons], rock="r")
    level = (blocks.vertices[:, 1] == 0) & (blocks.vertices[blocks.following, 1] == 0)
    blocks = replace(blocks, edge_joint=np.where(level, 0, -1).astype(np.int32), joint_names=("f",))
    model = bsm.Model(
        blocks=blocks,
        rocks=[rock],
        joints=[bsm.Joint("f", 1e10, 1e10, law=bsm.MohrCoulomb(friction=20))],
        supports=[bsm.Fixed(blocks=[0, 1])],
        loads=[bsm.PointLoad(block=2, point=(2, 0.5), force=(push * 25e3 * blocks.moments.area[2], 0))],
    )
    assert bsm.run(model).status == status


def test_contacts_of_a_face_that_slides_off_never_stand_for_more():
    """Seen: at the last .005 of a block they grew twenty times, to a lone corner's length; steps alternated."""
    moving = BlockSystem(model_of([rectangle(-3, -1, 0, 0), square(-0.02, 0)]))
    contacts, before = moving.gather(History.none(), moving.start, first=True), 0.01
    for overlap in (0.02, 0.012, 0.006, 0.0045, 0.002, 0.006, 0.0045):
        position = moving.start + np.array([(0, 0, 0), (0.02 - overlap, -6e-3, 0)])
        at = moving.evaluate(contacts, position)
        history, _ = commit(contacts, at, position, moving.outlines.size)
        contacts = moving.gather(history, position, first=False)
        length = contacts.candidates.length[moving.evaluate(contacts, position).closed]
        assert len(length) == 2
        assert length.max() <= max(overlap / 2, before) * (1 + 1e-9)
        before = length.max()
