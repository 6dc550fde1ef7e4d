"""Bolts of standard steel: what is taken from the catalogue, and what stays the user's."""

import numpy as np
import pytest

import bsm_mesh as bsm

DIAMETERS = 12, 16, 20, 25, 28, 32, 40
EUROPEAN = 113.1, 201.1, 314.2, 490.9, 615.8, 804.2, 1256.6  # mm2: DIN 488, BS 4449
AMERICAN = {6: 284, 7: 387, 8: 510, 9: 645, 10: 819, 11: 1006}  # mm2: ASTM A615M, Table 1

SECTIONS = {
    **{f"b500 {d} mm": (area, 500) for d, area in zip(DIAMETERS, EUROPEAN, strict=True)},
    **{f"grade 60 no. {n}": (area, 420) for n, area in AMERICAN.items()},
    **{f"grade 75 no. {n}": (area, 520) for n, area in AMERICAN.items()},
}


def test_every_bar_has_the_section_and_strength_of_its_standard():
    """Tabulated areas are rounded: to 1 mm2, and to .01 square inches before, up to 1 % of a no. 6."""
    assert {entry.name for entry in bsm.library.BOLTS} == SECTIONS.keys()
    for name, (area, strength) in SECTIONS.items():
        bolt = bsm.library.bolt(name, (0, 0), (0, -3))
        assert bolt.yield_force == pytest.approx(area * strength, rel=0.001 if name.startswith("b500") else 0.01)
        assert bolt.yield_force == pytest.approx(np.pi / 4 * bolt.diameter**2 * strength * 1e6)
        assert bolt.young == 200e9


def test_what_is_given_replaces_the_entry():
    bolt = bsm.library.bolt("b500 20 mm", (0, 0), (0, -3), spacing=1.5, bond_strength=2e5, young=205e9)
    assert (bolt.spacing, bolt.bond_strength, bolt.young) == (1.5, 2e5, 205e9)


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(bsm.ModelError, match=r"no bolt 'b500 26 mm'.*b500 2"):
        bsm.library.bolt("b500 26 mm", (0, 0), (0, -3))
    assert all(entry.source for entry in bsm.library.BOLTS)
