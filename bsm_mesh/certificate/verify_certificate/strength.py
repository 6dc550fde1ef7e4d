"""Shear strength of the joint laws, and contacts that carry more than theirs."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import AGREES, Arrays

USED = 1e-9  # by how much more than its strength a contact may carry: rounding
LITTLE = 1e-9  # of the greatest force: what carries no more has no utilisation, and is not looked at for it
OPEN = 1e-12  # of the coordinates: by rounding of the gap
CURVED = ("barton_bandis", "ladanyi_archambault")


def strength_of(law: dict[str, Any], pressure: Any, length: Any, failed: Any, slid: Any) -> Any:
    """Return the shear strength (m,) [N/m] at pressures (m,) [N/m], not a number for laws of the user's own.

    `slid` (m,) [m] is how far contacts have slid.
    """
    if law["kind"] == "weaker":
        return np.minimum(*(strength_of(one, pressure, length, failed, slid) for one in law["laws"]))
    if law["kind"] == "reduced":
        return strength_of(law["law"], pressure, length, failed, slid) / law["factor"]
    if law["kind"] == "barton_bandis":
        return barton_bandis(law, pressure, length, failed, slid)
    if law["kind"] == "ladanyi_archambault":
        return ladanyi_archambault(law, pressure, length, failed)
    if law["kind"] == "elastic":
        return np.full(len(pressure), np.inf)
    if law["kind"] == "own":
        return np.full(len(pressure), np.nan)
    first, left = law["friction"], law.get("residual_cohesion") or 0.0
    last = first if law["residual_friction"] is None else law["residual_friction"]
    slope, residual = np.tan(np.radians(first + law.get("dilation", 0.0))), np.tan(np.radians(last))
    line = slope * pressure
    if law["kind"] == "patton":  # the lower of two lines; once the asperities are sheared off friction is left
        return np.where(failed, residual * pressure, np.minimum(line, law["cohesion"] * length + residual * pressure))
    gone = failed.astype(float)
    if law.get("softening_slip"):  # both values fall while it slides that far
        gone = np.maximum(gone, np.minimum(slid / law["softening_slip"], 1.0))
    return (1 - gone) * (law["cohesion"] * length + line) + gone * (left * length + residual * pressure)


def barton_bandis(law: dict[str, Any], pressure: Any, length: Any, failed: Any, slid: Any) -> Any:
    """Return Barton and Bandis's shear strength (m,) [N/m] (Barton and Choubey 1977, Barton et al. 1985)."""
    scale = law["joint_length"] / 0.1
    rough, wall = law["jrc"] * scale ** (-0.02 * law["jrc"]), law["jcs"] * scale ** (-0.03 * law["jrc"])
    left = np.ones(len(pressure))
    if law["roughness_wears"] and rough > 0:
        peak = law["joint_length"] / 500 * (rough / law["joint_length"]) ** 0.33
        left = np.interp(1 + slid / peak, (1.0, 2.0, 4.0, 10.0, 100.0), (1.0, 0.85, 0.7, 0.5, 0.0))
    left = np.where(failed, 0.0, left)
    decades = np.log10(np.maximum(wall * length, pressure) / np.maximum(pressure, 1e-300))
    return pressure * np.tan(np.radians(np.minimum(law["residual_friction"] + left * rough * decades, 70.0)))


def ladanyi_archambault(law: dict[str, Any], pressure: Any, length: Any, failed: Any) -> Any:
    """Return Ladanyi and Archambault's shear strength (m,) [N/m] (1970), with Fairhurst's strength of rock."""
    wall, smooth = law["jcs"] * length, np.tan(np.radians(law["friction"]))
    x = pressure / wall
    climbs = np.maximum(1 - x, 0.0) ** 1.5
    rate = np.maximum(1 - x, 0.0) ** 4 * np.tan(np.radians(law["dilation"]))
    rock = (np.sqrt(11.0) - 1) / 10 * np.sqrt(1 + 10 * x)
    found = (x * climbs * (rate + smooth) + (1 - climbs) * rock) / (1 - climbs * rate * smooth)
    return np.where(failed, smooth * pressure, wall * found)


def is_curved(law: dict[str, Any]) -> bool:
    """Return whether straight lines can only bound a law's strength."""
    return is_curved(law["law"]) if law["kind"] == "reduced" else law["kind"] in CURVED


def own_laws(stage: dict[str, Any], a: Arrays) -> str:
    """Say of which laws the strength is not given by numbers."""
    used = [stage["laws"][number] for number in np.unique(a["law"])]
    names = sorted({law["name"] for law in used if law["kind"] == "own"})
    told = f"; the strength of laws of the user's own cannot be checked by numbers alone: {', '.join(names)}"
    return told if names else ""


def strength_faults(stage: dict[str, Any], a: Arrays) -> list[str]:
    """Return which contacts carry more than their strength, or another part of it than they are said to."""
    normal, shear, length, used = (
        a[f"contact_{name}"] for name in ("normal_force", "shear_force", "length", "utilisation")
    )
    pressure, strength = np.maximum(-normal, 0.0), np.full(len(normal), np.nan)
    for number, law in enumerate(stage["laws"]):
        rows = a["law"] == number
        strength[rows] = strength_of(law, pressure[rows], length[rows], a["failed"][rows], a["slip_path"][rows])
    known = ~np.isnan(strength)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(shear == 0, 0.0, np.minimum(np.abs(shear) / strength, 999.0))
    force = np.maximum(np.abs(normal), np.abs(shear))
    bears = force > LITTLE * force.max(initial=0.0)
    bears_open = np.zeros(len(normal), dtype=bool)
    if "closed_at" in a:
        slope, last = a.get("dilation", np.zeros((len(normal), 2))).T
        most = a["closed_at"] + slope * np.minimum(a["slip_path"], last)  # walls part as they slide, up to that
        bears_open = (normal < 0) & (a["contact_opening"] > most + OPEN * np.abs(a["vertices"]).max(initial=0.0))
    tests = (
        (bears_open, "carries pressure and is open"),
        (known & ~(found <= 1 + USED), "carries more than its shear strength"),
        (
            known & bears & ~(np.abs(found - used) <= AGREES * np.maximum(used, 1.0)),
            "has another strength than is said",
        ),
        (~(normal <= a["tension"] * (1 + USED)), "carries more than its tensile strength"),
        (a["failed"] & (a["tension"] > a.get("residual_tension", 0.0)), "has failed and carries tension"),
    )
    return [f"contact {int(bad.argmax())} {text}" for bad, text in tests if bad.any()]
