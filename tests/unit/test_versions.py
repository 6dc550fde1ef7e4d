"""The versions that are declared are those that are tested: pyproject.toml and the two files of constraints."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import bsm_mesh as bsm

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = ("dask", "dxf", "pardiso", "mpi", "test")  # that bootstrap.sh installs
REQUIREMENTS = [
    *PROJECT["build-system"]["requires"],
    *PROJECT["project"]["dependencies"],
    *(line for extra in EXTRAS for line in PROJECT["project"]["optional-dependencies"][extra]),
]


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def release(version: str) -> tuple[int, ...]:
    """Return 2.10 and 2.10.0 alike."""
    parts = [int(part) for part in version.split(".")]
    while parts and parts[-1] == 0:
        parts.pop()
    return tuple(parts)


def pins(file: str) -> dict[str, str]:
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    found = [line.split("==") for line in lines if line and not line.startswith("#")]
    return {plain(name): version for name, version in found}


@pytest.mark.parametrize("requirement", sorted(set(REQUIREMENTS)))
def test_the_lowest_version_is_the_tested_one(requirement: str) -> None:
    found = re.match(r"([\w.-]+)>=([\d.]+)", requirement)
    assert found is not None, "declare a lowest version"
    assert release(pins("constraints-lowest.txt")[plain(found[1])]) == release(found[2])
    assert release(pins("constraints.txt")[plain(found[1])]) >= release(found[2])


@pytest.mark.parametrize("file", ["constraints.txt", "constraints-lowest.txt"])
def test_constraints_are_names_and_versions(file: str) -> None:
    for line in (ROOT / file).read_text(encoding="utf-8").splitlines():
        assert line.startswith("#") or re.fullmatch(r"[\w.-]+==[\w.]+", line), line


def test_the_version_is_the_same_everywhere() -> None:
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited is not None
    assert bsm.__version__ == PROJECT["project"]["version"] == cited[1]


def test_the_version_is_the_newest_of_the_changelog() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.search(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)$", text, re.MULTILINE)
    cited = re.search(r"^date-released: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert newest is not None
    assert cited is not None
    assert (bsm.__version__, cited[1]) == newest.groups()


def test_extras_are_what_bootstrap_adds() -> None:
    script = (ROOT / "bootstrap.sh").read_text(encoding="utf-8")
    found = re.search(r"^    ((?:\w+ \| )+\w+)\) \[ \$# = 0 \] \|\| usage; extra=\$command", script, re.MULTILINE)
    assert found is not None
    assert set(found[1].split(" | ")) == set(PROJECT["project"]["optional-dependencies"]) - {
        "test",
        "benchmark",
        "mutation",
        "browser",
        "coverage",
        "view",
    }


def sentences(entry: str) -> int:
    """Return of how many sentences an entry of the changelog is; what is in code or in brackets is none."""
    plain = re.sub(r"\([^()]*\)", "", re.sub(r"`[^`]*`", "x", " ".join(entry.split())))
    return len(re.findall(r"(?<!Fig)(?<!Eq)[.!?](?=\s+[A-Zx\[0-9*]|$)", plain))


def test_an_entry_of_the_changelog_has_two_sentences_at_most() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    entries = re.findall(r"^- (.*?)(?=^- |^#|\Z)", text, re.MULTILINE | re.DOTALL)
    assert len(entries) > 200
    assert [entry for entry in entries if sentences(entry) > 2] == []
    assert sentences("One. Two (of 3. them). `x. y`: three (Wang Fig. 8.14).") == 3
