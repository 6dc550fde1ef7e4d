"""The task of every run of a study: the model with its values, solved or bracketed, and the outcome of it."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from bsm_mesh.commands.study_file import SafetyTable, Study
from bsm_mesh.errors import ModelError, one_line
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.modelfile.variation import Variation
from bsm_mesh.results.movement import gave_way
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results
from bsm_mesh.solving import solve
from bsm_mesh.studies.sampling import Value
from bsm_mesh.studies.scatter import Scatter, scatter_joint
from bsm_mesh.studies.table import FAILED, unstable_bulk


@dataclass(frozen=True, eq=False, kw_only=True)
class StudyWork:
    """The task of every run; a run depends on its number and its values alone.

    Attributes
    ----------
    key : str
        Its identity.
    variation : Variation
        The model file.
    scatters : tuple of Scatter
        What scatters from face to face.
    answers : tuple of str
        The answers that are asked for.
    safety : SafetyTable
        How a factor of safety is looked for.
    seed : int
        Of the study.
    """

    key: str
    variation: Variation
    scatters: tuple[Scatter, ...]
    answers: tuple[str, ...]
    safety: SafetyTable
    seed: int

    def __call__(self, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
        """Return the answers of a run; a fault in it is one."""
        began = time.perf_counter()
        try:
            with warnings.catch_warnings(action="ignore"):  # of a thousand runs the same
                found = self._answers(run, values)
        except ModelError as error:
            found = failed("; ".join(error.faults))
        except MemoryError:
            found = failed("not enough memory")
        except Exception as error:  # a fault of ours ends one run, and not the study
            found = failed(f"{type(error).__name__}: {error}")
        return {name: _finite(value) for name, value in found.items()} | {"seconds": time.perf_counter() - began}

    def _answers(self, run: int, values: Mapping[str, Value]) -> dict[str, Any]:
        loaded = self.variation.model(values)
        model, options = loaded.model, replace(loaded.options, threads=1)
        for number, scatter in enumerate(self.scatters):
            model = scatter_joint(model, scatter, (self.seed, run, number))
        found: dict[str, Any] = {}
        if "factor_of_safety" in self.answers:
            found.update(self._factor(model, options))
        if set(self.answers) & {"verdict", "movements"}:
            found.update(told_of(solve(model, options)))
        return found

    def _factor(self, model: Model, options: Options) -> dict[str, Any]:
        """Return the factor of safety; without a run of the model itself it says the verdict too."""
        from bsm_mesh.safety import factor_of_safety

        asked = self.safety
        joints = None if asked.joints is None else self._with_classes(asked.joints, model)
        found = factor_of_safety(model, options, stage=asked.stage, joints=joints, tolerance=asked.tolerance)
        if found.stable is not None and found.stable >= 1:
            status = Status.STABLE
        elif found.unstable is not None and found.unstable <= 1:
            status = Status.UNSTABLE
        else:
            status = Status.NOT_CONVERGED
        return {
            "status": status.value,
            "reason": "by the factor of safety",
            "factor": found.factor,
            "factor_stable": found.stable,
            "factor_unstable": found.unstable,
            "factor_undecided": len(found.undecided),
        }

    def _with_classes(self, names: Sequence[str], model: Model) -> list[str]:
        """Return joints by name, and the classes of those that scatter from face to face."""
        scattered = {f"{scatter.joint}~" for scatter in self.scatters if scatter.joint in names}
        there = [joint.name for joint in model.joints]
        known = {name for name in names if f"{name}~" not in scattered or name in there}
        return [*sorted(known), *(name for name in there if any(name.startswith(start) for start in scattered))]


def work_of(study: Study, key: str) -> StudyWork:
    """Return the task of every run of a study, known by a key."""
    return StudyWork(
        key=key,
        variation=study.variation,
        scatters=study.scatters,
        answers=tuple(study.file.answers),
        safety=study.file.safety,
        seed=study.file.seed,
    )


def failed(why: str) -> dict[str, Any]:
    """Return the answers of a run that came to nothing."""
    return {"status": FAILED, "error": one_line(why)}


def told_of(results: Results) -> dict[str, Any]:
    """Return the row of a table for results: of their last stage."""
    stage, down = results.stages[-1], results.unstable_blocks
    before_rest = [gave_way(results.blocks, each) for each in results.stages]
    return {
        "status": results.status.value,
        "stage": stage.name,
        "reason": stage.reason,
        "max_displacement": stage.max_displacement,
        "moved_blocks": sum(fallen + far.size for fallen, far in before_rest),
        "unstable_blocks": len(down),
        unstable_bulk(results.blocks.bulk_name): float(results.blocks.moments.bulk[down].sum()),
        "steps": sum(len(each.steps) for each in results.stages),
    }


def _finite(value: Any) -> Any:
    """Return a value for the journal: a number that is none, or beyond all, is left out."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
