"""From the compass to the section: apparent dips, joint sets of mapped orientations and of scan lines, stereonet.

A plane is given by its dip (0 to 90 degrees from the level) and dip direction (degrees clockwise from north). A section
is given by its azimuth: the direction in which its x axis points.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bsm_mesh.files import whole_file
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray, JointSet
from bsm_mesh.geometries.reading import as_path
from bsm_mesh.geometries.spacings import Lognormal

LEAST_SINE = 0.05  # of the angle between joint and section: nearer to parallel, a joint leaves no trace worth a line
LEAST_COSINE = 0.1  # of the angle between scan line and normal: Terzaghi's correction is not taken further


def apparent_dip(dip: npt.ArrayLike, dip_direction: npt.ArrayLike, section_azimuth: float) -> FloatArray:
    """Return the angle of the trace in the section from the x axis, counter-clockwise [degrees].

    A plane that dips towards the section's azimuth falls to the right: its angle is negative.

    Parameters
    ----------
    dip, dip_direction : (n,) array_like
        Of the planes [degrees].
    section_azimuth : float
        Direction of the x axis, clockwise from north [degrees].

    Notes
    -----
    tan(apparent dip) = tan(dip) cos(dip direction - azimuth).

    Examples
    --------
    >>> float(apparent_dip(30, 90, 90).round(9)), float(apparent_dip(30, 270, 90).round(9))
    (-30.0, 30.0)
    """
    delta, turn = np.radians(np.asarray(dip, dtype=np.float64)), np.radians(np.asarray(dip_direction) - section_azimuth)
    angle: FloatArray = np.degrees(np.arctan2(-np.sin(delta) * np.cos(turn), np.cos(delta)))
    return angle


def apparent_spacing(
    spacing: npt.ArrayLike, dip: npt.ArrayLike, dip_direction: npt.ArrayLike, section_azimuth: float
) -> FloatArray:
    """Return the distance between traces in the section [m] of planes at a true `spacing` [m].

    Parameters
    ----------
    spacing : (n,) array_like
        Between the planes, across them [m].
    dip, dip_direction, section_azimuth
        As for `apparent_dip`.

    Examples
    --------
    Upright joints that strike across the section have their own spacing in it.

    >>> from bsm_mesh import geometries as g
    >>> float(g.apparent_spacing(2.0, 90, 90, 90).round(6))
    2.0
    """
    delta, turn = np.radians(np.asarray(dip, dtype=np.float64)), np.radians(np.asarray(dip_direction) - section_azimuth)
    sine = np.hypot(np.sin(delta) * np.cos(turn), np.cos(delta))  # of the angle between plane and section
    with np.errstate(divide="ignore"):
        apparent: FloatArray = np.asarray(spacing, dtype=np.float64) / sine
    return apparent


def joint_set_in_section(
    name: str, *, dip: float, dip_direction: float, spacing: float, section_azimuth: float, **others: object
) -> JointSet:
    """Return a joint set by its orientation in space and its true spacing.

    Parameters
    ----------
    name : str
        Name of the joint.
    dip, dip_direction : float
        Of the planes [degrees].
    spacing : float
        Across the planes [m].
    section_azimuth : float
        Direction of the x axis [degrees from north].
    **others
        As for `JointSet`.

    Raises
    ------
    GeometryError
        For planes that are nearly parallel to the section.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> found = g.joint_set_in_section("J", dip=60, dip_direction=90, spacing=2.0, section_azimuth=90)
    >>> round(found.dip)  # it falls to the right
    -60
    """
    wide = float(apparent_spacing(spacing, dip, dip_direction, section_azimuth))
    if wide > spacing / LEAST_SINE:
        raise GeometryError(f"joint set '{name}': its planes are nearly parallel to the section and leave no traces")
    angle = float(apparent_dip(dip, dip_direction, section_azimuth))
    return JointSet(name=name, dip=angle, spacing=wide, **others)  # type: ignore[arg-type]


def joint_sets_of_scan_line(
    rows: Sequence[Mapping[str, float | str]], *, trend: float, plunge: float, section_azimuth: float
) -> list[JointSet]:
    """Return a joint set for every set that was mapped along a scan line.

    The dip is that of the mean normal of the set, its scatter the standard deviation of the apparent dips; spacings
    are the distances along the line between neighbours of a set times the cosine between line and normal (Terzaghi
    1965), lognormal by their mean and deviation.

    Parameters
    ----------
    rows : sequence of mapping
        Joints in any order, each with ``distance`` along the line [m], ``dip``, ``dip_direction`` [degrees], ``set``.
    trend, plunge : float
        Of the scan line, from north and from the level downwards [degrees].
    section_azimuth : float
        Direction of the x axis [degrees from north].

    Raises
    ------
    GeometryError
        For sets of fewer than two joints, and those nearly parallel to the section.
    """
    faults, sets = [], []
    line = line_directions(np.array([trend]), np.array([plunge]))[0]
    for name in dict.fromkeys(str(row["set"]) for row in rows):
        chosen = [row for row in rows if str(row["set"]) == name]
        dip, direction, at = (
            np.array([float(row[key]) for row in chosen]) for key in ("dip", "dip_direction", "distance")
        )
        if len(chosen) < 2:
            faults.append(f"scan line: set '{name}' has one joint; a spacing needs two at least")
            continue
        normal = mean_normal(dip, direction)
        spacing = np.diff(np.sort(at)) * max(abs(float(normal @ line)), LEAST_COSINE)
        mean_dip, mean_direction = plane_of(normal)
        wide = float(apparent_spacing(1.0, mean_dip, mean_direction, section_azimuth))
        if wide > 1 / LEAST_SINE:
            faults.append(f"scan line: set '{name}' is nearly parallel to the section and leaves no traces")
            continue
        angles = apparent_dip(dip, direction, section_azimuth)
        angle = float(apparent_dip(mean_dip, mean_direction, section_azimuth))
        scatter = float(np.sqrt(np.mean(((angles - angle + 90) % 180 - 90) ** 2)))
        mean, deviation = float(spacing.mean()) * wide, float(spacing.std()) * wide
        law = Lognormal(mean, deviation) if deviation > 0 else mean
        sets.append(JointSet(name=name, dip=angle, spacing=law, scatter=min(scatter, 44.0)))
    if faults:
        raise GeometryError(faults)
    return sets


def mean_normal(dip: npt.ArrayLike, dip_direction: npt.ArrayLike) -> FloatArray:
    """Return the mean upward unit normal (east, north, up) of planes, (3,).

    The mean is the principal axis of the normals' orientation tensor: a normal and its opposite are the same.
    """
    normals = upward_normals(np.asarray(dip, dtype=np.float64), np.asarray(dip_direction, dtype=np.float64))
    axis: FloatArray = np.linalg.eigh(normals.T @ normals)[1][:, -1]
    return axis if axis[2] >= 0 else -axis


def draw_stereonet(
    path: str | os.PathLike[str],
    sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    *,
    section_azimuth: float | None = None,
    friction: float | None = None,
    face: tuple[float, float] | None = None,
    title: str = "",
) -> Path:
    """Draw poles and mean planes in an equal-area net of the lower hemisphere, as PNG; return the path.

    Parameters
    ----------
    path : path
        The file, ``.png``.
    sets : mapping of str to (dip, dip direction)
        Arrays of the planes of each set [degrees].
    section_azimuth : float, optional
        The section is drawn as a line across the net [degrees from north].
    friction : float, optional [degrees]
        Two circles are drawn: planes whose poles lie inside the dashed one dip less than the friction angle; lines in
        which two planes meet plunge more steeply where they lie inside the dotted one.
    face : (dip, dip direction), optional [degrees]
        Of a slope, drawn as a great circle: lines between it and the rim come out of the slope.
    title : str
        Heading.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    target = as_path("path", path)
    if target.suffix.lower() != ".png":
        raise GeometryError(f"{target}: the picture is a PNG; give a name that ends in .png")
    figure = Figure(figsize=(7, 7.4), layout="constrained")
    axes = figure.add_subplot()
    axes.set(aspect="equal", xlim=(-1.15, 1.15), ylim=(-1.15, 1.2))
    axes.axis("off")
    round_ = np.radians(np.arange(361))
    axes.plot(np.sin(round_), np.cos(round_), color="black", lw=1.2)
    for degrees, name in zip(range(0, 360, 90), "NESW", strict=True):
        x, y = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        axes.plot([0.97 * x, 1.0 * x], [0.97 * y, 1.0 * y], color="black", lw=1.2)
        axes.text(1.07 * x, 1.07 * y, name, ha="center", va="center")
    for name, (dip, direction) in sets.items():
        normal = mean_normal(dip, direction)
        mean_dip, mean_direction = plane_of(normal)
        poles = project(
            -upward_normals(np.atleast_1d(np.asarray(dip, float)), np.atleast_1d(np.asarray(direction, float)))
        )
        label = f"{name}: {len(poles)} poles, mean {mean_dip:.0f}/{mean_direction:03.0f}"
        (points,) = axes.plot(*poles.T, "o", ms=4, alpha=0.7, label=label)
        axes.plot(*project(_great_circle(mean_dip, mean_direction)).T, color=points.get_color(), lw=1.5)
    if section_azimuth is not None:
        x, y = math.sin(math.radians(section_azimuth)), math.cos(math.radians(section_azimuth))
        axes.plot([-x, x], [-y, y], "--", color="grey", lw=1, label=f"section, x axis to {section_azimuth:03.0f}")
    for radius, style, what in _friction_circles(friction):
        axes.plot(radius * np.sin(round_), radius * np.cos(round_), style, color="firebrick", lw=1, label=what)
    if face is not None:
        label = f"slope {face[0]:.0f}/{face[1]:03.0f}"
        axes.plot(*project(_great_circle(*face)).T, color="black", lw=2, label=label)
    for text in axes.legend(loc="upper left", fontsize=8, frameon=False).get_texts():
        text.set_parse_math(False)  # a $ in a name is a $
    axes.set_title(title or "Equal area, lower hemisphere", parse_math=False)
    with whole_file(target, parents=True) as draft:
        FigureCanvasAgg(figure).print_png(str(draft))
    return target


def _friction_circles(friction: float | None) -> list[tuple[float, str, str]]:
    """Return radius, line style and label of the circles of a friction angle [degrees] in a net of radius 1."""
    if friction is None:
        return []
    if not 0 < friction < 90:
        raise GeometryError(f"friction = {friction} must lie between 0 and 90 degrees")
    steep, flat = (math.sqrt(2) * math.sin(math.radians(angle) / 2) for angle in (90 - friction, friction))
    return [
        (flat, "--", f"poles of planes dipping {friction:g} degrees"),
        (steep, ":", f"lines plunging {friction:g} degrees"),
    ]


def project(directions: FloatArray) -> FloatArray:
    """Return the place of downward unit vectors (east, north, up), (n, 3), in an equal-area net of radius 1, (n, 2).

    Examples
    --------
    >>> project(np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])).round(9).tolist()
    [[0.0, 0.0], [1.0, 0.0]]
    """
    down = np.clip(-directions[:, 2], -1.0, 1.0)
    place: FloatArray = directions[:, :2] / np.sqrt(1 + down)[:, None]
    return place


def upward_normals(dip: FloatArray, dip_direction: FloatArray) -> FloatArray:
    """Return the upward unit normals (east, north, up), (n, 3)."""
    delta, alpha = np.radians(np.atleast_1d(dip)), np.radians(np.atleast_1d(dip_direction))
    return np.stack([np.sin(delta) * np.sin(alpha), np.sin(delta) * np.cos(alpha), np.cos(delta)], axis=1)


def line_directions(trend: FloatArray, plunge: FloatArray) -> FloatArray:
    """Return the unit vectors (east, north, up) of lines, (n, 3)."""
    alpha, fall = np.radians(trend), np.radians(plunge)
    return np.stack([np.cos(fall) * np.sin(alpha), np.cos(fall) * np.cos(alpha), -np.sin(fall)], axis=1)


def plane_of(normal: FloatArray) -> tuple[float, float]:
    """Return dip and dip direction of the plane with an upward normal [degrees]."""
    dip = math.degrees(math.acos(min(1.0, float(normal[2]))))
    return dip, math.degrees(math.atan2(float(normal[0]), float(normal[1]))) % 360


def _great_circle(dip: float, dip_direction: float) -> FloatArray:
    """Return downward unit vectors in a plane, from one end of its strike to the other, (n, 3)."""
    strike = line_directions(np.array([dip_direction - 90]), np.array([0.0]))[0]
    down = line_directions(np.array([dip_direction]), np.array([dip]))[0]
    angle = np.linspace(0, np.pi, 91)[:, None]
    circle: FloatArray = np.cos(angle) * strike + np.sin(angle) * down
    return circle
