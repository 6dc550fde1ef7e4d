"""The versions that are declared are those that are tested: pyproject.toml and the two files of constraints."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

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
