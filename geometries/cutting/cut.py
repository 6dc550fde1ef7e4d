"""`cut_blocks`: from a description of jointed rock to its blocks."""

from __future__ import annotations

import dataclasses
from typing import Literal, get_args

import numpy as np

from bsm_mesh.geometries.cutting.block_cut import BlockCut, Choice, JointAccount
from bsm_mesh.geometries.cutting.dead_ends import dead_ends, extend_ends
from bsm_mesh.geometries.cutting.ends import join_ends
from bsm_mesh.geometries.cutting.faces import Faces, enclose_faces, excavations_at, keep_valid
from bsm_mesh.geometries.cutting.graph import Graph, place_points
from bsm_mesh.geometries.cutting.pieces import BoolArray, IntArray, Pieces, gather_pieces
from bsm_mesh.geometries.cutting.slivers import join_slivers
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.parameters import Checks
from bsm_mesh.geometries.rock_mass import Opening, Region, RockMass
from bsm_mesh.geometries.session import load_gmsh

Engine = Literal["auto", "gmsh", "shapely"]
MOST_MEETINGS = 5000  # places where lines meet: Gmsh fragments so many in 3 s of processor time, whatever the pattern


def cut_blocks(mass: RockMass, engine: Engine = "auto") -> BlockCut:
    """Return the blocks into which the joints cut the rock.

    Both engines give the same blocks with the same numbers. Where lines lie within the tolerance of each other, one
    engine may give a sliver that the other does not.

    Parameters
    ----------
    mass : RockMass
        The rock and its joints.
    engine : str
        ``gmsh`` fragments by Open CASCADE; ``shapely`` is a cutter of our own, which takes a second for 3e4 blocks;
        ``auto`` takes Gmsh where lines meet at 5000 places at most and Gmsh can be loaded, else the cutter. The report
        says which and why.

    Raises
    ------
    GeometryError
        For another engine, for outlines that enclose no rock, and for rock in three dimensions.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> rock = g.RockMass(
    ...     regions=[g.Region(outline=g.rectangle(0, 0, 4, 4), rock="gneiss")],
    ...     joints=[g.JointSet(name="bed", dip=0, spacing=1.0, start=(0, 0))],
    ... )
    >>> g.cut_blocks(rock).count
    4
    """
    checks = Checks("cut_blocks")
    checks.a_thing(RockMass, mass=mass)
    checks.raise_faults()
    pieces, given = gather_pieces(mass)
    in_rock = _sums(pieces.joint, pieces.length, len(pieces.joint_names))
    given += _sums(pieces.joint, np.where(pieces.region < 0, 0.0, pieces.length), len(given))
    extended = np.zeros_like(in_rock)
    chosen = choose_engine(pieces, engine)
    pieces, graph = _node(pieces, mass.grid, chosen.engine)
    if pieces.extends.any():
        placed = dataclasses.replace(graph, points=place_points(graph, pieces, mass.grid)[0])
        longer = extend_ends(placed, pieces, _in_rock(placed.points, mass), mass.grid)
        extended = _sums(pieces.joint, longer.length - pieces.length, len(in_rock))
        pieces, graph = _node(longer, mass.grid, chosen.engine)
    faces, region = enclose_faces(graph, mass)
    points = keep_valid(graph, faces, *place_points(graph, pieces, mass.grid), mass.grid)
    graph, faces, region, joined = join_slivers(graph, faces, region, points, pieces, mass)
    placed = dataclasses.replace(graph, points=points)
    chosen = dataclasses.replace(chosen, slivers=joined.count)
    return _gather(mass, pieces, placed, faces, region, (given, in_rock, extended, joined.lengths), chosen)


def choose_engine(pieces: Pieces, engine: Engine) -> Choice:
    """Return the engine that cuts some pieces, and why.

    Raises
    ------
    GeometryError
        For another engine.
    """
    if engine not in get_args(Engine):
        raise GeometryError(f"there is no engine '{engine}'; give {', '.join(get_args(Engine))}")
    if engine != "auto":
        return Choice(engine=engine, reason="as asked")
    places = count_meetings(pieces)
    reason = f"lines meet at {places} places (Gmsh takes up to {MOST_MEETINGS})"
    if places > MOST_MEETINGS:
        return Choice(engine="shapely", reason=reason)
    try:
        load_gmsh()
    except GeometryError as fault:
        return Choice(engine="shapely", reason=str(fault))
    return Choice(engine="gmsh", reason=reason)


def count_meetings(pieces: Pieces) -> int:
    """Return at how many places lines meet, two by two."""
    import shapely

    drawn = shapely.linestrings(pieces.ends)
    met = shapely.STRtree(drawn).query(drawn, predicate="intersects").shape[1]
    return int(met - len(drawn)) // 2


def _node(pieces: Pieces, grid: float, engine: str) -> tuple[Pieces, Graph]:
    """Return the pieces with their ends joined, and their graph."""
    lines = join_ends(pieces, grid)
    if engine == "gmsh":
        from bsm_mesh.geometries.cutting.fragment import node_by_gmsh

        return lines.pieces, node_by_gmsh(lines, grid)
    from bsm_mesh.geometries.cutting.noding import node_by_shapely

    return lines.pieces, node_by_shapely(lines, grid)


def _gather(
    mass: RockMass,
    pieces: Pieces,
    graph: Graph,
    faces: Faces,
    region: IntArray,
    lengths: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    chosen: Choice,
) -> BlockCut:
    import shapely

    edge, _ = faces.edge_faces(graph)
    sides = np.bincount(edge, minlength=len(graph.edges))
    joint = _joint_of_edges(graph, pieces)
    centre = shapely.get_coordinates(shapely.point_on_surface(faces.polygons(graph.points)))
    inside = _in_rock(graph.points[graph.edges].mean(axis=1), mass) & (graph.length > mass.grid)
    names = tuple(dict.fromkeys(r.rock for r in mass.regions if isinstance(r, Region)))
    index = {number: names.index(r.rock) for number, r in enumerate(mass.regions) if isinstance(r, Region)}
    rock = np.array([index.get(number, -1) for number in range(len(mass.regions))])[region]
    used, rock = np.unique(rock, return_inverse=True)
    excavated = {name: np.flatnonzero(which) for name, which in excavations_at(centre, mass.regions).items()}
    dead = (sides == 0) & inside & (joint >= 0)
    return BlockCut(
        points=graph.points,
        corners=faces.corners,
        rings=faces.rings,
        faces=faces.faces,
        rock=rock.reshape(-1),
        rock_names=tuple(names[k] for k in used),
        excavations={name: blocks for name, blocks in excavated.items() if blocks.size},
        joints=_by_name(graph.edges, joint, sides == 2, pieces.joint_names),
        boundaries=_boundaries(graph, pieces, mass, np.flatnonzero(sides == 1)),
        dead={} if mass.dead_ends == "cut" else _by_name(graph.edges, joint, dead, pieces.joint_names),
        accounts=_accounts(graph, pieces, sides, joint, inside, lengths),
        by=chosen,
    )


def _joint_of_edges(graph: Graph, pieces: Pieces) -> IntArray:
    """Return the joint of every edge, -1 for none: the first given of those that lie on it."""
    none = len(pieces.joint_names)
    joint = np.full(len(graph.edges), none)
    np.minimum.at(joint, graph.edge, np.where(pieces.joint < 0, none, pieces.joint)[graph.piece])
    return np.where(joint == none, -1, joint)


def _in_rock(points: FloatArray, mass: RockMass) -> BoolArray:
    """Return which points lie in the rock."""
    import shapely

    domain = mass.domain()
    shapely.prepare(domain)
    inside: BoolArray = shapely.contains_xy(domain, *points.T)
    return inside


def _by_name(edges: IntArray, joint: IntArray, which: BoolArray, names: tuple[str, ...]) -> dict[str, IntArray]:
    found = {name: edges[which & (joint == number)] for number, name in enumerate(names)}
    return {name: chosen for name, chosen in found.items() if len(chosen)}


def _boundaries(graph: Graph, pieces: Pieces, mass: RockMass, outer: IntArray) -> dict[str, IntArray]:
    """Return the outer edges by boundary: as named, that of an opening, a side of the model's box, else ``surface``."""
    import shapely

    low, high = mass.box
    names = ["left", "right", "bottom", "top", "surface"]
    ends = graph.points[graph.edges[outer]]
    side = np.full(len(outer), 4)
    walls = (ends[..., 0] - low[0], high[0] - ends[..., 0], ends[..., 1] - low[1], high[1] - ends[..., 1])
    for number in (3, 2, 1, 0):
        side[np.abs(walls[number]).max(axis=1) <= 2 * mass.grid] = number
    at = np.full(len(graph.edges), -1)
    at[outer] = np.arange(len(outer))
    for number, region in enumerate(mass.regions):
        if isinstance(region, Opening):
            if region.boundary not in names:
                names.append(region.boundary)
            here = at[graph.edge[pieces.region[graph.piece] == number]]
            side[here[here >= 0]] = names.index(region.boundary)
    for name, line in mass.boundaries.items():
        near = shapely.dwithin(shapely.points(ends), shapely.LineString(line), 2 * mass.grid).all(axis=1)
        if not near.any():
            raise GeometryError(
                f"boundary '{name}': no outer edge lies along the line given for it; name the face of an "
                "excavation in the model file, [boundary.NAME] along = [[x, y], ...]"
            )
        if name not in names:
            names.append(name)
        side[near] = names.index(name)
    return _by_name(graph.edges[outer], side, np.ones(len(outer), dtype=np.bool_), tuple(names))


def _accounts(
    graph: Graph,
    pieces: Pieces,
    sides: IntArray,
    joint: IntArray,
    inside: BoolArray,
    lengths: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
) -> tuple[JointAccount, ...]:
    jointed = pieces.joint[graph.piece] >= 0
    edge, own = graph.edge[jointed], pieces.joint[graph.piece[jointed]]
    length = graph.length[edge]
    first = np.concatenate([[True], edge[1:] != edge[:-1]]) & (joint[edge] == own)
    what = np.select(
        [sides[edge] == 1, ~first & (inside | (sides == 2))[edge], sides[edge] == 2, inside[edge]], [0, 1, 2, 3], 4
    )
    count = len(pieces.joint_names)
    share = np.stack([_sums(own[what == k], length[what == k], count) for k in range(5)])
    given, in_rock, extended, joined = lengths
    share[1] += joined
    snapped = in_rock + extended - share.sum(axis=0)
    is_end = np.zeros(len(graph.points), dtype=np.bool_)
    is_end[dead_ends(graph)] = True
    hanging = _sums(np.where(inside, joint, -1), is_end[graph.edges].sum(axis=1), count)
    return tuple(
        JointAccount(
            name=name,
            given=float(given[k]),
            in_rock=float(in_rock[k]),
            extended=float(extended[k]),
            bounding=float(share[2, k]),
            coincident=float(share[1, k]),
            on_outline=float(share[0, k]),
            dead=float(share[3, k]),
            outside=float(share[4, k]),
            snapped=float(snapped[k]),
            dead_ends=int(hanging[k]),
        )
        for k, name in enumerate(pieces.joint_names)
    )


def _sums(index: IntArray, values: FloatArray, count: int) -> FloatArray:
    chosen = index >= 0
    sums: FloatArray = np.bincount(index[chosen], values[chosen], minlength=count).astype(np.float64)
    return sums
