"""The ground's stress before anything is dug, as it is given (Wang 4.5.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Annotated, Any, Literal, TypeAlias, get_args

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import as_given, gathered, nearest, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.loads import linear_field
from bsm_mesh.model.quantities import COORDINATE, DIRECTION, PRESSURE, RATIO_BY_DEPTH, RATIO_PER_DEPTH, STRESS_RATIO
from bsm_mesh.model.values import Points, Rules, line, plain_numbers

InSituMethod = Literal["direct", "gravity"]
StressRatio: TypeAlias = tuple[float, float, float]
GivenRatio: TypeAlias = float | str | Mapping[str, float] | StressRatio
"""Coefficients (a [m], b, c [1/m]) of K = a / h + b + c h at the depth h."""

IN_PLANE = ("xx", "yy", "xy")
IN_SPACE = ("xx", "yy", "zz", "xy", "yz", "xz")
PARTS_OF_RATIO = (RATIO_BY_DEPTH, STRESS_RATIO, RATIO_PER_DEPTH)
STRESS_RATIOS: dict[str, StressRatio] = {
    "herget": (267.0, 1.25, 0.0),  # Canadian shield, Herget 1987: Wang Eq. 4.15
    "brown_hoek_upper": (1500.0, 0.5, 0.0),  # Brown and Hoek 1978: Wang Eq. 4.16
    "brown_hoek_lower": (100.0, 0.3, 0.0),  # Wang Eq. 4.17
}


@dataclass(frozen=True, slots=True, kw_only=True)
class InSitu:
    """The stress field of the ground, and how the model gets it.

    Either `surface` (with `surcharge` and `k0`) or `stress` describes the field. With ``method = "gravity"`` neither
    is needed: the field is then what weights and loads make of the blocks.

    Attributes
    ----------
    method : {"direct", "gravity"}
        ``"direct"``: contact forces and reactions are set from the field. ``"gravity"``: weights and loads are turned
        on (the thesis's way). Displacements count from the end of either.
    surface : float or sequence of (x, y) or None [m]
        Level of the ground, or its line from left to right, level beyond its ends. The vertical stress at a point is
        the weight of the ground above it, of all rocks on the way, plus `surcharge`; openings in the mesh count as
        filled, blocks above the surface weigh nothing here.
    surcharge : float [Pa]
        Pressure on the surface, compression positive. It describes the field only and loads nothing.
    k0 : float, str or mapping
        Ratio K of horizontal to vertical total stress: a number, or a published relation ("herget",
        "brown_hoek_upper", "brown_hoek_lower"). ``{"a": [m], "b": [-], "c": [1/m]}`` is K = a / h + b + c h at the
        depth h. With the surcharge and several rocks that is a gamma_top + (b + c h) sigma_v.
    k0_across : as k0, or None
        Of polyhedra: the ratio across the trend; None: as `k0`.
    trend : float or None [degrees]
        Of polyhedra: where `k0` acts, clockwise from north (+y); None: to the north.
    stress : mapping or None
        Components "xx", "yy", "xy" of the total stress [Pa], tension positive, each a number or (c, a_x, a_y).
        Polyhedra have "xx", "yy", "zz", "xy", "yz", "xz", each a number or (c, a_x, a_y, a_z).

    Raises
    ------
    ModelError
        With every fault found.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.InSitu(surface=20.0, k0=0.5).surface
    20.0
    """

    method: InSituMethod = "direct"
    surface: Given[float | Points | None, float | Sequence[Sequence[float]] | None] = by_default(None)
    surcharge: Annotated[float, PRESSURE] = 0.0
    k0: Given[StressRatio, GivenRatio] = by_default((0.0, 1.0, 0.0))
    stress: Given[tuple[tuple[float, ...], ...] | None, Mapping[str, Any] | None] = by_default(None)
    k0_across: Given[StressRatio | None, GivenRatio | None] = by_default(
        field(default=None, metadata={"in_hash": "given"})
    )
    trend: Annotated[float, DIRECTION] | None = field(default=None, metadata={"in_hash": "given"})

    def __post_init__(self) -> None:
        rules = Rules("in_situ")
        rules.choice("method", self.method, get_args(InSituMethod))
        rules.numbers(self)
        object.__setattr__(self, "k0", _stress_ratio(self.k0, rules))
        if self.k0_across is not None:
            object.__setattr__(self, "k0_across", _stress_ratio(self.k0_across, rules, "k0_across"))
        if isinstance(self.surface, Real):
            rules.number("surface", self.surface, COORDINATE)
        elif self.surface is not None:
            object.__setattr__(self, "surface", line(self.surface, "surface", rules))
        if self.stress is not None:
            object.__setattr__(self, "stress", _components(self.stress, rules))
        raise_faults(rules.faults)
        raise_faults([f"in_situ: {text}" for text in self._misfits()])
        plain_numbers(self)

    def _misfits(self) -> list[str]:
        """Return what does not fit together, a sentence each."""
        found = []
        if self.surface is not None and self.stress is not None:
            found.append("surface and stress both describe the field; give one of them")
        if self.method == "direct" and not self.describes_field:
            found.append(
                "method = 'direct' needs the field: surface (level of the ground [m]) with k0, or stress = {xx, yy, xy}"
                " (polyhedra: zz, yz, xz too)"
            )
        for name, default in (("surcharge", 0.0), ("k0", (0.0, 1.0, 0.0)), ("k0_across", None), ("trend", None)):
            if self.surface is None and getattr(self, name) != default:
                has_it = "a given stress has it already" if self.stress is not None else "give the surface"
                found.append(f"{name} belongs to a surface; {has_it}, or leave {name} out")
        return found

    @property
    def describes_field(self) -> bool:
        """Whether the stress at a point follows from the input here."""
        return self.surface is not None or self.stress is not None

    def level(self, x: FloatArray) -> FloatArray:
        """Return the level of the ground at abscissas x [m]; there must be a surface."""
        if isinstance(self.surface, tuple):
            level: FloatArray = np.interp(x, *np.array(self.surface).T)
            return level
        assert self.surface is not None
        return np.full(len(x), float(self.surface))


def places_of(components: Sequence[object]) -> tuple[tuple[int, int], ...]:
    """Return row and column in the tensor of each component of a given stress, three of the plane or six of space.

    Examples
    --------
    >>> places_of([0, 0, 0])
    ((0, 0), (1, 1), (0, 1))
    """
    names = IN_PLANE if len(components) == len(IN_PLANE) else IN_SPACE
    return tuple(("xyz".index(name[0]), "xyz".index(name[1])) for name in names)


def _stress_ratio(value: object, rules: Rules, name: str = "k0") -> StressRatio:
    if isinstance(value, str):
        if value not in STRESS_RATIOS:
            rules.faults.append(f"in_situ: {name} = '{value}' is unknown{nearest(value, STRESS_RATIOS)}")
        return STRESS_RATIOS.get(value, (0.0, 1.0, 0.0))
    if isinstance(value, Mapping):
        unknown = [key for key in value if key not in ("a", "b", "c")]
        if unknown or not value:
            rules.faults.append(
                f"in_situ: {name} = {as_given(dict(value))} needs a [m] and b (and c [1/m]): K = a / h + b + c h"
            )
            return 0.0, 1.0, 0.0
        value = tuple(value.get(key, 0.0) for key in "abc")
    plain = isinstance(value, Real)
    if plain:
        value = (0.0, value, 0.0)
    if not isinstance(value, Sequence) or len(value) != 3:
        rules.faults.append(
            f"in_situ: {name} = {as_given(value)} must be a number, {{a, b}} or one of {', '.join(STRESS_RATIOS)}"
        )
        return 0.0, 1.0, 0.0
    before = len(rules.faults)
    for letter, part, quantity in zip("abc", value, PARTS_OF_RATIO, strict=True):
        rules.number(name if plain else f"{name} {letter}", part, quantity)
    return (float(value[0]), float(value[1]), float(value[2])) if len(rules.faults) == before else (0.0, 1.0, 0.0)


def _components(value: Any, rules: Rules) -> tuple[tuple[float, ...], ...]:
    """Return the fields of the components, three of the plane or six of space."""
    given = value if isinstance(value, Mapping) else ()
    several = len(value) == len(IN_SPACE) if not given and isinstance(value, Sequence) else False
    names = IN_SPACE if several or "zz" in given else IN_PLANE
    if isinstance(value, Mapping):
        unknown = [key for key in value if key not in names]
        if unknown:
            rules.faults.append(f"in_situ: stress has no component '{unknown[0]}'{nearest(str(unknown[0]), names)}")
        value = tuple(value.get(key, 0.0) for key in names)
    if not isinstance(value, Sequence) or len(value) != len(names):
        rules.faults.append(f"in_situ: stress = {as_given(value)} needs the components xx, yy, xy [Pa]")
        return ()
    found = []
    for name, part in zip(names, value, strict=True):
        with gathered(rules.faults):
            found.append(linear_field(part, f"in_situ: stress {name}", axes=2 if names is IN_PLANE else 3))
    return tuple(found)
