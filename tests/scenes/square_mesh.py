"""Four squares as a mesh in text, MSH 4.1 and MSH 2.2: as they are, or with other nodes, squares and groups."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence

NODES: list[Sequence[object]] = [(x, y) for y in range(3) for x in range(3)]
QUADS = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
CURVES = {"boundary:bottom": [(0, 1), (1, 2)], "boundary:top": [(6, 7), (7, 8)], "joint:J1": [(3, 4), (4, 5)]}
SURFACE = "rock:gneiss"


Group = tuple[int, str | None, Sequence[Sequence[int]]]  # dimension, name, nodes of each element


def msh(
    nodes: Sequence[Sequence[object]] = NODES,
    quads: Sequence[Sequence[int]] = QUADS,
    curves: Mapping[str, Sequence[tuple[int, int]]] = CURVES,
    surface: str = SURFACE,
) -> str:
    """Return four squares as MSH 4.1, with a joint halfway up."""
    return msh_of(nodes, [(2, surface, quads), *((1, name, pairs) for name, pairs in curves.items())], "4.1")


def msh22(
    nodes: Sequence[Sequence[object]] = NODES,
    quads: Sequence[Sequence[int]] = QUADS,
    curves: Mapping[str, Sequence[tuple[int, int]]] = CURVES,
    surface: str = SURFACE,
    more: Mapping[str, Sequence[Sequence[int]]] | None = None,
) -> str:
    """Return the same as MSH 2.2, which meshio reads; squares of `more` surfaces stand twice."""
    surfaces = {surface: quads, **(more or {})}
    groups: list[Group] = [(1, name, pairs) for name, pairs in curves.items()]
    return msh_of(nodes, groups + [(2, name, cells) for name, cells in surfaces.items()], "2.2")


def msh_of(nodes: Sequence[Sequence[object]], groups: Sequence[Group], version: str) -> str:
    """Return a mesh of any groups, several of one name or without a name among them, as MSH 4.1 or 2.2."""
    named = [(dimension, tag, name) for tag, (dimension, name, _) in enumerate(groups, start=1) if name is not None]
    lines = ["$MeshFormat", f"{version} 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(named))]
    lines += [f'{dimension} {tag} "{name}"' for dimension, tag, name in named]
    lines += ["$EndPhysicalNames", *(_lines_41 if version == "4.1" else _lines_22)(nodes, groups)]
    return "\n".join([*lines, "$EndElements", ""])


def _lines_41(nodes: Sequence[Sequence[object]], groups: Sequence[Group]) -> Iterator[str]:
    """Yield entities, nodes and elements; each group is an entity of its own."""
    tags = {d: [tag for tag, (dimension, *_) in enumerate(groups, start=1) if dimension == d] for d in (1, 2)}
    yield from ("$Entities", f"0 {len(tags[1])} {len(tags[2])} 0")
    yield from (f"{tag} 0 0 0 1 1 0 1 {tag} 0" for tag in tags[1] + tags[2])
    yield from ("$EndEntities", "$Nodes", f"1 {len(nodes)} 1 {len(nodes)}", f"2 {tags[2][0]} 0 {len(nodes)}")
    yield from (str(k + 1) for k in range(len(nodes)))
    yield from (" ".join(str(c) for c in (*node, 0)[:3]) for node in nodes)
    runs = [
        (dimension, tag, size, list(cells))
        for tag, (dimension, _, of) in enumerate(groups, start=1)
        for size, cells in itertools.groupby(of, key=len)
    ]
    count = sum(len(cells) for *_, cells in runs)
    yield from ("$EndNodes", "$Elements", f"{len(runs)} {count} 1 {count}")
    number = itertools.count(1)
    for dimension, tag, size, cells in runs:
        yield f"{dimension} {tag} {size - 1} {len(cells)}"
        yield from (f"{next(number)} {' '.join(str(c + 1) for c in corners)}" for corners in cells)


def _lines_22(nodes: Sequence[Sequence[object]], groups: Sequence[Group]) -> Iterator[str]:
    """Yield nodes and elements, each with the number of its group."""
    yield from ("$Nodes", str(len(nodes)))
    yield from (f"{k} {' '.join(str(c) for c in (*node, 0)[:3])}" for k, node in enumerate(nodes, start=1))
    elements = [(tag, corners) for tag, (_, _, cells) in enumerate(groups, start=1) for corners in cells]
    yield from ("$EndNodes", "$Elements", str(len(elements)))
    for k, (tag, corners) in enumerate(elements, start=1):
        yield f"{k} {len(corners) - 1} 2 {tag} {tag} {' '.join(str(c + 1) for c in corners)}"
