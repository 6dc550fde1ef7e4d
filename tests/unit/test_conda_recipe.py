"""The conda recipe asks for what pyproject.toml asks for."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
RECIPE = (ROOT / "conda/meta.yaml").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
OTHER_NAMES = {"gmsh": "python-gmsh", "matplotlib": "matplotlib-base"}  # of conda-forge


def listed(section: str) -> dict[str, str]:
    """Return the packages of a list of the recipe, and the versions that it asks for."""
    lines = re.search(rf"^  {section}:\n((?:    - .*\n)+)", RECIPE, flags=re.MULTILINE)
    assert lines is not None
    return dict((*line.split(), "")[1:3] for line in lines[1].splitlines())


def as_in_recipe(requirements: list[str]) -> dict[str, str]:
    parts = [re.fullmatch(r"([\w-]+)(>=[\w.]+)?", each) for each in requirements]
    assert all(parts), requirements
    return {OTHER_NAMES.get(part[1], part[1]): part[2] or "" for part in parts if part is not None}


def test_dependencies_are_those_of_the_project() -> None:
    python = {"python": PROJECT["project"]["requires-python"]}
    assert listed("run") == python | as_in_recipe(PROJECT["project"]["dependencies"])
    assert listed("host") == python | {"pip": ""} | as_in_recipe(PROJECT["build-system"]["requires"])


def test_version_licence_and_command_are_those_of_the_project() -> None:
    assert f'version = "{PROJECT["project"]["version"]}"' in RECIPE
    assert f"license: {PROJECT['project']['license']}" in RECIPE
    (name, target), *others = PROJECT["project"]["scripts"].items()
    assert not others
    assert f"- {name} = {target}" in RECIPE


def test_no_host_is_named() -> None:
    assert "://" not in RECIPE
