"""Random rock masses: blocks too small to count are no contradiction, and exceptions are named."""

import pytest

from benchmarks import loaded_masses
from benchmarks.rock_masses import continued, judged, rock_mass, table


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


def test_a_mass_has_the_loads_that_it_tells():
    """Seed 3 is a roof with all but a pressure."""
    model, free, told = loaded_masses.loaded_mass(3)
    assert free == ("bottom",)
    assert told["loads"] == ["cohesion", "earthquake", "water", "bolts"]
    assert all(joint.law.cohesion > 0 for joint in model.joints)
    assert model.gravity_horizontal > 0
    assert model.water is not None
    assert model.bolts
    assert not model.loads


def test_the_table_of_loaded_masses_names_the_exceptions():
    usual = {
        "kind": "slope",
        "loads": ["water"],
        "admissible": True,
        "verdict": "stable",
        "certified": True,
        "moves": [],
    }
    records = [
        {**usual, "seed": 1, "not_named": []},
        {**usual, "seed": 2, "admissible": False, "not_named": []},
        {
            **usual,
            "seed": 3,
            "verdict": "unstable",
            "moves": [4],
            "not_named": [4],
            "certified": False,
            "translating": ("stable", []),
            "glued": [4],
            "united": [],
        },
    ]
    unexplained = {**records[2], "seed": 4, "translating": ("unstable", [4])}
    text = loaded_masses.table(records)
    assert "1 of 3 `stable` against the proof (seeds [2]); 0 of 3 without a verdict" in text
    assert "0 of 1 move blocks only that block theory names" in text
    assert "1 of the other 1 do so with the rotation of every block held" in text
    assert "0 with a tensile strength of joints of 10 times their cohesion; limit analysis proves that 0 must" in text
    assert "in 0 block theory names a block as one with the moving blocks that it touches" in text
    assert "none of this explains 0 (seeds [])" in text
    assert "none of this explains 1 (seeds [4])" in loaded_masses.table([*records, unexplained])
    assert "| slope | inadmissible | stable | 1 |" in text


def test_a_file_of_lines_is_continued(tmp_path):
    file = tmp_path / "masses.jsonl"
    judges = {1: lambda: {"seed": 1}, 2: lambda: {"seed": 2}}
    assert continued(file, [2], lambda seed: judges[seed]()) == [{"seed": 2}]
    assert continued(file, [0, 1, 2], lambda seed: judges.pop(seed)()) == [{"seed": 1}, {"seed": 2}]
    assert list(judges) == [2]
