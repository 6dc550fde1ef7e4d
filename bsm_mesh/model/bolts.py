"""Rockbolts as they are given (Wang ch. 5); all forces are for one bolt."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from bsm_mesh.errors import raise_faults
from bsm_mesh.model.quantities import (
    BEARING_STRENGTH,
    BOLT_CAPACITY,
    BOLT_DIAMETER,
    BOLT_FORCE,
    BOLT_SPACING,
    BOLT_STIFFNESS,
    BOLT_YOUNG,
    BOND_SHEAR_STRENGTH,
    BOND_STIFFNESS,
    BOND_STRENGTH,
    HOLE_DIAMETER,
    YIELD_STRENGTH,
)
from bsm_mesh.model.values import Rules, is_infinite, plain_numbers

BoltKind = Literal["grouted", "end_anchored"]
ROUNDING = 1e-9  # of the capacity: a pretension that exceeds it by less is at it

GROUTED_ONLY = ("bond_strength", "hole_diameter", "bond_steel_grout", "bond_grout_rock", "bond_stiffness", "plate")
DOWEL = ("bearing_stiffness", "bearing_strength")

STEEL = 200e9  # Pa
FINE = 0.15  # of the decay length of elastic bond: greatest distance of its nodes; the decay is 0.1 % off
MOST_PIECES = 2000  # of elastic bond along a bolt: a decay over a few millimetres is rigid bond


@dataclass(frozen=True, slots=True, kw_only=True)
class Bolt:
    """A rockbolt between two points; its head is at `start`, its tip at `end`.

    Attributes
    ----------
    start, end : (x, y) or (x, y, z) [m]
        Head and tip as given, before any movement; three coordinates in space.
    kind : {"grouted", "end_anchored"}
        Bonded to the rock along its length, or at its two ends only.
    diameter : float [m]
        Diameter of the steel.
    young : float [Pa]
        Elastic modulus of the steel.
    stiffness : float or None [N]
        Axial stiffness times length (K_b L of Wang Eq. 5.2), from a pull test or for a strand; None: `young` times the
        section of `diameter`.
    yield_strength : float or None [Pa]
        Stress at which the steel flows (Wang Fig. 5.2); None: never.
    pretension : float [N]
        Tension at installation; 0 for a passive bolt.
    anchor_capacity : float or None [N]
        Of an end-anchored bolt: capacity of each anchorage (Wang Eq. 5.3); None: unlimited.
    spacing : float [m]
        In the plane: distance of bolts out of it; forces on the blocks are divided by it. In space: leave it out.
    stage : str or None
        Stage that installs it; None: there from the start.
    bond_strength : float or None [N/m]
        Of a grouted bolt: greatest force on the rock per length. Give this, or `hole_diameter` with the two below;
        neither: unlimited.
    hole_diameter : float or None [m]
        Diameter of the drill hole.
    bond_steel_grout, bond_grout_rock : float or None [Pa]
        Shear strength of the two interfaces (Wang Eq. 5.7).
    bond_stiffness : float or None [N/m2]
        Force on the rock per length and slip while the grout is elastic; None: rigid, one node a block (Wang 5.3.2).
    bearing_stiffness : float or None [N/m2]
        Of a grouted bolt: force of the grout across the bolt per length and deflection. With it the bolt resists
        shear where it crosses a joint (dowel action, `dowel_stiffness`); None: it does not, as in the thesis.
    bearing_strength : float or None [Pa]
        Pressure of the bolt on the grout or rock at which that gives way, for `dowel_strength`; None: unlimited.
    plate : float [N]
        Capacity of a face plate at the head of a grouted bolt; infinite: it never fails.
    name : str
        For tables and messages.

    Raises
    ------
    ModelError
        With every value out of range, and keys that do not belong together.

    Examples
    --------
    >>> round(Bolt(start=(0, 0), end=(0, 3), diameter=0.025, yield_strength=500e6).yield_force)
    245437
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    diameter: Annotated[float, BOLT_DIAMETER]
    kind: BoltKind = "grouted"
    young: Annotated[float, BOLT_YOUNG] = STEEL
    stiffness: Annotated[float, BOLT_STIFFNESS] | None = None
    yield_strength: Annotated[float, YIELD_STRENGTH] | None = None
    pretension: Annotated[float, BOLT_FORCE] = 0.0
    anchor_capacity: Annotated[float, BOLT_CAPACITY] | None = None
    spacing: Annotated[float, BOLT_SPACING] = 1.0
    stage: str | None = None
    bond_strength: Annotated[float, BOND_STRENGTH] | None = None
    hole_diameter: Annotated[float, HOLE_DIAMETER] | None = None
    bond_steel_grout: Annotated[float, BOND_SHEAR_STRENGTH] | None = None
    bond_grout_rock: Annotated[float, BOND_SHEAR_STRENGTH] | None = None
    bond_stiffness: Annotated[float, BOND_STIFFNESS] | None = None
    bearing_stiffness: Annotated[float, BOND_STIFFNESS] | None = None
    bearing_strength: Annotated[float, BEARING_STRENGTH] | None = None
    plate: Annotated[float, BOLT_FORCE] = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        rules = Rules("bolt", self.name)
        rules.text("name", self.name)
        rules.text("stage", self.stage, optional=True)
        rules.choice("kind", self.kind, get_args(BoltKind))
        for name in ("start", "end"):
            object.__setattr__(self, name, rules.place(name, getattr(self, name)))
        rules.numbers(self, without=("plate",) if is_infinite(self.plate) else ())
        raise_faults(rules.faults)
        plain_numbers(self)
        if len(self.start) != len(self.end):
            raise_faults([f"{rules.thing}: start has {len(self.start)} coordinates and end {len(self.end)}; give both"])
        raise_faults([f"{rules.thing}: {text}" for text in self._misfits()])

    def _misfits(self) -> list[str]:
        """Return what does not fit together, a sentence each."""
        found = []
        if self.length == 0:
            found.append("start and end are the same point; give the tip of the bolt as its end")
        by_diameter = [name for name in ("hole_diameter", "bond_steel_grout", "bond_grout_rock") if self._given(name)]
        if self.kind == "end_anchored":
            strange = [name for name in (*GROUTED_ONLY, *DOWEL) if self._given(name)]
            if strange:
                found.append(f"{', '.join(strange)} belong to grouted bolts; give anchor_capacity, or kind = 'grouted'")
        elif self.anchor_capacity is not None:
            found.append("anchor_capacity belongs to end-anchored bolts; give bond_strength or plate")
        elif self.bond_strength is not None and by_diameter:
            found.append(f"bond_strength is given, and {', '.join(by_diameter)} too; give one or the other")
        elif by_diameter and len(by_diameter) < 3:
            missing = {"hole_diameter", "bond_steel_grout", "bond_grout_rock"} - set(by_diameter)
            found.append(f"{', '.join(by_diameter)} need {' and '.join(sorted(missing))} (Wang Eq. 5.7)")
        elif self.hole_diameter is not None and self.hole_diameter < self.diameter:
            found.append(f"hole_diameter = {self.hole_diameter:g} m is less than the diameter {self.diameter:g} m")
        if self.stiffness is not None and self.young != STEEL and self.bearing_stiffness is None:
            found.append("stiffness is given, and young too; give one or the other")
        if self.bearing_strength is not None and (self.bearing_stiffness is None or self.yield_strength is None):
            found.append("bearing_strength needs bearing_stiffness and yield_strength; give both, or leave it out")
        if self.length > MOST_PIECES * self.longest_piece:
            stiffest = self.axial_stiffness * (MOST_PIECES * FINE / self.length) ** 2
            found.append(
                f"bond_stiffness = {self.bond_stiffness:g} N/m2 is too stiff to be resolved along {self.length:g} m; "
                f"give {stiffest:.2g} or less, or leave it out for rigid bond"
            )
        most = min(self.yield_force, math.inf if self.anchor_capacity is None else self.anchor_capacity)
        if self.pretension > most * (1 + ROUNDING):
            found.append(f"pretension = {self.pretension:g} N is more than the bolt carries, {most:g} N; lower it")
        return found

    def _given(self, name: str) -> bool:
        return getattr(self, name) not in (None, 0.0)

    @property
    def length(self) -> float:
        """Length from head to tip [m]."""
        return math.dist(self.start, self.end)

    @property
    def axial_stiffness(self) -> float:
        """Axial stiffness times length [N]: `stiffness`, or elastic modulus times section, E A."""
        if self.stiffness is not None:
            return self.stiffness
        return self.young * math.pi * self.diameter**2 / 4

    @property
    def longest_piece(self) -> float:
        """Greatest distance of nodes that resolves elastic bond [m]; infinite where bond is rigid.

        A part of ``sqrt(E A / k)``, over which the slip of a long bolt decays by e.
        """
        return math.inf if self.bond_stiffness is None else FINE * math.sqrt(self.axial_stiffness / self.bond_stiffness)

    @property
    def yield_force(self) -> float:
        """Tension at which the steel flows [N]; infinite if never."""
        return math.inf if self.yield_strength is None else self.yield_strength * math.pi * self.diameter**2 / 4

    @property
    def bond_capacity(self) -> float:
        """Greatest force on the rock per length of a grouted bolt [N/m] (Wang Eq. 5.7); infinite if unlimited."""
        if self.bond_strength is not None:
            return self.bond_strength
        if self.hole_diameter is None or self.bond_steel_grout is None or self.bond_grout_rock is None:
            return math.inf
        return math.pi * min(self.diameter * self.bond_steel_grout, self.hole_diameter * self.bond_grout_rock)

    @property
    def dowel_stiffness(self) -> float:
        """Shear force over shear displacement of a joint that the bolt crosses [N/m]; 0 without dowel action.

        Two half-infinite beams on an elastic foundation k, joined at the joint, where the moment is zero:
        ``E I b^3`` with ``b = (k / (4 E I))^(1/4)`` and I = pi d^4 / 64.

        References
        ----------
        Hetenyi (1946), Beams on Elastic Foundation, University of Michigan Press, ch. 2.
        """
        if self.bearing_stiffness is None:
            return 0.0
        bending = self.young * math.pi * self.diameter**4 / 64
        return bending * math.pow(self.bearing_stiffness / (4 * bending), 0.75)

    @property
    def dowel_strength(self) -> float:
        """Greatest shear force across a joint [N]; infinite if unlimited.

        On either side the bolt presses the grout with p over its diameter up to a plastic hinge of moment
        ``d^3 s_y / 6``: ``d^2 sqrt(p s_y / 3)``.

        References
        ----------
        Johansen (1949), Theory of timber connections, IABSE Publications 9, 249-262.
        """
        if self.bearing_strength is None or self.yield_strength is None:
            return math.inf
        return self.diameter**2 * math.sqrt(self.bearing_strength * self.yield_strength / 3)
