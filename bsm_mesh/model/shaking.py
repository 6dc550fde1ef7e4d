"""Shaking of the ground as it is given: a record or a waveform, and the movement of the supports."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from bsm_mesh.errors import as_given, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.quantities import (
    COUNT_OF_WAVES,
    DAMPING,
    DIRECTION,
    DURATION,
    FREQUENCY,
    IMBALANCE,
    MASS_SCALING,
    MOTION,
    MOTION_FACTOR,
    PART,
)
from bsm_mesh.model.values import Rules, is_number, parts_of

Waveform = Literal["sine", "ricker", "pulse"]
MotionQuantity = Literal["acceleration", "velocity", "stress"]
Integrator = Literal["explicit", "implicit"]
Series = tuple[tuple[float, ...], tuple[float, ...]]
HOUSNER = "housner"
HOUSNER_DASHPOTS = 2.0  # over the critical ones: a block rebounds by a twentieth of its speed, by a seventh on critical
PART_OF_STABLE = 0.5  # of the stable time step, by default
RICKER_PERIODS = 3.0  # length of a Ricker wavelet, over its period: at both ends it is 1e-9 of its peak


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaking:
    """Shaking of all supports together, or of a quiet boundary, by a record or by a waveform.

    Give either `record` or `waveform`. The supports move as one rigid base in `direction`; displacements are relative
    to this base. With `boundary` a wave enters there instead, and supports are at rest.

    Attributes
    ----------
    record : (times, values) or None [s], [m/s2, m/s or Pa]
        Times, rising from 0 or later, and the base's values at them; straight lines in between.
    waveform : {"sine", "ricker", "pulse"} or None
        ``"sine"``: amplitude times the sine, from 0. ``"ricker"``: a Ricker wavelet of 3 periods, its peak in the
        middle. ``"pulse"``: the amplitude, constant.
    frequency : float [Hz]
        Of the waveform; of a Ricker wavelet the one of its greatest amplitude.
    amplitude : float [m/s2, m/s or Pa]
        Of the waveform, by `quantity`: m/s2 of an acceleration, m/s of a velocity, Pa of a stress.
    cycles : float
        Length of a sine or a pulse, in periods.
    quantity : {"acceleration", "velocity", "stress"}
        Of record or waveform; the stress is a traction on `boundary`, twice that of the wave that enters.
    direction : float [degrees]
        Of the movement, from x, counter-clockwise: 0 horizontal, 90 vertical.
    scale : float
        Factor on the record or the waveform.
    quiet : tuple of str
        Boundaries that let waves out. Viscous dashpots replace their supports while the stage is shaken; the forces of
        these supports stay. Waves have the speed of blocks on their springs.
    boundary : str or None
        The quiet boundary through which a wave enters; None: the supports move.
    duration : float or None [s]
        How long the stage is shaken and followed in time; None: as long as the record or the waveform. Beyond these the
        base keeps its velocity.
    every : float or None [s]
        Time between two values of histories and energies; None: a five-hundredth of the duration.
    contact_damping : float or "housner"
        Dashpots of closed contacts across and along the face, over the critical ones; 0: none. ``"housner"``: twice the
        critical ones, with which a rocking block loses as much in an impact as Housner's (1963), whatever its
        slenderness.
    mass_damping : (ratio, frequency) or None [-, Hz]
        Part of critical damping, at a frequency, of a drag on all blocks by their masses; None: none.
    integrator : {"explicit", "implicit"}
        Central differences; or the trapezoidal rule with contact forces at the end of each time step, for few blocks
        and as a second opinion.
    time_step : float
        Part of the stable time step that is taken. The error of the energy balance belongs to its square. Of the
        implicit integrator: the longest time step, over `every`; it is halved where the balance asks for it.
    mass_scaling : float
        Blocks may be heavier than real by this factor at most, for a longer time step; 1: never.
    max_imbalance : float
        Error of the energy balance, over the greatest energy in it. With a greater error the stage is not converged.

    Raises
    ------
    ModelError
        With every fault found.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> shaking = bsm.Shaking(waveform="sine", frequency=2.0, amplitude=3.0, cycles=20)
    >>> shaking.length
    10.0
    """

    record: Given[Series | None, tuple[npt.ArrayLike, npt.ArrayLike] | None] = by_default(None)
    waveform: Waveform | None = None
    frequency: Annotated[float, FREQUENCY] | None = None
    amplitude: Annotated[float, MOTION] | None = None
    cycles: Annotated[float, COUNT_OF_WAVES] | None = None
    quantity: MotionQuantity = "acceleration"
    direction: Annotated[float, DIRECTION] = 0.0
    scale: Annotated[float, MOTION_FACTOR] = 1.0
    quiet: Given[tuple[str, ...], Sequence[str]] = by_default(())
    boundary: str | None = None
    duration: Annotated[float, DURATION] | None = None
    every: Annotated[float, DURATION] | None = None
    contact_damping: Annotated[float, DAMPING] | Literal["housner"] = 0.0
    mass_damping: tuple[float, float] | None = None
    integrator: Integrator = "explicit"
    time_step: Annotated[float, PART] = PART_OF_STABLE
    mass_scaling: Annotated[float, MASS_SCALING] = 1.0
    max_imbalance: Annotated[float, IMBALANCE] = 0.01

    def __post_init__(self) -> None:
        rules = Rules("shaking")
        self._check_kinds(rules)
        raise_faults(rules.faults)
        rules.faults += [*self._boundary_faults(), *self._implicit_faults()]
        if (self.record is None) == (self.waveform is None):
            rules.faults.append("shaking: needs a record or a waveform, and not both")
        elif self.record is not None:
            object.__setattr__(self, "record", _series(self.record, rules))
        else:
            rules.faults += self._waveform_faults()
        if self.mass_damping is not None:
            object.__setattr__(self, "mass_damping", _damping(self.mass_damping, rules))
        raise_faults(rules.faults)
        if self.every is not None and self.every > self.length:
            raise_faults([f"shaking: every = {self.every:g} s is longer than the {self.length:g} s that are followed"])

    def _check_kinds(self, rules: Rules) -> None:
        """Hold every field to its kind, before those that belong together are compared."""
        damping = self.contact_damping
        rules.numbers(self, without=("contact_damping",) if isinstance(damping, str) and damping == HOUSNER else ())
        rules.choice("quantity", self.quantity, get_args(MotionQuantity))
        rules.choice("integrator", self.integrator, get_args(Integrator))
        if self.waveform is not None:
            rules.choice("waveform", self.waveform, get_args(Waveform))
        object.__setattr__(self, "quiet", rules.texts("quiet", self.quiet))
        rules.text("boundary", self.boundary, optional=True)

    def _waveform_faults(self) -> list[str]:
        """Return the missing and the surplus values of the waveform."""
        needed = {"frequency": self.frequency, "amplitude": self.amplitude}
        faults = [f"shaking: waveform needs {name}" for name, value in needed.items() if value is None]
        if self.waveform == "ricker" and self.cycles is not None:
            faults.append("shaking: a Ricker wavelet has no cycles; remove them")
        return faults

    def _boundary_faults(self) -> list[str]:
        """Return faults of the boundary through which a wave enters."""
        if self.boundary is not None and self.boundary not in self.quiet:
            return [f"shaking: boundary = '{self.boundary}' is not quiet; add it to quiet"]
        if self.boundary is None and self.quantity == "stress":
            return ["shaking: quantity = 'stress' needs the boundary on which it acts, one of quiet"]
        if len(set(self.quiet)) < len(self.quiet):
            return ["shaking: quiet names a boundary twice; name each once"]
        return []

    def _implicit_faults(self) -> list[str]:
        """Return the keys that the implicit integrator cannot take."""
        if self.integrator != "implicit":
            return []
        faults = []
        if self.quiet:
            faults.append("shaking: quiet boundaries need integrator = 'explicit'")
        if self.mass_scaling != 1:
            faults.append("shaking: mass_scaling has no use with integrator = 'implicit'; remove it")
        return faults

    @property
    def dashpots(self) -> float:
        """Dashpots of closed contacts over the critical ones: 2 for ``"housner"``."""
        return HOUSNER_DASHPOTS if isinstance(self.contact_damping, str) else float(self.contact_damping)

    @property
    def drag(self) -> float:
        """Drag on blocks over their masses [1/s]: 2 ratio (2 pi frequency)."""
        ratio, frequency = self.mass_damping or (0.0, 0.0)
        return 4 * math.pi * ratio * frequency

    @property
    def own_length(self) -> float:
        """Length of the record or the waveform [s]."""
        if self.record is not None:
            return self.record[0][-1]
        assert self.frequency is not None
        cycles = RICKER_PERIODS if self.waveform == "ricker" else (1.0 if self.cycles is None else self.cycles)
        return cycles / self.frequency

    @property
    def length(self) -> float:
        """How long the stage is shaken and followed in time [s]."""
        return self.own_length if self.duration is None else self.duration

    @property
    def interval(self) -> float:
        """Time between two values of histories and energies [s]: a whole part of the length."""
        wanted = self.length / 500 if self.every is None else self.every
        return self.length / max(1, round(self.length / wanted))


def _damping(value: Any, rules: Rules) -> tuple[float, float]:
    """Return ratio and frequency of mass damping; zeros where the rule is broken."""
    parts, before = parts_of(value) or [], len(rules.faults)
    if len(parts) != 2:
        rules.faults.append(f"shaking: mass_damping = {as_given(value)} must be a pair (ratio, frequency)")
        return 0.0, 0.0
    rules.number("mass_damping: ratio", parts[0], DAMPING)
    rules.number("mass_damping: frequency", parts[1], FREQUENCY)
    return (float(parts[0]), float(parts[1])) if len(rules.faults) == before else (0.0, 0.0)


def _series(value: Any, rules: Rules) -> Series | None:
    """Return times and values as tuples; faults are added where they are none."""
    before, parts = len(rules.faults), [parts_of(part) or [] for part in parts_of(value) or ()]
    if len(parts) != 2:
        rules.faults.append(f"shaking: record = {as_given(value)} must be a pair (times, values)")
        return None
    for name, numbers in zip(("times", "values"), parts, strict=True):
        bad = next((k for k, number in enumerate(numbers) if not is_number(number)), None)
        if bad is not None:
            rules.faults.append(f"shaking: record: {name}[{bad}] = {as_given(numbers[bad])} is not a finite number")
    if len(rules.faults) > before:
        return None
    times, values = tuple(map(float, parts[0])), tuple(map(float, parts[1]))
    if len(times) != len(values) or len(times) < 2:
        rules.faults.append(
            f"shaking: record has {len(times)} times and {len(values)} values; give two or more of both"
        )
    elif times[0] < 0 or min(np.diff(times)) <= 0:
        rules.faults.append("shaking: record: times must rise, from 0 or later")
    for number in (min(values, default=0.0), max(values, default=0.0)):
        rules.number("record", number, MOTION)
    return times, values
