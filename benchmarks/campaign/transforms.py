"""The same scene in other words: mirrored, turned with gravity, renumbered, in other units, with nodes on its edges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.scene import DOWN, FloatArray, Line, Scene, turn

Point = tuple[float, float]
ON_EDGE = 1e-6  # of a block's size: a corner lies on an edge, and is no other node
Map = Callable[[FloatArray], FloatArray]


def mirrored(scene: Scene) -> Scene:
    """Return the scene with left and right exchanged."""
    flip = np.array([-1.0, 1.0])
    moved = _mapped(scene, lambda points: points * flip)
    return replace(
        moved,
        polygons=[polygon[::-1].copy() for polygon in moved.polygons],
        gravity=_mirrored(scene.gravity),
        surface=moved.surface[::-1],
        table=moved.table[::-1],
        digs=tuple(
            replace(
                dig,
                table=None if dig.table is None else dig.table[::-1],
                gravity=None if dig.gravity is None else _mirrored(dig.gravity),
            )
            for dig in moved.digs
        ),
    )


def _mirrored(gravity: float) -> float:
    return DOWN if gravity == DOWN else -180.0 - gravity


def turned(scene: Scene, degrees: float) -> Scene:
    """Return the scene turned together with gravity; ground surfaces and water cannot be turned."""
    if scene.surface or scene.table or any(dig.table for dig in scene.digs):
        raise ValueError("a scene with a ground surface or a water table cannot be turned")
    moved = _mapped(scene, lambda points: turn(points, degrees))
    digs = tuple(replace(dig, gravity=None if dig.gravity is None else dig.gravity + degrees) for dig in moved.digs)
    return replace(moved, gravity=scene.gravity + degrees, digs=digs)


def renumbered(scene: Scene, generator: np.random.Generator) -> Scene:
    """Return the scene with its blocks in another order and each with another first corner."""
    order = generator.permutation(scene.count)
    number = np.argsort(order)
    shift = generator.integers(0, 8, scene.count)
    return replace(
        scene,
        polygons=[np.roll(scene.polygons[block], shift[block], axis=0) for block in order],
        held=np.sort(number[scene.held]),
        loads=tuple((int(number[block]), at, force) for block, at, force in scene.loads),
        digs=tuple(replace(dig, blocks=np.sort(number[dig.blocks])) for dig in scene.digs),
    )


def noded(scene: Scene, generator: np.random.Generator) -> Scene:
    """Return the scene with nodes on its edges: where corners of others lie, and up to two more an edge."""
    corners = np.concatenate(scene.polygons)
    reach = ON_EDGE * scene.size
    found = []
    for polygon in scene.polygons:
        nodes = []
        for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            along = end - start
            length = float(np.hypot(*along))
            rest = corners - start
            place = rest @ along / length**2
            away = np.abs(rest[:, 0] * along[1] - rest[:, 1] * along[0]) / length
            margin = reach / length
            own = place[(away < reach) & (place > margin) & (place < 1 - margin)]
            more = generator.uniform(0.05, 0.95, int(generator.integers(3)))
            at = np.sort(np.concatenate([own, more]))
            at = at[np.diff(at, prepend=0.0) > margin]
            nodes.append(start + np.concatenate([[0.0], at])[:, None] * along)
        found.append(np.concatenate(nodes))
    return replace(scene, polygons=found)


def scaled(scene: Scene, length: float, stress: float) -> Scene:
    """Return the scene in other units: all lengths times `length`, all stresses times `stress`."""
    per_length = stress / length
    moved = _mapped(scene, lambda points: points * length)
    bolts = tuple(_scaled_bolt(bolt, length, stress) for bolt in moved.bolts)
    force = stress * length
    return replace(
        moved,
        kn=scene.kn * per_length,
        ks=scene.ks * per_length,
        cohesion=scene.cohesion * stress,
        unit_weight=scene.unit_weight * per_length,
        water_weight=scene.water_weight * per_length,
        loads=tuple((block, at, (fx * force, fy * force)) for block, at, (fx, fy) in moved.loads),
        bolts=bolts,
    )


def _scaled_bolt(bolt: bsm.Bolt, length: float, stress: float) -> bsm.Bolt:
    """Return a bolt, its ends in the new lengths already, with all its forces times stress and length."""
    factors = {
        "diameter": length,
        "young": stress / length,
        "yield_strength": stress / length,
        "pretension": stress * length,
        "anchor_capacity": stress * length,
        "bond_strength": stress,
        "bearing_stiffness": stress / length,
        "bearing_strength": stress / length,
    }
    given = {name: factor * getattr(bolt, name) for name, factor in factors.items() if getattr(bolt, name) is not None}
    return replace(bolt, **given)


def _mapped(scene: Scene, change: Map) -> Scene:
    """Return the scene with all its points changed; its forces on blocks are changed likewise, as vectors."""

    def line(points: Line) -> Line:
        return tuple(_point(change, point) for point in points)

    return replace(
        scene,
        polygons=[change(polygon) for polygon in scene.polygons],
        surface=line(scene.surface),
        table=line(scene.table),
        loads=tuple((block, _point(change, at), _vector(change, force)) for block, at, force in scene.loads),
        bolts=tuple(
            replace(bolt, start=_point(change, bolt.start), end=_point(change, bolt.end)) for bolt in scene.bolts
        ),
        digs=tuple(replace(dig, table=None if dig.table is None else line(dig.table)) for dig in scene.digs),
    )


def _point(change: Map, point: Point) -> Point:
    x, y = change(np.array([point], dtype=np.float64))[0]
    return float(x), float(y)


def _vector(change: Map, force: Point) -> Point:
    x, y = change(np.array([force], dtype=np.float64))[0]
    size = float(np.hypot(x, y))
    keep = float(np.hypot(*force)) / size if size > 0 else 1.0  # a change of length is none of force
    return float(x) * keep, float(y) * keep
