"""Stereonets of a kinematic screening: a net for each movement, with its zone."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.files import whole_file
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.kinematics import Kinematics, permits_by_line, permits_by_plane
from bsm_mesh.geometries.orientations import line_directions, upward_normals
from bsm_mesh.geometries.reading import as_path
from bsm_mesh.geometries.stereonet import draw_net, finish_net, friction_circles, great_circle, project

ZONE, MARK = "#f4c7a1", "#d55e00"
MOST_RINGS = 300  # points in a zone; more are dots
STEP = 1.0  # degrees between the points that shade a zone


def draw_kinematics(path: str | os.PathLike[str], found: Kinematics, *, title: str = "") -> Path:
    """Draw four equal-area nets, planar and wedge sliding, flexural and direct toppling, as PNG; return the path.

    Poles of planes are in the nets of planar sliding and flexural toppling, lines of intersection in the others.
    The shaded zone holds what permits the movement; poles and lines in it are marked.

    Parameters
    ----------
    path : path
        The file, ``.png``.
    found : Kinematics
        Of `kinematic_screening`.
    title : str
        Heading.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    target = as_path("path", path)
    if target.suffix.lower() != ".png":
        raise GeometryError(f"{target}: the picture is a PNG; give a name that ends in .png")
    figure = Figure(figsize=(12, 12.4), layout="constrained")
    poles = project(-upward_normals(found.dip, found.dip_direction))
    known = np.isfinite(found.trend)
    lines = project(line_directions(found.trend[known], found.plunge[known]))
    marked = {
        "planar sliding": found.planar,
        "wedge sliding": found.wedge[known],
        "flexural toppling": found.flexural,
        "direct toppling": found.direct[known],
    }
    zones = _zones(found)
    for axes, (name, chosen) in zip(figure.subplots(2, 2).flat, marked.items(), strict=True):
        draw_net(axes)
        axes.plot(*zones[name].T, "s", ms=2.2, color=ZONE, zorder=0, label="permits the movement")
        axes.plot(
            *project(great_circle(*found.face)).T,
            color="black",
            lw=2,
            label=f"slope {found.face[0]:.0f}/{found.face[1]:03.0f}",
        )
        if name in ("planar sliding", "flexural toppling"):
            _draw_poles(axes, found, poles)
            points = poles[chosen]
        else:
            axes.plot(*lines.T, ".", ms=4, color="#555555", label="lines of intersection")
            points = lines[chosen]
        _draw_circle(axes, found, name)
        count, of = found.modes[name]
        look = {"mew": 0, "ms": 3} if len(points) > MOST_RINGS else {"mfc": "none", "mew": 1.6, "ms": 8}
        axes.plot(*points.T, "o", color=MARK, **look, label=f"{len(points)} in the zone")
        has_no_base = name == "direct toppling" and not found.base.any()
        finish_net(axes, f"{name}: no base" if has_no_base else f"{name}: {count} of {of}", below=True)
    figure.suptitle(title or "Kinematic screening", parse_math=False)
    with whole_file(target, parents=True) as draft:
        FigureCanvasAgg(figure).print_png(str(draft))
    return target


def _draw_poles(axes: Any, found: Kinematics, poles: FloatArray) -> None:
    for number, name in enumerate(found.sets):
        of = found.of_set == number
        axes.plot(*poles[of].T, "o", ms=4, alpha=0.8, label=f"{name}: {of.sum()} poles")


def _draw_circle(axes: Any, found: Kinematics, name: str) -> None:
    """Draw the circle of friction that belongs to poles, or to lines, in the nets of sliding."""
    if not name.endswith("sliding") or not 0 < found.friction < 90:
        return
    radius, style, what = friction_circles(found.friction)[0 if name == "planar sliding" else 1]
    turn = np.radians(np.arange(361))
    axes.plot(radius * np.sin(turn), radius * np.cos(turn), style, color="firebrick", lw=1, label=what)


def _zones(found: Kinematics) -> Mapping[str, FloatArray]:
    """Return points of each zone in the net, (k, 2): the same test as of the planes, on a grid of orientations."""
    slope = found.face, found.friction, found.lateral_limit
    dips, directions = (part.reshape(-1) for part in np.meshgrid(np.arange(0.5, 90, STEP), np.arange(0, 360, STEP)))
    planar, flexural, _ = permits_by_plane(dips, directions, *slope, found.toppling_limit)
    poles = project(-upward_normals(dips, directions))
    lines = project(line_directions(directions, dips))
    wedge, direct = permits_by_line(directions, dips, *slope)
    return {
        "planar sliding": poles[planar],
        "wedge sliding": lines[wedge],
        "flexural toppling": poles[flexural],
        "direct toppling": lines[direct],
    }
