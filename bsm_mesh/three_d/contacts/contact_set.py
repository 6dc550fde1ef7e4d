"""The contact set of a step: the points of shared polygons, with stiffness, strength and history.

Polygons are those of the given geometry until a block has slid by a part of one (`renewal`). A point that has slid off
its polygon bears nothing any more.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.features import Features, features_of
from bsm_mesh.contact.forces import rows_by_law
from bsm_mesh.contact.rules import CONTACT_TOLERANCE
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.polygons import owner_of_corner
from bsm_mesh.three_d.blocks.contact_polygons import ContactPoints, ContactPolygons
from bsm_mesh.three_d.blocks.flats import flat_areas, inner_corners
from bsm_mesh.three_d.blocks.polygons import bent_corners, spread
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.history import SLOTS, PointHistory, PolygonPoints, keys_of
from bsm_mesh.three_d.contacts.kernels import relative_positions
from bsm_mesh.three_d.contacts.properties import PolygonCatalogue
from bsm_mesh.three_d.contacts.rotations import swings

SAME = 1e-6  # of an area: smaller differences are rounding


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Candidates:
    """Blocks of every contact, and where it continues.

    Attributes
    ----------
    block_a, block_b : (m,) int32
        Block with the point, block with the face.
    length : (m,) float64 [m2]
        Area that the point stands for; a law's length.
    history : (m,) int64
        Row in the history if it was closed before; else -1.
    """

    block_a: IntArray
    block_b: IntArray
    length: FloatArray
    history: IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactSet:
    """The contact points of a step with all that their forces depend on; constant within the step.

    Vectors (m, 3) are in the frame of the face's block: its axes as given, turned with it.
    """

    candidates: Candidates
    key: IntArray  # (m,) faces and corner, as `keys_of`, rising
    joint: IntArray  # (m,) number in ``model.joints``; -1: unjointed rock
    law: IntArray  # (m,) number in the catalogue's laws
    geometry: FloatArray  # (m, 12) as `relative_positions` takes it
    reach: FloatArray  # (m,) [m] tangential movement with which the point has left its polygon
    renewed: PolygonPoints  # those of renewed polygons
    normal_stiffness: FloatArray  # [N/m]
    shear_stiffness: FloatArray
    tension: FloatArray  # [N]
    residual_tension: FloatArray
    offset: FloatArray  # gap at zero pressure
    old_shear: FloatArray  # (m, 3) on a
    old_place: FloatArray  # (m, 3) movement against the face at that shear force; nan: none yet
    first_place: FloatArray  # (m, 3) at first contact; nan: not closed yet
    failed: BoolArray
    mated: BoolArray
    slip_path: FloatArray
    within_tolerance: BoolArray
    features: Features
    by_law: tuple[tuple[int, IntArray | slice], ...]
    meeting: IntArray  # (k, 2) pairs of blocks without a contact whose edges may meet at any moment

    @property
    def count(self) -> int:
        """Number of contacts."""
        return len(self.offset)

    def frames(self, position: FloatArray) -> tuple[FloatArray, ...]:
        """Return rotations less the unit matrix (n, 3, 3), movements against the faces and both arms, (m, 3) each."""
        swing = swings(position[:, 3:])
        c = self.candidates
        return swing, *relative_positions(position, swing, c.block_a, c.block_b, self.geometry)

    def gaps(self, place: FloatArray) -> FloatArray:
        """Return the gaps (m,) [m] of movements against the faces (m, 3)."""
        gap: FloatArray = np.einsum("ij,ij->i", place, self.geometry[:, 6:9])
        return gap

    def along(self, vector: FloatArray) -> FloatArray:
        """Return the parts of vectors (m, 3) along the faces."""
        normal = self.geometry[:, 6:9]
        tangential: FloatArray = vector - np.einsum("ij,ij->i", vector, normal)[:, None] * normal
        return tangential

    def closed_history(self, place: FloatArray, shear: FloatArray, offset: FloatArray) -> PointHistory:
        """Return the history of all contacts, closed at movements against the faces (m, 3) [m].

        Parameters
        ----------
        place : (m, 3) float64 [m]
            Movements against the faces.
        shear : (m, 3) float64 [N]
            Shear force on block a.
        offset : (m,) float64 [m]
            Gap at zero pressure.
        """
        return PointHistory(
            key=self.key,
            block_a=self.candidates.block_a,
            block_b=self.candidates.block_b,
            closed=np.ones(self.count, dtype=bool),
            shear=shear,
            place=place,
            first_place=place,
            offset=offset,
            failed=self.failed,
            mated=self.mated,
            slip_path=self.slip_path,
            renewed=self.renewed,
        )

    def some(self, rows: IntArray, block: IntArray) -> ContactSet:
        """Return some of the contacts, their blocks renumbered (n,)."""
        number = np.full(self.count, -1, np.int32)
        number[rows] = np.arange(len(rows))
        c = self.candidates
        candidates = Candidates(
            block_a=block[c.block_a[rows]],
            block_b=block[c.block_b[rows]],
            length=c.length[rows],
            history=c.history[rows],
        )
        named = {field.name for field in fields(self)} - {"candidates", "features", "by_law", "renewed", "meeting"}
        return ContactSet(
            candidates=candidates,
            features=self.features.of(number),
            by_law=rows_by_law(self.law[rows]),
            renewed=self.renewed,
            meeting=self.meeting[:0],
            **{name: getattr(self, name)[rows] for name in named},
        )


def given_points(model: Model, held: BoolArray) -> PolygonPoints:
    """Return the contact points of a model as given. Two blocks that supports hold (n,) are no pair.

    Points lie on the block with the smaller plane part of its surface there: it takes them along where it slides. A
    point at the foot of a step lies on the other block: the rock of the step has no corner there.
    """
    assert in_space(model.blocks)
    whole = model.blocks.contact_polygons
    polygons = whole.some(np.flatnonzero(~(held[whole.block_a] & held[whole.block_b])))
    points, slot = points_of(polygons, model.contact_points)
    polygon, point = points.polygon, points.point
    key = keys_of(polygons.face[polygon], polygons.face[polygon], slot)
    a, b = polygons.block_a[polygon], polygons.block_b[polygon]
    centroid = model.blocks.moments.centroid
    found = PolygonPoints(
        key=key,
        block_a=a,
        block_b=b,
        geometry=np.hstack([point - centroid[a], point - centroid[b], polygons.normal[polygon], np.zeros_like(point)]),
        found_gap=np.zeros(len(a)),
        reach=reaches(polygons)[polygon],
        area=points.area,
        depth=depths(polygons, centroid)[polygon],
        joint=polygons.joint[polygon],
    )
    area_b, area_a = flat_areas(model.blocks)[polygons.face].T
    on_b, (inner_b, inner_a) = (area_b < area_a * (1 - SAME))[polygon], _at_steps(model.blocks, polygons, slot)
    found = found.turned_over(np.where(inner_a != inner_b, inner_a, on_b), -polygons.normal[polygon])
    return found.some(np.argsort(key, kind="stable"))


def _at_steps(blocks: Polyhedra, polygons: ContactPolygons, slot: IntArray) -> BoolArray:
    """Return which points of polygons lie where the surface of b, or of a, turns inwards, (2, k)."""
    bent = bent_corners(blocks.vertices[blocks.face_vertices], blocks.face_offsets)
    first = np.searchsorted(bent, blocks.face_offsets)[polygons.face]
    found = np.zeros((2, len(slot)), dtype=bool)
    found[:, : len(polygons.corners)] = inner_corners(blocks)[bent[spread(first, np.diff(polygons.offsets))]].T
    return found


def points_of(polygons: ContactPolygons, rule: str) -> tuple[ContactPoints, IntArray]:
    """Return the contact points of polygons, and the corner of each on its polygon; the last slot is the centroid."""
    points = polygons.points("corners" if rule == "corners" else "both")
    slot = np.full(points.count, SLOTS - 1, dtype=np.int64)
    slot[: len(polygons.corners)] = np.arange(len(polygons.corners))
    slot[: len(polygons.corners)] -= polygons.offsets[:-1][owner_of_corner(polygons.offsets)]
    return points, slot


def depths(polygons: ContactPolygons, centroid: FloatArray) -> FloatArray:
    """Return the distances of polygons from the centroids (n_blocks, 3) of a and b, across the polygon, (n, 2) [m]."""
    arms = (polygons.centroid - centroid[block] for block in (polygons.block_a, polygons.block_b))
    found: FloatArray = np.abs(np.stack([np.einsum("ij,ij->i", arm, polygons.normal) for arm in arms], axis=1))
    return found


def contacts_of(points: PolygonPoints, renewed: PolygonPoints, catalogue: PolygonCatalogue) -> ContactSet:
    """Return contact points with their properties: closed, intact, without force."""
    found, area, count = catalogue.properties(points), points.area, len(points.key)
    blank, none = np.full((count, 3), np.nan), np.zeros(count, dtype=bool)
    stiffness = found.normal_stiffness * area, found.shear_stiffness * area
    candidates = Candidates(block_a=points.block_a, block_b=points.block_b, length=area, history=np.full(count, -1))
    return ContactSet(
        candidates=candidates,
        key=points.key,
        joint=found.joint,
        law=found.law,
        geometry=points.geometry,
        reach=points.reach,
        renewed=renewed,
        normal_stiffness=stiffness[0],
        shear_stiffness=stiffness[1],
        tension=found.tension * area,
        residual_tension=found.residual_tension * area,
        offset=np.zeros(count),
        old_shear=np.zeros((count, 3)),
        old_place=blank,
        first_place=blank,
        failed=none,
        mated=~none,
        slip_path=np.zeros(count),
        within_tolerance=~none,
        features=features_of(catalogue, found.joint, area, stiffness, ~none),
        by_law=rows_by_law(found.law),
        meeting=np.zeros((0, 2), np.int32),
    )


def gathered(given: ContactSet, history: PointHistory, position: FloatArray, size: float, *, first: bool) -> ContactSet:
    """Return the contact points at a position with their history; at the start (`first`) all are intact.

    Points that were open have no cohesion, no tensile strength and residual friction.
    """
    _, place, *_ = given.frames(position)
    row, known = history.rows_of(given.key)
    closed = known & history.closed[row] if history.count else known
    offset = np.where(known, history.offset[row], given.offset) if history.count else given.offset
    on_polygon = np.linalg.norm(given.along(place), axis=1) <= given.reach
    near = (given.gaps(place) <= offset + CONTACT_TOLERANCE * size) & on_polygon
    within_tolerance = closed | near
    failed = np.where(known, history.failed[row], not first) if history.count else np.full(given.count, not first)
    mated = known & history.mated[row] if history.count else np.full(given.count, first)
    anchor = np.where(within_tolerance[:, None], place, np.nan)
    whole = given.tension, np.where(mated, given.residual_tension, 0.0)
    kept = closed[:, None]
    return replace(
        given,
        candidates=replace(given.candidates, history=np.where(closed, row, -1)),
        tension=np.where(within_tolerance, np.where(failed, whole[1], whole[0]), 0.0),
        residual_tension=whole[1],
        offset=offset,
        old_shear=np.where(kept, history.shear[row], 0.0) if history.count else given.old_shear,
        old_place=np.where(kept, history.place[row], anchor) if history.count else anchor,
        first_place=np.where(kept, history.first_place[row], anchor) if history.count else anchor,
        failed=failed,
        mated=mated,
        slip_path=np.where(known, history.slip_path[row], 0.0) if history.count else given.slip_path,
        within_tolerance=within_tolerance,
        features=given.features.of(np.where(mated, np.arange(given.count), -1)),
    )


def reaches(polygons: ContactPolygons) -> FloatArray:
    """Return the distance of the farthest corner of every polygon from its centroid, (n,) [m]."""
    sizes = np.diff(polygons.offsets)
    arm = polygons.corners - np.repeat(polygons.centroid, sizes, axis=0)
    reach: FloatArray = np.maximum.reduceat(np.linalg.norm(arm, axis=1), polygons.offsets[:-1])
    return reach
