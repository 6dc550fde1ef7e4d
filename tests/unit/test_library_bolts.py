"""Bolts of standard steel: what is taken from the catalogue, and what stays the user's."""

import numpy as np
import pytest

import bsm_mesh as bsm


def test_yield_forces_are_those_of_the_standards_sections():
    """A615M: 510 mm2 of a no. 8 bar at 420 MPa; EN 10080: 491 mm2 of 25 mm at 500 MPa."""
    american = bsm.library.bolt("Grade 60 no. 8", (0, 0), (0, -3))
    european = bsm.library.bolt("B500 25 mm", (0, 0), (0, -3))
    assert american.yield_force == pytest.approx(510e-6 * 420e6, rel=0.01)
    assert european.yield_force == pytest.approx(491e-6 * 500e6, rel=0.001)
    assert european.yield_force == pytest.approx(np.pi / 4 * 0.025**2 * 500e6)


def test_what_is_given_replaces_the_entry():
    bolt = bsm.library.bolt("b500 20 mm", (0, 0), (0, -3), spacing=1.5, bond_strength=2e5, young=205e9)
    assert (bolt.spacing, bolt.bond_strength, bolt.young) == (1.5, 2e5, 205e9)


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(bsm.ModelError, match=r"no bolt 'b500 26 mm'.*b500 2"):
        bsm.library.bolt("b500 26 mm", (0, 0), (0, -3))
    assert all(entry.source for entry in bsm.library.BOLTS)
