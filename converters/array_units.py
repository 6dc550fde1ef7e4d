"""Units of the arrays in the VTU files of a run; their meanings are in the table of the user guide."""

from __future__ import annotations

PER_METRE = "per metre of thickness"

UNITS = {
    **dict.fromkeys(("displacement", "stage_displacement", "position", "length", "slip", "opening", "station"), "m"),
    **dict.fromkeys(("spacing", "plastic_stretch", "shear_point"), "m"),
    **dict.fromkeys(("rotation", "stage_rotation"), "rad"),
    "origin": "m, m, rad",
    "pressure_gradient": "Pa/m",
    **dict.fromkeys(("stress", "stress_effective", "sigma_1", "sigma_3", "water_pressure"), "Pa"),
    **dict.fromkeys(("pressure", "normal_traction", "shear_traction"), "Pa"),
    **dict.fromkeys(("load", "water"), f"N/m, N/m, N {PER_METRE}"),
    "moment": f"N {PER_METRE}",
    **dict.fromkeys(("normal_force", "force"), f"N/m {PER_METRE}"),
    "bond_force": "N of one bolt",
    "axial_force": "N of one bolt",
    **dict.fromkeys(("mechanism", "normal", "shear_direction", "utilisation"), ""),
    **dict.fromkeys(("head", "aperture", "aperture_at_ends"), "m"),
    **dict.fromkeys(("discharge", "outflow"), f"m2/s {PER_METRE}"),
    "velocity": "m/s",
    "wet_pressure": "Pa",
    **dict.fromkeys(("filled", "wet", "place", "node"), ""),
    **dict.fromkeys(("slipping_share", "open_share", "yielded", "plastic_strain"), ""),
    **dict.fromkeys(("block_id", "block_a", "block_b", "rock", "joint", "edge_joint"), ""),
    **dict.fromkeys(("status", "unstable", "bolt", "alive", "piece", "limit"), ""),
}
"""Unit of each array by its name; "" where it has none. Units that differ from kind to kind are in `OF_A_KIND`."""

OF_A_KIND = {
    ("blocks", "reaction"): f"N/m, N/m, N {PER_METRE}",
    ("supports", "reaction"): f"N/m {PER_METRE}",
    ("contacts", "shear_force"): f"N/m {PER_METRE}",
    ("bolts", "shear_force"): "N of one bolt",
}


def unit_of(kind: str, name: str) -> str:
    """Return the unit of an array in the files of a kind; "" where it has none."""
    return OF_A_KIND[kind, name] if (kind, name) in OF_A_KIND else UNITS[name]
