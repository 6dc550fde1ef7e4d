"""Cells that make up blocks: a conforming complex, as cutting leaves it, and the arrays of its blocks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray


class Cells(Protocol):
    """A conforming complex of convex cells, as `geometries.three_d` cuts it; arrays as in `Polyhedra`.

    Cells have a rock, an index in `rock_names`, and an excavation, an index in `excavation_names` or -1.
    """

    @property
    def vertices(self) -> FloatArray: ...  # noqa: D102

    @property
    def face_vertices(self) -> IntArray: ...  # noqa: D102

    @property
    def face_offsets(self) -> IntArray: ...  # noqa: D102

    @property
    def face_cells(self) -> IntArray: ...  # noqa: D102

    @property
    def face_joint(self) -> IntArray: ...  # noqa: D102

    @property
    def joint_names(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def boundaries(self) -> Mapping[str, IntArray]: ...  # noqa: D102

    @property
    def cell_rock(self) -> IntArray: ...  # noqa: D102

    @property
    def rock_names(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def cell_excavation(self) -> IntArray: ...  # noqa: D102

    @property
    def excavation_names(self) -> tuple[str, ...]: ...  # noqa: D102


def arrays_of_cells(cells: Cells, *, whole: bool = False) -> dict[str, Any]:
    """Return the arrays of `Polyhedra`.

    One block are cells of one rock and excavation across faces without a joint; `whole`: each cell is a block.
    """
    first, second = np.asarray(cells.face_cells).T
    count, region = len(cells.cell_rock), np.stack([cells.cell_rock, cells.cell_excavation], axis=1)
    tied: BoolArray = (second >= 0) & (np.asarray(cells.face_joint) < 0) & (region[first] == region[second]).all(axis=1)
    tied &= not whole
    graph = coo_array((np.ones(tied.sum()), (first[tied], second[tied])), shape=(count, count))
    _, block, of_cell = np.unique(
        connected_components(graph, directed=False)[1], return_index=True, return_inverse=True
    )
    order = np.argsort(block)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    leading = block[order]
    names = ("vertices", "face_vertices", "face_offsets", "face_cells", "face_joint", "rock_names", "joint_names")
    return {name: getattr(cells, name) for name in (*names, "boundaries")} | {
        "cell_block": number[of_cell.reshape(-1)].astype(np.int32),
        "rock": np.asarray(cells.cell_rock)[leading].astype(np.int32),
        "excavations": {
            name: np.flatnonzero(np.asarray(cells.cell_excavation)[leading] == k).astype(np.int32)
            for k, name in enumerate(cells.excavation_names)
        },
    }
