"""Stages of construction as they are given: excavation, fill and changes, in their order (Wang 4.5.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from numbers import Integral
from typing import Annotated, Any, TypeAlias

import numpy as np

from bsm_mesh.arrays import BoolArray, ReadOnlyMapping
from bsm_mesh.errors import ModelError, as_given, crossing, listing, nearest, raise_faults
from bsm_mesh.model.flow import FlowChange
from bsm_mesh.model.kinds import AnyBlocks, in_space
from bsm_mesh.model.loads import GIVEN_LOADS, Load, PointForces
from bsm_mesh.model.quantities import BLOCK, DIRECTION, GRAVITY_PART, RELAXATION, STRENGTH_FACTOR, STRESS
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.values import Rules, is_number, parts_of
from bsm_mesh.model.water import Water

Polygon: TypeAlias = tuple[tuple[float, float], ...]
Region: TypeAlias = str | int | Polygon
"""An excavation group's name, a block's number, or a polygon: all blocks whose centroid lies in it."""


INITIAL = "initial"  # the name of the state before the first stage


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """One stage: it changes the ground, then the blocks find equilibrium.

    Attributes
    ----------
    name : str
        For results and pictures; ``initial`` is the state before the first stage.
    excavate, fill : sequence of str, int or polygon
        Blocks to excavate, and excavated blocks to put back without stress, fitted to the present position of their
        neighbours. Names of excavation groups, block numbers, or polygons [m] around centroids.
    relaxation : sequence of float
        Parts of the former forces on new surfaces that are released, one after the other, each up to equilibrium;
        rising. The rest after the last is held until a later stage releases it: one without `relaxation` releases all.
    pressure : float [Pa]
        Pressure into the blocks on the surfaces that this stage lays bare (the thesis's P_i); it stays.
    water : Water or None
        New water tables; None: as before.
    flow : FlowChange or None
        What changes of the flow in the joints; None: as before.
    loads : sequence of load
        Loads that are added, and stay.
    strength : mapping of str to float
        Factors on the strength of joints and faces of rock from this stage on, by the names of
        `bsm_mesh.model.strength.with_strength`. Others keep their strength.
    gravity : (float, float) or None
        New horizontal and vertical parts of the unit weights that pull besides, along +x and upwards, as the model's
        `gravity_horizontal` and `gravity_vertical`; None: as before.
    gravity_trend : float or None [degrees]
        Of polyhedra, with `gravity`: where its horizontal part pulls to; None: the model's `gravity_trend`.
    shaking : Shaking or None
        How the ground is shaken; such a stage changes nothing else.

    Raises
    ------
    ModelError
        With every fault found.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> stage = bsm.Stage("heading", excavate=["1"], relaxation=[0.5, 1.0])
    >>> stage.excavate, stage.relaxation
    (('1',), (0.5, 1.0))
    """

    name: str = field(kw_only=False)
    excavate: Sequence[Region] = ()
    fill: Sequence[Region] = ()
    relaxation: Sequence[float] = (1.0,)
    pressure: Annotated[float, STRESS] = 0.0
    water: Water | None = None
    flow: FlowChange | None = None
    loads: Sequence[Load] = ()
    strength: Mapping[str, float] = field(default_factory=dict, hash=False)
    gravity: tuple[float, float] | None = None
    gravity_trend: Annotated[float, DIRECTION] | None = field(default=None, metadata={"in_hash": "given"})
    shaking: Shaking | None = field(default=None, metadata={"in_hash": "given"})

    def __post_init__(self) -> None:
        rules = Rules("stage", self.name)
        rules.name(self.name)
        if isinstance(self.name, str) and self.name == INITIAL:
            rules.faults.append(
                f"stage '{INITIAL}': the name represents the state before the first stage; choose another"
            )
        for name in ("excavate", "fill"):
            object.__setattr__(self, name, _regions(getattr(self, name), name, rules))
        loads = rules.things("loads", self.loads, *GIVEN_LOADS, derived=(PointForces,))
        object.__setattr__(self, "loads", loads)
        rules.a_thing("water", self.water, Water, optional=True)
        rules.a_thing("flow", self.flow, FlowChange, optional=True)
        rules.a_thing("shaking", self.shaking, Shaking, optional=True)
        strength = rules.mapping("strength", self.strength)
        for name, part in strength.items():
            rules.number(f"strength of '{name}'", part, STRENGTH_FACTOR)
        if self.gravity is not None:
            gravity = rules.point("gravity", self.gravity, GRAVITY_PART)
            object.__setattr__(self, "gravity", gravity)
        elif self.gravity_trend is not None:
            rules.faults.append(f"{rules.thing}: gravity_trend is that of gravity; give gravity too")
        rules.numbers(self)
        several = parts_of(self.relaxation)
        factors: tuple[Any, ...] = (self.relaxation,) if several is None else tuple(several)
        for factor in factors:
            rules.number("relaxation", factor, RELAXATION)
        if is_number(self.pressure) and self.pressure and not self.excavate:
            rules.faults.append(
                f"{rules.thing}: pressure acts on surfaces that the stage lays bare, and it excavates none; give a load"
            )
        if not rules.faults and (not factors or any(b <= a for a, b in pairwise(factors))):
            rules.faults.append(f"{rules.thing}: relaxation = {list(factors)} must rise, for example [0.5, 1.0]")
        if self.shaking is not None:
            rules.faults += self._besides_shaking()
        raise_faults(rules.faults)
        object.__setattr__(self, "relaxation", tuple(float(factor) for factor in factors))
        object.__setattr__(self, "pressure", float(self.pressure))
        given = {name: float(part) for name, part in strength.items()}
        object.__setattr__(self, "strength", ReadOnlyMapping(given))

    def _besides_shaking(self) -> list[str]:
        """Return a sentence where a stage that is shaken is changed too."""
        changes = ("excavate", "fill", "pressure", "water", "flow", "loads", "strength", "gravity")
        given = [name for name in changes if getattr(self, name)]
        if self.relaxation not in ((1.0,), 1.0, [1.0]):
            given.append("relaxation")
        if not given:
            return []
        return [f"stage '{self.name}': shaking goes without {', '.join(given)}; give these in a stage before"]


def _regions(value: Any, name: str, rules: Rules) -> tuple[Region, ...]:
    if isinstance(value, str | Integral):
        value = [value]
    parts = parts_of(value)
    if parts is None:
        rules.faults.append(
            f"{rules.thing}: {name} = {as_given(value)} must be a list of groups, block numbers or polygons"
        )
        return ()
    found: list[Region] = []
    for part in parts:
        corners = parts_of(part) or []
        if isinstance(part, Integral) and not isinstance(part, bool):
            if int(part) > BLOCK.most:
                rules.number(name, part, BLOCK)
            found.append(int(part))
        elif isinstance(part, str):
            found.append(part)
        elif len(corners) >= 3:
            found.append(tuple(rules.point(f"{name}: polygon point", point) for point in corners))
        else:
            rules.faults.append(
                f"{rules.thing}: {name}: {as_given(part)} is no group name, block number or polygon of 3 points or more"
            )
    return tuple(found)


def blocks_in(region: Region, blocks: AnyBlocks) -> BoolArray:
    """Return which blocks a region means, (n,).

    Raises
    ------
    ModelError
        For a group or block that does not exist, or a polygon around no block.
    """
    import shapely

    found = np.zeros(blocks.count, dtype=bool)
    fault = ""
    if isinstance(region, str):
        if region in blocks.excavations:
            found[blocks.excavations[region]] = True
        else:
            fault = f"there is no excavation '{region}'{nearest(region, blocks.excavations)}"
    elif isinstance(region, int):
        if 0 <= region < blocks.count:
            found[region] = True
        else:
            fault = f"there is no block {region}; blocks are numbered 0 to {blocks.count - 1}"
    elif in_space(blocks):
        fault = "a polygon is for blocks in the plane; give the name of an excavation, or block numbers"
    else:
        polygon, which = shapely.Polygon(region), f"the polygon from ({region[0][0]:g}, {region[0][1]:g})"
        if polygon.is_valid:
            found = shapely.contains_xy(polygon, *blocks.moments.centroid.T)
        else:
            fault = f"{which} {crossing(shapely.is_valid_reason(polygon))}"
        if not (fault or found.any()):
            fault = f"no block has its centroid in {which}"
    raise_faults([fault] if fault else [])
    return found


def presence(stages: Sequence[Stage], blocks: AnyBlocks) -> list[BoolArray]:
    """Return which blocks are there at the start and after each stage, (n,) each.

    Raises
    ------
    ModelError
        With every fault: groups and blocks that do not exist, nothing to take away or put back, nothing left.
    """
    here = [np.ones(blocks.count, dtype=bool)]
    faults: list[str] = []
    for stage in stages:
        now = here[-1].copy()
        for key, regions, present in (("excavate", stage.excavate, True), ("fill", stage.fill, False)):
            for region in regions:
                try:
                    chosen = blocks_in(region, blocks)
                except ModelError as error:
                    faults.extend(f"stage '{stage.name}': {key}: {fault}" for fault in error.faults)
                    continue
                if not (chosen & (here[-1] == present)).any():
                    state = "gone already" if present else "there already"
                    which = f"'{region}'" if isinstance(region, str) else f"block {listing(np.flatnonzero(chosen))}"
                    faults.append(f"stage '{stage.name}': {key}: {which} is {state}; remove it from the stage")
                now[chosen] = not present
        if not now.any():
            faults.append(f"stage '{stage.name}': excavate leaves no block; excavate less")
        here.append(now)
    raise_faults(faults)
    return here
