"""The stereonet: equal-area projection of the lower hemisphere, with poles, planes and lines."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.errors import counted
from bsm_mesh.files import whole_file
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.orientations import line_directions, mean_normal, plane_of, upward_normals
from bsm_mesh.geometries.reading import as_path


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
    draw_net(axes)
    draw_sets(axes, sets)
    round_ = np.radians(np.arange(361))
    if section_azimuth is not None:
        x, y = math.sin(math.radians(section_azimuth)), math.cos(math.radians(section_azimuth))
        axes.plot([-x, x], [-y, y], "--", color="grey", lw=1, label=f"section, x axis to {section_azimuth:03.0f}")
    for radius, style, what in friction_circles(friction):
        axes.plot(radius * np.sin(round_), radius * np.cos(round_), style, color="firebrick", lw=1, label=what)
    if face is not None:
        draw_face(axes, face)
    finish_net(axes, title or "Equal area, lower hemisphere")
    with whole_file(target, parents=True) as draft:
        FigureCanvasAgg(figure).print_png(str(draft))
    return target


def draw_net(axes: Any) -> None:
    """Draw the rim of an equal-area net of radius 1, with the four directions."""
    axes.set(aspect="equal", xlim=(-1.15, 1.15), ylim=(-1.15, 1.2))
    axes.axis("off")
    round_ = np.radians(np.arange(361))
    axes.plot(np.sin(round_), np.cos(round_), color="black", lw=1.2)
    for degrees, name in zip(range(0, 360, 90), "NESW", strict=True):
        x, y = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        axes.plot([0.97 * x, 1.0 * x], [0.97 * y, 1.0 * y], color="black", lw=1.2)
        axes.text(1.07 * x, 1.07 * y, name, ha="center", va="center")


def draw_sets(axes: Any, sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]]) -> None:
    """Draw the poles and the mean plane of every set."""
    for name, (dip, direction) in sets.items():
        normal = mean_normal(dip, direction)
        mean_dip, mean_direction = plane_of(normal)
        poles = project(
            -upward_normals(np.atleast_1d(np.asarray(dip, float)), np.atleast_1d(np.asarray(direction, float)))
        )
        label = f"{name}: {counted(len(poles), 'pole')}, mean {mean_dip:.0f}/{mean_direction:03.0f}"
        (points,) = axes.plot(*poles.T, "o", ms=4, alpha=0.7, label=label)
        axes.plot(*project(great_circle(mean_dip, mean_direction)).T, color=points.get_color(), lw=1.5)


def draw_face(axes: Any, face: tuple[float, float]) -> None:
    """Draw the great circle of a slope's face (dip, dip direction) [degrees]."""
    label = f"slope {face[0]:.0f}/{face[1]:03.0f}"
    axes.plot(*project(great_circle(*face)).T, color="black", lw=2, label=label)


def finish_net(axes: Any, title: str, *, below: bool = False) -> None:
    """Add legend, in the upper left corner or below, and heading to a net."""
    where: dict[str, Any] = {"loc": "lower center", "ncols": 2} if below else {"loc": "upper left"}
    if below:
        axes.set_ylim(-1.6, 1.2)
    for text in axes.legend(fontsize=8, frameon=False, **where).get_texts():
        text.set_parse_math(False)  # a $ in a name is a $
    axes.set_title(title, parse_math=False)


def friction_circles(friction: float | None) -> list[tuple[float, str, str]]:
    """Return radius, line style and label of the circles of a friction angle [degrees] in a net of radius 1."""
    if friction is None:
        return []
    if not 0 < friction < 90:
        raise GeometryError(f"friction = {friction} must lie between 0 and 90 degrees")
    steep, flat = (math.sqrt(2) * math.sin(math.radians(angle) / 2) for angle in (90 - friction, friction))
    return [
        (flat, "--", f"friction {friction:g} degrees: planes with poles outside are steeper"),
        (steep, ":", f"friction {friction:g} degrees: intersections inside are steeper"),
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


def great_circle(dip: float, dip_direction: float) -> FloatArray:
    """Return downward unit vectors in a plane, from one end of its strike to the other, (n, 3)."""
    strike = line_directions(np.array([dip_direction - 90]), np.array([0.0]))[0]
    down = line_directions(np.array([dip_direction]), np.array([dip]))[0]
    angle = np.linspace(0, np.pi, 91)[:, None]
    circle: FloatArray = np.cos(angle) * strike + np.sin(angle) * down
    return circle
