"""A circular tunnel in unjointed rock: Example 1 of Wang (section 3.4), and a hole in a plate (Kirsch).

The centre of the tunnel is the origin, the ground surface lies at ``y = depth``. The distances to the
other boundaries are in Wang's Fig. 3.17 only; those here are a reconstruction.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from bsm_mesh.geometries import physical_groups
from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.session import gmsh_session, name_groups, write_mesh
from bsm_mesh.geometries.sizes import graded_layers, grow_sizes_from

MESH_KINDS = ("triangles", "quads", "radial")
OUTLINES = ("rectangle", "circle")
# Simple full-quad: no triangle is left. With blossom, 3, the core had quads of minSICN 0.11.
FULL_QUADS = {"Mesh.RecombinationAlgorithm": 2.0}
MOST_ELEMENTS = 3_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class _Tunnel:
    """The checked parameters of `build`, with every default filled in."""

    radius: float
    depth: float
    below: float
    width: float
    half: bool
    outline: str
    mesh: str
    size: float
    size_at_wall: float
    grading_distance: float
    order: int
    core: bool
    rock: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Curves:
    """Tags of the curves. Stations, on wall and outline at the same angle, bound the sectors."""

    centre: int  # a point, where all others are curves
    wall: list[int]  # an arc a sector, counter-clockwise
    spans: list[float]  # its angle [radians]
    outer: list[int]  # a piece of the outline a sector
    sides: list[str]  # its boundary's name
    spokes: dict[int, int]  # station -> curve from the wall outwards
    diameter: int | None  # of a half core, from its lower to its upper end


def build(
    path: str | os.PathLike[str],
    *,
    radius: float = 2.0,
    depth: float = 11.0,
    below: float | None = None,
    width: float | None = None,
    half: bool = True,
    outline: Literal["rectangle", "circle"] = "rectangle",
    mesh: Literal["triangles", "quads", "radial"] = "triangles",
    size: float = 0.9,
    size_at_wall: float | None = None,
    grading_distance: float | None = None,
    order: Literal[1, 2] = 1,
    core: bool = False,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a circular tunnel and return its path.

    Surfaces: ``rock:rock`` and, with `core`, ``excavation:tunnel``. Curves: ``boundary:wall`` around the
    tunnel and ``boundary:left``, ``right``, ``bottom``, ``top``; with a circular outline ``boundary:outer``
    and, of a half model, ``boundary:left``.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    radius : float
        Radius of the tunnel [m].
    depth : float
        From the centre up to the ground surface [m]; the radius of a circular outline.
    below : float, optional
        From the centre down to the bottom boundary [m]; as `depth` where not given.
    width : float, optional
        From the axis to the lateral boundary [m]; as `depth` where not given.
    half : bool
        Only x >= 0, with the axis of symmetry as left boundary; else the whole.
    outline : {"rectangle", "circle"}
        Shape of the outer boundary.
    mesh : {"triangles", "quads", "radial"}
        Unstructured triangles or quadrilaterals, or quadrilaterals in rays from wall to outline.
    size : float
        Length of an element's edge far from the wall [m].
    size_at_wall : float, optional
        The same at the wall [m]; half of `size` where not given.
    grading_distance : float, optional
        Distance from the wall at which the length has become `size` [m]; 3 radii where not given.
        A radial mesh is graded from wall to outline and does not take it.
    order : {1, 2}
        Straight elements, or curved ones with nodes at the middle of each edge.
    core : bool
        Whether the inside of the tunnel is meshed too, to be excavated.
    rock : str
        Name of the rock.
    **unknown
        Refused, with the nearest parameter that there is.

    Raises
    ------
    GeometryError
        With all faults of the parameters.

    Notes
    -----
    Elements with all other parameters at their defaults (Gmsh 4.15.2), and the worst minSICN of the three:

    ========= ========================== ========================= =====
    mesh      size                       elements                  worst
    ========= ========================== ========================= =====
    triangles 0.9, 0.45, 0.225           1094, 4015, 15606         0.76
    quads     0.75, 0.34, 0.17           968, 3989, 15646          0.67
    radial    0.52, 0.26, 0.13           576, 2304, 9216           0.51
    ========= ========================== ========================= =====

    The inside of a radial mesh (`core`) is of triangles. For Kirsch's hole far from any boundary::

        build("hole.msh", radius=1.0, depth=20.0, outline="circle", mesh="radial", half=False,
              size=2.0, size_at_wall=0.1)
    """
    given = {name: value for name, value in locals().items() if name not in ("path", "unknown")}
    tunnel = _check(given, unknown)
    with gmsh_session("circular_tunnel", FULL_QUADS) as gmsh:
        curves = _draw_curves(gmsh, tunnel)
        rock_surfaces = _fill_rock(gmsh, tunnel, curves)
        core_surfaces = _fill_core(gmsh, tunnel, curves) if core else []
        gmsh.model.geo.synchronize()
        zone_end = tunnel.radius + tunnel.grading_distance
        near, far = tunnel.size_at_wall, tunnel.size
        grow_sizes_from(curves.centre, near=near, far=far, start=tunnel.radius, end=zone_end)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(tunnel.order)
        name_groups(_groups(tunnel, curves, rock_surfaces, core_surfaces))
        return write_mesh(path)


def _check(given: dict[str, Any], unknown: dict[str, object]) -> _Tunnel:
    """Return the parameters with their defaults; raise one error for all faults."""
    checks = ParameterChecks(build, unknown)
    checks.one_of(OUTLINES, outline=given["outline"])
    checks.one_of(MESH_KINDS, mesh=given["mesh"])
    checks.one_of((1, 2), order=given["order"])
    checks.true_or_false(half=given["half"], core=given["core"])
    checks.group_part(rock=given["rock"])
    good = checks.positive(**{name: given[name] for name in ("radius", "depth", "size")})
    optional = ("below", "width", "size_at_wall", "grading_distance")
    if checks.positive_or_none(**{name: given[name] for name in optional}) and good:
        _check_lengths(checks, given)
    checks.raise_faults()
    defaults = {"below": given["depth"], "width": given["depth"]}
    defaults |= {"size_at_wall": given["size"] / 2.0, "grading_distance": 3.0 * given["radius"]}
    return _Tunnel(**(given | {name: value for name, value in defaults.items() if given[name] is None}))


def _check_lengths(checks: ParameterChecks, given: dict[str, Any]) -> None:
    radius, depth, size = given["radius"], given["depth"], given["size"]
    for name in ("depth", "below", "width"):
        if given[name] is not None and given[name] <= radius:
            checks.add(
                f"{name} = {given[name]} m does not exceed radius = {radius} m; the tunnel must lie inside "
                f"the outline: increase {name} or reduce radius"
            )
        if given["outline"] == "circle" and given[name] not in (None, depth):
            checks.add(f"{name} means nothing with outline = 'circle', of radius depth = {depth} m; leave it out")
    at_wall = given["size_at_wall"] or size / 2.0
    if at_wall > radius:
        checks.add(f"size_at_wall = {at_wall} m exceeds the radius {radius} m; give a smaller one")
    if at_wall > size:
        checks.add(f"size_at_wall = {at_wall} m exceeds size = {size} m; give a size_at_wall of at most size")
    if given["mesh"] == "radial" and given["grading_distance"] is not None:
        checks.add("grading_distance means nothing with mesh = 'radial', graded to the outline; leave it out")
    share = 0.5 if given["half"] is True else 1.0
    area = 2.0 * (given["width"] or depth) * (depth + (given["below"] or depth))
    zone = radius + (given["grading_distance"] or 3.0 * radius)
    estimate = 2.3 * share * (area / size**2 + math.pi * min(zone, depth) ** 2 / (at_wall * size))
    if estimate > MOST_ELEMENTS:
        checks.add(
            f"size = {size} m, at the wall {at_wall} m, would make about {estimate:.1e} elements, more than "
            f"{MOST_ELEMENTS:.0e}; give larger ones, or check that lengths are in metres"
        )


def _draw_curves(gmsh: Any, tunnel: _Tunnel) -> _Curves:
    geo = gmsh.model.geo
    stations, sides = _stations(tunnel)
    angles = [math.atan2(y, x) for x, y in stations]
    centre = geo.addPoint(0.0, 0.0, 0.0)
    outer_points = [geo.addPoint(x, y, 0.0) for x, y in stations]
    scales = [tunnel.radius / math.hypot(x, y) for x, y in stations]
    wall_points = [geo.addPoint(k * x, k * y, 0.0) for k, (x, y) in zip(scales, stations, strict=True)]
    sectors = [(i, (i + 1) % len(stations)) for i in range(len(sides))]
    wall = [geo.addCircleArc(wall_points[i], centre, wall_points[j]) for i, j in sectors]
    if tunnel.outline == "circle":
        outer = [geo.addCircleArc(outer_points[i], centre, outer_points[j]) for i, j in sectors]
    else:
        outer = [geo.addLine(outer_points[i], outer_points[j]) for i, j in sectors]
    ends = [0, len(stations) - 1] if tunnel.half else []
    with_spoke = range(len(stations)) if tunnel.mesh == "radial" else ends
    spokes = {i: geo.addLine(wall_points[i], outer_points[i]) for i in with_spoke}
    diameter = geo.addLine(wall_points[0], wall_points[-1]) if tunnel.half and tunnel.core else None
    return _Curves(
        centre=centre, wall=wall, spans=[(angles[j] - angles[i]) % (2.0 * math.pi) for i, j in sectors],
        outer=outer, sides=sides, spokes=spokes, diameter=diameter,
    )  # fmt: skip


def _stations(tunnel: _Tunnel) -> tuple[list[tuple[float, float]], list[str]]:
    """Return the points of the outline between sectors, and each sector's side; a whole outline closes."""
    top, bottom, right = tunnel.depth, -tunnel.below, tunnel.width
    if tunnel.outline == "circle":
        points = [(0.0, bottom), (right, 0.0), (0.0, top)] + ([] if tunnel.half else [(-right, 0.0)])
        return points, ["outer"] * (2 if tunnel.half else 4)
    left = 0.0 if tunnel.half else -right
    points = [(left, bottom), (right, bottom), (right, top), (left, top)]
    return points, ["bottom", "right", "top"] + ([] if tunnel.half else ["left"])


def _fill_rock(gmsh: Any, tunnel: _Tunnel, curves: _Curves) -> list[int]:
    geo = gmsh.model.geo
    if tunnel.mesh == "radial":
        return [_fill_sector(gmsh, tunnel, curves, sector) for sector in range(len(curves.wall))]
    if tunnel.half:
        inner = [-arc for arc in reversed(curves.wall)]
        lower, upper = curves.spokes[0], curves.spokes[len(curves.wall)]
        loops = [geo.addCurveLoop([*curves.outer, -upper, *inner, lower])]
    else:
        loops = [geo.addCurveLoop(curves.outer), geo.addCurveLoop(curves.wall)]
    surface: int = geo.addPlaneSurface(loops)
    if tunnel.mesh == "quads":
        geo.mesh.setRecombine(2, surface)
    return [surface]


def _fill_sector(gmsh: Any, tunnel: _Tunnel, curves: _Curves, sector: int) -> int:
    """Return one surface of a radial mesh: equal parts around, growing parts outwards."""
    geo = gmsh.model.geo
    first, second = curves.spokes[sector], curves.spokes[(sector + 1) % len(curves.spokes)]
    loop = geo.addCurveLoop([first, curves.outer[sector], -second, -curves.wall[sector]])
    surface: int = geo.addPlaneSurface([loop])
    around = max(1, round(tunnel.radius * curves.spans[sector] / tunnel.size_at_wall))
    shortest = min(tunnel.depth, tunnel.below, tunnel.width) - tunnel.radius
    layers, growth = graded_layers(shortest, tunnel.size_at_wall, tunnel.size)
    for curve in (curves.wall[sector], curves.outer[sector]):
        geo.mesh.setTransfiniteCurve(curve, around + 1)
    for curve in (first, second):
        geo.mesh.setTransfiniteCurve(curve, layers + 1, "Progression", growth)
    geo.mesh.setTransfiniteSurface(surface)
    geo.mesh.setRecombine(2, surface)
    return surface


def _fill_core(gmsh: Any, tunnel: _Tunnel, curves: _Curves) -> list[int]:
    geo = gmsh.model.geo
    loop = [*curves.wall, -curves.diameter] if curves.diameter is not None else curves.wall
    surface: int = geo.addPlaneSurface([geo.addCurveLoop(loop)])
    # The inside of a radial mesh stays triangles: with quads it came out as bad as minSICN 0.13.
    if tunnel.mesh == "quads":
        geo.mesh.setRecombine(2, surface)
    return [surface]


def _groups(
    tunnel: _Tunnel, curves: _Curves, rock_surfaces: list[int], core_surfaces: list[int]
) -> dict[str, list[int]]:
    """Return the tags of surfaces and curves under the name of their physical group."""
    groups = {physical_groups.rock(tunnel.rock): rock_surfaces + core_surfaces}
    if core_surfaces:
        groups[physical_groups.excavation("tunnel")] = core_surfaces
    groups[physical_groups.boundary("wall")] = curves.wall
    for side, curve in zip(curves.sides, curves.outer, strict=True):
        groups.setdefault(physical_groups.boundary(side), []).append(curve)
    if tunnel.half:
        axis = [curves.spokes[0], curves.diameter, curves.spokes[len(curves.wall)]]
        groups[physical_groups.boundary("left")] = [curve for curve in axis if curve is not None]
    return groups
