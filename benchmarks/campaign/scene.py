"""A scene: what a random model is made of, in a form that can be mirrored, turned, renumbered and scaled."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

import bsm_mesh as bsm

T = TypeVar("T")
FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Line = tuple[tuple[float, float], ...]
DOWN = -90.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Dig:
    """A stage: blocks that are taken away, and the water and the direction of weights from then on.

    Attributes
    ----------
    blocks : (k,) int64
        Taken away.
    relaxation : tuple of float
        As `bsm_mesh.Stage` takes it.
    table : sequence of (x, y) or None [m]
        The new water table; None: as before.
    gravity : float or None [degrees]
        The new direction of weights from the x axis; None: as before.
    """

    blocks: IntArray
    relaxation: tuple[float, ...] = (1.0,)
    table: Line | None = None
    gravity: float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """Rigid blocks on one joint without tension.

    Attributes
    ----------
    polygons : sequence of (k, 2) float64 [m]
        Corners of the blocks, counter-clockwise.
    held : (k,) int64
        Blocks that do not move.
    friction, cohesion : float [degrees, Pa]
        Of every joint.
    kn, ks : float [Pa/m]
        Stiffness of every joint.
    unit_weight, water_weight : float [N/m3]
        Of rock and water.
    gravity : float [degrees]
        Direction of gravity from the x axis.
    surface, k0 : sequence of (x, y) [m], float or None
        The ground and the ratio of in-situ stresses; None: the start is without stress.
    table : sequence of (x, y) [m]
        The water table; none: dry.
    loads : sequence of (int, (x, y), (fx, fy)) [-, m, N/m]
        Block, point and force.
    bolts : sequence of bsm_mesh.Bolt
        Those that name a stage are installed by it; stages are called "1", "2", ...
    digs : sequence of Dig
        Stages.
    """

    polygons: list[FloatArray]
    held: IntArray
    friction: float
    kn: float
    ks: float
    cohesion: float = 0.0
    unit_weight: float = 26e3
    water_weight: float = 9810.0
    gravity: float = DOWN
    surface: Line = ()
    k0: float | None = None
    table: Line = ()
    loads: tuple[tuple[int, tuple[float, float], tuple[float, float]], ...] = ()
    bolts: tuple[bsm.Bolt, ...] = ()
    digs: tuple[Dig, ...] = field(default_factory=tuple)

    @property
    def digest(self) -> str:
        """Hash of all that it is made of: the same whatever the program makes of it."""
        told = hashlib.sha256()
        for part in fields(self):
            value = getattr(self, part.name)
            told.update(f"{part.name}:".encode())
            arrays = value if part.name == "polygons" else [value] if isinstance(value, np.ndarray) else None
            for array in arrays or ():
                told.update(np.ascontiguousarray(array).tobytes())
            if arrays is None:
                told.update(repr(value).encode())
        return told.hexdigest()

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.polygons)

    @property
    def free(self) -> IntArray:
        """Blocks that may move and are never taken away."""
        taken = np.concatenate([self.held, *(dig.blocks for dig in self.digs)])
        return np.setdiff1d(np.arange(self.count), taken)

    @property
    def size(self) -> float:
        """Square root of the mean area of the blocks that may move [m]; where there is none, of all."""
        blocks = self.free if len(self.free) else np.arange(self.count)
        areas = [abs(polygon_area(self.polygons[block])) for block in blocks]
        return float(np.sqrt(np.mean(areas)))

    def model(self) -> bsm.Model:
        """Return the model."""
        law = bsm.MohrCoulomb(friction=self.friction, cohesion=self.cohesion)
        return bsm.Model(
            blocks=bsm.Blocks.from_polygons(self.polygons, rock="rock", merge_tolerance=1e-7 * self.size),
            rocks=(bsm.Rock("rock", unit_weight=self.unit_weight),),
            joints=(bsm.Joint("joint", normal_stiffness=self.kn, shear_stiffness=self.ks, law=law),),
            default_joint="joint",
            supports=(bsm.Fixed(blocks=self.held.tolist()),),
            loads=tuple(bsm.PointLoad(block=b, point=at, force=force) for b, at, force in self.loads),
            gravity_direction=self.gravity,
            in_situ=None if self.k0 is None else bsm.InSitu(surface=self.surface, k0=self.k0),
            water=self._water(self.table) if self.table else None,
            bolts=self.bolts,
            stages=tuple(self._stage(number, dig) for number, dig in enumerate(self.digs, start=1)),
        )

    def _water(self, table: Line) -> bsm.Water:
        return bsm.Water(table=table, unit_weight=self.water_weight)

    def _stage(self, number: int, dig: Dig) -> bsm.Stage:
        water = None if dig.table is None else self._water(dig.table)
        return bsm.Stage(
            name=str(number),
            excavate=dig.blocks.tolist(),
            relaxation=dig.relaxation,
            water=water,
            loads=() if dig.gravity is None else self._turning(number, dig.gravity),
        )

    def _turning(self, number: int, gravity: float) -> tuple[bsm.PointLoad, ...]:
        """Return the loads that turn weights in a stage to a new direction."""
        before = _last([self.gravity, *(dig.gravity for dig in self.digs[: number - 1])])
        old, new = (np.array([np.cos(angle), np.sin(angle)]) for angle in np.radians([before, gravity]))
        loads = []
        for block in np.setdiff1d(self.free, self.held).tolist():
            polygon = self.polygons[block]
            x, y = polygon_centre(polygon).tolist()
            fx, fy = (self.unit_weight * abs(polygon_area(polygon)) * (new - old)).tolist()
            loads.append(bsm.PointLoad(block=block, point=(x, y), force=(fx, fy)))
        return tuple(loads)

    def at_the_end(self) -> Scene:
        """Return the rest after the last stage, where it was given: for limit analysis."""
        if not self.digs:
            return replace(self, k0=None, surface=())
        left = np.setdiff1d(np.arange(self.count), np.concatenate([dig.blocks for dig in self.digs]))
        number = np.full(self.count, -1)
        number[left] = np.arange(len(left))
        held = number[self.held]
        return replace(
            self,
            polygons=[self.polygons[block] for block in left],
            held=held[held >= 0],
            bolts=tuple(without_stage(bolt) for bolt in self.bolts),
            loads=tuple((int(number[b]), at, force) for b, at, force in self.loads if number[b] >= 0),
            digs=(),
            k0=None,
            surface=(),
            table=_last([self.table, *(dig.table for dig in self.digs)]),
            gravity=_last([self.gravity, *(dig.gravity for dig in self.digs)]),
        )


def _last(values: Sequence[T | None]) -> T:
    """Return the last value that is given; the first is."""
    return next(value for value in reversed(values) if value is not None)


def without_stage(bolt: bsm.Bolt) -> bsm.Bolt:
    """Return the bolt as one that is there from the start."""
    return replace(bolt, stage=None)


def polygon_area(corners: FloatArray) -> float:
    """Return the area of a polygon (k, 2), positive if counter-clockwise."""
    x, y = (corners - corners[0]).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)


def polygon_centre(corners: FloatArray) -> FloatArray:
    """Return the centroid of a polygon (k, 2)."""
    x, y = (corners - corners[0]).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    middle = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()])
    return np.asarray(corners[0] + middle / (3 * cross.sum()), dtype=np.float64)


def box(x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    """Return an upright rectangle."""
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def turn(points: npt.ArrayLike, degrees: float) -> FloatArray:
    """Return points turned counter-clockwise about the origin."""
    a = np.radians(degrees)
    turning = np.array([(np.cos(a), np.sin(a)), (-np.sin(a), np.cos(a))])
    return np.asarray(np.asarray(points, dtype=np.float64) @ turning, dtype=np.float64)
