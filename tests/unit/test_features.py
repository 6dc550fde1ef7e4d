"""A feature of contacts is asked wherever contacts are used: one of a test's own acts, with no caller that names it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.feature import Feature
from bsm_mesh.joint_test.specimen import Specimen, position_of

JOINT = bsm.Joint("J", 1e9, 1e8, law=bsm.MohrCoulomb(friction=30.0))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Softer(Feature):
    """Contacts of half the pressure and stiffness, which open by a hundredth of their slip."""

    def pressures(self, overlap, pressure, stiffness):
        half = np.ones(len(pressure))
        half[self.rows] = 0.5
        return half * pressure, half * stiffness

    def opened(self, offset, before, after):
        offset = offset.copy()
        offset[self.rows] += 0.01 * (after - before)[self.rows]
        return offset

    def energies(self, energy, pressure):
        return energy + 1.0


def with_feature(contacts: Any) -> Any:
    """Return contacts whose closure is the feature, of all of them."""
    softer = Softer(rows=np.arange(contacts.count))
    return replace(contacts, features=contacts.features._replace(closure=softer))


def test_its_pressure_is_that_of_the_contacts() -> None:
    specimen, at = Specimen(JOINT), position_of(0.0, -1e-4)
    given = specimen.contacts(position_of(0.0, 0.0))
    plain = specimen.system.evaluate(given, at)
    found = specimen.system.evaluate(with_feature(given), at)
    assert (plain.pressure > 0).all()
    assert_allclose(found.pressure, plain.pressure / 2)
    assert_allclose(found.normal_stiffness, plain.normal_stiffness / 2)
    assert_allclose(found.forces[1, 1], plain.forces[1, 1] / 2)


def test_its_opening_is_kept_with_an_accepted_step() -> None:
    specimen = Specimen(JOINT)
    for at in (position_of(0.0, 0.0), position_of(1e-2, -1e-4)):
        contacts = with_feature(specimen.contacts(at))
        specimen.keep(contacts, specimen.system.evaluate(contacts, at))
    slid = specimen.history.slip_path
    assert (slid > 0).all()
    assert_allclose(specimen.history.offset, 0.01 * slid, rtol=1e-12)


@pytest.mark.parametrize("name", ["closure", "growing", "dilating"])
def test_without_rows_a_feature_changes_nothing(name: str) -> None:
    contacts = Specimen(JOINT).contacts(position_of(0.0, -1e-4))
    feature = getattr(contacts.features, name)
    assert not len(feature.rows)
    given = np.ones(contacts.count)
    assert feature.pressures(given, given, given) == (given, given)
    assert feature.opened(given, given, given) is given
    assert feature.energies(given, given) is given
