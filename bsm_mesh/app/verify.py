"""``bsm-mesh verify``: on what every verdict rests, checked from the files of a results folder alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.app.build import load
from bsm_mesh.app.model_text import MODEL
from bsm_mesh.app.terminal import say, say_json
from bsm_mesh.errors import ModelError, counted, listing
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Results, StageResult, Status
from bsm_mesh.solve.limit.analysis import limit_analysis

ModelOf = Callable[[], Model]
MOST_BLOCKS = 1000  # of which a proof is sought unasked: the linear program takes seconds there, minutes beyond
HELD, FAILED = 0, 3  # exit codes


@dataclass(frozen=True, slots=True, kw_only=True)
class Ground:
    """On what the verdict of a stage rests.

    Attributes
    ----------
    stage : str
        Name of the stage.
    verdict : str
        Its verdict.
    kind : {"checked", "proved", "followed", "none"}
        Forces that balance, checked; proof that blocks must move; blocks that were followed; no ground.
    holds : bool
        Whether what can be checked was found so.
    text : str
        The ground in words, with its numbers.
    """

    stage: str
    verdict: str
    kind: str
    holds: bool
    text: str


def verify(out: Path, *, proof: bool | None, as_json: bool) -> int:
    """Check every verdict in a results folder; print the grounds; return the exit code.

    `proof`: whether limit analysis is asked about what came down in the first stage; None: of a model that is small.
    """
    results = Results.load(out)
    grounds = tuple(grounds_of(results, lambda: _model(out), proof=proof))
    if as_json:
        say_json([asdict(ground) for ground in grounds])
    else:
        for ground in grounds:
            doubt = "" if ground.holds else "DOES NOT HOLD: "
            say(f"stage {ground.stage}: {ground.verdict}, {ground.kind}: {doubt}{ground.text}")
    return HELD if all(ground.holds for ground in grounds) else FAILED


def grounds_of(results: Results, model: ModelOf, *, proof: bool | None = None) -> Iterator[Ground]:
    """Yield the ground of every stage's verdict; `model` returns what was run, or raises a ModelError."""
    for number, stage in enumerate(results.stages):
        verdict = stage.status.value
        if stage.status.is_stable:
            yield Ground(stage=stage.name, verdict=verdict, **_checked(results, stage))
        elif stage.status is Status.UNSTABLE:
            asked = results.blocks.count <= MOST_BLOCKS if proof is None else proof
            unasked = "no proof was sought" if number == 0 else "a proof is sought in the first stage alone"
            told = _proved(model) if asked and number == 0 else unasked
            if told is None:
                text = "no forces within strength balance the loads where the blocks were given: they must move"
                yield Ground(stage=stage.name, verdict=verdict, kind="proved", holds=True, text=text)
            else:
                text = f"{_followed(results, stage)}; {told}"
                yield Ground(stage=stage.name, verdict=verdict, kind="followed", holds=True, text=text)
        else:
            text = f"residual {stage.residual:.1e} at the end; {stage.reason}"
            yield Ground(stage=stage.name, verdict=verdict, kind="none", holds=True, text=text)


def _checked(results: Results, stage: StageResult) -> dict[str, Any]:
    """Return what the independent check finds of a stage at rest."""
    check = replace(results, stages=(stage,)).check()
    if results.scheme == "linear":
        return {"kind": "checked", "holds": check.ok, "text": f"{check}; in this scheme nothing can slip or open"}
    if not check.ok:
        return {"kind": "checked", "holds": False, "text": "; ".join(check.faults)}
    closed = int((stage.contacts.normal_force != 0).sum())
    text = (
        f"forces in {counted(closed, 'contact')} balance every block to {check.block_residual:.1e} of the reference "
        f"weight, and all loads to {check.balance:.1e} (tolerance {check.tolerance:.0e}); none bears more than "
        f"{check.utilisation:.6f} of its shear strength; blocks overlap by {max(check.overlap, 0.0):.1e} of a block's "
        "area beyond the closure of joints"
    )
    return {"kind": "checked", "holds": True, "text": text}


def _followed(results: Results, stage: StageResult) -> str:
    """Say which blocks came down, and how far they were followed."""
    blocks = stage.unstable_blocks
    moved = np.hypot(*stage.displacement[blocks, :2].T)
    sizes = moved / np.sqrt(results.blocks.moments.area[blocks])
    return (
        f"{stage.reason}; {counted(len(blocks), 'block')} followed for {counted(len(stage.steps), 'step')}, over up to "
        f"{moved.max(initial=0.0):.3g} m, {sizes.max(initial=0.0):.2g} of its size (block {listing(blocks)})"
    )


def _proved(model: ModelOf) -> str | None:
    """Return None where limit analysis proves that blocks must move, else what it says."""
    try:
        found = limit_analysis(model())
    except ModelError as error:
        return f"no proof: {error}"
    if found.admissible:
        return "no proof: forces within strength exist that balance the loads, which proves nothing"
    return None


def _model(out: Path) -> Model:
    return load(out / MODEL, scripts=False)
