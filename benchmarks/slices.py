"""Models of the plane as slices of space: the same blocks, joints, supports, loads, water, bolts and stages.

Corners that touch the middle of an edge become corners of it, so that slices share whole faces. x stays, the plane's y
is z. Forces of the plane are for a metre of thickness, and grow with the slice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.loads import Load, PointForces, point_forces_of
from bsm_mesh.model.stages import presence
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.three_d.blocks.solids import arrays_of_solids

ON_EDGE = 1e-7  # of the model's size: distance of a corner that lies on an edge
FLAT = 1e-12  # product of two sides, over the sum of all their squares: a corner that is straight but for rounding
LEVEL = 1e-9  # of the model's size: a water table that differs by less from a straight line is one
EAST, WEST = 90.0, 270.0  # degrees: along +x, along -x


class NoSliceError(ValueError):
    """A model of the plane that has no slice, and why."""


@dataclass(frozen=True, slots=True)
class Slice:
    """Where a plane model lies in space.

    Attributes
    ----------
    turn : float [rad]
        By which the plane turns clockwise, until gravity pulls down.
    depth : float [m]
        Thickness, from y = 0.
    """

    turn: float
    depth: float

    @classmethod
    def of(cls, model: bsm.Model, depth: float = 1.0) -> Slice:
        """Return that of a model."""
        return cls(np.radians(-90.0 - model.gravity_direction), depth)

    def flat(self, vectors: FloatArray) -> FloatArray:
        """Return vectors (k, 2) of the plane, turned with it."""
        cosine, sine = np.cos(self.turn), np.sin(self.turn)
        turned: FloatArray = vectors @ np.array([[cosine, sine], [-sine, cosine]])
        return turned

    def placed(self, vectors: FloatArray, across: float = 0.0) -> FloatArray:
        """Return vectors (k, 2) of the plane as those of space (k, 3), at y = `across`."""
        flat = self.flat(vectors)
        return np.column_stack([flat[:, 0], np.full(len(flat), across), flat[:, 1]])


def extruded(model: bsm.Model, depth: float | None = None, *, walls: bool = False) -> bsm.Model:
    """Return a model of the plane as a slice of space.

    Parameters
    ----------
    model : Model
        The model of the plane.
    depth : float, optional [m]
        Thickness. By default blocks are as large as in the plane, by the mean of those that are free; with bolts it is
        their spacing.
    walls : bool
        Whether frictionless walls at both ends keep every block from moving across the slice.

    Raises
    ------
    NoSliceError
        For a model with parts that polyhedra do not have.
    """
    blocks = model.blocks
    bars = bars_of(model.supports, blocks)
    at = Slice.of(model, depth or _depth(model, bars))
    _refuse(model, at)
    outlines, joints = _outlines(blocks, at.flat(blocks.vertices))
    parts = [_convex(outline) for outline in outlines]
    owner = np.repeat(np.arange(blocks.count, dtype=np.int32), [len(cells) for cells in parts])
    arrays = arrays_of_solids([_prism(cell, at.depth) for cells in parts for cell in cells], "rock", None, 1e-9)
    arrays |= {"joint_names": blocks.joint_names, "face_joint": _joints_of_faces(arrays, joints)}
    arrays |= {"cell_block": owner, "rock": blocks.rock, "rock_names": blocks.rock_names}
    return bsm.Model(
        blocks=bsm.Polyhedra(**arrays),  # type: ignore[arg-type]  # polyhedra answer to the same names
        rocks=model.rocks,
        joints=model.joints,
        default_joint=model.default_joint,
        supports=[_bars(bars, blocks, at, walls)],
        loads=_loads(model, model.loads, at),
        bolts=[_bolt(bolt, at) for bolt in model.bolts],
        gravity_horizontal=model.gravity_horizontal,
        gravity_vertical=model.gravity_vertical,
        contact_points="corners",
        in_situ=_in_situ(model),
        water=_water(model, model.water),
        stages=_stages(model, at),
    )


def _depth(model: bsm.Model, bars: Bars) -> float:
    """Return the thickness at which blocks have the size of those of the plane, or the spacing of the bolts."""
    spacings = {bolt.spacing for bolt in model.bolts}
    if len(spacings) > 1:
        raise NoSliceError("bolts have several spacings")
    if spacings:
        return spacings.pop()
    free = ~bars.held_blocks(model.blocks)
    return model.blocks.moments.mean_size(free if free.any() else ~free)


def _refuse(model: bsm.Model, at: Slice) -> None:
    """Raise for parts that have no slice."""
    given = [name for name in ("flow", "face_water") if getattr(model, name)]
    for name in ("flow", "shaking"):
        given += [f"{name} of a stage" for stage in model.stages if getattr(stage, name)]
    if model.contact_points == "gauss":
        given.append("Gauss points")
    if at.turn and (model.water or model.in_situ or model.gravity_horizontal or model.gravity_vertical):
        given.append("water, in-situ stress or an earthquake where gravity is turned")
    if given:
        raise NoSliceError(f"has {', '.join(dict.fromkeys(given))}")


def _bars(bars: Bars, blocks: bsm.Blocks, at: Slice, walls: bool) -> Bars:
    """Return the bars at half depth, and three more across the slice for blocks that are held, or for all."""
    held = np.flatnonzero(bars.held_blocks(blocks) | walls).astype(np.int32)
    direction = at.placed(bars.direction)
    direction[bars.holds_rotation] = (0, -1, 0)  # from x to z
    across = np.repeat([(0, 1, 0), (1, 0, 0), (0, 0, 1)], len(held), axis=0)
    more = np.tile(held, 3)
    middle = at.depth / 2
    return Bars(
        block=np.append(bars.block, more),
        point=np.concatenate([at.placed(points, middle) for points in (bars.point, blocks.moments.centroid[more])]),
        direction=np.concatenate([direction, across]),
        holds_rotation=np.append(bars.holds_rotation, np.repeat([False, True, True], len(held))),
        value=np.append(bars.value, np.zeros(len(more))),
        support=np.append(bars.support, np.zeros(len(more), np.int32)),
        edge=np.full(len(bars.block) + len(more), -1, np.int32),
    )


def _loads(model: bsm.Model, loads: Sequence[Load], at: Slice) -> list[PointForces]:
    """Return loads as forces at half depth."""
    if not loads:
        return []
    found = point_forces_of(model.worked_out(loads), model.blocks)
    point, force = at.placed(found.point, at.depth / 2), at.depth * at.placed(found.force)
    return [PointForces(block=found.block, point=point, force=force)]


def _bolt(bolt: bsm.Bolt, at: Slice) -> bsm.Bolt:
    start, end = at.placed(np.array([bolt.start, bolt.end]), at.depth / 2)
    return replace(bolt, start=tuple(start), end=tuple(end), spacing=1.0)


def _in_situ(model: bsm.Model) -> bsm.InSitu | None:
    """Return the in-situ stress with k0 along x, and the components of the plane in x and z."""
    given = model.in_situ
    if given is None or given.method == "gravity":
        return given
    if given.stress is not None:
        xx, yy, xy = ((c, along, 0.0, up) for c, along, up in given.stress)
        stress = {"xx": xx, "yy": xx, "zz": yy, "xz": xy}
        return bsm.InSitu(stress=stress)  # type: ignore[arg-type]  # a mapping becomes a tuple
    surface = given.surface
    if isinstance(surface, tuple):
        if np.ptp([y for _, y in surface]):
            raise NoSliceError("has in-situ stress below ground that is not level")
        surface = surface[0][1]
    return replace(given, surface=surface, trend=EAST)


def _water(model: bsm.Model, water: bsm.Water | None) -> bsm.Water | None:
    """Return water whose table is a straight line over all blocks that are free as a plane of head."""
    if water is None or not water.table:
        return water
    if water.head != "vertical":
        raise NoSliceError("has a head parallel to the table")
    if len(water.table) > 1:
        raise NoSliceError("has several water tables")
    blocks = model.blocks
    free = ~bars_of(model.supports, blocks).held_blocks(blocks)
    table, x = np.array(water.table[0]), blocks.vertices[free[blocks.owner], 0]
    (x0, y0), (x1, y1) = table[0], table[-1]
    slope = (y1 - y0) / (x1 - x0) if len(table) > 1 else 0.0
    bent = np.abs(table[:, 1] - y0 - slope * (table[:, 0] - x0)).max() > LEVEL * blocks.span
    if bent or (slope and (x.min() < x0 or x.max() > x1)):
        raise NoSliceError("has a water table that is not straight")
    dip, falls = float(np.degrees(np.arctan(abs(slope)))), WEST if slope > 0 else EAST
    plane = bsm.HeadPlane(point=(float(x0), 0.0, float(y0)), dip=dip, dip_direction=falls)
    return replace(water, table=(), plane=plane)


def _stages(model: bsm.Model, at: Slice) -> list[bsm.Stage]:
    """Return the stages, their blocks by number."""
    here = presence(model.stages, model.blocks)
    return [
        replace(
            stage,
            excavate=tuple(np.flatnonzero(before & ~now).tolist()),
            fill=tuple(np.flatnonzero(now & ~before).tolist()),
            loads=_loads(model, stage.loads, at),
            water=_water(model, stage.water),
        )
        for stage, before, now in zip(model.stages, here, here[1:], strict=False)
    ]


def _outlines(blocks: bsm.Blocks, corners: FloatArray) -> tuple[list[FloatArray], dict[tuple[float, float], int]]:
    """Return the blocks' outlines with every corner on them, and the joint of every piece of an edge by its middle."""
    reach = ON_EDGE * float(np.ptp(corners, axis=0).max())
    outlines, joints = [], {}
    for first, last in zip(blocks.offsets, blocks.offsets[1:], strict=False):
        rows = np.arange(first, last)
        pieces = []
        for k, following in zip(rows, np.roll(rows, -1), strict=True):
            along = corners[following] - corners[k]
            length = np.hypot(*along)
            part = (corners - corners[k]) @ along / length**2
            off = np.abs(_cross(along, corners - corners[k])) / length
            inside = (off < reach) & (part * length > reach) & ((1 - part) * length > reach)
            places, chosen = np.unique(np.append(0.0, np.round(part[inside], 9)), return_index=True)
            pieces.append(corners[np.append(k, np.flatnonzero(inside))[chosen]])
            ends = np.append(places, 1.0)
            for middle in corners[k] + ((ends[:-1] + ends[1:]) / 2)[:, None] * along:
                key = _key(middle)
                joints[key] = max(joints.get(key, -1), int(blocks.edge_joint[k]))
        outlines.append(np.concatenate(pieces))
    return outlines, joints


def _convex(outline: FloatArray) -> list[FloatArray]:
    """Return an outline that is convex, else triangles of the same corners."""
    sides = np.roll(outline, -1, axis=0) - outline
    if (_cross(sides, np.roll(sides, -1, axis=0)) >= -FLAT * (sides**2).sum()).all():
        return [outline]
    triangles = shapely.constrained_delaunay_triangles(shapely.Polygon(outline))
    return [np.array(shapely.geometry.polygon.orient(part).exterior.coords)[:-1] for part in triangles.geoms]


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the products of plane vectors (..., 2)."""
    found: FloatArray = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return found


def _prism(outline: FloatArray, depth: float) -> tuple[FloatArray, list[tuple[int, ...]]]:
    """Return corners and faces of an outline in x and z, from y = 0 to the depth [m]."""
    k = len(outline)
    front, back = (np.column_stack([outline[:, 0], np.full(k, y), outline[:, 1]]) for y in (0.0, depth))
    sides = [(i, k + i, k + (i + 1) % k, (i + 1) % k) for i in range(k)]
    return np.concatenate([front, back]), [tuple(range(k)), tuple(range(2 * k - 1, k - 1, -1)), *sides]


def _joints_of_faces(arrays: dict[str, np.ndarray], joints: dict[tuple[float, float], int]) -> IntArray:
    """Return the joint of every face by its middle, of free ones too: blocks may land on them."""
    points, offsets = arrays["vertices"][arrays["face_vertices"]], arrays["face_offsets"]
    found = np.full(len(offsets) - 1, -1, dtype=np.int32)
    for face in range(len(found)):
        middle = points[offsets[face] : offsets[face + 1]].mean(axis=0)
        found[face] = joints.get(_key(middle[[0, 2]]), -1)
    return found


def _key(point: FloatArray) -> tuple[float, float]:
    return float(np.round(point[0], 6)) + 0.0, float(np.round(point[1], 6)) + 0.0
