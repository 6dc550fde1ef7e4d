"""Contact points of limit analysis: of shared faces, and where blocks touch on parts of faces or at edges."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.three_d.blocks.cell_sides import sides_of_cells
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.placed_cells import PlacedCells
from bsm_mesh.three_d.blocks.polygons import polygon_moments
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.history import PolygonPoints, faces_of
from bsm_mesh.three_d.contacts.surfaces import are_flat


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LimitPoints:
    """Places and directions in which blocks press on each other, one row each.

    Attributes
    ----------
    block_a, block_b : (m,) int32
        The two blocks.
    joint : (m,) int32
        Number of the joint in ``blocks.joint_names``; -1 for none.
    point : (m, 3) float64 [m]
        Where the force acts.
    normal : (m, 3) float64
        Unit normal that points into block_a.
    area : (m,) float64 [m2]
        The area that the point represents.
    """

    block_a: IntArray
    block_b: IntArray
    joint: IntArray
    point: FloatArray
    normal: FloatArray
    area: FloatArray

    @classmethod
    def of(cls, polygons: ContactPolygons, rule: str = "both") -> LimitPoints:
        """Return the points of shared faces, as `ContactPolygons.points` has them."""
        points = polygons.points(rule)
        polygon = points.polygon
        return cls(
            block_a=polygons.block_a[polygon],
            block_b=polygons.block_b[polygon],
            joint=polygons.joint[polygon],
            point=points.point,
            normal=polygons.normal[polygon],
            area=points.area,
        )

    @classmethod
    def touching(cls, blocks: Polyhedra, points: PolygonPoints, size: float) -> LimitPoints:
        """Return points where blocks as given touch on parts of faces, at edges or at corners.

        Where faces meet at an angle, a point has the normal of either face that separates the two cells. Their forces
        include that of every direction between. Where edges cross neither does: there both faces count.
        """
        face = faces_of(points.key)
        moments = polygon_moments(blocks.vertices[blocks.face_vertices], blocks.face_offsets)
        cells = PlacedCells.of(blocks, sides_of_cells(blocks), np.zeros((blocks.count, 6)))
        place = blocks.moments.centroid[points.block_a] + points.geometry[:, :3]
        outward, cell = [], []
        for block, number in ((points.block_a, face[0]), (points.block_b, face[1])):
            of_first = blocks.face_blocks[number, 0] == block
            outward.append(np.where(of_first[:, None], 1.0, -1.0) * moments.normal[number])
            both = blocks.face_cells[number]
            cell.append(np.where(of_first, both[:, 0], both[:, 1]))
        normals = -outward[0], outward[1]
        separates = [
            np.minimum(cells.least_along(cell[0], place, normal), cells.least_along(cell[1], place, -normal))
            >= -RULES.rounding * size
            for normal in normals
        ]
        neither, flat = ~(separates[0] | separates[1]), are_flat(*outward)
        chosen = [(separates[0] | neither) & ~flat, separates[1] | neither | flat]
        rows = np.concatenate([np.flatnonzero(some) for some in chosen])
        return cls(
            block_a=points.block_a[rows],
            block_b=points.block_b[rows],
            joint=points.joint[rows],
            point=place[rows],
            normal=np.concatenate([normal[some] for normal, some in zip(normals, chosen, strict=True)]),
            area=points.area[rows],
        )

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.block_a)

    def some(self, chosen: IntArray | BoolArray) -> LimitPoints:
        """Return some of the rows."""
        return replace(self, **{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    def with_more(self, more: LimitPoints) -> LimitPoints:
        """Return these rows and more."""
        columns = {f.name: np.concatenate([getattr(self, f.name), getattr(more, f.name)]) for f in fields(self)}
        return LimitPoints(**columns)
