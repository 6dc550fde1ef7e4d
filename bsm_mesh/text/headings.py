"""Stages by number or name, and common parts of pictures of results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError, named_stage, nearest
from bsm_mesh.results.movement import verdict_in_words
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results

PICTURES_FOLDER = "pictures"  # their folder, in that of the results


def heading(told: Mapping[str, Any], state: str = "") -> str:
    """Return the model's title with the stage, where there are several, and a state, by default the verdict."""
    stage = told["stages"][-1]
    unfinished = told["status"] == Status.UNFINISHED
    at = f"{named_stage(stage['name'])}, " if len(told["stages"]) > 1 or unfinished else ""
    rest = ", of an unfinished run" if unfinished else ""
    verdict = stage.get("verdict") or stage["status"]  # the latter in folders of before
    near = ", near its limit" if told.get("near_limit") and not state else ""
    return f"{told['title'] or 'bsm-mesh'}: {at}{state or verdict.replace('_', ' ')}{near}{rest}"


def stage_heading(results: Results, number: int) -> str:
    """Return the model's title with a stage, where there are several, and its verdict."""
    stage = results.stages[number]
    at = f"{named_stage(stage.name)}, " if len(results.stages) > 1 or not results.finished else ""
    rest = "" if results.finished else ", of an unfinished run"
    return f"{results.title or 'bsm-mesh'}: {at}{verdict_in_words(results.blocks, stage)}{rest}"


def stage_number(results: Results, stage: int | str) -> int:
    """Return the number of a stage, counted from 0.

    Parameters
    ----------
    results : Results
        The result.
    stage : int or str
        Its name, or its number as such or as text; negative numbers count from the last stage.

    Raises
    ------
    ModelError
        If there is no such stage.
    """
    names = [each.name for each in results.stages]
    if stage in names:
        return names.index(str(stage))
    is_number = isinstance(stage, int | np.integer) or str(stage).removeprefix("-").isdecimal()
    if is_number and -len(names) <= int(stage) < len(names):
        return range(len(names))[int(stage)]
    hint = f"; stages are numbered 0 to {len(names) - 1}" if is_number else nearest(str(stage), names)
    raise ModelError(f"there is no stage {stage!r}{hint}")
