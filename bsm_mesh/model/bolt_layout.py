"""Where bolts run: the blocks that each passes, its nodes and elements (Wang 5.2.1, 5.3.2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh import space
from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import place, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.kinds import AnyBlocks, in_space
from bsm_mesh.model.stages import Stage, presence

SHORT = 1e-6  # of the bolt's length: what it passes of a block below this is rounding
ROUNDED = 1e-3  # of the bolt's length: so much of an end may lie in the void, as coordinates are rounded


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Passages:
    """Pieces of bolts in blocks, bolt after bolt, from head to tip.

    Attributes
    ----------
    bolt, block : (k,) int32
        Which bolt in which block; a concave block may be passed more than once.
    first, last : (k,) float64 [m]
        Distances from the head at which the piece begins and ends.
    """

    bolt: IntArray
    block: IntArray
    first: FloatArray
    last: FloatArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BoltLayout:
    """Nodes and elements of all bolts, stored flat. Element i of a bolt joins its nodes i and i + 1.

    Attributes
    ----------
    node_start : (n_bolts + 1,) int32
        Bolt b has the nodes ``node_start[b]:node_start[b + 1]``.
    block : (n_nodes,) int32
        Block to which each node is bonded.
    station : (n_nodes,) float64 [m]
        Distance from the head.
    point : (n_nodes, 2) or (n_nodes, 3) float64 [m]
        Where the node is at the start.
    capacity : (n_nodes,) float64 [N]
        Greatest force on the rock (Wang Eq. 5.7); infinite if unlimited.
    bond_stiffness : (n_nodes,) float64 [N/m]
        Of elastic bond; infinite where it is rigid.
    crossing : (n_elements,) float64 [m]
        Distance from the head at which an element crosses a joint; not a number within a block.
    dowel_stiffness, dowel_strength : (n_bolts,) float64 [N/m, N]
        As in `Bolt`.
    stage : (n_bolts,) int32
        Number of the stage that installs each bolt; 0: there from the start.
    axial_stiffness, yield_force, pretension, spacing : (n_bolts,) float64 [N, N, N, m]
        As in `Bolt`.
    """

    node_start: IntArray
    block: IntArray
    station: FloatArray
    point: FloatArray
    capacity: FloatArray
    bond_stiffness: FloatArray
    crossing: FloatArray
    dowel_stiffness: FloatArray
    dowel_strength: FloatArray
    stage: IntArray
    axial_stiffness: FloatArray
    yield_force: FloatArray
    pretension: FloatArray
    spacing: FloatArray

    @classmethod
    def none(cls, coordinates: int = 2) -> BoltLayout:
        """Return the layout of no bolts, whose points would have so many coordinates."""
        numbers, whole = np.zeros(0), np.zeros(0, np.int32)
        return cls(
            node_start=np.zeros(1, np.int32),
            block=whole,
            station=numbers,
            point=np.zeros((0, coordinates)),
            capacity=numbers,
            bond_stiffness=numbers,
            crossing=numbers,
            dowel_stiffness=numbers,
            dowel_strength=numbers,
            stage=whole,
            axial_stiffness=numbers,
            yield_force=numbers,
            pretension=numbers,
            spacing=numbers,
        )

    @property
    def bolts(self) -> int:
        """Number of bolts."""
        return len(self.node_start) - 1

    @property
    def bolt_of_node(self) -> IntArray:
        """Bolt of every node, (n_nodes,)."""
        return np.repeat(np.arange(self.bolts, dtype=np.int32), np.diff(self.node_start))

    @property
    def bolt_of_element(self) -> IntArray:
        """Bolt of every element, (n_elements,)."""
        return np.repeat(np.arange(self.bolts, dtype=np.int32), np.diff(self.node_start) - 1)

    @property
    def first_node(self) -> IntArray:
        """First node of every element, (n_elements,); the second is the next one."""
        inner = np.ones(len(self.block), dtype=bool)
        inner[self.node_start[1:] - 1] = False
        return np.flatnonzero(inner).astype(np.int32)


def pass_blocks(bolts: Sequence[Bolt], blocks: AnyBlocks, stages: Sequence[Stage] = ()) -> Passages:
    """Return the pieces of the bolts in the blocks that are there when each is installed.

    Raises
    ------
    ModelError
        For a bolt whose head or tip lies in no block, and one along an edge (in space, a face).
    """
    given = [_given_fault(bolt, spatial=in_space(blocks)) for bolt in bolts]
    raise_faults([f"{label(bolts, b)}: {text}" for b, text in enumerate(given) if text])
    there = np.stack(presence(stages, blocks))[stage_numbers(bolts, stages)]
    if isinstance(blocks, Blocks):
        found, along = _pass_polygons(bolts, blocks, there)
    else:
        found, along = space.pass_polyhedra(bolts, blocks, there)
    faults = [""] * len(bolts)
    for b, thing, shared in along:
        faults[b] = f"runs along {thing} over {shared:.3g} m, so that no block holds it; move it off the joint"
    _report_ends(faults, bolts, found)
    raise_faults([f"{label(bolts, b)} {text}" for b, text in enumerate(faults) if text])
    return found


def cut_bolts(bolts: Sequence[Bolt], blocks: AnyBlocks, stages: Sequence[Stage], present: BoolArray) -> list[Bolt]:
    """Return the parts of installed bolts that act where only some blocks (n,) are present.

    A grouted bolt continues as its parts that join two blocks or more. An end-anchored one needs both anchorages.
    """
    if not bolts:
        return []
    passed, left = pass_blocks(bolts, blocks, stages), []
    for b, bolt in enumerate(bolts):
        mine = slice(*np.searchsorted(passed.bolt, (b, b + 1)))
        there, first, last = present[passed.block[mine]], passed.first[mine], passed.last[mine]
        if there.all() or (bolt.kind == "end_anchored" and there[0] and there[-1]):
            left.append(bolt)
        elif bolt.kind == "grouted":
            ends = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(int))).reshape(-1, 2)
            left += [_part(bolt, first, last, begin, end) for begin, end in ends.tolist() if end - begin > 1]
    return left


def _part(bolt: Bolt, first: FloatArray, last: FloatArray, begin: int, end: int) -> Bolt:
    """Return a bolt from the beginning of one of its pieces to the end of another; only its head has a plate."""
    start, tip = np.asarray(bolt.start), np.asarray(bolt.end)
    along = (tip - start) / bolt.length
    changes: dict[str, Any] = {}
    if begin > 0:
        changes |= {"start": tuple((start + first[begin] * along).tolist()), "plate": 0.0}
    if end < len(first):
        changes["end"] = tuple((start + last[end - 1] * along).tolist())
    return replace(bolt, **changes)


def _given_fault(bolt: Bolt, *, spatial: bool) -> str:
    """Return what of a bolt does not belong to blocks of its kind, or nothing."""
    if len(bolt.start) != (3 if spatial else 2):
        return "start and end need x, y and z in space" if spatial else "start and end need x and y only in the plane"
    return (
        "spacing is for the plane: in space every bolt counts once; leave it out"
        if spatial and bolt.spacing != 1
        else ""
    )


def _pass_polygons(
    bolts: Sequence[Bolt], blocks: Blocks, present: BoolArray
) -> tuple[Passages, list[tuple[int, str, float]]]:
    """Return the pieces of bolts in blocks present (n_bolts, n_blocks), and bolt, edge and length along edges [m]."""
    import shapely

    start = np.array([bolt.start for bolt in bolts])
    end = np.array([bolt.end for bolt in bolts])
    length = np.hypot(*(end - start).T)
    along = (end - start) / length[:, None]
    boxes = _boxes(blocks, SHORT * float(length.max()))
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    tree = shapely.STRtree(boxes)
    bolt, block = tree.query(lines, predicate="intersects")
    there = present[bolt, block]
    bolt, block = bolt[there], block[there]
    near = np.unique(block)
    outlines = np.full(blocks.count, None, dtype=object)
    outlines[near] = [shapely.Polygon(blocks.polygon(b)) for b in near.tolist()]
    met = shapely.intersection(lines[bolt], outlines[block])
    pieces, source = shapely.get_parts(met, return_index=True)
    kept = shapely.length(pieces) > SHORT * length[bolt[source]]
    pieces, source = pieces[kept], source[kept]
    ends = shapely.get_coordinates([shapely.get_point(pieces, 0), shapely.get_point(pieces, -1)]).reshape(2, -1, 2)
    piece_bolt = bolt[source]
    reached = ((ends - start[piece_bolt]) * along[piece_bolt]).sum(axis=2)
    first, last = reached.min(axis=0), reached.max(axis=0)
    order = np.lexsort((first, piece_bolt))
    found = Passages(
        bolt=piece_bolt[order].astype(np.int32),
        block=block[source][order].astype(np.int32),
        first=first[order],
        last=last[order],
    )
    edges = _along_edges(blocks, start, along, length, bolt, block)
    return found, [(b, f"an edge of block {blocks.owner[edge]}", shared) for b, edge, shared in edges]


def _along_edges(
    blocks: Blocks, start: FloatArray, along: FloatArray, length: FloatArray, bolt: IntArray, block: IntArray
) -> Iterator[tuple[int, int, float]]:
    """Return bolt, edge and shared length where a bolt lies on an edge of a block near it, the first edge last."""
    sizes = np.diff(blocks.offsets)[block]
    of_pair = np.repeat(np.arange(len(block)), sizes)
    edge = blocks.offsets[block][of_pair] + np.arange(len(of_pair)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    of_bolt = bolt[of_pair]
    reach, off = [], []
    for end in (edge, blocks.following[edge]):
        relative, unit = blocks.vertices[end] - start[of_bolt], along[of_bolt]
        reach.append((relative * unit).sum(axis=1))
        off.append(np.abs(relative[:, 0] * unit[:, 1] - relative[:, 1] * unit[:, 0]))
    near = SHORT * length[of_bolt]
    shared = np.minimum(np.maximum(*reach), length[of_bolt]) - np.maximum(np.minimum(*reach), 0.0)
    for k in np.flatnonzero((np.maximum(*off) <= near) & (shared > near))[::-1].tolist():
        yield int(of_bolt[k]), int(edge[k]), float(shared[k])


def label(bolts: Sequence[Bolt], number: int) -> str:
    """Return the label of a bolt in messages: its number in the list, its name and its place."""
    bolt = bolts[number]
    name = f" '{bolt.name}'" if bolt.name else ""
    return f"bolt {number + 1}{name} from {place(bolt.start)} to {place(bolt.end)}"


def _report_ends(faults: list[str], bolts: Sequence[Bolt], found: Passages) -> None:
    """Say of every bolt whose head or tip is in the void by how much; ends stay where they were given."""
    inside = np.unique(found.bolt)
    head, tip = np.full(len(bolts), np.inf), np.full(len(bolts), -np.inf)
    np.minimum.at(head, found.bolt, found.first)
    np.maximum.at(tip, found.bolt, found.last)
    for b, bolt in enumerate(bolts):
        slack = ROUNDED * bolt.length
        if faults[b]:
            continue
        if b not in inside:
            faults[b] = "passes no block; place it in the rock"
        elif head[b] > slack:
            faults[b] = (
                f"has its start in the void, {head[b]:.4g} m before the rock; start it at {_along(bolt, head[b])}"
            )
        elif tip[b] < bolt.length - slack:
            beyond = bolt.length - tip[b]
            faults[b] = f"has its end in the void, {beyond:.4g} m beyond the rock; end it at {_along(bolt, tip[b])}"


def _along(bolt: Bolt, distance: float) -> str:
    """Return the point of a bolt at a distance [m] from its start, to be typed: in ten digits, also where it is 0."""
    start, end = np.asarray(bolt.start), np.asarray(bolt.end)
    point = start + distance / bolt.length * (end - start)
    point[np.abs(point) < 1e-10 * bolt.length] = 0.0
    return f"({', '.join(f'{x:.10g}' for x in point)})"


def _boxes(blocks: Blocks, margin: float) -> FloatArray:
    import shapely

    low = np.minimum.reduceat(blocks.vertices, blocks.offsets[:-1])
    high = np.maximum.reduceat(blocks.vertices, blocks.offsets[:-1])
    boxes: FloatArray = shapely.box(*(low - margin).T, *(high + margin).T)
    return boxes


def stage_numbers(bolts: Sequence[Bolt], stages: Sequence[Stage]) -> IntArray:
    """Return the number of the stage that installs each bolt, (n_bolts,); 0: there from the start."""
    number = {stage.name: k for k, stage in enumerate(stages, start=1)}
    return np.array([0 if bolt.stage is None else number[bolt.stage] for bolt in bolts], dtype=np.int32)


def lay_out_bolts(bolts: Sequence[Bolt], blocks: Blocks, stages: Sequence[Stage] = ()) -> BoltLayout:
    """Return the nodes of all bolts.

    A rigid bond has one node a block for the whole length there: at the head in the first, at the tip in the last, at
    mid-length elsewhere. Elastic bond has nodes at the middles of shorter pieces. An end-anchored bolt has two nodes.

    Raises
    ------
    ModelError
        As `pass_blocks`.
    """
    if not bolts:
        return BoltLayout.none(3 if in_space(blocks) else 2)
    passed = pass_blocks(bolts, blocks, stages)
    parts = []
    for b, bolt in enumerate(bolts):
        mine = slice(*np.searchsorted(passed.bolt, (b, b + 1)))
        parts.append(_nodes(bolt, passed.block[mine], passed.first[mine], passed.last[mine]))
    columns = zip(*parts, strict=True)
    block, station, capacity, stiffness, begins, ends = (np.concatenate(column) for column in columns)
    sizes = [len(part[0]) for part in parts]
    bolt_of = np.repeat(np.arange(len(bolts)), sizes)
    first = np.flatnonzero(bolt_of[1:] == bolt_of[:-1])
    start = np.array([bolt.start for bolt in bolts])
    end = np.array([bolt.end for bolt in bolts])

    def of_bolts(name: str) -> FloatArray:
        return np.array([getattr(bolt, name) for bolt in bolts], dtype=np.float64)

    return BoltLayout(
        node_start=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        block=block.astype(np.int32),
        station=station,
        point=start[bolt_of] + (station / of_bolts("length")[bolt_of])[:, None] * (end - start)[bolt_of],
        capacity=capacity,
        bond_stiffness=stiffness,
        crossing=np.where(block[first] == block[first + 1], np.nan, (ends[first] + begins[first + 1]) / 2),
        dowel_stiffness=of_bolts("dowel_stiffness"),
        dowel_strength=of_bolts("dowel_strength"),
        stage=stage_numbers(bolts, stages),
        axial_stiffness=of_bolts("axial_stiffness"),
        yield_force=of_bolts("yield_force"),
        pretension=of_bolts("pretension"),
        spacing=of_bolts("spacing"),
    )


def _nodes(bolt: Bolt, block: IntArray, first: FloatArray, last: FloatArray) -> tuple[npt.NDArray[np.generic], ...]:
    """Return block, station, capacity, bond stiffness, and the block's beginning and end, of the nodes of one bolt."""
    if bolt.kind == "end_anchored":
        two = [0, -1]
        most = math.inf if bolt.anchor_capacity is None else bolt.anchor_capacity
        station = np.array([0.0, bolt.length])
        return block[two], station, np.full(2, most), np.full(2, math.inf), first[two], last[two]
    if bolt.bond_stiffness is None:
        station = (first + last) / 2
        station[-1] = bolt.length
        station[0] = 0.0
        capacity = bolt.bond_capacity * (last - first)
        capacity[0] += bolt.plate
        return block, station, capacity, np.full(len(block), math.inf), first, last
    pieces = np.ceil((last - first) / bolt.longest_piece).astype(np.int64)
    owner = np.repeat(np.arange(len(block)), pieces)
    piece = ((last - first) / pieces)[owner]
    within = np.arange(len(piece)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    station = first[owner] + (within + 0.5) * piece
    found = block[owner], station, bolt.bond_capacity * piece, bolt.bond_stiffness * piece, first[owner], last[owner]
    if bolt.plate == 0:
        return found
    head = (block[0], 0.0, bolt.plate, math.inf, first[0], last[0])
    return tuple(np.concatenate([[value], values]) for value, values in zip(head, found, strict=True))
