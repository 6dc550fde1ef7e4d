"""Joints in a Gmsh script of your own: sets fragmented into its surfaces, curves found by direction, box or line.

With the OpenCASCADE kernel (`gmsh.model.occ`), inside or outside a `gmsh_session`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bsm_mesh.geometries.abutting import ended
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray, Joints, Points, clip_traces
from bsm_mesh.geometries.session import load_gmsh

BEYOND = 0.01  # of the model's size: so far traces stick out of its box, lest their ends move the rim to them
OFF = 1e-6  # of the model's size, where no tolerance is given


def fragment_by_joints(
    surfaces: Sequence[int], joints: Sequence[Joints], *, seed: int = 0
) -> tuple[list[list[int]], dict[str, list[int]]]:
    """Fragment surfaces of the current model by joint sets and faults; synchronises.

    Parameters
    ----------
    surfaces : sequence of int
        Tags of surfaces of the OpenCASCADE kernel.
    joints : sequence of Joints
        `JointSet`, `Fault` or anything that gives traces; clipped to the surfaces' boxes.
    seed : int
        Of the random numbers.

    Returns
    -------
    children : list of list of int
        Tags of the surfaces that each given one has become.
    curves : dict of str to list of int
        Tags of the curves of each joint, as ``joint:name``, for `name_groups`. Where two lie on each other the first
        given has the curve.

    Raises
    ------
    GeometryError
        If there are no surfaces or no joints in them, or a set abuts on one that is not given.
    """
    gmsh = load_gmsh()
    occ = gmsh.model.occ
    if not surfaces:
        raise GeometryError("fragment_by_joints: there are no surfaces; give the tags of those that joints cut")
    boxes = np.array([occ.getBoundingBox(2, tag) for tag in surfaces])
    low, high = boxes[:, :2].min(axis=0), boxes[:, 3:5].max(axis=0)
    off = BEYOND * float((high - low).max())
    (left, bottom), (right, top) = low - off, high + off
    corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
    lines: list[tuple[int, int]] = []
    names: list[str] = []
    traces = ended(joints, [one.traces(low, high, seed) for one in joints])
    for one, drawn in zip(joints, traces, strict=True):
        for start, end in clip_traces(drawn, corners):
            lines.append((1, occ.addLine(occ.addPoint(*start, 0.0), occ.addPoint(*end, 0.0))))
            names.append(f"joint:{one.name}")
    none = GeometryError("fragment_by_joints: no joint crosses the surfaces; give closer spacings, or others")
    if not lines:
        raise none
    _, parts = occ.fragment([(2, tag) for tag in surfaces], lines)
    made = {tag for part in parts[len(surfaces) :] for dimension, tag in part if dimension == 1}
    middle = {tag: np.array(occ.getCenterOfMass(1, tag)[:2]) for tag in made}
    beyond = [(1, tag) for tag, at in middle.items() if np.any(at < low) or np.any(at > high)]
    occ.remove(beyond, recursive=True)
    occ.synchronize()
    bounds = {tag for _, tag in gmsh.model.getBoundary(gmsh.model.getEntities(2), combined=False, oriented=False)}
    curves: dict[str, list[int]] = {name: [] for name in names}
    taken: set[int] = set()
    for name, children in zip(names, parts[len(surfaces) :], strict=True):
        mine = {tag for dimension, tag in children if dimension == 1 and tag in bounds} - taken
        curves[name] += sorted(mine)
        taken |= mine
    if not taken:
        raise none
    children = [[tag for dimension, tag in part if dimension == 2] for part in parts[: len(surfaces)]]
    return children, {name: tags for name, tags in curves.items() if tags}


def find_curves(
    *,
    dip: float | None = None,
    box: Points | None = None,
    along: Points | None = None,
    among: Sequence[int] | None = None,
    tolerance: float | None = None,
) -> list[int]:
    """Return the tags of curves of the current model that fit all that is given; straight ones, where a dip is.

    Parameters
    ----------
    dip : float, optional
        Angle from the x axis, counter-clockwise [degrees]; to a tenth of a degree.
    box : two points, optional
        Lower left and upper right corner [m]; curves with all of their points in it.
    along : (k, 2) array_like, optional
        Line [m]; curves with all of their points on it.
    among : sequence of int, optional
        Curves to choose from; by default those that bound a surface or are embedded in one, all in a model without
        surfaces.
    tolerance : float, optional
        Distance that still counts [m]; by default a millionth of the model's size.
    """
    import shapely

    gmsh = load_gmsh()
    tags = _in_surfaces(gmsh) if among is None else list(among)
    if not tags:
        return []
    extent = np.array(gmsh.model.getBoundingBox(-1, -1))
    off = OFF * float(np.hypot(*(extent[3:5] - extent[:2]))) if tolerance is None else tolerance
    points = np.stack([_points(gmsh, tag) for tag in tags])
    fits = np.ones(len(tags), dtype=np.bool_)
    if dip is not None:
        chord = points[:, -1] - points[:, 0]
        turn = np.degrees(np.arctan2(chord[:, 1], chord[:, 0])) - dip
        fits &= np.abs((turn + 90) % 180 - 90) < 0.1
        lines = shapely.linestrings(points[:, [0, -1]])
        fits &= shapely.dwithin(lines[:, None], shapely.points(points), off).all(axis=1)
    if box is not None:
        low, high = np.asarray(box, dtype=np.float64)
        fits &= ((points >= low - off) & (points <= high + off)).all(axis=(1, 2))
    if along is not None:
        line = shapely.LineString(np.asarray(along, dtype=np.float64))
        fits &= shapely.dwithin(shapely.points(points), line, off).all(axis=1)
    return [tag for tag, chosen in zip(tags, fits, strict=True) if chosen]


def _in_surfaces(gmsh: Any) -> list[int]:
    """Return the curves that bound a surface or are embedded in one: others are in no mesh of the rock."""
    surfaces = gmsh.model.getEntities(2)
    everything = [tag for _, tag in gmsh.model.getEntities(1)]
    if not surfaces:
        return everything
    found = {tag for _, tag in gmsh.model.getBoundary(surfaces, combined=False, oriented=False)}
    for surface in surfaces:
        found |= {tag for dimension, tag in gmsh.model.mesh.getEmbedded(*surface) if dimension == 1}
    return [tag for tag in everything if tag in found]


def _points(gmsh: Any, tag: int) -> FloatArray:
    """Return five points of a curve, ends included, (5, 2)."""
    low, high = gmsh.model.getParametrizationBounds(1, tag)
    values = gmsh.model.getValue(1, tag, np.linspace(low[0], high[0], 5))
    points: FloatArray = np.asarray(values, dtype=np.float64).reshape(5, 3)[:, :2]
    return points
