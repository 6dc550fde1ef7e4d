"""Units that names of fields and columns tell in brackets, ``Sigma XX (MPa)``, ``u_x [mm]``."""

from __future__ import annotations

import math
import re

from bsm_mesh.errors import ModelError

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048, "in": 0.0254, "km": 1e3}
POUND = 4.4482216152605  # N
STRESSES = {
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "N/m2": 1.0,
    "kN/m2": 1e3,
    "MN/m2": 1e6,
    "N/mm2": 1e6,
    "psi": POUND / 0.0254**2,
    "ksi": 1e3 * POUND / 0.0254**2,
    "psf": POUND / 0.3048**2,
    "tsf": 2e3 * POUND / 0.3048**2,
    "ksf": 1e3 * POUND / 0.3048**2,
}
UNIT_WEIGHTS = {"N/m3": 1.0, "pcf": POUND / 0.3048**3, "kcf": 1e3 * POUND / 0.3048**3}

ANGLES = {"deg": 1.0, "degrees": 1.0, "\N{DEGREE SIGN}": 1.0, "rad": math.degrees(1.0), "mrad": math.degrees(1e-3)}
BRACKETS = re.compile(r"\s*[(\[]([^()\[\]]*)[)\]]\s*$")


def without_unit(name: str) -> str:
    """Return a name without the unit in brackets at its end.

    Examples
    --------
    >>> without_unit("Sigma XX (MPa)"), without_unit("ux")
    ('Sigma XX', 'ux')
    """
    return BRACKETS.sub("", name).strip()


def with_unit(cell: str, title: str) -> str:
    """Return a number with the unit that its column's title has in brackets, unless it has one of its own.

    Examples
    --------
    >>> with_unit("25", "diameter [mm]"), with_unit("25 mm", "diameter [m]"), with_unit("25", "diameter")
    ('25 mm', '25 mm', '25')
    """
    found = BRACKETS.search(title)
    if found is None or not found[1].strip():
        return cell
    try:
        float(cell)
    except ValueError:
        return cell
    return f"{cell} {found[1].strip()}"


def unit_in(name: str) -> str:
    """Return the unit in brackets at the end of a name, an exponent as a plain number; empty without one.

    Examples
    --------
    >>> unit_in("Sigma XX (MPa)"), unit_in("Stress [kN/m^2]"), unit_in("ux")
    ('MPa', 'kN/m2', '')
    """
    found = BRACKETS.search(name)
    return re.sub(r"[\s^]", "", found.group(1)).replace("\N{SUPERSCRIPT TWO}", "2") if found else ""


def factor_of(unit: str, known: dict[str, float], what: str, cure: str) -> float:
    """Return by what values in a unit are to be multiplied; 1 without a unit.

    Parameters
    ----------
    unit : str
        As `unit_in` returns it.
    known : dict of str to float
        `LENGTHS` or `STRESSES`.
    what, cure : str
        The thing with the unit, and the option that gives another.

    Raises
    ------
    ModelError
        If the unit is not among the known ones.
    """
    factors = {name.lower(): factor for name, factor in known.items()}  # programs write FT, MPA, kPA
    if unit and unit.lower() not in factors:
        raise ModelError(f"{what}: unit '{unit}' is none of {', '.join(known)}; give one, for example {cure}")
    return factors.get(unit.lower(), 1.0)
