"""Quality of polyhedra: sizes, faces of joints and how the blocks hang together, for ``bsm-mesh check``."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import counted
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import presence
from bsm_mesh.model.supports import bars_of
from bsm_mesh.text.quality import counts, listed, part_rows, parts_of
from bsm_mesh.text.tables import engineering

TROUBLE = {
    "slivers": "slivers (left out of the time step and of the verdict)",
    "without_contact": "blocks without contact",
    "unsupported": "unsupported blocks (no path of contacts to a support)",
}


def space_summary(model: Model, touching: IntArray) -> dict[str, Any]:
    """Return numbers on polyhedra, their contact polygons and supports, and the blocks that commonly make trouble.

    `touching` (k, 2) has the pairs of blocks that touch on parts of faces or at edges. Volumes are in m3, areas in m2,
    the weight in N.
    """
    blocks = model.blocks
    assert in_space(blocks)
    volume, polygons = blocks.moments.volume, blocks.contact_polygons
    held = np.unique(bars_of(model.supports, model.blocks).block)
    pairs = np.concatenate([np.stack([polygons.block_a, polygons.block_b], axis=1), touching])
    part = parts_of(blocks.count, pairs[:, 0], pairs[:, 1])
    trouble = {
        "slivers": blocks.slivers,
        "without_contact": np.setdiff1d(np.arange(blocks.count), pairs),
        "unsupported": np.flatnonzero(~np.isin(part, part[held])),
    }
    area = np.bincount(polygons.joint + 1, polygons.area, len(blocks.joint_names) + 1)
    return {
        "dimensions": 3,
        "blocks": blocks.count,
        "volume": [float(volume.min()), float(np.median(volume)), float(volume.max())],
        "total_volume": float(volume.sum()),
        "weight": float(model.weights.sum()),
        "rocks": counts(blocks.rock_names, blocks.rock),
        "contact_polygons": polygons.count,
        "touching_pairs": len(touching),
        "joint_areas": dict(zip(blocks.joint_names, area[1:].tolist(), strict=True)),
        "unjointed_area": float(area[0]),
        "boundaries": {name: len(faces) for name, faces in blocks.boundaries.items()},
        "excavations": {name: len(ids) for name, ids in blocks.excavations.items()},
        "stages": {
            stage.name: int(there.sum())
            for stage, there in zip(model.stages, presence(model.stages, model.blocks)[1:], strict=True)
        },
        "supported_blocks": len(held),
        "parts": int(part.max()) + 1,
        **{key: ids.tolist() for key, ids in trouble.items()},
        "first_at": {key: blocks.moments.centroid[ids[0]].tolist() for key, ids in trouble.items() if len(ids)},
    }


def space_rows(report: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the summary of polyhedra as rows of a table."""
    low, middle, high = report["volume"]
    rows = [
        ("blocks", f"{report['blocks']}"),
        ("volume (least, median, greatest)", f"{low:.4g}, {middle:.4g}, {high:.4g} m3"),
        ("total volume", f"{report['total_volume']:.6g} m3"),
        ("total weight", engineering(report["weight"], "N")),
        ("contact polygons (shared faces)", f"{report['contact_polygons']}"),
        ("pairs of blocks that touch on parts of faces or at edges", f"{report['touching_pairs']}"),
        ("supported blocks", f"{report['supported_blocks']}"),
        ("separate groups of blocks", f"{report['parts']}"),
    ]
    rows += [(f"rock {name}", counted(count, "block")) for name, count in report["rocks"].items()]
    rows += [(f"joint {name}", f"{area:.4g} m2") for name, area in report["joint_areas"].items()]
    rows += [("unjointed rock", f"{report['unjointed_area']:.4g} m2")]
    rows += part_rows(report, "face")
    return rows + [(meaning, listed(report[key], report["first_at"].get(key))) for key, meaning in TROUBLE.items()]
