"""All straight lines that cut the rock: outlines of regions and traces of joints, clipped to the rock."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.abutting import ended
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.rock_mass import Region, RockMass

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
CHUNKS = 64  # a long slanting line has a wide box; a piece of the diagonal over this has few others in its own


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pieces:
    """Straight lines that cut the rock.

    Attributes
    ----------
    ends : (n, 2, 2) float64 [m]
        Both ends of each.
    joint : (n,) int64
        Index of its joint in `joint_names`; -1 for none.
    region : (n,) int64
        Index of the region that it outlines; -1 for traces.
    extends : (n,) bool
        Whether its dead ends continue to the next joint.
    joint_names : tuple of str
        Names of the joints: those of borders first, then in the order given.
    """

    ends: FloatArray
    joint: IntArray
    region: IntArray
    extends: BoolArray
    joint_names: tuple[str, ...]

    @property
    def length(self) -> FloatArray:
        """Length of each [m]."""
        length: FloatArray = np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)
        return length

    @property
    def direction(self) -> FloatArray:
        """Unit vector along each, (n, 2)."""
        length = np.maximum(self.length, np.finfo(np.float64).tiny)  # ends may have been joined
        direction: FloatArray = (self.ends[:, 1] - self.ends[:, 0]) / length[:, None]
        return direction

    def chosen(self, which: BoolArray) -> Pieces:
        """Return some of the pieces."""
        fields = {name: getattr(self, name)[which] for name in ("ends", "joint", "region", "extends")}
        return dataclasses.replace(self, **fields)

    def chunks(self, least: float) -> tuple[FloatArray, IntArray]:
        """Return the pieces in parts of a small box each, (n, 2, 2) [m], none below `least`, and the piece of each."""
        extent = float(np.hypot(*np.ptp(self.ends.reshape(-1, 2), axis=0)))
        parts = np.maximum(1, np.ceil(self.length / max(extent / CHUNKS, least))).astype(np.int64)
        owner = np.repeat(np.arange(len(parts)), parts)
        within = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
        share = np.stack([within, within + 1], axis=1) / parts[owner][:, None]
        start, vector = self.ends[owner, 0], self.ends[owner, 1] - self.ends[owner, 0]
        return start[:, None] + share[:, :, None] * vector[:, None], owner


def gather_pieces(mass: RockMass) -> tuple[Pieces, FloatArray]:
    """Return the pieces, and the length of the traces of each joint as given [m].

    Traces are clipped half a tolerance outside the rock, so that one along the outline is kept.
    """
    borders = [getattr(region, "border", None) for region in mass.regions]
    names = tuple(dict.fromkeys([*(b for b in borders if b is not None), *(joints.name for joints in mass.joints)]))
    ends, joint, region, extends = [], [], [], []
    for number, (sides, border) in enumerate(zip(_outlines(mass), borders, strict=True)):
        ends.append(sides)
        joint.append(np.full(len(sides), -1 if border is None else names.index(border)))
        region.append(np.full(len(sides), number))
        extends.append(np.zeros(len(sides), dtype=np.bool_))
    given = np.zeros(len(names))
    low, high = mass.box
    jointed = mass.jointed()
    found = ended(mass.joints, [joints.traces(low, high, mass.seed) for joints in mass.joints])
    for joints, traces in zip(mass.joints, found, strict=True):
        index = names.index(joints.name)
        given[index] += np.hypot(*(traces[:, 1] - traces[:, 0]).T).sum()
        inside = _clip(traces, jointed, mass.grid)
        ends.append(inside)
        joint.append(np.full(len(inside), index))
        region.append(np.full(len(inside), -1))
        extends.append(np.full(len(inside), joints.extends or mass.dead_ends == "extend"))
    pieces = Pieces(
        ends=np.concatenate(ends),
        joint=np.concatenate(joint),
        region=np.concatenate(region),
        extends=np.concatenate(extends),
        joint_names=names,
    )
    return pieces, given


def _outlines(mass: RockMass) -> list[FloatArray]:
    """Return the sides of every region, (n, 2, 2) [m].

    Regions that follow each other, are of one kind and overlap, such as bands that cross, have one outline in common,
    that of the first: between their own there would be slivers.
    """
    import shapely

    def kind(number: int) -> tuple[object, ...] | None:
        region = mass.regions[number]
        return (region.rock, region.border, region.clipped, region.intact) if isinstance(region, Region) else None

    found = [_sides(np.asarray(region.outline, dtype=np.float64)) for region in mass.regions]
    polygons = shapely.polygons([shapely.linearrings(region.outline) for region in mass.regions])
    first = 0
    for number in range(1, len(found) + 1):
        if number < len(found) and kind(number) is not None and kind(number) == kind(first):
            continue
        _fuse(found, polygons, first, number)
        first = number
    return found


def _fuse(found: list[FloatArray], polygons: Any, first: int, end: int) -> None:
    """Give the overlapping ones of the regions from `first` to `end` one outline in common."""
    import shapely
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    mine = polygons[first:end]
    one, other = shapely.STRtree(mine).query(mine, predicate="intersects")
    overlapping = (one < other) & (shapely.area(shapely.intersection(mine[one], mine[other])) > 0)
    if not overlapping.any():
        return
    graph = coo_array((np.ones(int(overlapping.sum())), (one[overlapping], other[overlapping])), (len(mine), len(mine)))
    _, label = connected_components(graph, directed=False)
    for group in np.flatnonzero(np.bincount(label) > 1):
        members = first + np.flatnonzero(label == group)
        rings = shapely.get_rings(shapely.get_parts(shapely.union_all(polygons[members])))
        found[members[0]] = np.concatenate([_sides(shapely.get_coordinates(ring)[:-1]) for ring in rings])
        for number in members[1:]:
            found[number] = np.empty((0, 2, 2))


def _sides(corners: FloatArray) -> FloatArray:
    """Return the sides of an outline, (n, 2, 2), corners given twice left out."""
    corners = corners[np.any(corners != np.roll(corners, -1, axis=0), axis=1)]
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def _clip(traces: FloatArray, jointed: Any, shortest: float) -> FloatArray:
    """Return the parts of the traces where joints may run that are longer than `shortest`."""
    import shapely

    shapely.prepare(jointed)
    parts = shapely.get_parts(shapely.intersection(shapely.linestrings(traces), jointed))
    parts = parts[shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING]
    points = [shapely.get_coordinates(shapely.get_point(parts, end)) for end in (0, -1)]
    ends = np.stack(points, axis=1) if len(parts) else np.empty((0, 2, 2))
    longer: FloatArray = ends[np.hypot(*(ends[:, 1] - ends[:, 0]).T) > shortest]
    return longer
