"""Jointed rock as it is described: regions of rock, openings, excavation stages, and the joints through them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from bsm_mesh.errors import as_given, crossing
from bsm_mesh.geometries.joint_sets import FloatArray, Joints, Points
from bsm_mesh.geometries.parameters import Checks

DeadEnds = Literal["keep", "extend", "cut"]
TOLERANCE = 1e-6  # of the model's diagonal


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Region:
    """A region of rock; it lies over the regions given before it.

    Attributes
    ----------
    outline : (k, 2) array_like [m]
        Its outline.
    rock : str
        Name of the rock.
    border : str, optional
        Joint along the outline; without it the rocks meet without a joint.
    clipped : bool
        Whether it keeps to the rock given before it, as a shear zone drawn beyond the frame of the model does.
    intact : bool
        Whether joints end at it, as at a dam, a lining or a lintel.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.Region(outline=g.band([(0, 0), (10, 5)], 1.0), rock="shear_zone", border="wall", clipped=True).rock
    'shear_zone'
    """

    outline: Points
    rock: str
    border: str | None = None
    clipped: bool = False
    intact: bool = False

    def __post_init__(self) -> None:
        checks = Checks("Region")
        checks.group_part(rock=self.rock)
        checks.group_part_or_none(border=self.border)
        checks.true_or_false(clipped=self.clipped, intact=self.intact)
        checks.raise_faults()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Opening:
    """A void: no rock inside.

    Attributes
    ----------
    outline : (k, 2) array_like [m]
        Its outline.
    boundary : str
        Name of the boundary along it.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.Opening(outline=g.circle(2.0, (0, 5)), boundary="tunnel").boundary
    'tunnel'
    """

    outline: Points
    boundary: str = "opening"

    def __post_init__(self) -> None:
        checks = Checks("Opening")
        checks.group_part(boundary=self.boundary)
        checks.raise_faults()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Excavation:
    """A part that a stage removes: its outline divides the blocks, its rock is that of the regions.

    Attributes
    ----------
    outline : (k, 2) array_like [m]
        Its outline.
    name : str
        Name of the group, ``excavation:name``.
    border : str, optional
        Joint along the outline inside the rock. Without it the rock is whole across it until the stage.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.Excavation(outline=g.rectangle(0, 0, 4, 3), name="heading").name
    'heading'
    """

    outline: Points
    name: str
    border: str | None = None

    def __post_init__(self) -> None:
        checks = Checks("Excavation")
        checks.group_part(name=self.name)
        checks.group_part_or_none(border=self.border)
        checks.raise_faults()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RockMass:
    """Jointed rock, ready to be cut into blocks.

    Attributes
    ----------
    regions : sequence of Region, Opening or Excavation
        The later ones lie over the earlier ones.
    joints : sequence of Joints
        Joint sets and faults. Where two lie on each other, a border names the edge, else the one given first.
    seed : int
        Of the random numbers: same seed, same blocks.
    tolerance : float, optional
        Points nearer than this are taken as touching [m]; a millionth of the model's diagonal where not given.
    boundaries : mapping of str to (k, 2) array_like
        Lines along the outline [m]: the outer edges on them have that name instead of ``left``, ``top``, ...
    dead_ends : str
        Joints that end in the rock. ``keep``: they stay in the mesh and bound no block. ``extend``: they continue to
        the next joint. ``cut``: they are left out. All are reported.

    Examples
    --------
    A square of 4 m in two sets of 2 m: four blocks.

    >>> from bsm_mesh import geometries as g
    >>> rock = g.RockMass(
    ...     regions=[g.Region(outline=g.rectangle(0, 0, 4, 4), rock="gneiss")],
    ...     joints=[g.JointSet(name=f"J{dip}", dip=dip, spacing=2.0, start=(0, 0)) for dip in (0, 90)],
    ... )
    >>> g.cut_blocks(rock).count
    4
    """

    regions: Sequence[Region | Opening | Excavation]
    joints: Sequence[Joints] = ()
    seed: int = 0
    tolerance: float | None = None
    boundaries: Mapping[str, Points] = field(default_factory=dict)
    dead_ends: DeadEnds = "keep"

    def __post_init__(self) -> None:
        checks = Checks("rock mass")
        if checks.things(_is_part, "Region(...), Opening(...) or Excavation(...)", regions=self.regions):
            for number, region in enumerate(self.regions):
                fault = outline_fault(region.outline)
                if fault:
                    checks.add(f"region {number} ({type(region).__name__}): {fault}")
            if not any(isinstance(region, Region) and not region.clipped for region in self.regions):
                checks.add("there is no rock; give at least one Region(outline=..., rock=...)")
        checks.things(_gives_traces, "JointSet(...), Fault(...) or other joints of the plane", joints=self.joints)
        checks.count(0, seed=self.seed)
        checks.positive_or_none(tolerance=self.tolerance)
        checks.one_of(get_args(DeadEnds), dead_ends=self.dead_ends)
        if isinstance(self.boundaries, Mapping):
            checks.points(2, **{f"boundary '{name}'": line for name, line in self.boundaries.items()})
        else:
            checks.add(
                f"boundaries = {as_given(self.boundaries)} must be a mapping by names: {{'base': [(x, y), ...]}}"
            )
        checks.raise_faults()

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Lower left and upper right corner of all rock [m]."""
        outlines = [
            np.asarray(r.outline, dtype=np.float64) for r in self.regions if isinstance(r, Region) and not r.clipped
        ]
        corners = np.concatenate(outlines)
        return corners.min(axis=0), corners.max(axis=0)

    @property
    def grid(self) -> float:
        """The tolerance [m]."""
        low, high = self.box
        return self.tolerance or TOLERANCE * float(np.hypot(*(high - low)))

    def domain(self) -> Any:
        """Return all rock as a shapely polygon or multipolygon."""
        import shapely

        rock = shapely.Polygon()
        for region in self.regions:
            polygon = shapely.Polygon(np.asarray(region.outline, dtype=np.float64))
            if isinstance(region, Region) and not region.clipped:
                rock = shapely.union(rock, polygon)
            elif isinstance(region, Opening):
                rock = shapely.difference(rock, polygon)
        return rock

    def jointed(self) -> Any:
        """Return where joints may run, as shapely geometry: in and half a tolerance around rock that is not intact."""
        import shapely

        around = shapely.buffer(self.domain(), self.grid / 2, join_style="mitre")
        for region in self.regions:
            if isinstance(region, Region):
                polygon = shapely.Polygon(np.asarray(region.outline, dtype=np.float64))
                if region.intact:
                    around = shapely.difference(around, polygon)
        return around


def _is_part(thing: object) -> bool:
    return isinstance(thing, Region | Opening | Excavation)


def _gives_traces(thing: object) -> bool:
    return isinstance(getattr(thing, "name", None), str) and callable(getattr(thing, "traces", None))


def outline_fault(outline: Points) -> str | None:
    """Return the faults of an outline, or None."""
    import shapely

    try:
        corners = np.asarray(outline, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        corners = np.empty(0)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
        return "the outline needs three or more points (x, y) of finite numbers"
    polygon = shapely.Polygon(corners)
    if not polygon.is_valid or polygon.area <= 0:
        return f"the outline {crossing(shapely.is_valid_reason(polygon))}"
    return None
