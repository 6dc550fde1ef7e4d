"""The answer to a combination: run, checked, saved, verified, read back, run again and drawn."""

from __future__ import annotations

import contextlib
import io
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.combinations import plane, space
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.results.records import StepRecord
from examples.numbers.pages import markdown

LONGEST = 60.0  # s of processor time that a run may take
DRAWN = ("displacement", "joints_state", "deformation", "histories", "sigma_1")


Combination = tuple[dict[str, Any], bsm.Options, list[str]]
"""Parts of a model, its options, and the names of its features."""


def in_turn(seed: int) -> dict[str, Any]:
    """Return the answer to the combination of a seed: in the plane of even seeds, in space of odd ones."""
    return judged(seed, space.combination if seed % 2 else plane.combination)


def judged(seed: int, draw: Callable[[int], Combination]) -> dict[str, Any]:
    """Return the answer to a combination: its verdict or ``refused``, and faults."""
    parts, options, tags = draw(seed)
    begun = time.process_time()
    told: dict[str, Any] = {"seed": seed, "tags": tags, "faults": []}
    try:
        results = bsm.run(bsm.Model(**parts), options, _ends_by(begun + LONGEST))
        told |= {"verdict": str(results.status), "reason": results.stages[-1].reason}
        told["faults"] = _faults(results)
    except bsm.ModelError as error:
        told |= {"verdict": "refused", "reason": str(error)}
    except TimeoutError:
        told |= {"verdict": "stopped", "reason": f"after {LONGEST:g} s"}
    except Exception as error:
        told |= {"verdict": "error", "reason": f"{type(error).__name__}: {error}", "faults": ["error"]}
    return {**told, "seconds": round(time.process_time() - begun, 2)}


def _ends_by(end: float) -> Callable[[StepRecord], None]:
    """Return an observer that stops a run at a processor time [s]."""

    def watch(record: StepRecord) -> None:
        if time.process_time() > end:
            raise TimeoutError

    return watch


def _faults(results: bsm.Results) -> list[str]:
    """Return which of check, certificate, reading, running again and drawing do not hold."""
    found = [] if results.status != "stable" or results.check().ok else ["check"]
    with tempfile.TemporaryDirectory() as place, contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.ResultsWarning)  # a model in space that is made in Python has no file
        folder = results.save(Path(place) / "out")
        found += ["certificate"] * (verify_certificate.main(folder) != 0)
        back = bsm.Results.load(folder)
        found += _other_again(results, folder / "model.toml")
    found += ["read back"] * (back.status != results.status)
    for picture in DRAWN:
        with contextlib.suppress(bsm.ModelError):  # there is nothing to show
            back.plot(picture)
    return found


def _other_again(results: bsm.Results, path: Path) -> list[str]:
    """Return a fault if the model as run, where it has a file, has another answer."""
    if not path.is_file():
        return []
    again = bsm.run(path, observer=_ends_by(time.process_time() + LONGEST))
    before, now = (each.stages[-1].displacement for each in (results, again))
    return ["run again"] * (again.status != results.status or not np.allclose(now, before, rtol=1e-6, atol=1e-9))


def table(records: list[dict[str, Any]]) -> str:
    """Return verdicts and processor times, and the combinations with a fault."""
    verdicts = Counter(record["verdict"] for record in records)
    seconds = {name: sum(r["seconds"] for r in records if r["verdict"] == name) for name in verdicts}
    rows = [(name, str(count), f"{seconds[name]:.0f}") for name, count in sorted(verdicts.items())]
    wrong = [f"seed {r['seed']}: {', '.join(r['faults'])} ({', '.join(r['tags'])})" for r in records if r["faults"]]
    return "\n".join([markdown(("answer", "combinations", "processor time, s"), rows), "", *wrong])
