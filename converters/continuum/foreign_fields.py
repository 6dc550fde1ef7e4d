"""Displacement and stress among the fields of another program, by whatever name and in whatever unit it has them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.meshes.foreign_result import ForeignResult
from bsm_mesh.errors import ModelError
from bsm_mesh.named_units import LENGTHS, STRESSES, factor_of, unit_in

DISPLACEMENT = ("displacement", "displacements", "totaldisplacement", "disp", "depl", "u")
STRESS = (
    "stress",
    "stresses",
    "totalstress",
    "cauchystress",
    "cauchy",
    "sigma",
    "sigm",
    "sig",
    "s",
    "siefnoeu",
    "sigmnoeu",
)
VECTOR = {
    "x": ("ux", "dx", "dispx", "displacementx", "u1", "horizontaldisplacement", "xdisplacement"),
    "y": ("uy", "dy", "dispy", "displacementy", "u2", "verticaldisplacement", "ydisplacement"),
}
TENSOR = ("s{}", "si{}", "sig{}", "sigma{}", "stress{}", "totalstress{}")
TENSOR_PARTS = {"xx": ("xx", "x", "11"), "yy": ("yy", "y", "22"), "xy": ("xy", "12")}
COLUMNS = {9: (0, 4, 1), 6: (0, 1, 3), 4: (0, 1, 3), 3: (0, 1, 2)}  # of xx, yy, xy among so many components
KEYS = ("displacement", "stress", "ux", "uy", "sxx", "syy", "sxy")


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldNames:
    """Which arrays hold what, and in which unit.

    Attributes
    ----------
    arrays : mapping of str to str
        Names in the file of "displacement", "stress", or of their parts "ux", "uy", "sxx", "syy", "sxy"; others are
        looked for among names that programs use.
    factors : mapping of str to float
        Factors on the values. "displacement", or its parts "ux" and "uy", becomes metres; "stress", or its parts
        "sxx", "syy" and "sxy", pascals; "length" (of the mesh) metres. Default: the unit in the name in the file
        ("Sigma XX (MPa)"), else 1. A part's own counts before that of the whole.
    compression_positive : bool
        Whether stresses are positive in compression.
    """

    arrays: Mapping[str, str]
    factors: Mapping[str, float]
    compression_positive: bool = False

    def __post_init__(self) -> None:
        unknown = [key for key in self.arrays if key not in KEYS]
        if unknown:
            raise ModelError(f"field '{unknown[0]}' is none of {', '.join(KEYS)}")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PlaneFields:
    """Displacement and stress of another program at its nodes or elements, in SI units and tension positive.

    Attributes
    ----------
    point, cell : mapping of str to (n,) float64
        "ux", "uy" [m], "sxx", "syy", "sxy" [Pa] at nodes and at elements.
    named : tuple of str
        Which arrays of the file they come from.
    """

    point: Mapping[str, FloatArray]
    cell: Mapping[str, FloatArray]
    named: tuple[str, ...]

    def has(self, *parts: str) -> bool:
        """Whether all parts are there."""
        return all(part in self.point or part in self.cell for part in parts)


def plane_fields(result: ForeignResult, names: FieldNames) -> PlaneFields:
    """Return displacement and stress of a result.

    Raises
    ------
    ModelError
        If an array that was named is not there or has too few or many components, or if neither is found.
    """
    for array in names.arrays.values():
        if array not in result.at_points and array not in result.at_cells:
            raise ModelError(f"{result.source}: has no array '{array}' ({_known(result)})")
    point: dict[str, FloatArray] = {}
    cell: dict[str, FloatArray] = {}
    used: list[str] = []
    whole = {"displacement": ("ux", "uy"), "stress": ("sxx", "syy", "sxy")}
    for quantity, parts in whole.items():
        name = names.arrays.get(quantity) or _found(result, DISPLACEMENT if quantity == "displacement" else STRESS, 2)
        single = {part: names.arrays.get(part) or _found(result, _spellings(part), 1) for part in parts}
        sign = -1.0 if quantity == "stress" and names.compression_positive else 1.0
        if all(single.values()) and quantity not in names.arrays:
            values = {part: _array(result, str(array), 1) for part, array in single.items()}
            arrays = {part: str(array) for part, array in single.items()}
            used += [str(array) for array in single.values()]
        elif name is not None:
            values = _split(result, name, parts)
            arrays = dict.fromkeys(parts, name)
            used.append(name)
        else:
            continue
        for part, (at_points, column) in values.items():
            (point if at_points else cell)[part] = sign * _factor(result, names, parts, part, arrays[part]) * column
    if not used:
        raise ModelError(
            f"{result.source}: neither a displacement nor a stress is found among its arrays ({_known(result)}); "
            "name them, for example --field displacement=U --field stress=SIG:MPa"
        )
    return PlaneFields(point=point, cell=cell, named=tuple(dict.fromkeys(used)))


def length_factor(result: ForeignResult, names: FieldNames) -> float:
    """Return the factor of the nodes of a result to metres.

    Raises
    ------
    ModelError
        If the file names a unit that is not known, and the user none.
    """
    if "length" in names.factors:
        return names.factors["length"]
    return factor_of(result.length_unit, LENGTHS, f"{result.source}: coordinates", "--length m")


def _factor(result: ForeignResult, names: FieldNames, parts: Sequence[str], part: str, array: str) -> float:
    """Return the factor of an array: as given for the part, for the whole, or as its name tells."""
    is_stress = part.startswith("s")
    for key in (part, "stress" if is_stress else "displacement"):
        if key in names.factors:
            return names.factors[key]
    known, unit = (STRESSES, "kPa") if is_stress else (LENGTHS, "mm")
    what, cure = f"{result.source}: '{array}'", f'--field {part}="{array}":{unit}'
    named, others = unit_in(array), [other for other in parts if other in names.factors]
    if others and not named:
        raise ModelError(f"{what}: {others[0]} was given a unit and {part} none; give each its own, for example {cure}")
    return factor_of(named, known, what, cure)


def _spellings(part: str) -> Sequence[str]:
    if part in ("ux", "uy"):
        return VECTOR[part[1]]
    return [spelling.format(end) for spelling in TENSOR for end in TENSOR_PARTS[part[1:]]]


def _plain(name: str) -> str:
    """Return a name without case, signs, a unit in brackets and what Code_Aster writes before two underscores."""
    return re.sub(r"[(\[][^()\[\]]*[)\]]\s*$|[^a-z0-9]", "", name.rpartition("__")[2].lower())


def _found(result: ForeignResult, spellings: Sequence[str], least: int) -> str | None:
    """Return the array with the first of several spellings, with so many components at least."""
    for spelling in spellings:
        for fields in (result.at_points, result.at_cells):
            for name, values in fields.items():
                if _plain(name) == spelling and values.shape[1] >= least:
                    return name
    return None


def _array(result: ForeignResult, name: str, components: int) -> tuple[bool, FloatArray]:
    at_points = name in result.at_points
    values = (result.at_points if at_points else result.at_cells)[name]
    if values.shape[1] != components:
        raise ModelError(f"{result.source}: '{name}' has {values.shape[1]} components, and {components} is needed")
    return at_points, values[:, 0]


def _split(result: ForeignResult, name: str, parts: Sequence[str]) -> dict[str, tuple[bool, FloatArray]]:
    at_points = name in result.at_points
    values = (result.at_points if at_points else result.at_cells)[name]
    count = values.shape[1]
    if len(parts) == 2:
        if count not in (2, 3):
            raise ModelError(f"{result.source}: displacement '{name}' has {count} components, and 2 or 3 are needed")
        columns: Sequence[int] = (0, 1)
    elif count in COLUMNS:
        columns = COLUMNS[count]
    else:
        raise ModelError(
            f"{result.source}: stress '{name}' has {count} components; 3 (xx, yy, xy), 4 (xx, yy, zz, xy), 6 (xx, yy, "
            "zz, xy, ...) or 9 are known; name its parts, for example --field sxx=S11 --field syy=S22 --field sxy=S12"
        )
    return {part: (at_points, values[:, column]) for part, column in zip(parts, columns, strict=True)}


def _known(result: ForeignResult) -> str:
    names = [
        f"'{name}' at {where}"
        for where, fields in (("nodes", result.at_points), ("elements", result.at_cells))
        for name in fields
    ]
    return "it holds " + ", ".join(names[:12]) if names else "it holds none"
