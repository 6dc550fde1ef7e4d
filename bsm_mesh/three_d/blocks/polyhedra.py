"""Rigid polyhedral blocks: cells with plane faces, stored flat, each block one or several of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, ReadOnlyMapping, own_array, read_only
from bsm_mesh.errors import ModelError, counted, nearest, place, raise_faults, shortened
from bsm_mesh.model.blocks import MERGE_TOLERANCE, merge_points
from bsm_mesh.model.polygons import owner_of_corner
from bsm_mesh.model.values import Rules
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons, contact_polygons
from bsm_mesh.three_d.blocks.faults import cell_faults, index_faults, volume_faults
from bsm_mesh.three_d.blocks.moments import Moments, cell_moments

if TYPE_CHECKING:
    from bsm_mesh.model.loads import PointForces

SLIVER = 1e-3  # of the mean volume: smaller blocks are slivers, left out of time step and verdict

FacePredicate = Callable[[FloatArray, FloatArray, FloatArray], npt.NDArray[np.bool_]]


class Cells(Protocol):
    """A conforming complex of convex cells, as `geometries.three_d` cuts it; arrays as in `Polyhedra`.

    Cells have a rock, an index in `rock_names`, and an excavation, an index in `excavation_names` or -1.
    """

    @property
    def vertices(self) -> FloatArray: ...  # noqa: D102

    @property
    def face_vertices(self) -> IntArray: ...  # noqa: D102

    @property
    def face_offsets(self) -> IntArray: ...  # noqa: D102

    @property
    def face_cells(self) -> IntArray: ...  # noqa: D102

    @property
    def face_joint(self) -> IntArray: ...  # noqa: D102

    @property
    def joint_names(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def boundaries(self) -> Mapping[str, IntArray]: ...  # noqa: D102

    @property
    def cell_rock(self) -> IntArray: ...  # noqa: D102

    @property
    def rock_names(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def cell_excavation(self) -> IntArray: ...  # noqa: D102

    @property
    def excavation_names(self) -> tuple[str, ...]: ...  # noqa: D102


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
        for name in ("boundaries", "excavations"):
            given = rules.mapping(name, getattr(self, name))
            groups = {key: read_only(v, np.int32, (None,), f"Polyhedra.{name}['{key}']") for key, v in given.items()}
            object.__setattr__(self, name, ReadOnlyMapping(groups))
        for name in ("rock_names", "joint_names"):
            object.__setattr__(self, name, rules.texts(name, getattr(self, name)))
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
    def from_cells(cls, cells: Cells) -> Polyhedra:
        """Return the blocks of a complex of cells.

        Cells are one block where they meet in a face without a joint, are of one rock, and in the same excavation.
        Blocks are numbered by their first cells.

        Parameters
        ----------
        cells : Cells
            What `geometries.three_d` has cut, or an object with the same arrays.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        first, second = np.asarray(cells.face_cells).T
        count, region = len(cells.cell_rock), np.stack([cells.cell_rock, cells.cell_excavation], axis=1)
        tied = (second >= 0) & (np.asarray(cells.face_joint) < 0) & (region[first] == region[second]).all(axis=1)
        graph = coo_array((np.ones(tied.sum()), (first[tied], second[tied])), shape=(count, count))
        _, block, of_cell = np.unique(
            connected_components(graph, directed=False)[1], return_index=True, return_inverse=True
        )
        order = np.argsort(block)
        number = np.empty_like(order)
        number[order] = np.arange(len(order))
        leading = block[order]
        return cls(
            vertices=cells.vertices,
            face_vertices=cells.face_vertices,
            face_offsets=cells.face_offsets,
            face_cells=cells.face_cells,
            face_joint=cells.face_joint,
            cell_block=number[of_cell.reshape(-1)].astype(np.int32),
            rock=np.asarray(cells.cell_rock)[leading].astype(np.int32),
            rock_names=cells.rock_names,
            joint_names=cells.joint_names,
            boundaries=cells.boundaries,
            excavations={
                name: np.flatnonzero(np.asarray(cells.cell_excavation)[leading] == k).astype(np.int32)
                for k, name in enumerate(cells.excavation_names)
            },
        )

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
        names = [rock] * len(solids) if isinstance(rock, str) else list(rock)
        if len(names) != len(solids):
            raise ModelError(f"rock: {len(names)} names for {len(solids)} blocks; give one name, or one a block")
        points, loops, owner = _corners_of(solids)
        number = merge_points(points, merge_tolerance)
        _, kept = np.unique(number, return_index=True)
        matched: dict[tuple[int, ...], int] = {}
        faces: list[list[int]] = []
        cells: list[list[int]] = []
        for loop, solid in zip(loops, owner, strict=True):
            corners = [int(number[i]) for i in loop]
            f = matched.setdefault(tuple(sorted(corners)), len(faces))
            if f < len(faces):
                cells[f][1] = solid
            else:
                faces.append(corners)
                cells.append([solid, -1])
        sizes = [len(loop) for loop in faces]
        rock_names = tuple(dict.fromkeys(names))
        return cls(
            vertices=points[kept],
            face_vertices=np.concatenate([[], *faces]).astype(np.int32),
            face_offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
            face_cells=np.array(cells, dtype=np.int32).reshape(-1, 2),
            face_joint=np.array([0 if joint is not None and c[1] >= 0 else -1 for c in cells], dtype=np.int32),
            cell_block=np.arange(len(solids), dtype=np.int32),
            rock=np.array([rock_names.index(name) for name in names], dtype=np.int32),
            rock_names=rock_names,
            joint_names=() if joint is None else (joint,),
        )

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
        at_point = np.broadcast_to(np.asarray(where(*self.vertices.T), dtype=bool), (len(self.vertices),))
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

    def block_vertices(self, block: int) -> FloatArray:
        """Return the corners of one block, (k, 3) [m]."""
        on_face = np.zeros(len(self.face_offsets) - 1, dtype=bool)
        on_face[self.block_faces(block)] = True
        return self.vertices[np.unique(self.face_vertices[on_face[owner_of_corner(self.face_offsets)]])]


def _corners_of(
    solids: Sequence[tuple[npt.ArrayLike, Sequence[Sequence[int]]]],
) -> tuple[FloatArray, list[list[int]], list[int]]:
    """Return the corners of all solids, the loops of all faces in them, and the solid of every face."""
    points, loops, owner, faults, count = [np.empty((0, 3))], [], [], [], 0
    for s, (given, faces) in enumerate(solids):
        corners = np.array(given, dtype=np.float64)
        if corners.ndim != 2 or corners.shape[1] != 3 or not np.isfinite(corners).all():
            faults.append(f"block {s}: needs corners (x, y, z), has an array of shape {corners.shape}")
            continue
        wrong = [k for k, face in enumerate(faces) if not {*face} <= {*range(len(corners))} or len({*face}) < 3]
        faults += [f"block {s}: face {k} must name 3 or more of the corners 0 .. {len(corners) - 1}" for k in wrong]
        loops += [[count + i for i in face] for face in faces]
        owner += [s] * len(faces)
        points.append(corners)
        count += len(corners)
    raise_faults(faults)
    return np.concatenate(points), loops, owner
