"""Contact forces at a position: every contact answers by its own law, however many are asked at a time."""

from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.contact import forces
from bsm_mesh.contact.forces import evaluate, rows_by_law
from bsm_mesh.contact.history import History
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.large import jointed_slope
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.steps import begun

LAWS = (bsm.MohrCoulomb(friction=35), bsm.Patton(friction=30, dilation=5, cohesion=2e4))


@pytest.fixture
def pressed():
    """Contacts of a slope and a position at which some press, some are open, and all have slipped a little."""
    model = BlockSystem(jointed_slope(150).model())
    contacts = model.gather(History.none(), model.start, first=True)
    return contacts, model.start + np.random.default_rng(0).normal(scale=2e-5, size=model.start.shape)


def forces_of(contacts, law, position):
    return evaluate(replace(contacts, law=law, by_law=rows_by_law(law)), LAWS, position)


@pytest.mark.parametrize("laws", [1, 2])
def test_some_contacts_at_a_time_answer_as_all_at_once(monkeypatch, pressed, laws):
    contacts, position = pressed
    law = (np.arange(contacts.count) % laws).astype(np.int32)
    whole = forces_of(contacts, law, position)
    monkeypatch.setattr(forces, "AT_ONCE", 7)
    parts = forces_of(contacts, law, position)
    assert whole.shear.any()
    assert not whole.sticking.all()
    for field in fields(whole):
        found, wanted = getattr(parts, field.name), getattr(whole, field.name)
        for one, other in zip(found, wanted, strict=True) if isinstance(wanted, tuple) else [(found, wanted)]:
            assert_array_equal(one, other, err_msg=field.name)


def test_open_contacts_bear_no_shear_and_do_not_stick(pressed):
    contacts, position = pressed
    at = forces_of(contacts, np.zeros(contacts.count, np.int32), position)
    assert at.closed.any()
    assert not at.closed.all()
    assert not at.sticking[~at.closed].any()
    assert not at.shear[~at.closed].any()
    assert not at.strength[~at.closed].any()


def test_every_contact_answers_by_its_own_law(pressed):
    contacts, position = pressed
    law = (np.arange(contacts.count) % 2).astype(np.int32)
    both = forces_of(contacts, law, position)
    for number in range(2):
        alone, own = forces_of(contacts, np.full_like(law, number), position), law == number
        assert_array_equal(both.shear[own], alone.shear[own])
        assert_array_equal(both.strength[own], alone.strength[own])
    assert not np.array_equal(both.strength, alone.strength)


def test_what_bears_no_more_than_rounding_does_not_slip():
    """Forces of rounding are at a strength of rounding, or not: that is no slip."""
    step = begun(model_of([rectangle(-4, -1, 8, 0), rectangle(0, 0, 1, 1)]))
    position = step.start.copy()
    position[1, 1] = -1e-5
    at = step.evaluate(position)
    first, *others = np.flatnonzero(at.closed)
    force = np.where(at.closed, 1e-20 * at.pressure, 0.0)
    force[first] = at.pressure[first]
    slides = replace(at, pressure=force, shear=0.7 * force, strength=0.7 * force, sticking=np.zeros_like(at.closed))
    assert others
    assert np.flatnonzero(slides.at_strength).tolist() == [first]
