"""The rigid blocks: outlines stored flat, the rock of each, and the joints and boundaries of their edges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray, IntArray, Portable, own_array
from bsm_mesh.errors import ModelError, as_given, counted, nearest, place, raise_faults, shortened
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.block_faults import FARTHEST, outline_faults
from bsm_mesh.model.edges import EdgeTable
from bsm_mesh.model.overlap import Overlaps, find_overlaps
from bsm_mesh.model.polygons import Moments, edge_vectors, next_corner, owner_of_corner, polygon_moments
from bsm_mesh.model.quantities import MERGE_TOLERANCE as MERGING
from bsm_mesh.model.values import Rules, parts_of

MERGE_TOLERANCE = 1e-9  # m; corners nearer than this are one point

EdgePredicate = Callable[[FloatArray, FloatArray], npt.NDArray[np.bool_]]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Blocks(Portable):
    """Rigid polygonal blocks, stored flat.

    Edge e runs from corner e to the next corner of the same block, so edges and corners share their numbers.

    Attributes
    ----------
    vertices : (n_vertices, 2) float64 [m]
        Corners, counter-clockwise, block after block.
    offsets : (n_blocks + 1,) int32
        Block b owns ``vertices[offsets[b]:offsets[b + 1]]``.
    nodes : (n_vertices,) int32
        Number of the point at which each corner lies: corners of different blocks that touch share it.
    rock : (n_blocks,) int32
        Index of each block's rock in `rock_names`.
    rock_names : tuple of str
        Names of the rocks.
    edge_joint : (n_vertices,) int32
        Index of each edge's joint in `joint_names`; -1 where it has none.
    joint_names : tuple of str
        Names of the joints.
    boundaries : mapping of str to (k,) int32
        Edges of each named boundary.
    excavations : mapping of str to (k,) int32
        Blocks of each named excavation.

    Raises
    ------
    ModelError
        If an outline is not a simple polygon of positive area, or the arrays do not fit together.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> blocks = bsm.Blocks.from_polygons([[(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1), (2, 1), (1, 2)]], rock="granite")
    >>> blocks.count, blocks.moments.area.tolist()
    (2, [2.0, 1.0])
    """

    vertices: FloatArray
    offsets: IntArray
    nodes: IntArray = field(metadata={"in_hash": False})  # follows from the vertices
    rock: IntArray
    rock_names: tuple[str, ...]
    edge_joint: IntArray
    joint_names: tuple[str, ...] = ()
    boundaries: Mapping[str, IntArray] = field(default_factory=dict)
    excavations: Mapping[str, IntArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._own_arrays()
        raise_faults(outline_faults(self.vertices, self.offsets))

    def __repr__(self) -> str:
        area = self.moments.area
        low, high = place(self.vertices.min(axis=0)), place(self.vertices.max(axis=0))
        named = {"rocks": self.rock_names, "joints": self.joint_names, "boundaries": self.boundaries}
        groups = "; ".join(f"{kind} {shortened(', '.join(names))}" for kind, names in named.items() if names)
        return (
            f"Blocks: {counted(self.count, 'block')} of {area.min():.3g} to {area.max():.3g} m2, "
            f"{low} to {high} m\n{groups}"
        )

    bulk_name, bulk_unit = "area", "m2"  # of `Moments.bulk`
    components, force_unit, face_unit = "x, y", "N/m", "m"  # of vectors; of forces; of what a contact represents
    axes = 3  # numbers that say how a block moved: u, v, theta

    @property
    def span(self) -> float:
        """Longest side of the box round all blocks [m]."""
        return float(np.ptp(self.vertices, axis=0).max())

    def _own_arrays(self) -> None:
        rules = Rules("Blocks")
        own_array(self, "vertices", np.float64, (None, 2))
        own_array(self, "offsets", np.int32, (None,))
        for name in ("nodes", "rock", "edge_joint"):
            own_array(self, name, np.int32, (None,))
        rules.own_names(self, groups=("boundaries", "excavations"), texts=("rock_names", "joint_names"))
        raise_faults(rules.faults)
        self._check_sizes()

    def _check_sizes(self) -> None:
        """Raise for arrays that do not fit together; outlines are looked at only once these do."""
        faults = []
        offsets, n_vertices = self.offsets, len(self.vertices)
        if len(offsets) < 2:
            raise ModelError("there are no blocks; a model needs at least one polygon")
        if offsets[0] != 0 or offsets[-1] != n_vertices or np.any(np.diff(offsets) < 3):
            faults.append(
                f"Blocks.offsets: must rise from 0 to {n_vertices} (the number of corners) by 3 or more a block"
            )
        for name, length in (("nodes", n_vertices), ("edge_joint", n_vertices), ("rock", len(offsets) - 1)):
            if len(getattr(self, name)) != length:
                faults.append(f"Blocks.{name}: has {len(getattr(self, name))} entries, needs {length}")
        for name, lowest, names in (("rock", 0, self.rock_names), ("edge_joint", -1, self.joint_names)):
            values = getattr(self, name)
            if values.size and (values.min() < lowest or values.max() >= len(names)):
                faults.append(f"Blocks.{name}: index outside {lowest} .. {len(names) - 1}")
        limits = (("boundaries", n_vertices, "edge"), ("excavations", len(offsets) - 1, "block"))
        for name, limit, thing in limits:
            for key, ids in getattr(self, name).items():
                if ids.size and (ids.min() < 0 or ids.max() >= limit):
                    faults.append(f"Blocks.{name}['{key}']: {thing} number outside 0 .. {limit - 1}")
        raise_faults(faults)

    @classmethod
    def from_polygons(
        cls,
        polygons: Sequence[npt.ArrayLike],
        *,
        rock: str | Sequence[str],
        merge_tolerance: float = MERGE_TOLERANCE,
    ) -> Blocks:
        """Return blocks from one array of corners each; clockwise outlines are turned round.

        Parameters
        ----------
        polygons : sequence of (k, 2) array_like [m]
            Corners of each block in order; the first may be repeated at the end, as in GeoJSON and Shapely.
        rock : str or sequence of str
            Name of the rock of all blocks, or one name a block.
        merge_tolerance : float [m]
            Corners of different blocks nearer than this are taken as touching.

        Raises
        ------
        ModelError
            If a polygon is not a simple outline of at least three finite corners, or blocks overlap.

        Examples
        --------
        >>> square = [(0, 0), (1, 0), (1, 1), (0, 1)]
        >>> Blocks.from_polygons([square], rock="granite").count
        1
        """
        rules = Rules("Blocks.from_polygons")
        rules.number("merge_tolerance", merge_tolerance, MERGING)
        outlines = parts_of(polygons)
        if outlines is None:
            rules.faults.append(f"{rules.thing}: polygons = {as_given(polygons)} must be a list of outlines")
        names = rock_of_each(rules, rock, len(outlines or []))
        raise_faults(rules.faults)
        corners = _as_corners(outlines or [])
        offsets = np.concatenate([[0], np.cumsum([len(c) for c in corners])]).astype(np.int32)
        vertices = np.concatenate(corners)
        clockwise = np.flatnonzero(polygon_moments(vertices, offsets).area < 0)
        for b in clockwise:
            vertices[offsets[b] : offsets[b + 1]] = vertices[offsets[b] : offsets[b + 1]][::-1].copy()
        rock_names = tuple(dict.fromkeys(names))
        blocks = cls(
            vertices=vertices,
            offsets=offsets,
            nodes=merge_points(vertices, merge_tolerance),
            rock=np.array([rock_names.index(name) for name in names], dtype=np.int32),
            rock_names=rock_names,
            edge_joint=np.full(len(vertices), -1, dtype=np.int32),
        )
        raise_faults(blocks.overlaps.faults())
        return blocks

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.offsets) - 1

    @cached_property
    def moments(self) -> Moments:
        """Area, centroid and polar second moment of every block."""
        return polygon_moments(self.vertices, self.offsets)

    @cached_property
    def following(self) -> IntArray:
        """Next corner of the same block, for every corner."""
        return next_corner(self.offsets)

    @cached_property
    def preceding(self) -> IntArray:
        """Corner before of the same block, for every corner."""
        found = np.empty_like(self.following)
        found[self.following] = np.arange(len(found), dtype=found.dtype)
        return found

    @cached_property
    def owner(self) -> IntArray:
        """Block of every corner and edge."""
        return owner_of_corner(self.offsets)

    @property
    def edge_vectors(self) -> FloatArray:
        """Vector along every edge, (n_vertices, 2) [m]."""
        return edge_vectors(self.vertices, self.offsets)

    @cached_property
    def edge_table(self) -> EdgeTable:
        """All edges, found by the points that they join."""
        return EdgeTable.of(self.nodes, self.offsets)

    @cached_property
    def overlaps(self) -> Overlaps:
        """Pairs of blocks that share area; a model can begin with none."""
        return find_overlaps(self.vertices, self.offsets, self.nodes, self.edge_table)

    @property
    def outer_edges(self) -> IntArray:
        """Edges that no edge of another block matches from end to end: the outline of the body, lips of gaps."""
        return np.flatnonzero(self.edge_table.unpaired()).astype(np.int32)

    @property
    def extent(self) -> tuple[float, float]:
        """Least and greatest x of the corners [m]."""
        return float(self.vertices[:, 0].min()), float(self.vertices[:, 0].max())

    def polygon(self, block: int) -> FloatArray:
        """Return the corners of one block, (k, 2) [m].

        Raises
        ------
        ModelError
            If there is no block of this number.
        """
        if not 0 <= block < self.count:
            raise ModelError(f"there is no block {block} (blocks 0 .. {self.count - 1})")
        return self.vertices[self.offsets[block] : self.offsets[block + 1]]

    def boundary_edges(self, name: str) -> IntArray:
        """Return the edges of a named boundary.

        Raises
        ------
        ModelError
            If there is no such boundary.
        """
        if name not in self.boundaries:
            raise ModelError(f"there is no boundary '{name}'{nearest(name, self.boundaries)}")
        return self.boundaries[name]

    def with_boundary(self, name: str, where: EdgePredicate) -> Blocks:
        """Return a copy whose boundary `name` holds the outer edges with ``where(x, y)`` true at both ends.

        Examples
        --------
        >>> blocks = Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="granite")
        >>> blocks.with_boundary("bottom", lambda x, y: y < 1e-9).boundaries["bottom"]
        array([0], dtype=int32)
        """
        edges = self.outer_edges
        chosen = edges[self._edges_where("boundary", name, where)[edges]]
        if chosen.size == 0:
            raise ModelError(f"boundary '{name}': no outer edge fulfils the condition at both its ends")
        return self._with(boundaries={**self.boundaries, name: chosen})

    def with_joint(self, name: str, where: EdgePredicate) -> Blocks:
        """Return a copy in which the edges with ``where(x, y)`` true at both ends carry the joint `name`."""
        chosen = self._edges_where("joint", name, where)
        if not chosen.any():
            raise ModelError(f"joint '{name}': no edge fulfils the condition at both its ends")
        names = self.joint_names if name in self.joint_names else (*self.joint_names, name)
        edge_joint = np.where(chosen, names.index(name), self.edge_joint).astype(np.int32)
        return self._with(edge_joint=edge_joint, joint_names=names)

    def with_edge_joints(self, edge_joint: IntArray, joint_names: tuple[str, ...]) -> Blocks:
        """Return a copy whose edges carry other joints: `edge_joint` and `joint_names` as the fields of these names."""
        return self._with(edge_joint=edge_joint, joint_names=joint_names)

    def _with(self, **changes: object) -> Blocks:
        """Return a copy with other groups; the outlines, and all quantities derived from them, stay as they are."""
        made = object.__new__(Blocks)
        made.__dict__.update(self.__dict__)
        for name, value in changes.items():
            object.__setattr__(made, name, value)
        made._own_arrays()
        return made

    def _edges_where(self, kind: str, name: str, where: EdgePredicate) -> npt.NDArray[np.bool_]:
        at_corner = true_where(kind, name, where, self.vertices)
        both: npt.NDArray[np.bool_] = at_corner & at_corner[self.following]
        return both


def rock_of_each(rules: Rules, rock: str | Sequence[str], count: int) -> list[str]:
    """Return the rock of each of `count` blocks, by one name or one each; add faults to the rules."""
    if isinstance(rock, str):
        return [rock] * count
    names = list(rules.texts("rock", rock))
    if not rules.faults and len(names) != count:
        rules.faults.append(f"rock: {len(names)} names for {count} blocks; give one name, or one a block")
    return names


def true_where(kind: str, name: str, where: Callable[..., object], points: FloatArray) -> npt.NDArray[np.bool_]:
    """Return at which points (n, d) the condition ``where(x, y)`` of a named group is true.

    Raises
    ------
    ModelError
        For a name that is no text, and for a condition that does not return True or False for every point.
    """
    rules = Rules(kind, name)
    rules.name(name)
    found = np.asarray(where(*points.T)) if callable(where) else np.zeros(0)
    if found.dtype != np.bool_ or found.shape not in ((), (len(points),)):
        axes = ", ".join("xyz"[: points.shape[1]])
        rules.faults.append(
            f"{rules.thing}: where must be a function of the arrays {axes} that returns True or "
            f"False for every point, such as lambda {axes}: y < 1e-9"
        )
    raise_faults(rules.faults)
    return np.broadcast_to(found, len(points))


def _as_corners(polygons: Sequence[npt.ArrayLike]) -> list[FloatArray]:
    corners, faults = [], []
    for b, polygon in enumerate(polygons):
        try:
            array = np.array(polygon, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        if array.ndim != 2 or array.shape[1] != 2 or len(array) < 3:
            faults.append(f"block {b}: needs at least 3 corners (x, y), has an array of shape {array.shape}")
        elif not (near := np.abs(array) < FARTHEST).all():
            corner = int(np.argmin(near.all(axis=1)))
            faults.append(f"block {b}: corner {corner} has coordinates that are no numbers below {FARTHEST:g} m")
        elif len(array) > 3 and (array[0] == array[-1]).all():
            array = array[:-1]
        corners.append(array)
    raise_faults(faults)
    if not corners:
        raise ModelError("there are no blocks; a model needs at least one polygon")
    return corners
