"""Records of earthquakes: tables (CSV) of time and value, and the files of the PEER strong-motion database (.at2)."""

from __future__ import annotations

import re
from pathlib import Path

from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import MotionQuantity, Series
from bsm_mesh.reading import read_text
from bsm_mesh.table_rows import Rows, read_rows

SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3}
ACCELERATIONS = {"m/s2": 1.0, "m/s^2": 1.0, "g": GRAVITY, "cm/s2": 0.01, "cm/s^2": 0.01, "gal": 0.01, "mm/s2": 1e-3}
ACCELERATIONS |= {"%g": 0.01 * GRAVITY, "ft/s2": 0.3048, "ft/s^2": 0.3048, "in/s2": 0.0254, "in/s^2": 0.0254}
STRESSES = {"pa": 1.0, "kpa": 1e3, "mpa": 1e6}
VELOCITIES = {"m/s": 1.0, "cm/s": 0.01, "mm/s": 1e-3, "ft/s": 0.3048, "in/s": 0.0254}
UNITS: dict[str, dict[str, float]] = {"acceleration": ACCELERATIONS, "velocity": VELOCITIES, "stress": STRESSES}
AMPLITUDE = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S.*?)\s*")
STEP = re.compile(r"\bDT\s*=\s*([\d.]+(?:[eE][-+]?\d+)?)", re.IGNORECASE)
HEADER_OF_PEER = 4  # lines


def read_record(path: Path, quantity: MotionQuantity) -> Series:
    """Return times [s] and accelerations [m/s2], velocities [m/s] or stresses [Pa] of a file.

    Raises
    ------
    ModelError
        If it is no such table, or no number is where one is to be.
    """
    if path.suffix.lower() == ".at2":
        return _of_peer(path, quantity)
    rows = read_rows(path, "a record: time and value")
    values = [name for name in rows.names if name in (quantity, "value")]
    if "time" not in rows.names or len(values) != 1:
        other = [name for name in rows.names if name in UNITS and name != quantity]
        cure = f"; give quantity = '{other[0]}' if it is of that" if "time" in rows.names and len(other) == 1 else ""
        raise ModelError(
            f"{path}: a record needs the columns 'time' and '{quantity}' (or 'value'); its header has "
            f"{', '.join(rows.header)}{cure}"
        )
    units = UNITS[quantity]
    faults: list[str] = []
    time = _column(rows, "time", SECONDS, "s", faults)
    value = _column(rows, values[0], units, next(iter(units)), faults)
    raise_faults(faults)
    return time, value


def amplitude_of(text: str, quantity: str) -> float:
    """Return the amplitude of a waveform in SI units, from a text in a unit that records have too.

    Examples
    --------
    >>> amplitude_of("0.15 g", "acceleration"), amplitude_of("20 cm/s", "velocity")
    (1.4715, 0.2)

    Raises
    ------
    ValueError
        If it has another unit, or none.
    """
    units, found = UNITS[quantity], AMPLITUDE.fullmatch(text)
    factor = units.get(found[2].lower()) if found else None
    if found is None or factor is None:
        raise ValueError(
            f"amplitude = '{text}': give a plain number [{next(iter(units))}], or a text with one of the units "
            f"{', '.join(units)} of quantity = '{quantity}'"
        )
    try:
        return float(f"{float(found[1]) * factor:.15g}")
    except ValueError:
        raise ValueError(f"amplitude = '{text}': '{found[1]}' is no number") from None


def _column(rows: Rows, name: str, units: dict[str, float], example: str, faults: list[str]) -> tuple[float, ...]:
    """Return a column in SI units; faults are added where a cell is no finite number."""
    column = rows.names.index(name)
    factor = rows.factor(column, units, example)
    return tuple(factor * rows.finite(row, column, faults) for row in range(len(rows.cells)))


def _of_peer(path: Path, quantity: MotionQuantity) -> Series:
    """Return the record of a file of PEER: accelerations in g, at times that its header says."""
    if quantity != "acceleration":
        raise ModelError(f"{path}: an .at2 file holds accelerations; remove quantity = '{quantity}'")
    lines = read_text(path).splitlines()
    found = STEP.search(" ".join(lines[:HEADER_OF_PEER]))
    if found is None or float(found[1]) <= 0:
        raise ModelError(f"{path}: its first four lines have no time step (DT = 0.01); is it a file of PEER?")
    try:
        values = tuple(GRAVITY * float(word) for line in lines[HEADER_OF_PEER:] for word in line.split())
    except ValueError as error:
        raise ModelError(f"{path}: {error}") from None
    return tuple(float(found[1]) * number for number in range(len(values))), values
