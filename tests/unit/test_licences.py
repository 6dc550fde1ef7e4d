"""LICENSES.md says of every package what its installed metadata say, and knows whatever the project needs."""

from __future__ import annotations

import sys
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

import pytest
from packaging.utils import canonicalize_name

from examples.numbers.licences import EXTRAS, PROJECT, all_needed, licence, needed, read
from examples.numbers.pages import table_in

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "LICENSES.md").read_text(encoding="utf-8")
LINES = [
    line.split("==") for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines() if "==" in line
]
PINS = {canonicalize_name(name): version for name, version in LINES}


def is_pinned(package: Distribution) -> bool:
    return PINS.get(canonicalize_name(package.name)) == package.version


def test_it_says_what_the_metadata_say() -> None:
    """Of the versions that are pinned: others may have changed their licence, or the way they state it."""
    different = {}
    for name, stated in read(table_in(PAGE, "licences")).items():
        try:
            package = distribution(name)
        except PackageNotFoundError:  # another system, or fewer extras
            continue
        if is_pinned(package) and licence(package) != stated:
            different[name] = (stated, licence(package))
    assert different == {}, "python -m examples.numbers licences"


def test_it_has_all_that_the_project_names() -> None:
    named = {name for extra in ("", *EXTRAS) for name in needed(PROJECT, extra)}
    assert {"gmsh", "numpy", "vtk", "ezdxf", "distributed"} <= named
    assert named - set(read(table_in(PAGE, "licences"))) == set()


@pytest.mark.skipif(sys.platform != "linux", reason="the table is that of Linux")
def test_it_has_all_that_comes_with_these() -> None:
    try:
        found = all_needed()
    except ValueError as missing:
        pytest.skip(str(missing))
    pinned = {name for name in found if is_pinned(distribution(name))}
    assert pinned - set(read(table_in(PAGE, "licences"))) == set()


class Package:
    """Metadata of a package that is not there."""

    name = "nobody"

    def __init__(self, **stated: object) -> None:
        self.metadata = type("Metadata", (), {"json": stated})()


@pytest.mark.parametrize(
    ("stated", "found"),
    [
        ({"license_expression": "MIT", "license": "MIT License"}, "MIT"),
        ({"license": "GPLv2+", "classifier": ["License :: OSI Approved :: MIT License"]}, "GPLv2+"),
        ({"license": "Copyright " * 20, "classifier": ["Topic :: X", "License :: OSI :: BSD"]}, "BSD"),
    ],
)
def test_where_it_is_read(stated: dict[str, object], found: str) -> None:
    assert licence(Package(**stated)) == found  # type: ignore[arg-type]


def test_none_is_no_licence() -> None:
    with pytest.raises(ValueError, match="nobody: its metadata name no licence"):
        licence(Package(license="UNKNOWN" * 20))  # type: ignore[arg-type]
