"""The polygons in which blocks as given touch flat on parts of faces: none of their faces is shared there."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from bsm_mesh.contact.rules import RULES
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.polygons import polygon_moments
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.history import SLOTS, faces_of, polygons_of
from bsm_mesh.three_d.contacts.renewal import points_apart
from bsm_mesh.three_d.contacts.surfaces import Surfaces


@lru_cache(maxsize=1)  # trials of a factor of safety have the same blocks
def part_polygons(blocks: Polyhedra) -> ContactPolygons:
    """Return the polygons of parts of faces, whose blocks share no face and touch.

    The blocks are as given. Contacts at edges and corners share no area and are left out.
    """
    size = float(np.median(blocks.moments.size))
    near, start = RULES.rounding * size, np.zeros((blocks.count, 6))
    surfaces = Surfaces(blocks=blocks, rule="both")
    points = points_apart(surfaces, start, np.zeros(blocks.count, dtype=bool), near, size)
    _, polygon = np.unique(polygons_of(points.key), return_inverse=True)
    furthest = np.zeros(len(points.key))
    np.maximum.at(furthest, polygon, np.abs(points.found_gap))
    slot = points.key % SLOTS
    corners = np.flatnonzero((furthest[polygon] <= near) & (slot < SLOTS - 1))
    order = corners[np.lexsort((slot[corners], polygon[corners]))]
    _, first, count = np.unique(polygon[order], return_index=True, return_counts=True)
    one = order[first]
    place = (blocks.moments.centroid[points.block_a] + points.geometry[:, :3])[order]
    offsets = np.concatenate([[0], np.cumsum(count)]).astype(np.int32)
    found = polygon_moments(place, offsets).normal
    into_a = np.einsum("ij,ij->i", found, points.geometry[one, 6:9]) > 0
    return ContactPolygons(
        block_a=np.where(into_a, points.block_a[one], points.block_b[one]),
        block_b=np.where(into_a, points.block_b[one], points.block_a[one]),
        joint=points.joint[one],
        face=faces_of(points.key[one])[1],
        corners=place,
        offsets=offsets,
    )
