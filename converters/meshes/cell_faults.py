"""Faults of elements, groups and cell data, a sentence each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.errors import ModelError, counted, listing
from bsm_mesh.model.edges import LongArray

CellSets = Mapping[str, Sequence[npt.ArrayLike | None]]
CellArrays = Mapping[str, Sequence[npt.NDArray[Any]]]

VOLUMES = ("tetra", "hexa", "wedge", "pyramid", "polyhedron", "penta", "volume")
VOLUMES_VTK = ("TETRAHEDRON", "HEXAHEDRON", "WEDGE", "PYRAMID")


def group_faults(sets: CellSets, arrays: CellArrays, sizes: Sequence[int]) -> list[str]:
    """Return the faults of groups and cell data of blocks of so many elements: a sentence each."""
    faults = [
        f"the name {name!r} of a group or of cell data is no text"
        for name in (*sets, *arrays)
        if not isinstance(name, str)
    ]
    for name, members in sets.items():
        if len(members) > len(sizes):
            faults.append(
                f"group '{name}' has {len(members)} entries for {len(sizes)} blocks of elements; give one for each"
            )
        for inside, size in zip(members, sizes, strict=False):
            which = np.asarray([] if inside is None else inside)
            if not which.size:
                continue
            if which.ndim != 1 or which.dtype.kind not in "iu":
                faults.append(
                    f"group '{name}' is no list of element numbers; give whole numbers (of a mask: np.flatnonzero)"
                )
            elif which.min() < 0 or which.max() >= size:
                outside = which[(which < 0) | (which >= size)]
                faults.append(
                    f"group '{name}' has elements that are not there ({listing(outside)}; its block has {size}, "
                    "counted from 0); give those that are"
                )
    for name, blocks in arrays.items():
        lengths = [len(np.atleast_1d(np.asarray(block))) for block in blocks]
        if lengths != list(sizes):
            faults.append(
                f"cell data '{name}' has {lengths} values for blocks of {list(sizes)} elements; give one each"
            )
    return faults


def refuse_volumes(source: str, data: Sequence[tuple[str, LongArray]]) -> None:
    """Raise `ModelError` where there are volume elements among blocks of (type, nodes)."""
    volumes: dict[str, int] = {}
    for kind, nodes in data:
        if kind.startswith(VOLUMES) or kind.endswith(VOLUMES_VTK):
            volumes[kind] = volumes.get(kind, 0) + len(nodes)
    if volumes:
        found = ", ".join(f"{count} {kind}" for kind, count in volumes.items())
        raise ModelError(
            f"{source}: a three-dimensional mesh ({found} elements), but blocks are plane; "
            "mesh one cross-section and save only its surfaces and curves (in Gmsh: generate(2))"
        )


def refuse_missing_nodes(source: str, data: Sequence[tuple[str, LongArray]], n_points: int) -> None:
    """Raise `ModelError` where elements refer to nodes that are not there."""
    for kind, nodes in data:
        if nodes.size and (nodes.min() < 0 or nodes.max() >= n_points):
            bad = int(((nodes < 0) | (nodes >= n_points)).any(axis=1).sum())
            raise ModelError(
                f"{source}: {counted(bad, f'{kind} element')} with nodes that are not in the file; "
                "it is damaged or incomplete: save the mesh again"
            )


def no_surfaces(data: Sequence[tuple[str, LongArray]]) -> str:
    """Return the description of a mesh without surface elements."""
    found = ", ".join(f"{len(nodes)} {kind}" for kind, nodes in data) or "none at all"
    return (
        f"no surface elements (triangles, quadrilaterals or polygons); elements found: {found}; mesh the surfaces "
        "and save them (Gmsh leaves out surfaces in no physical group if there is any other group)"
    )
