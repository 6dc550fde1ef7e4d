"""Rigid polyhedral blocks: cells with plane faces, stored flat, each block one or several of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, ReadOnlyMapping, own_array
from bsm_mesh.errors import ModelError, as_given, counted, nearest, place, raise_faults, shortened
from bsm_mesh.model.blocks import MERGE_TOLERANCE, true_where
from bsm_mesh.model.values import Rules
from bsm_mesh.three_d.blocks.cells import Cells, arrays_of_cells
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons, contact_polygons
from bsm_mesh.three_d.blocks.faults import cell_faults, index_faults, volume_faults
from bsm_mesh.three_d.blocks.moments import Moments, cell_moments
from bsm_mesh.three_d.blocks.polygons import vector_areas
from bsm_mesh.three_d.blocks.solids import arrays_of_solids

if TYPE_CHECKING:
    from bsm_mesh.model.loads import PointForces

SLIVER = 1e-3  # of the mean volume: smaller blocks are slivers, left out of time step and verdict

FacePredicate = Callable[[FloatArray, FloatArray, FloatArray], npt.NDArray[np.bool_]]


SLOPE = "slope"  # boundary along the slope of a model file


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Polyhedra(Portable):
    """Rigid polyhedral blocks, stored flat.

    A block is one convex cell or several, joined across faces that are no joint. The complex conforms: where cells
    touch they share whole faces. Contact polygons are in `contact_polygons`: ``block_a``, ``block_b``, ``joint``,
    ``face``, ``corners``, ``offsets``, ``normal``, ``area``, ``centroid``, ``polar_moment``; contact points are
    ``contact_polygons.points(rule)``: ``polygon``, ``point``, ``area``. Masses are in `moments`: ``volume``,
    ``centroid``, ``inertia`` (unit density, about the centroid), ``gyration``, ``size``.

    Attributes
    ----------
    vertices : (n_vertices, 3) float64 [m]
        Points: x east, y north, z up.
    face_vertices : (k,) int32
        Points of the faces' corners, counter-clockwise seen from outside the first cell, face after face.
    face_offsets : (n_faces + 1,) int32
        Face f owns ``face_vertices[face_offsets[f]:face_offsets[f + 1]]``.
    face_cells : (n_faces, 2) int32
        The two cells of every face; the second is -1 where there is none.
    face_joint : (n_faces,) int32
        Index of each face's joint in `joint_names`; -1 where it has none.
    cell_block : (n_cells,) int32
        Block of every cell.
    rock : (n_blocks,) int32
        Index of each block's rock in `rock_names`.
    rock_names : tuple of str
        Names of the rocks.
    joint_names : tuple of str
        Names of the joints.
    boundaries : mapping of str to (k,) int32
        Faces of each named boundary.
    excavations : mapping of str to (k,) int32
        Blocks of each named excavation.

    Raises
    ------
    ModelError
        If a cell is not closed, a block has no volume, or the arrays do not fit together.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    >>> blocks = bsm.Polyhedra.from_solids([(corners, faces)], rock="granite")
    >>> blocks.count, round(float(blocks.moments.volume[0]), 6)
    (1, 0.166667)
    """

    vertices: FloatArray
    face_vertices: IntArray
    face_offsets: IntArray
    face_cells: IntArray
    face_joint: IntArray
    cell_block: IntArray
    rock: IntArray
    rock_names: tuple[str, ...]
    joint_names: tuple[str, ...] = ()
    boundaries: Mapping[str, IntArray] = field(default_factory=dict)
    excavations: Mapping[str, IntArray] = field(default_factory=dict)

    bulk_name, bulk_unit = "volume", "m3"  # of `Moments.bulk`
    components, force_unit, face_unit = "x, y, z", "N", "m2"  # of vectors; of forces; of what a contact stands for
    axes = 6  # numbers that say how a block has moved: three displacements and a rotation vector

    @property
    def span(self) -> float:
        """Longest side of the box round all blocks [m]."""
        return float(np.ptp(self.vertices, axis=0).max())

    def __post_init__(self) -> None:
        self._own_arrays()
        faults = cell_faults(
            self.vertices, self.face_vertices, self.face_offsets, self.face_cells, len(self.cell_block)
        )
        raise_faults(faults or volume_faults(self.moments.volume))

    def __repr__(self) -> str:
        volume = self.moments.volume
        low, high = place(self.vertices.min(axis=0)), place(self.vertices.max(axis=0))
        named = {"rocks": self.rock_names, "joints": self.joint_names, "boundaries": self.boundaries}
        groups = "; ".join(f"{kind} {shortened(', '.join(names))}" for kind, names in named.items() if names)
        return (
            f"Polyhedra: {counted(self.count, 'block')} of {volume.min():.3g} to {volume.max():.3g} m3, "
            f"{low} to {high} m\n{groups}"
        )

    def _own_arrays(self) -> None:
        rules = Rules("Polyhedra")
        own_array(self, "vertices", np.float64, (None, 3))
        own_array(self, "face_cells", np.int32, (None, 2))
        for name in ("face_vertices", "face_offsets", "face_joint", "cell_block", "rock"):
            own_array(self, name, np.int32, (None,))
        rules.own_names(self, groups=("boundaries", "excavations"), texts=("rock_names", "joint_names"))
        raise_faults(rules.faults)
        self._check_sizes()

    def _check_sizes(self) -> None:
        """Raise for arrays that do not fit together."""
        offsets, faces = self.face_offsets, len(self.face_offsets) - 1
        if not self.rock.size or faces < 4:
            raise ModelError("there are no blocks; a model needs at least one polyhedron")
        faults = []
        if offsets[0] != 0 or offsets[-1] != len(self.face_vertices) or np.any(np.diff(offsets) < 3):
            faults.append(
                f"Polyhedra.face_offsets: must rise from 0 to {len(self.face_vertices)} (the number of corners) by 3 "
                "or more a face"
            )
        for name in ("face_cells", "face_joint"):
            if len(getattr(self, name)) != faces:
                faults.append(f"Polyhedra.{name}: has {len(getattr(self, name))} entries, needs {faces}")
        if not np.isfinite(self.vertices).all():
            faults.append("Polyhedra.vertices: holds coordinates that are no finite numbers")
        if not np.array_equal(np.unique(self.cell_block), np.arange(len(self.rock))):
            faults.append(f"Polyhedra.cell_block: must name every block from 0 to {len(self.rock) - 1} at least once")
        faults += index_faults("face_vertices", self.face_vertices, 0, len(self.vertices))
        faults += index_faults("face_cells", self.face_cells[:, 0], 0, len(self.cell_block))
        faults += index_faults("face_cells", self.face_cells[:, 1], -1, len(self.cell_block))
        faults += index_faults("face_joint", self.face_joint, -1, len(self.joint_names))
        faults += index_faults("rock", self.rock, 0, len(self.rock_names))
        for key, ids in self.boundaries.items():
            faults += index_faults(f"boundaries['{key}']", ids, 0, faces)
        for key, ids in self.excavations.items():
            faults += index_faults(f"excavations['{key}']", ids, 0, len(self.rock))
        raise_faults(faults)

    @classmethod
    def from_cells(cls, cells: Cells, *, whole: bool = False) -> Polyhedra:
        """Return the blocks of a complex of cells.

        Cells are one block where they meet in a face without a joint, are of one rock, and in the same excavation.
        Blocks are numbered by their first cells.

        Parameters
        ----------
        cells : Cells
            What `geometries.three_d` has cut, or an object with the same arrays.
        whole : bool
            Whether every cell is a block of its own.

        Raises
        ------
        ModelError
            If `cells` are none.
        """
        if not hasattr(cells, "face_cells"):
            raise ModelError(
                f"Polyhedra.from_cells: cells = {as_given(cells)} must be what geometries.three_d.cut_cells returns"
            )
        return cls(**arrays_of_cells(cells, whole=whole))

    @classmethod
    def from_solids(
        cls,
        solids: Sequence[tuple[npt.ArrayLike, Sequence[Sequence[int]]]],
        *,
        rock: str | Sequence[str],
        joint: str | None = None,
        merge_tolerance: float = MERGE_TOLERANCE,
    ) -> Polyhedra:
        """Return blocks from one convex solid each: corners, and faces as lists of their numbers.

        Solids touch where they share a whole face.

        Parameters
        ----------
        solids : sequence of ((k, 3) array_like [m], sequence of sequences of int)
            Corners, and for every face the numbers of its corners, counter-clockwise seen from outside.
        rock : str or sequence of str
            Name of the rock of all blocks, or one name a block.
        joint : str, optional
            Name of the joint of all faces between blocks.
        merge_tolerance : float [m]
            Corners of different solids nearer than this are one point.

        Raises
        ------
        ModelError
            If a face names a corner that is not there, or the blocks are not closed.
        """
        return cls(**arrays_of_solids(solids, rock, joint, merge_tolerance))

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.rock)

    @cached_property
    def moments(self) -> Moments:
        """Volume, centroid and inertia of every block."""
        return cell_moments(self.vertices, self.face_vertices, self.face_offsets, self.face_cells, self.cell_block)

    @cached_property
    def face_blocks(self) -> IntArray:
        """Blocks on both sides of every face, (n_faces, 2) int32; -1 for none."""
        blocks: IntArray = np.where(self.face_cells >= 0, self.cell_block[self.face_cells], -1).astype(np.int32)
        return blocks

    @cached_property
    def contact_polygons(self) -> ContactPolygons:
        """The faces in which different blocks touch."""
        return contact_polygons(self.vertices, self.face_vertices, self.face_offsets, self.face_blocks, self.face_joint)

    @cached_property
    def areas(self) -> FloatArray:
        """Area of every face, (n_faces,) [m2]."""
        area: FloatArray = np.linalg.norm(vector_areas(self.vertices[self.face_vertices], self.face_offsets), axis=1)
        return area

    @cached_property
    def surfaces(self) -> FloatArray:
        """Area of the surface of every block, (n,) [m2]; faces between its own cells are not among it."""
        first, second = self.face_blocks.T
        found: FloatArray = np.zeros(self.count)
        for side in (first, second):
            bare = np.flatnonzero((side >= 0) & (first != second))
            found += np.bincount(side[bare], self.areas[bare], self.count)
        return found

    @property
    def slivers(self) -> IntArray:
        """Blocks smaller than a thousandth of the mean volume."""
        volume = self.moments.volume
        return np.flatnonzero(volume < SLIVER * volume.mean()).astype(np.int32)

    @property
    def outer_faces(self) -> IntArray:
        """Faces with one cell only: the surface of the body."""
        return np.flatnonzero(self.face_cells[:, 1] < 0).astype(np.int32)

    def boundary_faces(self, name: str) -> IntArray:
        """Return the faces of a named boundary.

        Raises
        ------
        ModelError
            If there is no such boundary.
        """
        if name not in self.boundaries:
            raise ModelError(f"there is no boundary '{name}'{nearest(name, self.boundaries)}")
        return self.boundaries[name]

    def boundary_blocks(self, *names: str) -> IntArray:
        """Return the blocks with a face of one of the named boundaries."""
        faces = np.concatenate([self.boundary_faces(name) for name in names]) if names else np.empty(0, np.int32)
        return np.unique(self.face_blocks[faces, 0])

    def with_boundary(self, name: str, where: FacePredicate) -> Polyhedra:
        """Return a copy whose boundary `name` holds the outer faces with ``where(x, y, z)`` true at all corners.

        Examples
        --------
        >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        >>> faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
        >>> blocks = Polyhedra.from_solids([(corners, faces)], rock="granite")
        >>> blocks.with_boundary("bottom", lambda x, y, z: z < 1e-9).boundaries["bottom"]
        array([0], dtype=int32)
        """
        at_point = true_where("boundary", name, where, self.vertices)
        whole: BoolArray = np.logical_and.reduceat(at_point[self.face_vertices], self.face_offsets[:-1])
        outer = self.outer_faces
        chosen = outer[whole[outer]]
        if chosen.size == 0:
            raise ModelError(f"boundary '{name}': no outer face fulfils the condition at all its corners")
        made = object.__new__(Polyhedra)
        made.__dict__.update(self.__dict__)
        object.__setattr__(made, "boundaries", ReadOnlyMapping({**self.boundaries, name: chosen}))
        return made

    def pressure_on_new_faces(self, stays: BoolArray, leaves: BoolArray, pressure: float) -> PointForces:
        """Return a pressure [Pa] on the faces between blocks that stay (n,) and that leave (n,), into the former."""
        from bsm_mesh.model.loads import PointForces

        faces = self.contact_polygons
        a, b = faces.block_a, faces.block_b
        bare = np.flatnonzero((stays[a] & leaves[b]) | (stays[b] & leaves[a]))
        into_a = np.where(stays[a[bare]], 1.0, -1.0)[:, None]  # normals point into a
        return PointForces(
            block=np.where(stays[a], a, b)[bare],
            point=faces.centroid[bare],
            force=pressure * faces.area[bare, None] * into_a * faces.normal[bare],
        )

    def polygon(self, face: int) -> FloatArray:
        """Return the corners of one face, (k, 3) [m]."""
        return self.vertices[self.face_vertices[self.face_offsets[face] : self.face_offsets[face + 1]]]

    def block_faces(self, block: int) -> IntArray:
        """Return the faces of the surface of one block; those between its own cells are not among them."""
        return np.flatnonzero((self.face_blocks == block).sum(axis=1) == 1).astype(np.int32)
