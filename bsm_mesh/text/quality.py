"""Quality of the blocks: sizes, shapes and how they hang together, for ``bsm-mesh check``."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray, rounding_of
from bsm_mesh.errors import ModelError, counted, named_stage, nearest, numbered, place
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.bolt_layout import BoltLayout
from bsm_mesh.model.model import Model
from bsm_mesh.model.overlap import polygons_of
from bsm_mesh.model.polygons import convex_polygons
from bsm_mesh.model.stages import presence
from bsm_mesh.text.tables import engineering

if TYPE_CHECKING:
    from bsm_mesh.contact.table import ContactTable
    from bsm_mesh.solve.linear.system import LinearSystem


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Where a block begins to make trouble; each can be set by its name.

    Attributes
    ----------
    tiny : float
        Area, of the median area.
    thin : float
        4 pi area / outline^2: 1 for a circle, 0.6 for an equilateral triangle.
    short_edged : float
        Shortest edge, of the square root of the block's area.
    elongated : float
        Length over width of the narrowest rectangle around the block.
    deeply_concave : float
        Area, of the area of the convex hull.
    many_edged : float
        Edges of the block.
    gap : float
        Width of a void between blocks, of the square root of the median area: a wider one is an opening.
    """

    tiny: float = 1e-3
    thin: float = 0.05
    short_edged: float = 0.01
    elongated: float = 20.0
    deeply_concave: float = 0.7
    many_edged: float = 20
    gap: float = 0.05

    @classmethod
    def parse(cls, settings: Sequence[str]) -> Thresholds:
        """Return the thresholds with some set by texts, ``"thin=0.1"``.

        Raises
        ------
        ModelError
            For an unknown name or a value that is no number above 0.
        """
        names = [field.name for field in dataclasses.fields(cls)]
        values: dict[str, float] = {}
        for setting in settings:
            key, _, text = (part.strip() for part in setting.partition("="))
            if key not in names:
                raise ModelError(f"--threshold {setting}: there is no threshold '{key}'{nearest(key, names)}")
            try:
                values[key] = float(text)
            except ValueError:
                values[key] = float("nan")
            if not 0 < values[key] < float("inf"):
                raise ModelError(f"--threshold {setting}: '{text}' is no number above 0")
        return cls(**values)


def quality_summary(
    model: Model,
    system: LinearSystem,
    thresholds: Thresholds | None = None,
    dangling: Mapping[str, int] | None = None,
) -> dict[str, Any]:
    """Return numbers on the blocks and the lists of those that commonly make trouble.

    Parameters
    ----------
    model : Model
        The model.
    system : LinearSystem
        Its contacts and supports.
    thresholds : Thresholds, optional
        Where trouble begins.
    dangling : mapping of str to int, optional
        Pieces of joints that bound no block, as the mesh was read.
    """
    limits = thresholds or Thresholds()
    blocks = model.blocks
    area = blocks.moments.area
    edge = np.hypot(*blocks.edge_vectors.T)
    contacts = system.contacts
    part = parts_of(blocks.count, contacts.block_a, contacts.block_b)
    poor = poor_blocks(blocks, limits)
    poor["without_contact"] = _without_contact(blocks, contacts)
    poor["unsupported"] = np.flatnonzero(~np.isin(part, part[system.constraints.block]))
    gaps, gap_place, overlap = _voids(blocks, limits.gap)
    stiffness = contacts.normal_stiffness
    return {
        "blocks": blocks.count,
        "corners_per_block": [int(np.diff(blocks.offsets).min()), int(np.diff(blocks.offsets).max())],
        "area": [float(area.min()), float(np.median(area)), float(area.max())],
        "total_area": float(area.sum()),
        "shortest_edge": float(edge.min()),
        "weight": float(model.weights.sum()),
        "rocks": counts(blocks.rock_names, blocks.rock),
        "contacts": contacts.count,
        "joint_lengths": {
            joint.name: float(contacts.length[contacts.joint == k].sum()) for k, joint in enumerate(model.joints)
        },
        "unjointed_length": float(contacts.length[contacts.joint < 0].sum()),
        "boundaries": {name: len(edges) for name, edges in blocks.boundaries.items()},
        "excavations": {name: len(ids) for name, ids in blocks.excavations.items()},
        "stages": {
            stage.name: int(there.sum())
            for stage, there in zip(model.stages, presence(model.stages, blocks)[1:], strict=True)
        },
        "supported_blocks": len(system.constraints.block),
        "stiffness_ratio": float(stiffness.max() / stiffness.min()) if contacts.count else 1.0,
        "bolts": len(model.bolts),
        "bolts_in_one_block": _in_one_block(system.bolts.layout),
        "parts": int(part.max()) + 1,
        "t_intersections": _t_intersections(blocks),
        "gaps": gaps,
        "overlap_area": overlap,
        "dangling_joints": dict(dangling or {}),
        **{key: ids.tolist() for key, ids in poor.items()},
        "first_at": {key: blocks.moments.centroid[ids[0]].tolist() for key, ids in poor.items() if ids.size}
        | ({"gaps": gap_place} if gap_place else {}),
        "thresholds": dataclasses.asdict(limits),
    }


def poor_blocks(blocks: Blocks, limits: Thresholds) -> dict[str, IntArray]:
    """Return the blocks of poor shape, by their fault."""
    import shapely

    area = blocks.moments.area
    edge = np.hypot(*blocks.edge_vectors.T)
    outline = np.add.reduceat(edge, blocks.offsets[:-1])
    shortest = np.minimum.reduceat(edge, blocks.offsets[:-1])
    polygons = polygons_of(blocks.vertices, blocks.offsets, np.arange(blocks.count))
    convex = convex_polygons(blocks.vertices, blocks.offsets)
    solid = np.ones(blocks.count)
    solid[~convex] = area[~convex] / shapely.area(shapely.convex_hull(polygons[~convex]))
    found = {
        "tiny": area < limits.tiny * np.median(area),
        "thin": 4 * np.pi * area / outline**2 < limits.thin,
        "short_edged": shortest < limits.short_edged * np.sqrt(area),
        "elongated": _aspects(polygons) > limits.elongated,
        "concave": ~convex,
        "deeply_concave": solid < limits.deeply_concave,
        "many_edged": np.diff(blocks.offsets) > limits.many_edged,
    }
    return {key: np.flatnonzero(which) for key, which in found.items()}


def _aspects(polygons: Any) -> FloatArray:
    """Return length over width of the narrowest rectangle around each polygon."""
    import shapely

    corners = shapely.get_coordinates(shapely.oriented_envelope(polygons)).reshape(-1, 5, 2)
    sides = np.hypot(*(corners[:, 1:3] - corners[:, :2]).transpose(2, 0, 1))
    aspects: FloatArray = sides.max(axis=1) / np.maximum(sides.min(axis=1), np.finfo(np.float64).tiny)
    return aspects


def counts(names: tuple[str, ...], index: Any) -> dict[str, int]:
    """Return how often each name occurs among the indices of names."""
    counts = np.bincount(index, minlength=len(names))
    return {name: int(count) for name, count in zip(names, counts, strict=True)}


def _in_one_block(layout: BoltLayout) -> int:
    """Return how many bolts lie in a single block."""
    starts = layout.node_start[:-1]
    if not len(starts):
        return 0
    return int((np.minimum.reduceat(layout.block, starts) == np.maximum.reduceat(layout.block, starts)).sum())


def parts_of(count: int, block_a: IntArray, block_b: IntArray) -> IntArray:
    """Return the part that each of `count` blocks belongs to: blocks in contact are in one part."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(block_a), dtype=np.int8), (block_a, block_b)), shape=(count, count))
    part: IntArray = connected_components(graph, directed=False)[1]
    return part


def _without_contact(blocks: Blocks, contacts: ContactTable) -> IntArray:
    touched = np.zeros(blocks.count, dtype=bool)
    touched[contacts.block_a] = touched[contacts.block_b] = True
    return np.flatnonzero(~touched)


def _t_intersections(blocks: Blocks) -> int:
    """Return how many points are a corner of one block and lie in the middle of another's edge."""
    import shapely

    unpaired = np.flatnonzero(blocks.edge_table.unpaired())
    ends = np.stack([blocks.vertices[unpaired], blocks.vertices[blocks.following[unpaired]]], axis=1)
    _, first = np.unique(blocks.nodes, return_index=True)
    points = blocks.vertices[first]
    reach = MERGE_TOLERANCE
    edge, point = shapely.STRtree(shapely.points(points)).query(
        shapely.linestrings(ends), predicate="dwithin", distance=reach
    )
    node = blocks.nodes[first[point]]
    middle = (node != blocks.nodes[unpaired[edge]]) & (node != blocks.nodes[blocks.following[unpaired[edge]]])
    return len(np.unique(node[middle]))


def _voids(blocks: Blocks, width: float) -> tuple[int, list[float], float]:
    """Return how many narrow voids the blocks enclose, where the first is, and the area covered more than once."""
    import shapely

    middle, rounding = blocks.vertices.mean(axis=0), rounding_of(blocks.vertices)
    union = shapely.union_all(polygons_of(blocks.vertices - middle, blocks.offsets, np.arange(blocks.count)))
    parts = shapely.get_parts(union)
    holes = shapely.polygons(shapely.get_rings(parts))[_are_holes(parts)]
    wide = 2 * shapely.area(holes) / shapely.length(holes)
    narrow = (wide > max(MERGE_TOLERANCE, rounding)) & (wide < width * np.sqrt(np.median(blocks.moments.area)))
    place = [] if not narrow.any() else (shapely.get_coordinates(holes[narrow][0].centroid)[0] + middle).tolist()
    overlap = float(blocks.moments.area.sum() - union.area)
    least = 1e-12 * union.area + rounding * float(np.hypot(*blocks.edge_vectors.T).sum())
    return int(narrow.sum()), place, overlap if overlap > least else 0.0


def _are_holes(polygons: Any) -> Any:
    """Return which rings of the polygons are holes: all but the first of each."""
    import shapely

    _, owner = shapely.get_rings(polygons, return_index=True)
    return np.concatenate([[False], owner[1:] == owner[:-1]])


def quality_rows(report: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the report as rows of a table."""
    low, middle, high = report["area"]
    few, many = report["corners_per_block"]
    gap_at = report["first_at"].get("gaps")
    rows = [
        ("blocks", f"{report['blocks']}"),
        ("corners a block", f"{few}" if few == many else f"{few} to {many}"),
        ("area (least, median, greatest)", f"{low:.4g}, {middle:.4g}, {high:.4g} m2"),
        ("total area", f"{report['total_area']:.6g} m2"),
        ("total weight", engineering(report["weight"], "N/m")),
        ("shortest edge", engineering(report["shortest_edge"], "m")),
        ("contacts", f"{report['contacts']}"),
        ("stiffest over softest contact", f"{report['stiffness_ratio']:.3g}"),
        ("supported blocks", f"{report['supported_blocks']}"),
        ("separate groups of blocks", f"{report['parts']}"),
        ("T-intersections", f"{report['t_intersections']}"),
        ("narrow gaps between blocks", f"{report['gaps'] or 'none'}{_place(gap_at)}"),
        ("area covered twice", f"{report['overlap_area']:.3g} m2"),
    ]
    rows += [(f"rock {name}", counted(count, "block")) for name, count in report["rocks"].items()]
    rows += [(f"joint {name}", f"{length:.4g} m") for name, length in report["joint_lengths"].items()]
    rows += [("unjointed rock", f"{report['unjointed_length']:.4g} m")]
    rows += [(f"dangling {name}", counted(count, "piece")) for name, count in report["dangling_joints"].items()]
    rows += part_rows(report, "block edge")
    if report["bolts"]:
        alone = f", {report['bolts_in_one_block']} of them in a single block, without effect"
        rows += [("bolts", f"{report['bolts']}" + (alone if report["bolts_in_one_block"] else ""))]
    for key, meaning in _meanings(report["thresholds"]).items():
        rows.append((meaning, listed(report[key], report["first_at"].get(key))))
    return rows


def part_rows(report: dict[str, Any], side: str) -> list[tuple[str, str]]:
    """Return the rows of boundaries, by the word for a side of a block, excavations and stages."""
    rows = [(f"boundary {name}", counted(count, side)) for name, count in report["boundaries"].items()]
    rows += [(f"excavation {name}", counted(count, "block")) for name, count in report["excavations"].items()]
    return rows + [(named_stage(name), counted(count, "block")) for name, count in report["stages"].items()]


def _meanings(limits: dict[str, float]) -> dict[str, str]:
    """Return in words the fault of the blocks of each list."""
    return {
        "tiny": f"tiny blocks (area below {limits['tiny']:g} of the median)",
        "thin": f"thin blocks (4 pi A / outline^2 below {limits['thin']:g})",
        "short_edged": f"short-edged blocks (an edge below {limits['short_edged']:g} of their size)",
        "elongated": f"elongated blocks (length over width above {limits['elongated']:g})",
        "concave": "concave blocks",
        "deeply_concave": f"deeply concave blocks (area below {limits['deeply_concave']:g} of the convex hull's)",
        "many_edged": f"many-edged blocks (more than {limits['many_edged']:g} edges)",
        "without_contact": "blocks without contact",
        "unsupported": "unsupported blocks (no path of contacts to a support)",
    }


def listed(ids: Sequence[int], first_at: Sequence[float] | None) -> str:
    """Return the numbers of the first blocks of a list, and the place of the first one."""
    return (numbered("block", ids, 5) if ids else "none") + _place(first_at)


def _place(point: Sequence[float] | None) -> str:
    return "" if point is None else f", first at {place(point)}"
