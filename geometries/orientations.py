"""From the compass to the section: apparent dips, joint sets of mapped orientations and of scan lines.

A plane is given by its dip (0 to 90 degrees from the level) and dip direction (degrees clockwise from north). A section
is given by its azimuth: the direction in which its x axis points.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray, JointSet
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

    The dip is that of the mean normal of the set, its scatter the standard deviation of the apparent dips. Spacings
    are distances between neighbours along the line, times the cosine between line and normal (Terzaghi 1965). Their
    distribution is lognormal.

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
