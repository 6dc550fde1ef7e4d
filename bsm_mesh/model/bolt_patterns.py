"""Many bolts at once: radial round an opening, in a row along a boundary, along curves of a mesh, from a table.

Every function takes the keys of `Bolt` that all bolts share, and numbers their names.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, read_only
from bsm_mesh.errors import ModelError, nearest, place, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.quantities import BOLT_COUNT, BOLT_INTERVAL, BOLT_LENGTH, COORDINATE, DIRECTION, DISTANCE, RADIUS
from bsm_mesh.model.stages import Stage, presence
from bsm_mesh.model.supports import unit_vector
from bsm_mesh.model.values import Rules
from bsm_mesh.named_units import with_unit
from bsm_mesh.reading import as_path
from bsm_mesh.table_rows import Rows, read_rows

STRAIGHT = 1e-3  # of a curve's length: how far its points may be off a straight line
ENDS = ("start_x", "start_y", "end_x", "end_y")
ENDS_IN_SPACE = ("start_x", "start_y", "start_z", "end_x", "end_y", "end_z")
TEXTS = ("kind", "stage", "name")


def radial_bolts(
    *,
    centre: tuple[float, float],
    radius: float,
    length: float,
    count: int,
    first: float = 0.0,
    last: float = 180.0,
    **keys: Any,
) -> list[Bolt]:
    """Return bolts that point away from a centre, their heads on a circle.

    Parameters
    ----------
    centre : (x, y) [m]
        Centre of the circle.
    radius, length : float [m]
        Of the circle, and of each bolt.
    count : int
        How many; evenly from `first` to `last`, both included, unless these are a whole turn apart.
    first, last : float [degrees]
        Directions of the first and the last bolt, from the x axis.
    **keys
        What all bolts share; see `Bolt`.

    Examples
    --------
    >>> [bolt.end for bolt in radial_bolts(centre=(0, 0), radius=2, length=1, count=3, diameter=0.025)]
    [(3.0, 0.0), (0.0, 3.0), (-3.0, 0.0)]
    """
    rules = Rules("radial bolts")
    middle = rules.point("centre", centre)
    rules.number("radius", radius, RADIUS)
    rules.number("length", length, BOLT_LENGTH)
    rules.number("first", first, DIRECTION)
    rules.number("last", last, DIRECTION)
    rules.number("count", count, BOLT_COUNT)
    raise_faults(rules.faults)
    whole_turn = abs(abs(last - first) - 360) < 1e-9
    angles = np.linspace(first, last, count, endpoint=not whole_turn)
    directions = np.array([unit_vector(float(angle)) for angle in angles])
    return _bolts(middle + radius * directions, directions, length, keys)


def row_of_bolts(
    blocks: Blocks,
    *,
    boundary: str,
    length: float,
    interval: float,
    offset: float | None = None,
    direction: float | None = None,
    stages: Sequence[Stage] = (),
    **keys: Any,
) -> list[Bolt]:
    """Return bolts in a row along a boundary, into the rock.

    Parameters
    ----------
    blocks : Blocks
        With the boundary.
    boundary : str
        Its name. Where it has rock on both sides when the bolts are installed, the side that no excavation takes away
        is bolted.
    length : float [m]
        Of each bolt.
    interval : float [m]
        Distance of the heads along the boundary.
    offset : float, optional [m]
        Distance of the first head from the boundary's beginning; half an interval where not given. A boundary runs
        with the rock to its left, round an opening clockwise; a closed one begins where x is least.
    direction : float, optional [degrees]
        Direction of all bolts from the x axis; normal to the boundary where not given.
    stages : sequence of Stage
        Of the model, for bolts with a `stage`. A face that it or an earlier one lays bare is bolted from that side.
    **keys
        What all bolts share; see `Bolt`.

    Raises
    ------
    ModelError
        If there is no such boundary, or it has rock on both sides and neither, or both, are excavated.
    """
    rules = Rules("bolts along", boundary)
    rules.text("boundary", boundary)
    rules.a_thing("blocks", blocks, Blocks)
    rules.number("length", length, BOLT_LENGTH)
    rules.number("interval", interval, BOLT_INTERVAL)
    rules.number("offset", offset, DISTANCE, optional=True)
    rules.number("direction", direction, DIRECTION, optional=True)
    raise_faults(rules.faults)
    heads, directions = [], []
    for chain in _chains(blocks, _one_side(blocks, boundary, rules.thing, keys.get("stage"), stages)):
        start, along = blocks.vertices[chain], blocks.edge_vectors[chain]
        reach = np.hypot(*along.T)
        ends = np.cumsum(reach)
        _refuse_too_many(rules.thing, float(ends[-1]), interval)
        at = np.arange(interval / 2 if offset is None else offset, ends[-1] * (1 + 1e-9), interval)
        edge = np.minimum(np.searchsorted(ends, at), len(chain) - 1)
        unit = along[edge] / reach[edge, None]
        heads.append(start[edge] + (at - ends[edge] + reach[edge])[:, None] * unit)
        inward = np.stack([-unit[:, 1], unit[:, 0]], axis=1)  # corners run counter-clockwise: the rock is to the left
        directions.append(inward if direction is None else np.tile(unit_vector(direction), (len(at), 1)))
    if not any(map(len, heads)):
        raise ModelError(
            f"{rules.thing}: no bolt fits: the first head, {interval / 2 if offset is None else offset:g} m from the "
            "boundary's beginning, is beyond its end; give a smaller interval or offset"
        )
    return _bolts(np.concatenate(heads), np.concatenate(directions), length, keys)


def bolts_on_curves(pieces: FloatArray, **keys: Any) -> list[Bolt]:
    """Return a bolt for every connected, straight curve of a mesh.

    Parameters
    ----------
    pieces : (n, 2, 2) float64 [m]
        Both ends of every line element, such as ``report.bolts["B1"]`` of `converters.read_mesh`.
    **keys
        What all bolts share; see `Bolt`. The head is where the first element of each curve begins.

    Raises
    ------
    ModelError
        If a curve branches or bends.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pieces = read_only(pieces, np.float64, (None, 2, 2), "bolts on curves: pieces")
    if not len(pieces) or not (np.abs(pieces) <= COORDINATE.most).all():
        raise ModelError(
            f"bolts on curves: pieces must be lines between points (x, y), whose coordinates {COORDINATE.rule}"
        )
    points, number = np.unique(pieces.reshape(-1, 2), axis=0, return_inverse=True)
    pairs = number.reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, curve = connected_components(graph, directed=False)
    heads, tips, faults = [], [], []
    for c in dict.fromkeys(curve[pairs[:, 0]].tolist()):
        mine = pairs[curve[pairs[:, 0]] == c]
        nodes, times = np.unique(mine, return_counts=True)
        ends = nodes[times == 1]
        if len(ends) != 2 or times.max() > 2:
            faults.append(f"the curve near {place(points[nodes[0]])} is no open line")
            continue
        head, tip = points[ends[0]], points[ends[1]]
        along = tip - head
        if (points[mine[0, 1]] - points[mine[0, 0]]) @ along < 0:
            head, tip, along = tip, head, -along
        off = points[nodes] - head
        if np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]).max() > STRAIGHT * float(along @ along):
            faults.append(f"the curve from {place(head)} bends; a bolt is straight")
        heads.append(head)
        tips.append(tip)
    raise_faults([f"bolt curve: {fault}; draw each bolt as one straight line" for fault in faults])
    return [_one(k, head, tip, keys) for k, (head, tip) in enumerate(zip(heads, tips, strict=True))]


def bolts_from_table(
    path: str | os.PathLike[str],
    read: Callable[[str, str], float] | None = None,
    **keys: Any,
) -> list[Bolt]:
    """Return a bolt for every row of a CSV file with the columns start_x, start_y, end_x, end_y [m].

    In space there are start_z and end_z too. Further columns are keys of `Bolt` and go before those in `keys`; an empty
    cell is not given. A unit in brackets (``diameter [mm]``) is that of every cell without one of its own.

    Parameters
    ----------
    path : path
        The file.
    read : callable, optional
        Turns a column's name and a text, a number with or without a unit, into a number in SI units. By default all
        are in SI units without one.
    **keys
        What all bolts share; see `Bolt`.

    Raises
    ------
    ModelError
        If the file cannot be read, with every row that is wrong.
    """
    file = as_path("bolt table", path)
    rows = read_rows(file, "start_x, start_y, end_x, end_y of a bolt")
    ends = ENDS_IN_SPACE if {"start_z", "end_z"} & set(rows.names) else ENDS
    known = [*ends, *(name for name in Bolt.__dataclass_fields__ if name not in ("start", "end"))]
    raise_faults(
        [
            f"{file}: unknown column '{title}'{nearest(name, known)}"
            for name, title in zip(rows.names, rows.header, strict=True)
            if name not in known
        ]
    )
    rows.columns(*ends)
    rows.columns(*rows.names)  # none is there twice
    bolts: list[Bolt] = []
    faults: list[str] = []
    for k in range(len(rows.cells)):
        try:
            bolts.append(_of_row(k, rows, read or _plain_number, ends, keys))
        except (ModelError, ValueError) as error:
            told = error.faults if isinstance(error, ModelError) else (str(error),)
            faults.extend(f"{rows.place(k)}: {fault}" for fault in told)
    raise_faults(faults)
    return bolts


def _plain_number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name} = '{text}' is no plain number; give it in SI units") from None


def _of_row(
    k: int, rows: Rows, read: Callable[[str, str], float], columns: Sequence[str], keys: Mapping[str, Any]
) -> Bolt:
    given: dict[str, Any] = {}
    for name, title, cell in zip(rows.names, rows.header, rows.cells[k], strict=True):
        if cell:
            given[name] = cell if name in TEXTS else read(name, with_unit(rows.plain(cell), title))
    lacking = [name for name in columns if name not in given]
    if lacking:
        raise ValueError(f"{', '.join(lacking)} must be given")
    if "diameter" not in {**keys, **given}:
        raise ValueError("diameter must be given, in a column or for all")
    head, tip = np.array([given.pop(name) for name in columns]).reshape(2, -1)
    return _one(k, head, tip, {**keys, **given}, number="name" not in given)


def _one(k: int, head: FloatArray, tip: FloatArray, keys: Mapping[str, Any], *, number: bool = True) -> Bolt:
    given = dict(keys)
    if number and isinstance(given.get("name"), str) and given["name"]:
        given["name"] = f"{given['name']} {k + 1}"
    return Bolt(start=tuple(head.tolist()), end=tuple(tip.tolist()), **given)


def _bolts(heads: FloatArray, directions: FloatArray, length: float, keys: Mapping[str, Any]) -> list[Bolt]:
    return [
        _one(k, head, head + length * along, keys)
        for k, (head, along) in enumerate(zip(heads, directions, strict=True))
    ]


def _refuse_too_many(thing: str, length: float, interval: float) -> None:
    if length > BOLT_COUNT.most * interval:
        raise ModelError(
            f"{thing}: interval = {interval:g} m makes {length / interval:.0f} bolts on {length:.6g} m; at most "
            f"{BOLT_COUNT.most:g} are in a row; give a greater interval"
        )


def _present_at(stage: str | None, stages: Sequence[Stage], blocks: Blocks) -> BoolArray:
    """Return which blocks are there after a stage, (n,): all of them where it is None or not among the stages."""
    names = [None, *(each.name for each in stages)]
    return presence(stages, blocks)[names.index(stage) if stage in names else 0]


def _laid_bare(blocks: Blocks, present: BoolArray) -> IntArray:
    """Return the edges of present blocks (n,) whose neighbour is gone."""
    there = present[blocks.owner]
    pairs = np.stack(blocks.edge_table.pairs())
    edges: IntArray = np.concatenate([side[there[side] & ~there[other]] for side, other in (pairs, pairs[::-1])])
    return edges


def _one_side(blocks: Blocks, boundary: str, thing: str, stage: str | None, stages: Sequence[Stage]) -> IntArray:
    """Return the edges of a boundary on the side that is bare; where neither is, on the side that stays."""
    if boundary not in blocks.boundaries and blocks.excavations:
        raise ModelError(
            f"there is no boundary '{boundary}'{nearest(boundary, blocks.boundaries)}; name the face of an excavation "
            "by its line, [boundary.NAME] along = [[x, y], ...], or by a curve boundary:NAME of the mesh; or give "
            "start and end of each bolt, or a table"
        )
    edges = blocks.boundary_edges(boundary)
    two_sided = ~np.isin(edges, blocks.outer_edges)
    if not two_sided.any():
        return edges
    present = _present_at(stage, stages, blocks)
    bare = np.isin(edges, _laid_bare(blocks, present))
    if bare.any():
        return edges[bare | (~two_sided & present[blocks.owner[edges]])]
    taken = np.zeros(blocks.count, dtype=bool)
    for ids in blocks.excavations.values():
        taken[ids] = True
    stays = ~taken[blocks.owner[edges]]
    if stays.all():
        raise ModelError(f"{thing}: it has rock on both sides, and neither is in an excavation; bolt from an opening")
    if not stays.any():
        raise ModelError(
            f"{thing}: excavations take the rock on both sides; bolt a face whose rock "
            "stays, or give the bolts the stage that lays the face bare"
        )
    return edges[stays]


def _chains(blocks: Blocks, edges: IntArray) -> list[IntArray]:
    """Return the edges in the order in which they follow each other, an array a connected part.

    An open part begins at its first edge, a closed one where x, then y, is least.
    """
    start, end = blocks.nodes[edges], blocks.nodes[blocks.following[edges]]
    x, y = blocks.vertices[edges].T
    order = np.lexsort((y, x, np.isin(start, end)))
    next_at = {int(node): k for k, node in enumerate(start)}
    left = set(range(len(edges)))
    chains = []
    for first in order.tolist():
        chain, k = [], first
        while k in left:
            left.remove(k)
            chain.append(int(edges[k]))
            k = next_at.get(int(end[k]), -1)
        if chain:
            chains.append(np.array(chain))
    return chains
