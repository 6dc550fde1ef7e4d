"""Elements cut along lines, whatever their shape: areas between the lines and the edges they cross.

All are divided where they meet by snap rounding (Hobby 1999), by GEOS, on a grid far below the elements: which pieces
meet is settled there without doubt. The points are then put back where segments and edges cross. A line that ends
inside an element is extended to the next edge, since a rigid block has no crack in it; the extension is no joint.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.meshes.faces_in_elements import Faces, with_faces
from bsm_mesh.converters.meshes.nodes_on_lines import NEAR, single_edges
from bsm_mesh.converters.meshes.report import places
from bsm_mesh.converters.meshes.segments import Segments, crossings, foot_points
from bsm_mesh.errors import ModelError
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import owner_of_corner

GRID = 2.0**-36  # of the model's size: spacing of the grid on which lines and edges meet
REACH = 4.0  # spacings of the grid: what is nearer is the same place
CLEAR = 1e-9  # of an element's size: an end stays this far from what was there before it
LEAST_SINE = 1e-6  # of the angle at which two lines are taken to cross
MOST_ROUNDS = 20  # of extending lines, and of joining loops to the outline around them


def grid_of(blocks: Blocks) -> float:
    """Return the spacing of the grid on which lines and edges meet [m]: no coordinate is known better than that."""
    size = float(np.ptp(blocks.vertices, axis=0).max())
    return max(GRID * size, 2 * float(np.spacing(np.abs(blocks.vertices).max())))


def cut_elements(blocks: Blocks, segments: Segments) -> tuple[Blocks, LongArray]:
    """Return the blocks cut along segments, and the given block of each.

    Parts of an edge keep the joint and the boundaries of it, parts of a block its rock and excavations.

    Parameters
    ----------
    blocks : Blocks
        An element a block, conforming.
    segments : Segments
        The cutting lines, led through the nodes that they touch.
    """
    import shapely

    grid = grid_of(blocks)
    polygons = shapely.polygons(shapely.linearrings(blocks.vertices, indices=blocks.owner))
    tree = shapely.STRtree(polygons)
    crossed = np.unique(tree.query(segments.shapes, predicate="dwithin", distance=REACH * grid)[1])
    if not crossed.size:
        return blocks, np.arange(blocks.count)
    own = np.isin(blocks.owner, crossed)
    single = single_edges(blocks)
    one, other = blocks.edge_table.pairs()
    own[one] |= own[other]
    edges = single[own[single]]
    sides = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
    middle = blocks.vertices.mean(axis=0)
    carriers = np.concatenate([sides, segments.ends]) - middle
    inside = _Within(polygons[crossed], middle)
    faces, of_face = _enclosed(carriers, segments, inside, grid)
    found = _placed(faces, crossed[of_face], carriers, middle, grid)
    return with_faces(blocks, crossed, found, REACH * grid)


class _Within:
    """Which of some elements points lie in; coordinates from the middle of the model."""

    def __init__(self, polygons: Any, middle: FloatArray) -> None:
        import shapely

        self.polygons = shapely.transform(polygons, lambda points: points - middle)
        self._tree = shapely.STRtree(self.polygons)

    def element(self, points: FloatArray, depth: float = 0.0) -> LongArray:
        """Return the element of every point, its number among these; -1 outside, and nearer to a rim than `depth`."""
        import shapely

        shapes = shapely.points(points)
        point, element = self._tree.query(shapes, predicate="intersects")
        deep = shapely.distance(shapely.get_exterior_ring(self.polygons[element]), shapes[point]) >= depth
        found = np.full(len(points), -1, dtype=np.int64)
        found[point[deep]] = element[deep]
        return found

    def size(self, points: FloatArray) -> FloatArray:
        """Return a length that leads out of the element of every point, whatever the direction [m]."""
        import shapely

        length: FloatArray = shapely.length(self.polygons)[self.element(points)]
        return length


def _enclosed(carriers: FloatArray, segments: Segments, inside: _Within, grid: float) -> tuple[Any, LongArray]:
    """Return the polygons that lines and edges enclose within elements, without holes, and the element of each."""
    import shapely

    drawn = shapely.linestrings(carriers)
    middle = (carriers[-len(segments.ends) :] - segments.ends)[0, 0]
    tips, outward = segments.tips()
    tips = tips + middle
    noded = _noded(drawn, grid)
    open_ends = (inside.element(tips, REACH * grid) >= 0) & _is_end(tips, noded, grid)
    rays = _rays(tips[open_ends], outward[open_ends], inside.size(tips[open_ends]), noded)
    for _ in range(MOST_ROUNDS):
        noded = _noded(np.concatenate([noded, rays]), grid)
        faces = shapely.orient_polygons(shapely.get_parts(shapely.polygonize(noded)))
        element = inside.element(shapely.get_coordinates(shapely.point_on_surface(faces)))
        faces, element = faces[element >= 0], element[element >= 0]
        holes = faces[shapely.get_num_interior_rings(faces) > 0]
        if not len(holes):
            return faces, element
        rays = _bridges(holes, noded)
    where = places(shapely.get_coordinates(shapely.point_on_surface(holes)))
    raise ModelError(f"lines of joints make loops in elements that cannot be divided ({where}); leave some of them out")


def _noded(lines: Any, grid: float) -> Any:
    """Return lines divided where they meet, on the grid, as straight pieces."""
    import shapely

    parts = shapely.get_parts(shapely.union_all(lines, grid_size=grid))
    parts = parts[shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING]
    points, line = shapely.get_coordinates(parts, return_index=True)
    follows = line[1:] == line[:-1]
    return shapely.linestrings(np.stack([points[:-1][follows], points[1:][follows]], axis=1))


def _is_end(points: FloatArray, noded: Any, grid: float) -> Any:
    """Return at which points a single piece ends."""
    from scipy.spatial import cKDTree

    ends = cKDTree(_ends_of(noded).reshape(-1, 2))
    return ends.query_ball_point(points, REACH * grid, return_length=True) == 1


def _ends_of(noded: Any) -> FloatArray:
    import shapely

    ends: FloatArray = shapely.get_coordinates(noded).reshape(-1, 2, 2)
    return ends


def _rays(points: FloatArray, directions: FloatArray, size: FloatArray, noded: Any) -> Any:
    """Return lines from points in some directions to the first piece that each meets, `size` [m] away at most."""
    import shapely

    if not len(points):
        return shapely.linestrings(np.empty((0, 2, 2)))
    ends = _ends_of(noded)
    tree = shapely.STRtree(noded)
    reach = np.stack([points + part * size[:, None] * directions for part in (CLEAR, 1.0)], axis=1)
    ray, piece = tree.query(shapely.linestrings(reach), predicate="intersects")
    place, sine = crossings(reach[ray], ends[piece])
    along_it = ~(sine > LEAST_SINE)  # a piece in the ray's own line: to its nearer end
    nearer = np.einsum("nij,nj->ni", ends[piece] - points[ray][:, None], directions[ray])
    nearer[nearer < 0] = np.inf
    place[along_it] = ends[piece, np.argmin(nearer, axis=1)][along_it]
    distance = np.hypot(*(place - points[ray]).T)
    order = np.lexsort([distance, ray])
    first = order[np.append(True, ray[order][1:] != ray[order][:-1])]
    hit, at = ends[piece[first]], np.arange(len(first))
    gap = np.hypot(*(hit - place[first][:, None]).transpose(2, 0, 1))
    nearest = np.argmin(gap, axis=1)
    to_end = gap[at, nearest] < NEAR * gap.sum(axis=1)  # else a sliver would be cut off there
    target = np.where(to_end[:, None], hit[at, nearest], place[first])
    return shapely.linestrings(np.stack([points[ray[first]], target], axis=1))


def _bridges(faces: Any, noded: Any) -> Any:
    """Return lines from the leftmost and the rightmost point of every hole of some faces to its neighbour."""
    import shapely

    ring, face = shapely.get_rings(faces, return_index=True)
    is_hole = np.append(False, face[1:] == face[:-1])
    ring, sizes = ring[is_hole], 2 * shapely.length(faces)[face[is_hole]]
    points, of_ring = shapely.get_coordinates(ring, return_index=True)
    order = np.lexsort([points[:, 0], of_ring])
    first = np.flatnonzero(np.append(True, of_ring[1:] != of_ring[:-1]))
    last = np.append(first[1:], len(order)) - 1
    ends = points[np.concatenate([order[first], order[last]])]
    directions = np.repeat([[-1.0, 0.0], [1.0, 0.0]], len(first), axis=0)
    return _rays(ends, directions, np.tile(sizes[of_ring[order[first]]], 2), noded)


def _placed(faces: Any, parent: LongArray, carriers: FloatArray, middle: FloatArray, grid: float) -> Faces:
    """Return the faces with their corners where segments and edges cross, not where the grid has them."""
    import shapely

    rounded, ring = shapely.get_coordinates(shapely.get_exterior_ring(faces), return_index=True)
    closing = np.append(ring[1:] != ring[:-1], True)
    on_grid, corners = np.unique(rounded[~closing], axis=0, return_inverse=True)
    exact = _exact(on_grid, carriers, grid)
    same = merge_points(exact, max(REACH * grid, MERGE_TOLERANCE))  # where more than two lines cross
    _, first = np.unique(same, return_index=True)
    on_grid, exact = on_grid[first], exact[first]
    corners, offsets, left = _without_repeats(same[corners.reshape(-1)], ring[~closing])
    owner = owner_of_corner(offsets)
    while True:
        shapes = shapely.polygons(shapely.linearrings(exact[corners], indices=owner))
        bad = ~shapely.is_valid(shapes) | ~shapely.is_ccw(shapely.get_exterior_ring(shapes))
        back = np.unique(corners[bad[owner]])
        back = back[np.any(exact[back] != on_grid[back], axis=1)]
        if not back.size:
            return Faces(points=exact + middle, corners=corners, offsets=offsets, parent=parent[left])
        exact[back] = on_grid[back]


def _without_repeats(corners: IntArray, owner: LongArray) -> tuple[LongArray, IntArray, LongArray]:
    """Return corners of outlines that differ from the one before, offsets, and which outlines have three and more."""
    first = np.append(True, owner[1:] != owner[:-1])
    before = np.arange(-1, len(owner) - 1)
    before[first] = np.append(np.flatnonzero(first)[1:], len(owner)) - 1
    distinct = corners != corners[before]
    count = np.bincount(owner[distinct], minlength=int(owner[-1]) + 1)
    distinct &= count[owner] >= 3
    offsets = np.concatenate([[0], np.cumsum(count[count >= 3])]).astype(np.int32)
    return corners[distinct].astype(np.int64), offsets, np.flatnonzero(count >= 3)


def _exact(on_grid: FloatArray, carriers: FloatArray, grid: float) -> FloatArray:
    """Return the points where the two steepest lines near each point on the grid cross, or the end of one there."""
    import shapely
    from scipy.spatial import cKDTree

    exact = on_grid.copy()
    point, carrier = shapely.STRtree(shapely.linestrings(carriers)).query(
        shapely.points(on_grid), predicate="dwithin", distance=REACH * grid
    )
    order = np.argsort(point, kind="stable")
    point, carrier = point[order], carrier[order]
    if len(point):
        first = np.flatnonzero(np.append(True, point[1:] != point[:-1]))
        of_first = np.repeat(first, np.diff(np.append(first, len(point))))
        cross, sine = crossings(carriers[carrier[of_first]], carriers[carrier])
        sine = np.nan_to_num(sine)
        steepest = np.lexsort([sine, point])[np.append(first[1:], len(point)) - 1]
        here = point[first]
        foot = foot_points(on_grid[here], carriers[carrier[first]])
        near = np.hypot(*(cross[steepest] - on_grid[here]).T) <= REACH * grid / np.maximum(sine[steepest], LEAST_SINE)
        steep = (sine[steepest] > LEAST_SINE) & near
        exact[here] = np.where(steep[:, None], cross[steepest], foot)
    ends = carriers.reshape(-1, 2)
    distance, nearest = cKDTree(ends).query(on_grid)
    at_end = distance <= REACH * grid
    exact[at_end] = ends[nearest[at_end]]
    return exact
