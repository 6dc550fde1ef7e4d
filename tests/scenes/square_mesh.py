"""Four squares as a mesh in text, MSH 4.1 and MSH 2.2: as they are, or with other nodes, squares and groups."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

NODES: list[Sequence[object]] = [(x, y) for y in range(3) for x in range(3)]
QUADS = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
CURVES = {"boundary:bottom": [(0, 1), (1, 2)], "boundary:top": [(6, 7), (7, 8)], "joint:J1": [(3, 4), (4, 5)]}
SURFACE = "rock:gneiss"


def msh(
    nodes: Sequence[Sequence[object]] = NODES,
    quads: Sequence[Sequence[int]] = QUADS,
    curves: dict[str, list[tuple[int, int]]] = CURVES,
    surface: str = SURFACE,
) -> str:
    """Return four squares as MSH 4.1, with a joint halfway up."""
    groups = [(2, surface, quads), *((1, name, pairs) for name, pairs in curves.items())]
    numbered = [(dimension, tag, cells) for tag, (dimension, _, cells) in enumerate(groups, start=1) if cells]
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    lines += [f'{dimension} {tag} "{name}"' for tag, (dimension, name, _) in enumerate(groups, start=1)]
    lines += ["$EndPhysicalNames", "$Entities", f"0 {len(groups) - 1} 1 0"]
    lines += [f"{tag} 0 0 0 1 1 0 1 {tag} 0" for tag in (*range(2, len(groups) + 1), 1)]
    lines += ["$EndEntities", "$Nodes", f"1 {len(nodes)} 1 {len(nodes)}", f"2 1 0 {len(nodes)}"]
    lines += [str(k + 1) for k in range(len(nodes))]
    lines += [" ".join(str(c) for c in (*node, 0)[:3]) for node in nodes]
    count = sum(len(cells) for _, _, cells in numbered)
    lines += ["$EndNodes", "$Elements", f"{len(numbered)} {count} 1 {count}"]
    number = itertools.count(1)
    for dimension, tag, cells in numbered:
        lines.append(f"{dimension} {tag} {3 if dimension == 2 else 1} {len(cells)}")
        lines += [f"{next(number)} {' '.join(str(c + 1) for c in corners)}" for corners in cells]
    return "\n".join([*lines, "$EndElements", ""])


def msh22(
    nodes: Sequence[Sequence[object]] = NODES,
    quads: Sequence[Sequence[int]] = QUADS,
    curves: Mapping[str, Sequence[tuple[int, int]]] = CURVES,
    surface: str = SURFACE,
    more: Mapping[str, Sequence[Sequence[int]]] | None = None,
) -> str:
    """Return the same as MSH 2.2, which meshio reads; squares of `more` surfaces stand twice."""
    surfaces = {surface: quads, **(more or {})}
    groups = [(1, name, pairs) for name, pairs in curves.items()] + [(2, name, q) for name, q in surfaces.items()]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    lines += [f'{dimension} {tag} "{name}"' for tag, (dimension, name, _) in enumerate(groups, start=1)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += [f"{k} {' '.join(str(c) for c in (*node, 0)[:3])}" for k, node in enumerate(nodes, start=1)]
    elements = [(dimension, tag, e) for tag, (dimension, _, cells) in enumerate(groups, start=1) for e in cells]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for k, (dimension, tag, corners) in enumerate(elements, start=1):
        lines.append(f"{k} {3 if dimension == 2 else 1} 2 {tag} {tag} {' '.join(str(c + 1) for c in corners)}")
    return "\n".join([*lines, "$EndElements", ""])
