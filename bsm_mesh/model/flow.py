"""Steady flow of water in the joints as it is given: levels at boundaries, drains, wells, grout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, get_args

from bsm_mesh.arrays import ReadOnlyMapping
from bsm_mesh.errors import as_given, raise_faults
from bsm_mesh.model.quantities import APERTURE, COORDINATE, DISCHARGE, FLOW_TOLERANCE, ROUNDS, VISCOSITY, WATER_WEIGHT
from bsm_mesh.model.values import Rules, parts_of, plain_numbers
from bsm_mesh.model.water import WATER

Coupling = Literal["two_way", "one_way"]
Point = tuple[float, float]
OF_WATER = 1.0e-3  # Pa s, at 20 degrees Celsius


@dataclass(frozen=True, slots=True, kw_only=True)
class Drain:
    """A hole that lets water out of all joints it crosses, and never in.

    Attributes
    ----------
    start, end : (x, y) [m]
        Its ends.
    level : float or None [m]
        Level of the water that is in it; above, and everywhere by default (None), it is open to the air.
    """

    start: Point
    end: Point
    level: Annotated[float, COORDINATE] | None = None

    def __post_init__(self) -> None:
        rules = Rules("drain")
        for name in ("start", "end"):
            object.__setattr__(self, name, rules.point(name, getattr(self, name)))
        rules.numbers(self)
        if not rules.faults and self.start == self.end:
            rules.faults.append("drain: start and end are one point; give a hole with a length")
        raise_faults(rules.faults)
        plain_numbers(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Well:
    """A place where a discharge is taken out of the nearest joint, or put in.

    Attributes
    ----------
    point : (x, y) [m]
        In a joint.
    discharge : float [m2/s]
        Taken out, per metre of thickness, or as much as flows to it; negative: put in.
    """

    point: Point
    discharge: Annotated[float, DISCHARGE]

    def __post_init__(self) -> None:
        rules = Rules("well")
        object.__setattr__(self, "point", rules.point("point", self.point))
        rules.numbers(self)
        if not rules.faults and self.discharge == 0:
            rules.faults.append("well: discharge = 0 m^2/s changes nothing; remove the well, or give it a discharge")
        raise_faults(rules.faults)
        plain_numbers(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Grout:
    """A region in which the joints are grouted: their aperture there is given, whatever the rock does.

    Attributes
    ----------
    polygon : sequence of (x, y) [m]
        The region's corners.
    aperture : float [m]
        Hydraulic aperture of grouted joints; 0: sealed.
    """

    polygon: Sequence[Point]
    aperture: Annotated[float, APERTURE] = 0.0

    def __post_init__(self) -> None:
        rules = Rules("grout")
        corners = parts_of(self.polygon)
        if corners is None or len(corners) < 3:
            rules.faults.append(f"grout: polygon = {as_given(self.polygon)} must be three points (x, y) or more [m]")
            corners = []
        object.__setattr__(self, "polygon", tuple(rules.point("polygon point", corner) for corner in corners))
        rules.numbers(self)
        raise_faults(rules.faults)
        plain_numbers(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlowChange:
    """Changes of the flow by a stage; all else stays.

    Attributes
    ----------
    head : mapping of str to float [m]
        New levels of the water at boundaries.
    seepage : sequence of str
        Boundaries that are open to the air from now on.
    closed : sequence of str
        Boundaries that let no water through from now on.
    drains, wells, grout : sequence of Drain, Well, Grout
        Additions of the stage.
    """

    head: Mapping[str, float] = field(default_factory=dict, hash=False)
    seepage: Sequence[str] = ()
    closed: Sequence[str] = ()
    drains: Sequence[Drain] = ()
    wells: Sequence[Well] = ()
    grout: Sequence[Grout] = ()

    def __post_init__(self) -> None:
        rules = Rules("flow")
        _own_parts(self, rules, "seepage", "closed")
        twice = _twice((*self.head, *self.seepage, *self.closed))
        rules.faults.extend(f"flow: boundary '{name}' is named more than once; leave one" for name in twice)
        raise_faults(rules.faults)


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """Steady flow of water in the joints, by the cubic law; blocks are tight.

    Every joint of the model gives its `aperture`. A boundary without a name lets no water through; surfaces that stages
    lay bare are open to the air.

    Attributes
    ----------
    head : mapping of str to float [m]
        Level of the water at boundaries: it presses on them below, and above they are open to the air.
    seepage : sequence of str
        Boundaries that are open to the air: water may come out of them.
    drains, wells, grout : sequence of Drain, Well, Grout
        What else lets water in or out, or keeps it.
    unit_weight : float [N/m3]
        Of the water.
    viscosity : float [Pa s]
        Its dynamic viscosity.
    coupling : {"two_way", "one_way"}
        Whether apertures follow the blocks, which follow the water's pressure: both are solved alternately
        until neither changes; or apertures are as given, but for grout.
    tolerance : float
        Of a two-way coupling: pressures change by less in the last turn, over the greatest.
    max_rounds : int
        Turns after which a stage counts as not converged.
    """

    head: Mapping[str, float] = field(default_factory=dict, hash=False)
    seepage: Sequence[str] = ()
    drains: Sequence[Drain] = ()
    wells: Sequence[Well] = ()
    grout: Sequence[Grout] = ()
    unit_weight: Annotated[float, WATER_WEIGHT] = WATER
    viscosity: Annotated[float, VISCOSITY] = OF_WATER
    coupling: Coupling = "two_way"
    tolerance: Annotated[float, FLOW_TOLERANCE] = 1e-4
    max_rounds: Annotated[int, ROUNDS] = 50

    def __post_init__(self) -> None:
        rules = Rules("flow")
        _own_parts(self, rules, "seepage")
        rules.numbers(self)
        rules.choice("coupling", self.coupling, get_args(Coupling))
        twice = _twice((*self.head, *self.seepage))
        rules.faults.extend(f"flow: boundary '{name}' is named more than once; leave one" for name in twice)
        if not rules.faults and not (self.head or any(well.discharge < 0 for well in self.wells)):
            rules.faults.append("flow: nothing lets water in: give head (the water's level at a boundary)")
        raise_faults(rules.faults)
        plain_numbers(self)

    def changed(self, change: FlowChange | None) -> Flow:
        """Return the flow as a stage leaves it."""
        if change is None:
            return self
        named = {*change.head, *change.seepage, *change.closed}
        stays = {name: change.head.get(name, level) for name, level in self.head.items()}
        shut = {*change.seepage, *change.closed}
        head = {name: level for name, level in stays.items() if name not in shut} | dict(change.head)
        if not head and not any(well.discharge < 0 for well in (*self.wells, *change.wells)):
            head = {name: level for name, level in self.head.items() if name in named}
            raise_faults([f"flow: the last boundary with a head ({', '.join(head)}) is closed; nothing lets water in"])
        return replace(
            self,
            head=head,
            seepage=(*(name for name in self.seepage if name not in named), *change.seepage),
            drains=(*self.drains, *change.drains),
            wells=(*self.wells, *change.wells),
            grout=(*self.grout, *change.grout),
        )


def _own_parts(owner: Flow | FlowChange, rules: Rules, *lists: str) -> None:
    """Hold mappings and lists to their kinds, and keep them read-only."""
    head = rules.mapping("head", owner.head)
    for name, level in head.items():
        rules.number(f"head of '{name}'", level, COORDINATE)
    for name in lists:
        object.__setattr__(owner, name, rules.texts(name, getattr(owner, name)))
    kinds: dict[str, type[Any]] = {"drains": Drain, "wells": Well, "grout": Grout}
    for name, kind in kinds.items():
        object.__setattr__(owner, name, rules.things(name, getattr(owner, name), kind))
    raise_faults(rules.faults)
    levels = {str(name): float(level) for name, level in head.items()}
    object.__setattr__(owner, "head", ReadOnlyMapping(levels))


def _twice(names: tuple[str, ...]) -> list[str]:
    return [name for name in dict.fromkeys(names) if names.count(name) > 1]
