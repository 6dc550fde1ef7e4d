"""One input of a campaign, and the outcome of it."""

from __future__ import annotations

import re
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.geometries.errors import GeometryError

ROOT = Path(__file__).parents[2]
OK, REFUSED = "ok", "refused"
FAULTS = ("traceback", "crash", "hang", "left behind", "accepted", "control characters")  # what must not be
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e]")


class AcceptedError(AssertionError):
    """What should have been refused was taken without a word."""


class ControlError(AssertionError):
    """A control character of the input reached the terminal."""


@dataclass(frozen=True)
class Input:
    """An input: files in a folder of their own, and what is done with them there.

    Attributes
    ----------
    told : str
        What is done, for people.
    act : callable
        Does it. It may raise `ModelError` and `GeometryError`, or return `REFUSED`; what else it raises is a finding.
    files : mapping of str to bytes
        The folder's content.
    leaves : tuple of str
        Names that `act` may leave in the folder.
    """

    told: str
    act: Callable[[], object]
    files: Mapping[str, bytes] = field(default_factory=dict)
    leaves: tuple[str, ...] = ()


@dataclass(frozen=True)
class Target:
    """A door of the program.

    Attributes
    ----------
    name : str
        Its name.
    draw : callable
        Returns the input of a `Random`, from the good ones in a folder.
    share : float
        Its part of all inputs.
    prepare : callable
        Writes the good ones into that folder; called once.
    """

    name: str
    draw: Callable[[Random, Path], Input]
    share: float
    prepare: Callable[[Path], None] = lambda folder: None


@dataclass(frozen=True)
class Outcome:
    """The outcome of an input: a class, and for a fault a signature that is the same for the same fault."""

    kind: str
    signature: str = ""
    detail: str = ""


def random_of(seed: int, target: str, index: int) -> Random:
    """Return the random numbers of an input: the same whenever and wherever it is drawn."""
    return Random(f"{seed}/{target}/{index}")


def judge(given: Input) -> Outcome:
    """Do what an input asks, in the current folder, and return the outcome of it."""
    try:
        kind = given.act()
    except (ModelError, GeometryError):
        return Outcome(REFUSED)
    except AcceptedError as error:
        return Outcome("accepted", str(error).partition("\n")[0], str(error))
    except ControlError as error:
        return Outcome("control characters", str(error).partition("\n")[0], str(error))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        lines = "".join(traceback.format_exception(error, limit=-12))
        return Outcome("traceback", f"{type(error).__name__} in {where(error)}", lines[-6000:])
    return Outcome(REFUSED if kind == REFUSED else OK)


def where(error: BaseException) -> str:
    """Return the deepest place of ours in an exception's traceback: ``bsm_mesh/modelfile/units.py:convert``."""
    found = "?"
    for frame in traceback.extract_tb(error.__traceback__):
        path = Path(frame.filename).resolve()  # bsm_mesh.geometries is a link to the folder
        if path.is_relative_to(ROOT) and not {"tests", "tools", ".venv"} & set(path.relative_to(ROOT).parts):
            found = f"{path.relative_to(ROOT)}:{frame.name}"
    return found


def demand_finite(values: Any, what: str) -> None:
    """Raise `AcceptedError` where an array that came of an input holds nan or infinity."""
    import numpy as np

    if not np.all(np.isfinite(np.asarray(values, dtype=float))):
        raise AcceptedError(f"{what}: not finite")


def without_numbers(name: str) -> str:
    """Return a name with a mark for every digit in it."""
    return "".join("#" if letter.isdigit() else letter for letter in name)
