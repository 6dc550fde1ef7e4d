"""``bsm-mesh verify``: the ground of every verdict, checked from the files of a results folder alone."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.certificate.certificate import CERTIFICATE, SCHEMA_VERSION, certificate, certificate_arrays
from bsm_mesh.certificate.verify_certificate import check_stage, read_arrays
from bsm_mesh.errors import ModelError, named_stage
from bsm_mesh.folder.older_results import WRITTEN
from bsm_mesh.folder.saved_results import SavedResults, damage_told
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results, StageResults
from bsm_mesh.text.terminal import say, say_json

HELD, FAILED = 0, 3  # exit codes


@dataclass(frozen=True, slots=True, kw_only=True)
class Ground:
    """Ground of the verdict of a stage.

    Attributes
    ----------
    stage : str
        Name of the stage.
    verdict : str
        Its verdict.
    kind : {"equilibrium", "proved", "followed", "best state"}
        Forces that balance; a mechanism that proves that blocks must move; blocks that were followed; none of them.
    holds : bool
        Whether all checks that are possible agree.
    text : str
        The ground in words, with its numbers.
    """

    stage: str
    verdict: str
    kind: str
    holds: bool
    text: str

    def __str__(self) -> str:
        """Return the ground in words; one that does not hold says so."""
        return f"{self.kind}: {'' if self.holds else 'DOES NOT HOLD: '}{self.text}"


def print_grounds(grounds: Sequence[Ground], *, as_json: bool) -> int:
    """Print the grounds of all stages; return the exit code."""
    if as_json:
        say_json([asdict(ground) for ground in grounds])
    else:
        for ground in grounds:
            say(f"{named_stage(ground.stage)}: {ground.verdict}, {ground}")
    return HELD if all(ground.holds for ground in grounds) else FAILED


def grounds_in(out: Path) -> tuple[Ground, ...]:
    """Return the grounds of all stages in a results folder.

    Raises
    ------
    ModelError
        If it holds no results, or none with a certificate.
    """
    results = Results.load(out)
    saved = SavedResults(out)
    if CERTIFICATE not in saved:
        raise ModelError(f"{out} holds no {CERTIFICATE}; run the model again")
    if WRITTEN in saved.told:
        raise ModelError(
            f"{out} was written with schema version {saved.told[WRITTEN]}: its certificate is checked by the bsm-mesh "
            "that wrote it, or run its model.toml again"
        )
    told = _certificate_in(saved)
    if told.get("schema_version") != SCHEMA_VERSION:
        raise ModelError(
            f"{CERTIFICATE} in {out} has schema version {told.get('schema_version')}, and {SCHEMA_VERSION} is checked; "
            "run its model.toml again"
        )
    with damage_told(out):
        arrays = [saved.content(stage["arrays"]) for stage in told["stages"]]
        return tuple(grounds_of(results, told, arrays))


def _certificate_in(saved: SavedResults) -> dict[str, Any]:
    with damage_told(saved.folder / CERTIFICATE):
        told: dict[str, Any] = json.loads(saved.content(CERTIFICATE))
        if not isinstance(told, dict):
            raise TypeError("no JSON object")
        return told


def grounds_of(results: Results, told: dict[str, Any], arrays: list[bytes]) -> Iterator[Ground]:
    """Yield the ground of every stage's verdict.

    Parameters
    ----------
    results : Results
        Results of the folder.
    told : dict
        Its certificate.
    arrays : list of bytes
        Content of the certificate's arrays, a file a stage.
    """
    expected = certificate(results)
    if {key: told[key] for key in told if key != "stages"} != {
        key: expected[key] for key in expected if key != "stages"
    }:
        raise ModelError(f"{CERTIFICATE} is not of these results; run the model again")
    for stage, said, meant, content in zip(results.stages, told["stages"], expected["stages"], arrays, strict=True):
        columns = read_arrays(io.BytesIO(content))
        text, faults = check_stage(told, said, columns)
        if said != meant or not _agree(columns, certificate_arrays(results, stage)):
            faults.append("the certificate is not of these results")
        faults += _against(results, stage)
        yield Ground(
            stage=meant["name"],
            verdict=meant["verdict"],
            kind=meant["ground"],
            holds=not faults,
            text="; ".join(faults) or text,
        )


def _agree(one: dict[str, Any], other: dict[str, Any]) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


def _against(results: Results, stage: StageResult) -> list[str]:
    """Return the faults that the results' own check, which knows no limit of size, finds in a stage at rest."""
    if not stage.status.is_at_rest:
        return []
    return list(replace(results, stages=StageResults((stage,))).check().faults)
