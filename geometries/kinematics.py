"""Kinematic screening of a rock slope: which joints and lines can slide or topple by their orientation alone."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.orientations import line_directions, mean_normal, plane_of, upward_normals
from bsm_mesh.geometries.parameters import Checks

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]
ROUNDING = 1e-9  # of direction cosines: a line within it of a plane lies in it
MAX_LINES = 2_000_000


@dataclass(frozen=True, eq=False, kw_only=True)
class Kinematics:
    """Planes and lines of intersection, and the movements that their orientation permits.

    Attributes
    ----------
    face : (float, float) [degrees]
        Dip and dip direction of the slope.
    friction, lateral_limit, toppling_limit : float [degrees]
        As given.
    sets : tuple of str
        Names of the sets.
    of_set : (n,) int64
        Set of every plane, by its position in `sets`.
    dip, dip_direction : (n,) float64 [degrees]
        Of every plane.
    planar : (n,) bool
        Whether the plane can slide out of the slope along its dip.
    flexural : (n,) bool
        Whether layers along the plane can topple by flexure, with slip between them.
    base : (n,) bool
        Whether the plane can be the base of toppling blocks.
    first, second : (m,) int64
        Planes of every line of intersection.
    trend, plunge : (m,) float64 [degrees]
        Of every line.
    wedge : (m,) bool
        Whether a wedge on the two planes can slide out of the slope.
    slides_on : (m,) int64
        The plane on which a wedge slides, -1 where it slides along the line on both (as Hocking 1976 finds it).
    direct : (m,) bool
        Whether blocks that the two planes bound can topple, if a base is there.
    """

    face: tuple[float, float]
    friction: float
    lateral_limit: float
    toppling_limit: float
    sets: tuple[str, ...]
    of_set: IntArray
    dip: FloatArray
    dip_direction: FloatArray
    planar: BoolArray
    flexural: BoolArray
    base: BoolArray
    first: IntArray
    second: IntArray
    trend: FloatArray
    plunge: FloatArray
    wedge: BoolArray
    slides_on: IntArray
    direct: BoolArray

    @property
    def modes(self) -> dict[str, tuple[int, int]]:
        """How many planes or lines permit each movement, and of how many."""
        topples = int(self.direct.sum()) if self.base.any() else 0
        return {
            "planar sliding": (int(self.planar.sum()), len(self.dip)),
            "wedge sliding": (int(self.wedge.sum()), len(self.trend)),
            "flexural toppling": (int(self.flexural.sum()), len(self.dip)),
            "direct toppling": (topples, len(self.trend)),
        }


def kinematic_screening(
    sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    *,
    face: tuple[float, float],
    friction: float,
    lateral_limit: float = 20.0,
    toppling_limit: float = 30.0,
    means: bool = False,
) -> Kinematics:
    """Return which planes and lines of intersection permit sliding or toppling out of a slope.

    Orientations and friction alone are judged; a movement that is possible is no failure yet.

    Parameters
    ----------
    sets : mapping of str to (dip, dip direction)
        Numbers or arrays of the planes of each set [degrees].
    face : (dip, dip direction) [degrees]
        Of the slope.
    friction : float [degrees]
        Friction angle of the joints.
    lateral_limit : float [degrees]
        Planar sliding and direct toppling: greatest angle between the dip direction of the slope and the movement.
    toppling_limit : float [degrees]
        The same for flexural toppling.
    means : bool
        Whether the mean planes of the sets are judged instead of all planes.

    Raises
    ------
    GeometryError
        With every angle out of its range.

    Notes
    -----
    *Planar* (Markland 1972): the line of dip comes out of the face and is steeper than friction, within the lateral
    limit. *Wedge*: the same of the line of intersection, without a lateral limit. *Flexural* (Goodman and Bray 1976):
    the normal to the layers plunges less than the face minus friction, seen across the slope, within the limit.
    *Direct* (Hudson and Harrison 1997): the line dips into the slope within the lateral limit and plunges more than
    90 degrees minus the face; its base dips less than friction, or towards the face and less than it.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> found = g.kinematic_screening({"A": (45, 105), "B": (70, 235)}, face=(65, 185), friction=30)
    >>> bool(found.wedge[0]), float(found.plunge[0].round(1)), float(found.trend[0].round(1))
    (True, 31.2, 157.7)
    """
    names, of_set, dip, direction = _planes(sets, means)
    _check(dip, direction, face, friction, lateral_limit, toppling_limit)
    first, second = _pairs(of_set)
    trend, plunge = intersections(dip, direction, first, second)
    planar, flexural, base = permits_by_plane(dip, direction, face, friction, lateral_limit, toppling_limit)
    wedge, direct = permits_by_line(trend, plunge, face, friction, lateral_limit)
    return Kinematics(
        face=face,
        friction=friction,
        lateral_limit=lateral_limit,
        toppling_limit=toppling_limit,
        sets=names,
        of_set=of_set,
        dip=dip,
        dip_direction=direction,
        planar=planar,
        flexural=flexural,
        base=base,
        first=first,
        second=second,
        trend=trend,
        plunge=plunge,
        wedge=wedge,
        slides_on=_slides_on(dip, direction, first, second),
        direct=direct,
    )


def permits_by_plane(
    dip: FloatArray,
    direction: FloatArray,
    face: tuple[float, float],
    friction: float,
    lateral_limit: float,
    toppling_limit: float,
) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Return which planes permit planar sliding, flexural toppling, and toppling on them as a base, (n,) each."""
    out = upward_normals(np.array([face[0]]), np.array([face[1]]))[0]  # of the face, into the air
    ahead: BoolArray = np.abs(_between(direction, face[1])) <= lateral_limit
    leaves = (line_directions(direction, dip) @ out > ROUNDING) & ahead
    slip_limit = upward_normals(np.array([face[0] - friction]), np.array([face[1]]))[0]
    against: BoolArray = np.abs(_between(direction + 180, face[1])) <= toppling_limit
    flexural = against & (-upward_normals(dip, direction) @ slip_limit >= -ROUNDING) & (face[0] > friction)
    return leaves & (dip > friction), flexural, leaves | (dip < friction)


def permits_by_line(
    trend: FloatArray, plunge: FloatArray, face: tuple[float, float], friction: float, lateral_limit: float
) -> tuple[BoolArray, BoolArray]:
    """Return which lines of intersection permit wedges to slide, and which blocks to topple, (m,) each."""
    out = upward_normals(np.array([face[0]]), np.array([face[1]]))[0]
    wedge: BoolArray = (line_directions(trend, plunge) @ out > ROUNDING) & (plunge > friction)
    into: BoolArray = np.abs(_between(trend + 180, face[1])) <= lateral_limit
    return wedge, into & (plunge >= 90 - face[0])


def intersections(dip: FloatArray, direction: FloatArray, first: IntArray, second: IntArray) -> tuple[FloatArray, ...]:
    """Return trend and plunge of the lines in which planes meet, (m,) each [degrees]; NaN of parallel planes."""
    normals = upward_normals(dip, direction)
    line = np.cross(normals[first], normals[second])
    length = np.linalg.norm(line, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        line /= np.where(length > ROUNDING, length, np.nan)[:, None]
    line *= np.where(line[:, 2] > 0, -1.0, 1.0)[:, None]
    trend: FloatArray = np.degrees(np.arctan2(line[:, 0], line[:, 1])) % 360
    plunge: FloatArray = np.degrees(np.arcsin(np.clip(-line[:, 2], -1.0, 1.0)))
    return trend, plunge


def _planes(
    sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]], means: bool
) -> tuple[tuple[str, ...], IntArray, FloatArray, FloatArray]:
    """Return names of sets, and set, dip and dip direction of every plane."""
    if not sets:
        raise GeometryError("kinematics: no sets; give planes by their dips and dip directions")
    parts = []
    for name, (dip, direction) in sets.items():
        dips, directions = (np.atleast_1d(np.asarray(values, np.float64)) for values in (dip, direction))
        if dips.shape != directions.shape or dips.ndim != 1 or not dips.size:
            raise GeometryError(
                f"set '{name}': {dips.size} dips and {directions.size} dip directions; give a pair each"
            )
        if means:
            mean = plane_of(mean_normal(dips, directions))
            dips, directions = np.array([mean[0]]), np.array([mean[1]])
        parts.append((dips, directions))
    of_set = np.repeat(np.arange(len(parts)), [len(dips) for dips, _ in parts])
    return tuple(sets), of_set, np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])


def _check(
    dip: FloatArray, direction: FloatArray, face: tuple[float, float], friction: float, lateral: float, toppling: float
) -> None:
    checks = Checks("kinematics")
    given = {
        "dip": (dip, 0, 90),
        "dip direction": (direction, -360, 360),
        "dip of the face": (np.array([face[0]]), 0, 90),
        "dip direction of the face": (np.array([face[1]]), -360, 360),
        "friction": (np.array([friction]), 0, 90),
        "lateral limit": (np.array([lateral]), 0, 90),
        "toppling limit": (np.array([toppling]), 0, 90),
    }
    for what, (values, low, high) in given.items():
        wrong = values[~((values >= low) & (values <= high))]
        if wrong.size:
            checks.add(f"{what} = {wrong[0]:g} must be from {low} to {high} degrees")
    checks.raise_faults()


def _pairs(of_set: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of planes of different sets, or of one set where there is one only."""
    count = np.bincount(of_set)
    alone = len(count) == 1
    lines = (len(of_set) ** 2 - (len(of_set) if alone else (count**2).sum())) // 2
    if lines > MAX_LINES:
        raise GeometryError(
            f"kinematics: {lines} lines of intersection; give fewer planes, or judge the mean plane of each set "
            "(means = True in Python)"
        )
    if alone:
        first, second = np.triu_indices(len(of_set), 1)
        return first, second
    starts = np.concatenate([[0], np.cumsum(count)])
    pairs = [
        np.stack(np.meshgrid(np.arange(starts[a], starts[a + 1]), np.arange(starts[b], starts[b + 1]), indexing="ij"))
        for a, b in itertools.combinations(range(len(count)), 2)
    ]
    found = np.concatenate([np.zeros((2, 0), np.int64), *(pair.reshape(2, -1) for pair in pairs)], axis=1)
    return found[0], found[1]


def _between(angle: FloatArray, reference: float) -> FloatArray:
    """Return the turn from a direction to others, -180 to 180 [degrees]."""
    turn: FloatArray = (angle - reference + 180) % 360 - 180
    return turn


def _slides_on(dip: FloatArray, direction: FloatArray, first: IntArray, second: IntArray) -> IntArray:
    """Return the plane on which each wedge slides: the one whose line of dip leaves the other plane; -1: both."""
    fall, normals = line_directions(direction, dip), upward_normals(dip, direction)
    found = np.full(len(first), -1)
    for plane, other in ((first, second), (second, first)):
        found = np.where(np.einsum("mi,mi->m", fall[plane], normals[other]) > ROUNDING, plane, found)
    return found
