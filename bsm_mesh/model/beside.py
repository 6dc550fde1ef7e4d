"""Values compared with a history: measured ones, or those of another program."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from bsm_mesh.errors import as_given, nearest, raise_faults
from bsm_mesh.model.quantities import DISTANCE
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.model.values import Rules, parts_of, plain_numbers

VALUE = Quantity(least=-1e13, most=1e13, example="0.008")
UNITS = {
    **dict.fromkeys(("u", "v", "displacement", "extension", "towards", "across", "slip", "opening"), "m"),
    **dict.fromkeys(("slipping_share", "open_share"), ""),
    "rotation": "deg",
    "axial_force": "N",
}
"""Unit of each quantity."""
QUANTITIES = {
    "point": ("u", "v", "displacement"),
    "line": ("extension", "towards", "across"),
    "block": ("u", "v", "displacement", "rotation"),
    "joint": ("slip", "opening", "slipping_share", "open_share"),
    "bolt": ("axial_force",),
}
"""Reference values that a history of each kind takes."""


@dataclass(frozen=True, kw_only=True)
class Beside:
    """A value at the end of a stage, compared with a history of a run.

    Attributes
    ----------
    quantity : str
        Of a point or block ``u``, ``v``, ``displacement`` (its length) [m], of a block ``rotation`` [deg]; of a line
        ``extension``, ``towards`` its first point, ``across`` it (to the left of the way along it) [m]; of a joint
        ``slip``, ``opening`` [m], ``slipping_share``, ``open_share``; of a bolt ``axial_force`` [N].
    value : float
        In that unit.
    until : float, optional
        Where only a range is known its other end.
    stage : str, optional
        Name or number of the stage at whose end it holds; by default the last one.
    distance : float, optional [m]
        Of a line, and only there: from its first point.
    source : str
        Where it comes from; the key of the pictures says so.

    Raises
    ------
    ModelError
        If a value is none, or the quantity unknown.
    """

    quantity: str
    value: float
    until: float | None = None
    stage: str | None = None
    distance: float | None = None
    source: str = "measured"

    def __post_init__(self) -> None:
        rules = Rules("value compared with a history", self.quantity)
        rules.choice("quantity", self.quantity, UNITS)
        rules.number("value", self.value, VALUE)
        rules.number("until", self.until, VALUE, optional=True)
        rules.number("distance", self.distance, DISTANCE, optional=True)
        rules.text("stage", self.stage, optional=True)
        rules.name(self.source)
        raise_faults(rules.faults)
        plain_numbers(self)

    @property
    def middle(self) -> float:
        """The value, or the middle of the range."""
        return self.value if self.until is None else (self.value + self.until) / 2

    def difference(self, found: float) -> float:
        """Return the computed value less the reference value; of a range from its nearer end, 0 within it."""
        low, high = sorted((self.value, self.value if self.until is None else self.until))
        return found if math.isnan(found) else found - min(max(found, low), high)


def values_beside(rules: Rules, value: object) -> tuple[Beside, ...]:
    """Return values as a tuple; a fault is added where they are none."""
    parts = parts_of(value)
    if parts is None or not all(isinstance(part, Beside) for part in parts):
        rules.faults.append(f"{rules.thing}: measured = {as_given(value)} must be a list of bsm.Beside(...)")
        return ()
    return tuple(parts)


def faults_beside(name: str, kind: str, measured: Iterable[Beside], length: float) -> Iterable[str]:
    """Return a sentence for every value that cannot stand compared with a history of a kind, a line of a length [m]."""
    for one in measured:
        if one.quantity not in QUANTITIES[kind]:
            yield (
                f"history '{name}': a {kind} has no {one.quantity}; "
                f"measured values of it are {', '.join(QUANTITIES[kind])}"
            )
        elif kind != "line" and one.distance is not None:
            yield f"history '{name}': a {kind} has no distance; leave the column distance empty"
        elif kind == "line" and one.distance is None:
            yield f"history '{name}': {one.quantity} needs its distance from the first point of the line"
        elif kind == "line" and one.distance is not None and not one.distance <= length * (1 + 1e-6):
            yield f"history '{name}': the distance {one.distance:g} m is beyond the end of the line at {length:.6g} m"


def unknown_stages(name: str, measured: Iterable[Beside], stage_names: Sequence[str]) -> Iterable[str]:
    """Return a sentence for every stage of the values of a history that is not among the stages of a run."""
    for stage in dict.fromkeys(one.stage for one in measured):
        if stage is not None and number_of(stage, stage_names) is None:
            yield f"history '{name}': measured: there is no stage '{stage}'{nearest(stage, stage_names)}"


def number_of(stage: str | None, stage_names: Sequence[str]) -> int | None:
    """Return the number of a stage by its name or number, the last one where none is named; None: there is none."""
    if stage is None:
        return len(stage_names) - 1
    if stage in stage_names:
        return list(stage_names).index(stage)
    return int(stage) if stage.isdecimal() and int(stage) < len(stage_names) else None
