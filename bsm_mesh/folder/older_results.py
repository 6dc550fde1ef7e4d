"""Summaries of older schema versions, each turned into that of the next version by a function of its own.

Missing values of the other files are known to their readers. These are names of numbers (`names_in` of
`converters/vtk_files.py`) and the pressure below a water table (`_water_of` of `storage.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bsm_mesh.results.records import Status

WRITTEN = "schema_version_written"


def from_3(told: dict[str, Any]) -> dict[str, Any]:
    """Return a summary of version 3 as one of version 4, since when the linear scheme gives no verdict."""
    if told["scheme"] != "linear":
        return told
    stages = [_without_verdict(stage) for stage in told["stages"]]
    return {**_without_verdict(told), "stages": stages}


def _without_verdict(told: dict[str, Any]) -> dict[str, Any]:
    return {**told, "status": Status.NO_VERDICT.value} if told["status"] == Status.STABLE else told


NEXT: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {3: from_3}  # 1 and 2 did not know the joints of faces


def brought_up(told: dict[str, Any]) -> dict[str, Any]:
    """Return a summary as one of the present version; an older one keeps the version that it was `WRITTEN` in."""
    version = told["schema_version"]
    if version in NEXT:
        told = {**told, WRITTEN: version}
    while version in NEXT:
        told = {**NEXT[version](told), "schema_version": version + 1}
        version += 1
    return told
