"""Results of key blocks: a row a block at a free face, its words, table and file."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.errors import counted
from bsm_mesh.reading import as_path
from bsm_mesh.results.tables import ResultTable
from bsm_mesh.three_d.key_blocks.modes import FALLS, HELD, MODES, NOT_JUDGED


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class KeyBlocks(Portable):
    """Blocks at free faces, one row each.

    Attributes
    ----------
    block : (n,) int32
        Number of the block.
    mode : (n,) int8
        Number in `modes`: not removable, stays, falls, slides on one plane, slides on two planes, not judged.
    held : (n,) bool
        Whether it reaches the surface of the body beyond the free faces; such a block is not judged.
    round : (n,) int32
        In which round it falls or slides below the required factor, with its bolts; 0 where it does not.
    factor : (n,) float64
        Of safety: strength over the pull along its movement; 0 where it falls, infinite where nothing moves it.
    direction : (n, 3) float64
        Unit vector of its movement; zero where there is none.
    joints : (n, 2) int32
        Joints of the planes on which it slides, by their largest faces; -1 for none.
    centroid : (n, 3) float64 [m]
        Centre of volume.
    volume, weight, area : (n,) float64 [m3, N, m2]
        Volume, weight, and area of the free faces.
    apex, trace : (n,) float64 [m]
        Depth behind its free faces, and the greatest distance between their corners.
    support : (n,) float64 [Pa]
        Uniform pressure on its free faces that gives it the required factor; 0 where it has that, NaN where no such
        pressure was found.
    pull, bolted_factor, bolted_support : (n,) float64 [N, -, Pa]
        Greatest pull of the bolts together; factor with it; and uniform pressure that it leaves to be given.
    sliver : (n,) bool
        Whether it is smaller than a thousandth of the mean volume.
    free_faces : (k,) int32
        All free faces of these blocks.
    required : float
        The required factor.
    joint_names : tuple of str
        Names of the joints.
    """

    block: IntArray
    mode: IntArray
    held: BoolArray
    round: IntArray
    factor: FloatArray
    direction: FloatArray
    joints: IntArray
    centroid: FloatArray
    volume: FloatArray
    weight: FloatArray
    area: FloatArray
    apex: FloatArray
    trace: FloatArray
    support: FloatArray
    pull: FloatArray
    bolted_factor: FloatArray
    bolted_support: FloatArray
    sliver: BoolArray
    free_faces: IntArray
    required: float
    joint_names: tuple[str, ...]

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def count(self) -> int:
        """Number of blocks at free faces."""
        return len(self.block)

    @property
    def modes(self) -> tuple[str, ...]:
        """Mode of every block in words."""
        return tuple(MODES[mode] for mode in self.mode)

    @property
    def removable(self) -> BoolArray:
        """Which blocks can leave."""
        can: BoolArray = (self.mode != HELD) & (self.mode != NOT_JUDGED)
        return can

    @property
    def unstable(self) -> BoolArray:
        """Which blocks fall, or slide at a factor below 1, with their bolts; 1 to rounding is none."""
        return self.bolted_factor < 1 - ROUNDING

    def table(self) -> ResultTable:
        """Return a row a block, with units."""
        joints = np.array([*self.joint_names, ""], dtype=object)[self.joints]
        columns = {
            "block": self.block,
            "mode": np.array(self.modes, dtype=object),
            "removable": self.removable,
            "held": self.held,
            "round": self.round,
            "joint_1": joints[:, 0],
            "joint_2": joints[:, 1],
            "factor": self.factor,
            "volume": self.volume,
            "weight": self.weight,
            "support_pressure": self.support,
            "bolt_pull": self.pull,
            "bolted_factor": self.bolted_factor,
            "bolted_support": self.bolted_support,
            "free_area": self.area,
            "apex": self.apex,
            "trace": self.trace,
            "x": self.centroid[:, 0],
            "y": self.centroid[:, 1],
            "z": self.centroid[:, 2],
            "direction_x": self.direction[:, 0],
            "direction_y": self.direction[:, 1],
            "direction_z": self.direction[:, 2],
            "sliver": self.sliver,
        }
        units = dict.fromkeys(("apex", "trace", "x", "y", "z"), "m")
        units |= {"volume": "m^3", "weight": "N", "support_pressure": "Pa", "free_area": "m^2"}
        units |= {"bolt_pull": "N", "bolted_support": "Pa"}
        return ResultTable(columns=columns, units=units)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the table as CSV, or as Parquet where the name ends in .parquet; return the path."""
        from bsm_mesh.folder.result_tables import write_table

        return write_table(self.table(), as_path("key blocks: path", path))

    def to_pandas(self) -> Any:
        """Return the table as a pandas DataFrame, a row a block, with the units in ``attrs["units"]``.

        Raises
        ------
        ModelError
            If pandas is not installed.
        """
        from bsm_mesh.folder.result_tables import frame_of

        return frame_of(self.table())

    def and_then(self, later: KeyBlocks) -> KeyBlocks:
        """Return two tables as one: blocks that fell keep their rows, others are as they are `later`."""
        kept = (self.round > 0) | ~np.isin(self.block, later.block)
        rows: dict[str, Any] = {
            name: np.concatenate([getattr(self, name)[kept], getattr(later, name)])
            for name in KeyBlocks.__dataclass_fields__
            if isinstance(getattr(later, name), np.ndarray) and name != "free_faces"
        }
        order = np.argsort(rows["block"])
        free = np.union1d(self.free_faces, later.free_faces)
        return replace(later, free_faces=free, **{name: values[order] for name, values in rows.items()})

    def __repr__(self) -> str:
        falls, slides = int((self.mode == FALLS).sum()), int((self.unstable & (self.mode != FALLS)).sum())
        return (
            f"KeyBlocks: {counted(self.count, 'block')} at free faces, {int(self.removable.sum())} removable, {falls} "
            f"fall, {slides} slide at a factor below 1; {self.volume[self.unstable].sum():.3g} m3 in all"
        )
