"""Bodies in space, each a union of convex parts: tunnels and caverns by a profile, hulls of points, slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bsm_mesh.errors import crossing
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.orientations import line_directions, upward_normals
from bsm_mesh.geometries.parameters import Checks

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class HalfSpaces:
    """A convex body: the points below all of some planes.

    Attributes
    ----------
    normal : (n, 3) float64
        Outward unit normals.
    offset : (n,) float64 [m]
        The body is ``normal @ x <= offset``.
    """

    normal: FloatArray
    offset: FloatArray


Body = Sequence[HalfSpaces]
PARTS = "parts, as prism(...), hull(...) and slope(...) give it"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Opening:
    """A void: no rock inside.

    Attributes
    ----------
    body : sequence of HalfSpaces
        Its parts: of `prism`, `hull` or `slope`.
    boundary : str
        Name of the boundary along it.
    """

    body: Body
    boundary: str = "opening"

    def __post_init__(self) -> None:
        checks = Checks("Opening")
        checks.things(_is_convex, PARTS, body=self.body)
        checks.group_part(boundary=self.boundary)
        checks.raise_faults()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Excavation:
    """A part that is removed later: it divides the blocks, its rock is there until then.

    Attributes
    ----------
    body : sequence of HalfSpaces
        Its parts: of `prism`, `hull` or `slope`.
    name : str
        Name of the excavation.
    """

    body: Body
    name: str

    def __post_init__(self) -> None:
        checks = Checks("Excavation")
        checks.things(_is_convex, PARTS, body=self.body)
        checks.group_part(name=self.name)
        checks.raise_faults()


def prism(
    profile: npt.ArrayLike,
    *,
    trend: float = 0.0,
    plunge: float = 0.0,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    length: float | None = None,
) -> Body:
    """Return the body of a profile along an axis: a tunnel, a cavern, a shaft.

    Parameters
    ----------
    profile : (k, 2) array_like [m]
        Outline across the axis: to the right as one looks along it, and up. It need not be convex.
    trend, plunge : float
        Direction of the axis, clockwise from north, and its fall from the level [degrees].
    origin : (float, float, float) [m]
        Where the axis begins.
    length : float, optional [m]
        Length of the body; where not given it continues to both sides.

    Raises
    ------
    GeometryError
        If the profile is no simple polygon, or the axis is no direction.

    Examples
    --------
    >>> from bsm_mesh.geometries import three_d
    >>> len(three_d.prism([(-2, 0), (2, 0), (2, 3), (-2, 3)])[0].offset)
    4
    """
    checks = Checks("prism")
    checks.number("degrees", trend=trend, plunge=plunge)
    checks.vector(origin=origin)
    checks.positive_or_none(length=length)
    checks.points(3, profile=profile)
    checks.raise_faults()
    axis = line_directions(np.array([trend]), np.array([plunge]))[0]
    right = line_directions(np.array([trend + 90.0]), np.array([0.0]))[0]
    up, start = np.cross(right, axis), np.asarray(origin, dtype=np.float64)
    parts = []
    for corners in _convex_parts(np.asarray(profile, dtype=np.float64)):
        side = np.roll(corners, -1, axis=0) - corners
        across = np.stack([side[:, 1], -side[:, 0]], axis=1) / np.linalg.norm(side, axis=1)[:, None]
        normal = across[:, :1] * right + across[:, 1:] * up
        offset = (across * corners).sum(axis=1) + normal @ start
        if length is not None:
            normal = np.concatenate([normal, [axis, -axis]])
            offset = np.concatenate([offset, [axis @ start + length, -axis @ start]])
        parts.append(HalfSpaces(normal, offset))
    return parts


def hull(points: npt.ArrayLike) -> Body:
    """Return the convex hull of points (n, 3) [m].

    Raises
    ------
    GeometryError
        If the points span no volume.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        equations = ConvexHull(np.asarray(points, dtype=np.float64)).equations
    except (QhullError, ValueError, TypeError, IndexError, OverflowError):
        raise GeometryError("hull: give four or more points (x, y, z) that do not lie in one plane") from None
    _, first = np.unique(equations.round(9), axis=0, return_index=True)  # a triangulated face comes several times
    chosen = equations[np.sort(first)]
    return [HalfSpaces(chosen[:, :3], -chosen[:, 3])]


def slope(
    *,
    toe: Sequence[float],
    dip: float,
    dip_direction: float,
    height: float,
    top_dip: float = 0.0,
    top_direction: float | None = None,
) -> Body:
    """Return the air in front of a rock slope and above it.

    Parameters
    ----------
    toe : (float, float, float) [m]
        A point at the foot of the face; the ground in front of it is level.
    dip, dip_direction : float
        Of the face [degrees].
    height : float [m]
        Height of the crest over the toe, straight up the face.
    top_dip, top_direction : float
        Of the ground above the crest [degrees]; by default level. Its direction is that of the face where not given.

    Examples
    --------
    >>> from bsm_mesh.geometries import three_d
    >>> len(three_d.slope(toe=(0, 0, 0), dip=65, dip_direction=180, height=30))
    2
    """
    checks = Checks("slope")
    checks.vector(toe=toe)
    checks.number("degrees", dip_direction=dip_direction, top_dip=top_dip)
    if checks.number("degrees", dip=dip) and not 0 < dip <= 90:
        checks.add(f"dip = {dip:g} must be above 0 and at most 90 degrees")
    checks.positive(height=height)
    checks.raise_faults()
    direction = dip_direction if top_direction is None else top_direction
    face, top = upward_normals(np.array([dip, top_dip]), np.array([dip_direction, direction]))
    foot, floor = np.asarray(toe, dtype=np.float64), np.array([0.0, 0.0, 1.0])
    along = line_directions(np.array([dip_direction]), np.array([dip]))[0]
    crest = foot - along * height / np.sin(np.radians(dip))
    front = HalfSpaces(np.array([-face, -floor]), np.array([-face @ foot, -floor @ foot]))
    above = HalfSpaces(np.array([face, -top, -floor]), np.array([face @ foot, -top @ crest, -floor @ foot]))
    return [front, above]


def _is_convex(thing: object) -> bool:
    return isinstance(thing, HalfSpaces)


def _convex_parts(profile: FloatArray) -> list[FloatArray]:
    """Return convex polygons, counter-clockwise, that make up a profile."""
    import shapely

    polygon = shapely.Polygon(profile)
    if not polygon.is_valid or polygon.area <= 0:
        raise GeometryError(f"prism: the profile {crossing(shapely.is_valid_reason(polygon))}")
    polygon = shapely.remove_repeated_points(polygon)
    if polygon.convex_hull.area <= polygon.area * (1 + 1e-12):
        parts = [polygon.convex_hull]
    else:
        parts = list(shapely.constrained_delaunay_triangles(polygon).geoms)
    return [shapely.get_coordinates(shapely.geometry.polygon.orient(part))[:-1] for part in parts]
