"""Copies of a model in other units: none differs where nothing is rounded."""

from __future__ import annotations

import pytest

from benchmarks.campaign import copies
from benchmarks.campaign.transforms import scaled


def test_a_twin_that_disagrees_has_a_row_and_copies_agree_away_from_limits(monkeypatch):
    claimed = {"facts": {"twins": {"mirrored": "unstable", "stronger": "stable"}}}
    disagrees = claimed | {"contradictions": ["symmetry: stable, but mirrored unstable, after 0 and 2 of a block"]}
    records = {("plane", 5): disagrees, ("plane", 6): claimed, ("plane", 7): {"contradictions": ["check: no"]}}
    told, units = [], []
    monkeypatch.setattr(copies, "scaled", lambda scene, *factors: units.append(factors) or scaled(scene, *factors))
    head, row = copies.of_twins(records, 3, told.append)
    assert head == copies.HEAD
    assert told == ["plane 5"]
    assert units[0] == (4.0, 16.0)
    assert len(set(units)) == 4
    assert row[:1] + row[2:7] == ["plane 5", "stable", "mirrored unstable", "stable, the same movement", "3", "0"]


@pytest.mark.heavy
def test_units_by_powers_of_four_change_no_digit():
    """A tolerance that depended on units would show: of a fall, which is followed without any matrix."""
    here, exact = (copies._run(s) for s in (PILE, copies.scaled(PILE, *copies.EXACT)))
    assert here["status"] == exact["status"] == "unstable"
    assert here["steps"] == exact["steps"]
    assert here["moved"] == exact["moved"]
    assert here["residual"] == exact["residual"]


PILE = copies.trial_of(copies.FAMILIES["pile"], 4).scene
