"""Outlines of tunnels, stopes, slopes, dams and zones: corners counter-clockwise, (k, 2) [m]."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Sequence
from typing import ParamSpec

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.parameters import Checks

Point = tuple[float, float]
Given = ParamSpec("Given")
IN_DEGREES = ("angle", "dip", "upstream", "downstream")


def _checked(shape: Callable[Given, FloatArray]) -> Callable[Given, FloatArray]:
    """Return a shape that refuses values of another kind than its parameters have, before it takes them."""
    signature = inspect.signature(shape)

    @functools.wraps(shape)
    def checked(*args: Given.args, **kwargs: Given.kwargs) -> FloatArray:
        checks = Checks(shape.__name__)
        for name, value in signature.bind_partial(*args, **kwargs).arguments.items():
            kind = signature.parameters[name].annotation
            if kind == "Point":
                checks.vector("xy", **{name: value})
            elif kind == "int":
                checks.count(**{name: value})
            elif kind == "float" or (kind == "float | None" and value is not None):
                checks.number("degrees" if name in IN_DEGREES else "m", **{name: value})
            elif kind.startswith("Sequence"):
                checks.points(2, **{name: value})
        checks.raise_faults()
        return shape(*args, **kwargs)

    return checked


@_checked
def rectangle(left: float, bottom: float, right: float, top: float) -> FloatArray:
    """Return a rectangle: a model's frame, a box tunnel, a stope, a stage.

    Examples
    --------
    >>> rectangle(0, 0, 2, 1).tolist()
    [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]
    """
    _positive("rectangle", width=right - left, height=top - bottom)
    return np.array([(left, bottom), (right, bottom), (right, top), (left, top)], dtype=np.float64)


@_checked
def circle(radius: float, centre: Point = (0.0, 0.0), sides: int = 48) -> FloatArray:
    """Return a regular polygon with its corners on a circle, the first at the right.

    Parameters
    ----------
    radius : float
        Radius [m].
    centre : (float, float)
        Centre [m].
    sides : int
        Corners; the polygon has ``sides / (2 pi) sin(2 pi / sides)`` of the circle's area.

    Examples
    --------
    Four corners: a square on its corner.

    >>> from bsm_mesh import geometries as g
    >>> abs(g.circle(2.0, sides=4).round(6)).tolist()
    [[2.0, 0.0], [0.0, 2.0], [2.0, 0.0], [0.0, 2.0]]
    """
    _positive("circle", radius=radius)
    return _at(centre, _arc(radius, 0.0, 2 * math.pi, max(3, sides))[:-1])


@_checked
def horseshoe(width: float, height: float, base: Point = (0.0, 0.0), sides: int = 24) -> FloatArray:
    """Return a horseshoe: upright walls under a semicircle over the whole width.

    Parameters
    ----------
    width, height : float
        Greatest width, height at the crown [m].
    base : (float, float)
        Middle of the floor [m].
    sides : int
        Straight sides of the semicircle.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> float(g.horseshoe(6, 6)[:, 0].max())
    3.0
    """
    wall = height - width / 2
    _positive("horseshoe", width=width, height=height, **{"height - width / 2": wall})
    crown = np.array([0.0, wall]) + _arc(width / 2, 0.0, math.pi, sides)
    return _at(base, np.concatenate([[(-width / 2, 0.0), (width / 2, 0.0)], crown]))


@_checked
def vaulted_box(width: float, height: float, rise: float, base: Point = (0.0, 0.0), sides: int = 12) -> FloatArray:
    """Return a box under an arc of a circle: a cavern, a stope with an arched back, a door.

    Parameters
    ----------
    width, height : float
        Width, height at the crown [m].
    rise : float
        Height of the arc over its springing, at most half the width [m].
    base : (float, float)
        Middle of the floor [m].
    sides : int
        Straight sides of the arc.
    """
    _positive("vaulted_box", width=width, rise=rise, **{"height - rise": height - rise})
    if rise > width / 2:
        raise GeometryError(f"vaulted_box: rise = {rise} must be at most half the width, {width / 2} m")
    radius = (width**2 / 4 + rise**2) / (2 * rise)
    half = math.asin(min(1.0, width / 2 / radius))
    arc = np.array([0.0, height - radius]) + _arc(radius, math.pi / 2 - half, math.pi / 2 + half, sides)
    arc[0, 0], arc[-1, 0] = width / 2, -width / 2
    return _at(base, np.concatenate([[(-width / 2, 0.0), (width / 2, 0.0)], arc]))


@_checked
def stope(width: float, height: float, dip: float, base: Point = (0.0, 0.0)) -> FloatArray:
    """Return a stope in an inclined vein: level floor and back, walls at the dip.

    Parameters
    ----------
    width : float
        Width of floor and back, measured level [m].
    height : float
        Height [m].
    dip : float
        Angle of the walls from the x axis, above 0 and below 180 [degrees]; 90 is upright.
    base : (float, float)
        Middle of the floor [m].
    """
    _positive("stope", width=width, height=height, dip=dip, **{"180 - dip": 180 - dip})
    lean = height / math.tan(math.radians(dip))
    half = width / 2
    return _at(base, np.array([(-half, 0.0), (half, 0.0), (half + lean, height), (-half + lean, height)]))


@_checked
def slope(
    height: float,
    angle: float,
    *,
    benches: int = 1,
    berm: float = 0.0,
    toe: Point = (0.0, 0.0),
    ahead: float | None = None,
    behind: float | None = None,
    below: float | None = None,
) -> FloatArray:
    """Return the rock of a slope that rises to the right, with benches.

    Parameters
    ----------
    height : float
        From toe to crest [m].
    angle : float
        Of the faces of the benches [degrees].
    benches : int
        Number of benches of equal height.
    berm : float
        Width of the berms between them [m].
    toe : (float, float)
        Foot of the lowest face [m].
    ahead, behind, below : float, optional
        Rock in front of the toe, behind the crest and under the toe [m]; the height, where not given.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> float(g.slope(10.0, 45.0)[:, 1].max())
    10.0
    """
    ahead, behind, below = (height if value is None else value for value in (ahead, behind, below))
    _positive("slope", height=height, angle=angle, ahead=ahead, behind=behind, below=below, benches=benches)
    if angle > 90 or berm < 0:
        raise GeometryError(f"slope: angle = {angle} must be at most 90 degrees, berm = {berm} m not below 0")
    rise = height / benches
    run = rise / math.tan(math.radians(angle)) if angle < 90 else 0.0
    face: list[Point] = [(0.0, 0.0)]
    for bench in range(benches):
        if bench and berm > 0:
            face.append((face[-1][0] + berm, face[-1][1]))
        face.append((face[-1][0] + run, (bench + 1) * rise))
    crest = face[-1][0]
    frame = [(-ahead, 0.0), (-ahead, -below), (crest + behind, -below), (crest + behind, height)]
    return _at(toe, np.array([*frame, *reversed(face)]))


@_checked
def dam(
    height: float, crest: float, *, upstream: float = 90.0, downstream: float = 52.0, heel: Point = (0.0, 0.0)
) -> FloatArray:
    """Return a gravity dam, its upstream face to the left.

    Parameters
    ----------
    height, crest : float
        Height, width of the crest [m].
    upstream, downstream : float
        Angles of the faces from the level [degrees].
    heel : (float, float)
        Foot of the upstream face [m].

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> float(g.dam(40.0, 8.0)[:, 1].max())
    40.0
    """
    _positive("dam", height=height, crest=crest, upstream=upstream, downstream=downstream)
    left = height / math.tan(math.radians(upstream)) if upstream < 90 else 0.0
    right = left + crest + (height / math.tan(math.radians(downstream)) if downstream < 90 else 0.0)
    return _at(heel, np.array([(0.0, 0.0), (right, 0.0), (left + crest, height), (left, height)]))


@_checked
def band(line: Sequence[Point] | FloatArray, width: float) -> FloatArray:
    """Return a zone of constant width along a line: a shear zone, a dyke, a weak layer.

    Parameters
    ----------
    line : (k, 2) array_like
        Its middle [m].
    width : float
        Width across it [m].

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.band([(0, 0), (4, 0)], 1.0).tolist()
    [[4.0, 0.5], [0.0, 0.5], [0.0, -0.5], [4.0, -0.5]]
    """
    import shapely

    _positive("band", width=width)
    zone = shapely.orient_polygons(
        shapely.buffer(shapely.LineString(line), width / 2, cap_style="flat", join_style="mitre")
    )
    outline: FloatArray = shapely.get_coordinates(zone.exterior)[:-1]
    return outline


def _at(place: Point, outline: FloatArray) -> FloatArray:
    moved: FloatArray = np.asarray(place, dtype=np.float64) + outline
    return moved


def _arc(radius: float, start: float, end: float, sides: int) -> FloatArray:
    angle = np.linspace(start, end, sides + 1)
    arc: FloatArray = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return arc


def _positive(shape: str, **values: float) -> None:
    bad = {name: value for name, value in values.items() if not value > 0}
    if bad:
        raise GeometryError([f"{shape}: {name} = {value:g} must be above 0" for name, value in bad.items()])
