"""The licences of what is installed with bsm-mesh, as each package's own metadata state them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from examples.numbers.pages import Table, markdown

ROOT = Path(__file__).parents[2]
PROJECT = "bsm-mesh"
EXTRAS = (
    "pardiso",
    "mpi",
    "dask",
    "dxf",
    "gis",
    "view",
    "pandas",
    "pyvista",
)  # of those who use the program; other extras are tools of its developers, and meshlane takes meshio's place
LONG = 40  # letters: a longer "License" is the text itself
INSTALL = "sh bootstrap.sh test --all"


def licence(package: Distribution) -> str:
    """Return what a package's metadata say: its SPDX expression, its short name of a licence, or its classifiers."""
    stated = package.metadata.json  # a plain mapping: keys in lower case
    expression = str(stated.get("license_expression", ""))
    name = " ".join(str(stated.get("license", "")).split())
    classifiers = [str(line) for line in stated.get("classifier", []) if str(line).startswith("License ::")]
    found = expression or (name if len(name) <= LONG else "") or ", ".join(c.split(" :: ")[-1] for c in classifiers)
    if not found:
        raise ValueError(f"{package.name}: its metadata name no licence; look into its files")
    return found


def needed(name: str, extra: str = "") -> Iterator[str]:
    """Give the names that a package requires here; of the project, with an extra, those of the extra."""
    for line in declared(extra) if name == PROJECT else distribution(name).requires or ():
        requirement = Requirement(line)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield canonicalize_name(requirement.name)


def declared(extra: str) -> list[str]:
    """Return what pyproject.toml requires: an environment may have been installed from an older one."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return project["optional-dependencies"][extra] if extra else project["dependencies"]


def all_needed() -> dict[str, str]:
    """Return every package that comes with the project and its extras, and what brings it.

    Raises
    ------
    ValueError
        If one that the project names itself is not installed.
    """
    found: dict[str, str] = {}
    for reason in ("", *EXTRAS):
        direct = sorted(set(needed(PROJECT, reason)) - set(found))
        found |= {name: f"extra `{reason}`" if reason else "always" for name in direct}
        queue = direct
        while queue:
            name = queue.pop(0)
            try:
                more = sorted(set(needed(name)) - set(found))
            except PackageNotFoundError:
                raise ValueError(f"{name} is not installed, so that its licence cannot be read: {INSTALL}") from None
            found |= dict.fromkeys(more, f"by {name}")
            queue += more
    return found


def rows() -> dict[str, tuple[str, str]]:
    """Return the licence of every package and what brings it."""
    return {name: (licence(distribution(name)), reason) for name, reason in sorted(all_needed().items())}


def read(table: str) -> dict[str, str]:
    """Return the licence of every package in a table."""
    return {cells[1]: cells[2] for cells in (re.split(r"\s*\|\s*", line) for line in table.splitlines()[2:])}


def make() -> str:
    """Return the table."""
    return markdown(
        ("package", "licence, as its metadata say", "comes"),
        [(name, stated, reason) for name, (stated, reason) in rows().items()],
    )


TABLES = (Table(name="licences", page="LICENSES.md", make=make),)
