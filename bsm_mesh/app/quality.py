"""Quality of the blocks: sizes, shapes and how they hang together, for ``bsm-mesh check``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.app.tables import engineering
from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import listing
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.model import Model
from bsm_mesh.model.polygons import convex_polygons
from bsm_mesh.model.stages import presence

if TYPE_CHECKING:
    from bsm_mesh.solve.system import LinearSystem

TINY_AREA = 1e-3  # of the median area
THIN_ASPECT = 0.05  # 4 pi area / outline^2 is 1 for a circle, 0.6 for an equilateral triangle
SHORT_EDGE = 0.01  # of the square root of the block's area


def quality_summary(model: Model, system: LinearSystem) -> dict[str, Any]:
    """Return numbers on the blocks and the lists of those that commonly make trouble."""
    blocks = model.blocks
    area = blocks.moments.area
    edge = np.hypot(*blocks.edge_vectors.T)
    outline = np.add.reduceat(edge, blocks.offsets[:-1])
    shortest = np.minimum.reduceat(edge, blocks.offsets[:-1])
    roundness = 4 * np.pi * area / outline**2
    contacts = system.contacts
    jointed = contacts.joint >= 0
    poor = {
        "tiny": np.flatnonzero(area < TINY_AREA * np.median(area)),
        "thin": np.flatnonzero(roundness < THIN_ASPECT),
        "short_edged": np.flatnonzero(shortest < SHORT_EDGE * np.sqrt(area)),
        "concave": np.flatnonzero(~convex_polygons(blocks.vertices, blocks.offsets)),
        "without_contact": _without_contact(blocks, system),
    }
    return {
        "blocks": blocks.count,
        "corners_per_block": [int(np.diff(blocks.offsets).min()), int(np.diff(blocks.offsets).max())],
        "area": [float(area.min()), float(np.median(area)), float(area.max())],
        "total_area": float(area.sum()),
        "shortest_edge": float(edge.min()),
        "weight": float(model.weights.sum()),
        "rocks": _counts(blocks.rock_names, blocks.rock),
        "contacts": contacts.count,
        "joint_lengths": {
            joint.name: float(contacts.length[contacts.joint == k].sum()) for k, joint in enumerate(model.joints)
        },
        "unjointed_length": float(contacts.length[~jointed].sum()),
        "boundaries": {name: len(edges) for name, edges in blocks.boundaries.items()},
        "excavations": {name: len(ids) for name, ids in blocks.excavations.items()},
        "stages": {
            stage.name: int(there.sum())
            for stage, there in zip(model.stages, presence(model.stages, blocks)[1:], strict=True)
        },
        "supported_blocks": len(system.constraints.block),
        "stiffness_ratio": float(contacts.normal_stiffness.max() / contacts.normal_stiffness.min())
        if contacts.count
        else 1.0,
        **{key: ids.tolist() for key, ids in poor.items()},
        "first_at": {key: blocks.moments.centroid[ids[0]].tolist() for key, ids in poor.items() if ids.size},
    }


def _counts(names: tuple[str, ...], index: Any) -> dict[str, int]:
    counts = np.bincount(index, minlength=len(names))
    return {name: int(count) for name, count in zip(names, counts, strict=True)}


def _without_contact(blocks: Blocks, system: LinearSystem) -> IntArray:
    touched = np.zeros(blocks.count, dtype=bool)
    touched[system.contacts.block_a] = touched[system.contacts.block_b] = True
    return np.flatnonzero(~touched)


def quality_rows(report: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the report as rows of a table."""
    low, middle, high = report["area"]
    few, many = report["corners_per_block"]
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
    ]
    rows += [(f"rock {name}", f"{count} blocks") for name, count in report["rocks"].items()]
    rows += [(f"joint {name}", f"{length:.4g} m") for name, length in report["joint_lengths"].items()]
    rows += [("unjointed faces", f"{report['unjointed_length']:.4g} m")]
    rows += [(f"boundary {name}", f"{count} edges") for name, count in report["boundaries"].items()]
    rows += [(f"excavation {name}", f"{count} blocks") for name, count in report["excavations"].items()]
    rows += [(f"stage {name}", f"{count} blocks") for name, count in report["stages"].items()]
    for key, meaning in (
        ("tiny", f"tiny blocks (area below {TINY_AREA:g} of the median)"),
        ("thin", f"thin blocks (4 pi A / outline^2 below {THIN_ASPECT:g})"),
        ("short_edged", f"blocks with an edge below {SHORT_EDGE:g} of their size"),
        ("concave", "concave blocks"),
        ("without_contact", "blocks without contact"),
    ):
        first = report["first_at"].get(key)
        place = "" if first is None else f", first at ({first[0]:.4g}, {first[1]:.4g})"
        rows.append((meaning, (listing(report[key], 5) or "none") + place))
    return rows
