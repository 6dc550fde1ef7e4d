"""Random rock masses: blocks too small to count are no contradiction, and exceptions are named."""

import pytest

from benchmarks.rock_masses import judged, rock_mass, table


@pytest.mark.heavy
def test_a_roof_whose_smallest_block_falls_is_admissible_without_it():
    """Seed 31: the run takes block 38 away, which is smaller than a hundredth of the mean; with it no forces exist."""
    model, _, told = rock_mass(31)
    assert 40 <= model.blocks.count == told["blocks"] <= 250
    found = judged(31)
    assert (found["verdict"], found["admissible"], found["moves"]) == ("stable", True, [])


def test_the_table_names_the_exceptions():
    usual = {"kind": "roof", "friction": 30.0, "admissible": True, "verdict": "stable", "moves": [], "not_named": []}
    records = [
        {**usual, "seed": 1},
        {**usual, "seed": 2, "admissible": False},
        {**usual, "seed": 3, "verdict": "not_converged"},
        {
            **usual,
            "seed": 4,
            "moves": [7],
            "not_named": [7],
            "factors": [1.06],
            "turn": 0.4,
            "translating": ["stable", []],
        },
    ]
    text = table(records)
    assert "1 of 4 against the proof (seeds [2]); 1 of 4 without a verdict (seeds [3])" in text
    assert "0 of 1 move blocks only that block theory names" in text
    assert "| 4 | roof | 30° | 1.06 | 0.4 | stable | 0 |" in text
