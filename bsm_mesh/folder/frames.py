"""The states of a results folder, in order: the ends of its stages, and the snapshots of steps between them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.errors import ModelError, named_stage

if TYPE_CHECKING:
    from bsm_mesh.folder.saved_results import SavedResults

OF_A_STATE = re.compile(r"blocks_(\d{4,})(?:_(\d{5,}))?\.vtu")


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A state of the blocks that was written.

    Attributes
    ----------
    time : float
        PVD time: the number of the stage, of the steps since the run began, or seconds of a shaken stage.
    steps : int
        Accepted steps since the run began.
    stage : int
        Number of the stage.
    step : int or None
        Number of the step within it, from 0; None at the stage's end.
    stage_name : str
        Name of the stage; empty where it did not reach its end.
    verdict : str
        The verdict on the stage, in words; empty for a step.
    """

    time: float
    steps: int
    stage: int
    step: int | None
    stage_name: str
    verdict: str

    @property
    def is_end(self) -> bool:
        """Whether it is the end of a stage."""
        return self.step is None

    @property
    def label(self) -> str:
        """Its name for a reader: the stage, and the step or the verdict."""
        stage = named_stage(self.stage_name or str(self.stage))
        return f"{stage}: {self.verdict}" if self.step is None else f"{stage}, step {self.step + 1}"

    def file(self, kind: str) -> str:
        """Return the name of the file of a kind."""
        step = "" if self.step is None else f"_{self.step:05d}"
        return f"{kind}_{self.stage:04d}{step}.vtu"


def frames_in(saved: SavedResults) -> list[Frame]:
    """Return the states that a results folder holds, in the order of their times."""
    stages = saved.told["stages"]
    return [_frame(time, file, stages) for time, file in sorted(saved.series("blocks"))]


def _frame(time: float, file: str, stages: list[dict[str, Any]]) -> Frame:
    found = OF_A_STATE.fullmatch(file)
    if found is None or int(found[1]) > len(stages):
        raise ModelError(f"blocks.pvd names {file!a:.80}, which is no file of a run; run the model again")
    stage, step = int(found[1]), None if found[2] is None else int(found[2])
    told = stages[stage] if stage < len(stages) else {"name": "", "status": ""}
    verdict = "" if step is not None else (told.get("verdict") or told["status"]).replace("_", " ")
    before = sum(each["steps"] for each in stages[: stage + (step is None)])
    steps = before if step is None else before + step + 1
    return Frame(time=time, steps=steps, stage=stage, step=step, stage_name=told["name"], verdict=verdict)


def evenly(frames: Iterable[Frame], most: int) -> list[Frame]:
    """Return the ends of all stages and at most so many steps, evenly spread over those that there are.

    Examples
    --------
    >>> steps = [Frame(time=k, steps=k, stage=0, step=k, stage_name="a", verdict="") for k in range(9)]
    >>> [frame.step for frame in evenly(steps, 3)]
    [0, 4, 8]
    """
    frames = list(frames)
    steps = [number for number, frame in enumerate(frames) if not frame.is_end]
    if len(steps) > most:
        steps = [steps[k] for k in np.linspace(0, len(steps) - 1, most).round().astype(int)] if most > 0 else []
    kept = {*steps, *(number for number, frame in enumerate(frames) if frame.is_end)}
    return [frame for number, frame in enumerate(frames) if number in kept]
