"""Zones: finite elements inside blocks, whose rock deforms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.quantities import DILATION, ZONE_ORDER, ZONE_SIZE
from bsm_mesh.model.values import Rules, plain_numbers

if TYPE_CHECKING:
    from bsm_mesh.model.materials import Rock
    from bsm_mesh.model.model import Model
    from bsm_mesh.model.shaking import Shaking

ZoneLaw = Literal["elastic", "mohr_coulomb", "hoek_brown"]
ZoneDisplacement = Literal["small", "large"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Zones:
    """Triangles that the blocks of a rock are divided into, so that they deform.

    Attributes
    ----------
    size : float or None [m]
        Greatest side of the triangles; None: the fewest triangles that fill a block.
    order : int
        Polynomial order of the displacements in them: 1 (constant stress) or 2 (linear stress).
    law : {"elastic", "mohr_coulomb", "hoek_brown"}
        Whether the rock within blocks yields: ``"mohr_coulomb"`` by its `cohesion`, `friction` and `tensile_strength`
        (0 where they are not given), ``"hoek_brown"`` by its `hoek_brown`.
    dilation : float [degrees]
        Dilation angle of rock that yields. With Mohr-Coulomb it is the friction angle at most; with Hoek-Brown the
        friction angle of the curve takes its place where that is smaller.
    displacement : {"small", "large"}
        Whether forces act where blocks were given (``"small"``), or blocks turn by any angle, and forces with them
        (``"large"``). All rocks with zones have the same.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Rock("gneiss", unit_weight=26e3, young=20e9, poisson=0.25, zones=bsm.Zones(size=0.5)).zones.order
    2
    """

    size: Annotated[float, ZONE_SIZE] | None = None
    order: Annotated[int, ZONE_ORDER] = 2
    law: ZoneLaw = "elastic"
    dilation: Annotated[float, DILATION] = 0.0
    displacement: ZoneDisplacement = "small"

    def __post_init__(self) -> None:
        rules = Rules("zones")
        rules.numbers(self)
        rules.choice("law", self.law, get_args(ZoneLaw))
        rules.choice("displacement", self.displacement, get_args(ZoneDisplacement))
        raise_faults(rules.faults)
        if self.dilation and self.law == "elastic":
            raise_faults([f"zones: dilation = {self.dilation:g} is of rock that yields; give law"])
        plain_numbers(self)


def has_zones(model: Model) -> bool:
    """Return whether any block of a model has zones."""
    return any(rock.zones is not None for rock in model.rocks) and bool(zoned_blocks(model).any())


def zoned_blocks(model: Model) -> BoolArray:
    """Return which blocks have zones, (n,) bool."""
    zoned = {rock.name for rock in model.rocks if rock.zones is not None}
    of_rock = np.array([name in zoned for name in model.blocks.rock_names], dtype=bool)
    found: BoolArray = of_rock[model.blocks.rock]
    return found


def zone_order(model: Model) -> int:
    """Return the order of the zones: rocks in use have one."""
    used = {model.blocks.rock_names[number] for number in np.unique(model.blocks.rock)}
    return next(rock.zones.order for rock in model.rocks if rock.zones is not None and rock.name in used)


def large_zones(model: Model) -> bool:
    """Return whether the zones of a model are in large displacement: rocks in use are all alike."""
    used = {model.blocks.rock_names[number] for number in np.unique(model.blocks.rock)}
    zoned = (rock.zones for rock in model.rocks if rock.zones is not None and rock.name in used)
    return next((zones.displacement == "large" for zones in zoned), False)


def zones_in_space(model: Model) -> list[str]:
    """Return one sentence for every rock of polyhedra that has zones."""
    return [
        f"rock '{rock.name}': zones are for the plane; polyhedra are rigid: leave zones out"
        for rock in model.rocks
        if rock.zones is not None
    ]


def zone_faults(model: Model) -> list[str]:
    """Return one sentence for every conflict of the zones with the rest of the model."""
    used = {model.blocks.rock_names[number] for number in np.unique(model.blocks.rock)}
    rocks = [rock for rock in model.rocks if rock.name in used]
    zoned = [rock for rock in rocks if rock.zones is not None]
    if not zoned:
        return []
    faults = [
        f"rock '{rock.name}' is elastic and has no zones, but rock '{zoned[0].name}' has: its blocks would be rigid "
        'and ignore young and poisson; give it zones = {}, or stiffness = "rigid"'
        for rock in rocks
        if rock.zones is None and not rock.is_rigid
    ]
    orders = {rock.name: rock.zones.order for rock in zoned if rock.zones is not None}
    if len(set(orders.values())) > 1:
        said = ", ".join(f"{order} of rock '{name}'" for name, order in orders.items())
        faults.append(f"zones: rocks have elements of different order ({said}); give all of them the same")
    if model.flow is not None:
        faults.append("zones know no flow in joints; give [water] instead of [flow], or leave zones out")
    faults += [
        f"stage '{stage.name}' is shaken, and zones that are shaken know no {name}; {cure}"
        for stage in model.stages
        if stage.shaking is not None
        for name, cure in _unshaken(stage.shaking, zoned)
    ]
    kinds = {rock.zones.displacement for rock in zoned if rock.zones is not None}
    if len(kinds) > 1:
        faults.append('zones: some rocks have displacement = "large" and others "small"; give all of them the same')
    return faults + (_large_faults(model) if "large" in kinds else [])


def _unshaken(shaking: Shaking, zoned: list[Rock]) -> Iterator[tuple[str, str]]:
    """Return what zones that are shaken do not know, and the cure."""
    if shaking.integrator == "implicit":
        yield 'integrator = "implicit"', 'give "explicit"'
    if shaking.mass_scaling != 1:
        yield "mass_scaling", "remove it"
    for rock in zoned:
        if rock.yields and rock.zones is not None:
            yield f"rock that yields ('{rock.name}', law = \"{rock.zones.law}\")", "remove its law, or the stage"


def _large_faults(model: Model) -> list[str]:
    """Return one sentence for every part of a model that zones in large displacement do not know."""
    waters = [water for water in (model.water, *(stage.water for stage in model.stages)) if water is not None]
    known = {
        "pressure of a joint's own water (joint_pressure)": any(water.joint_pressure for water in waters),
        "water in a stage that is shaken": bool(waters) and any(stage.shaking is not None for stage in model.stages),
        "bolts that resist shear (bearing_stiffness)": any(bolt.dowel_stiffness > 0 for bolt in model.bolts),
        "blocks put back (fill)": any(stage.fill for stage in model.stages),
        'contact_points = "gauss"': model.contact_points == "gauss",
    }
    return [
        f'zones with displacement = "large" know no {name}; give "small", or leave that out'
        for name, there in known.items()
        if there
    ]
