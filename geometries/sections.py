"""Cross-sections drawn in other programs: outline, material boundaries, excavations and joints, a layer each."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import Fault, FloatArray
from bsm_mesh.geometries.rock_mass import Excavation, Region, RockMass
from bsm_mesh.geometries.traces import read_traces

Seeds: TypeAlias = "tuple[float, float] | Sequence[tuple[float, float]]"
GRID = 1e-6  # of the section's size: ends that are nearer meet


def read_section(
    path: str | os.PathLike[str],
    *,
    outline: str,
    rocks: Mapping[str, Seeds],
    materials: Sequence[str] = (),
    excavations: Mapping[str, str] | None = None,
    joints: Mapping[str, str] | None = None,
    border: str | None = None,
    scale: float | None = None,
    tolerance: float | None = None,
) -> RockMass:
    """Return a section of a drawing as a rock mass, ready to be cut into blocks.

    The lines of the outline and of the material boundaries part the section; each part has the rock of the point in it.

    Parameters
    ----------
    path : path
        The drawing, of any format of `read_traces`: DXF, shapefile, GeoPackage, GeoJSON or CSV; layers are its sets.
    outline : str
        Layer with the outline of the section.
    rocks : mapping of str to (x, y) or several [m]
        A point, or several, in the parts of each rock.
    materials : sequence of str
        Layers with the boundaries between rocks.
    excavations : mapping of str to str, optional
        Name of the excavation for each layer with closed outlines of it.
    joints : mapping of str to str, optional
        Name of the joint for each layer with traces.
    border : str, optional
        Joint along the boundaries between rocks; without it they meet without a joint.
    scale, tolerance : float, optional
        As for `read_traces` [m].

    Raises
    ------
    GeometryError
        With parts that have no rock or several, points outside of the section, lines that bound nothing, and unknown
        layers.
    """
    excavated, jointed = dict(excavations or {}), dict(joints or {})
    wanted = [outline, *materials, *excavated, *jointed]
    read = read_traces(path, names={name: name for name in wanted}, scale=scale, tolerance=tolerance)
    found = {fault.name: [np.asarray(line, dtype=np.float64) for line in fault.lines] for fault in read}
    lines = [line for layer in (outline, *materials) for line in found[layer]]
    faults: list[str] = []
    parts, _ = _parts(found[outline], f"layer '{outline}'", faults)
    if not parts:
        raise GeometryError([f"{path}: {fault}" for fault in faults])
    parts, dangling = _parts(lines, "the section", faults, within=parts)
    if dangling:
        faults.append(f"{dangling} of the material boundaries end inside a rock; draw them up to the next line")
    regions = _with_rocks(parts, rocks, border, faults)
    for layer, name in excavated.items():
        holes, _ = _parts(found[layer], f"layer '{layer}'", faults)
        regions += [Excavation(outline=hole, name=name) for hole in holes]
    if faults:
        raise GeometryError([f"{path}: {fault}" for fault in faults])
    named: dict[str, list[FloatArray]] = {}
    for layer, joint in jointed.items():
        named.setdefault(joint, []).extend(found[layer])
    return RockMass(regions=regions, joints=[Fault(name=joint, lines=traces) for joint, traces in named.items()])


def _parts(
    lines: Sequence[FloatArray], what: str, faults: list[str], within: Sequence[FloatArray] | None = None
) -> tuple[list[FloatArray], int]:
    """Return the outlines of the parts that lines bound, the largest first, and how many lines end inside."""
    import shapely

    size = float(np.ptp(np.concatenate(lines), axis=0).max())
    merged = shapely.node(shapely.MultiLineString([np.asarray(line) for line in lines]))
    merged = shapely.unary_union(shapely.set_precision(merged, GRID * size))
    pieces = list(getattr(merged, "geoms", [merged]))
    polygons, _, dangles, _ = shapely.polygonize_full(pieces)
    found = list(polygons.geoms)
    inside = 0
    if within is not None:
        frame = shapely.unary_union([shapely.Polygon(part) for part in within])
        found = [part for part in found if frame.covers(part.representative_point())]
        inner = frame.buffer(-10 * GRID * size)
        inside = sum(line.intersects(inner) for line in dangles.geoms)
    if not found:
        faults.append(f"{what} bounds no area; draw closed lines")
    found.sort(key=lambda part: -part.envelope.area)
    return [np.asarray(part.exterior.coords)[:-1] for part in found], inside


def _with_rocks(
    parts: Sequence[FloatArray], rocks: Mapping[str, Seeds], border: str | None, faults: list[str]
) -> list[Region | Excavation]:
    """Return a region for each part with points in it, of their rock; a part within another lies over it."""
    import shapely

    shapes = [shapely.Polygon(part) for part in parts]
    of_part: list[set[str]] = [set() for _ in parts]
    for rock, seeds in rocks.items():
        for seed in np.reshape(np.asarray(seeds, dtype=np.float64), (-1, 2)):
            holds = [k for k, shape in enumerate(shapes) if shape.contains(shapely.Point(seed))]
            if not holds:
                faults.append(f"the point ({seed[0]:g}, {seed[1]:g}) of rock '{rock}' lies in no part of the section")
            else:
                of_part[min(holds, key=lambda k: shapes[k].area)].add(rock)
    for shape, names in zip(shapes, of_part, strict=True):
        place = shape.representative_point()
        where = f"the part of {shape.area:.4g} m2 round ({place.x:.4g}, {place.y:.4g})"
        if not names:
            faults.append(f"{where} has no rock; give a point in it: NAME = ({place.x:.4g}, {place.y:.4g})")
        elif len(names) > 1:
            faults.append(f"{where} has points of {' and '.join(sorted(names))}; give one rock")
    return [
        Region(outline=part, rock=min(names), border=border)
        for part, names in zip(parts, of_part, strict=True)
        if names
    ]
