"""Random lines over a mesh, and whether all of them is there once they are laid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely

from bsm_mesh.model import Blocks
from bsm_mesh.model.overlap import find_overlaps

KINDS = ("through", "inside", "short", "broken", "curve", "nodes", "edge", "rim", "by the rim", "rim to rim", "grazing")


def domain_of(blocks: Blocks) -> Any:
    """Return the area that blocks cover."""
    polygons = shapely.polygons(shapely.linearrings(blocks.vertices, indices=blocks.owner))
    return shapely.union_all(polygons)


def random_line(kind: str, blocks: Blocks, rng: np.random.Generator) -> np.ndarray:
    """Return the points of a line of a kind."""
    low, high = blocks.vertices.min(axis=0), blocks.vertices.max(axis=0)
    size = float(np.sqrt(np.median(blocks.moments.area)))
    rim = np.flatnonzero(blocks.edge_table.unpaired())
    start, end = blocks.vertices, blocks.vertices[blocks.following]
    anywhere = rng.uniform(low, high, (12, 2))
    turn = np.exp(1j * rng.uniform(0, 2 * np.pi))
    direction = np.array([turn.real, turn.imag])
    far = float(np.hypot(*(high - low)))
    match kind:
        case "through":
            return np.array([anywhere[0] - far * direction, anywhere[0] + far * direction])
        case "inside":
            return anywhere[:2]
        case "short":
            return np.array([anywhere[0], anywhere[0] + 0.2 * size * rng.uniform() * direction])
        case "broken":
            return anywhere[: rng.integers(3, 12)]
        case "curve":
            share = np.linspace(0, 1, 80)[:, None]
            wave = np.sin(5 * share) * np.array([-direction[1], direction[0]]) * size * rng.uniform(0.1, 3)
            return (1 - share) * anywhere[0] + share * anywhere[1] + wave
        case "nodes":
            one, other = blocks.vertices[rng.choice(len(blocks.vertices), 2, replace=False)]
            reach = rng.choice([0.0, 0.3]) * (other - one)
            return np.array([one - reach, other + reach])
        case "edge":
            edge = rng.integers(len(start))
            reach = rng.choice([0.0, -0.3, 0.7]) * (end[edge] - start[edge])
            return np.array([start[edge] - reach, end[edge] + reach])
        case "rim":
            edge = rng.choice(rim)
            reach = rng.choice([0.0, -0.3]) * (end[edge] - start[edge])
            return np.array([start[edge] - reach, end[edge] + reach])
        case "by the rim":
            edge = rng.choice(rim)
            along = (end[edge] - start[edge]) / np.hypot(*(end[edge] - start[edge]))
            off = 10 ** rng.uniform(-5, -1) * size * np.array([-along[1], along[0]])
            return np.array([start[edge] + off - 5 * along, start[edge] + off + 5 * along])
        case "rim to rim":
            edges, share = rng.choice(rim, 2, replace=False), rng.uniform(size=(2, 1))
            return (1 - share) * start[edges] + share * end[edges]
    edge = rng.integers(len(start))
    vector = end[edge] - start[edge]
    off = 10 ** rng.uniform(-6, -2) * np.array([-vector[1], vector[0]]) * rng.choice([-1, 1])
    return np.array([start[edge] - 2 * vector - off, end[edge] + 2 * vector + off])


def grouped(blocks: Blocks) -> Blocks:
    """Return blocks of a mesh without groups in two rocks, an excavation, a joint, and boundaries in and around it."""
    x, y = blocks.moments.centroid.T
    middle = (blocks.vertices + blocks.vertices[blocks.following]) / 2
    rim = blocks.edge_table.unpaired()
    upper = (y > 4).astype(np.int32)
    one, other = blocks.edge_table.pairs()
    border = upper[blocks.owner[one]] != upper[blocks.owner[other]]
    east = np.concatenate([one[border], other[border]])
    return replace(
        blocks,
        rock=upper,
        rock_names=("lower", "upper"),
        boundaries={
            "base": np.flatnonzero(rim & (middle[:, 1] < 1e-6)),
            "east": np.flatnonzero(rim & (middle[:, 0] > 24 - 1e-6)),
            "border": east[middle[east, 0] > 12],
        },
        excavations={"1": np.flatnonzero((x > 15) & (x < 20) & (y > 5) & (y < 10))},
    )


GRAZING = 1e-6  # of an element: what lies that near to the rim may be on it
CLOSE = ("by the rim", "grazing")  # lines that may lie so


def faults_of(
    given: Blocks, laid: Blocks, lines: dict[str, list[np.ndarray]], *, on_rim: bool = False, close: bool = False
) -> list[str]:
    """Return the faults of blocks in which lines of joints are laid; nothing for most.

    `on_rim`: the lines lie on the rim, to rounding; `close`: they may lie near it for some way.
    """
    found = []
    before, after = _inventory(given), _inventory(laid)
    for name, amount in before.items():
        if abs(after.get(name, 0.0) - amount) > 1e-9 * amount:
            found.append(f"{name}: {after.get(name, 0.0)!r} instead of {amount!r}")
    if len(find_overlaps(laid.vertices, laid.offsets, laid.nodes, laid.edge_table).pairs):
        found.append("overlaps")
    size = float(np.sqrt(np.median(given.moments.area)))
    for joint, some in lines.items():
        length = length_laid(given, laid, joint, some, "rim" if on_rim else "grazing" if close else "")
        if abs(length.laid - length.near) > 1e-9 * max(length.near, 1e-3):
            found.append(f"{length.laid!r} of {length.near!r} m of {joint} laid")
        edges = _edges_of(laid, joint)
        drawn = shapely.union_all([shapely.linestrings(line) for line in some])
        if len(edges) and shapely.distance(drawn, shapely.points(laid.vertices[edges])).max() > 1e-6 * size:
            found.append(f"{joint} is off its line")
    return found


@dataclass(frozen=True)
class LaidLength:
    """A joint's length as it is laid, and the nearest length of its lines that lies in the rock [m]."""

    laid: float
    near: float


def length_laid(given: Blocks, laid: Blocks, joint: str, lines: list[np.ndarray], kind: str) -> LaidLength:
    """Return the length of a joint that is laid along lines of a kind, by Shapely beside it.

    Lines on the rim, or near it for some way, have a least and a greatest length in the rock.
    """
    domain, size = domain_of(given), float(np.sqrt(np.median(given.moments.area)))
    near = GRAZING * size if kind in CLOSE else 1e-9
    drawn = shapely.union_all([shapely.linestrings(line) for line in lines])
    least = float(shapely.length(drawn if kind == "rim" else shapely.intersection(drawn, domain)))
    most = float(shapely.length(shapely.intersection(drawn, shapely.buffer(domain, near, join_style="mitre"))))
    length = _once(laid, _edges_of(laid, joint))
    return LaidLength(laid=length, near=min(max(length, least), most))


def _edges_of(blocks: Blocks, joint: str) -> np.ndarray:
    number = blocks.joint_names.index(joint) if joint in blocks.joint_names else len(blocks.joint_names)
    return np.flatnonzero(blocks.edge_joint == number)


def _once(blocks: Blocks, edges: np.ndarray) -> float:
    ends = np.stack([blocks.nodes[edges], blocks.nodes[blocks.following[edges]]], axis=1)
    _, first = np.unique(np.sort(ends, axis=1), axis=0, return_index=True)
    return float(np.hypot(*blocks.edge_vectors[edges[first]].T).sum())


def _inventory(blocks: Blocks) -> dict[str, float]:
    """Return areas of rocks and excavations, and lengths of boundaries and of the rim."""
    area = blocks.moments.area
    areas = np.bincount(blocks.rock, area, minlength=len(blocks.rock_names))
    return {
        "area": float(area.sum()),
        "rim": _once(blocks, np.flatnonzero(blocks.edge_table.unpaired())),
        **{f"rock {name}": float(area) for name, area in zip(blocks.rock_names, areas, strict=True)},
        **{f"excavation {name}": float(area[ids].sum()) for name, ids in blocks.excavations.items()},
        **{f"boundary {name}": _once(blocks, edges) for name, edges in blocks.boundaries.items()},
    }
