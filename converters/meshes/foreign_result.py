"""Results of another program: a plane mesh with fields at its nodes and elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray, IntArray

Fields = dict[str, npt.NDArray[Any]]
NUMBERS = "iufb"  # kinds of NumPy arrays that are numbers


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ForeignResult:
    """A mesh of another program and its fields.

    Attributes
    ----------
    source : str
        The file.
    points : (n, 3) float64
        Nodes, in the file's unit.
    cell_type : (c,) int64
        VTK's numbers of the types of the surface elements.
    offsets : (c + 1,) int64
        Element i has the nodes ``connectivity[offsets[i]:offsets[i + 1]]``, in VTK's order.
    connectivity : (k,) int64
        Nodes of the elements.
    at_points, at_cells : mapping of str to (n, ...), (c, ...) array
        Fields by name: numbers only.
    length_unit : str
        Of the nodes, as the file names it; empty where it does not.
    has_elements : bool
        Whether the elements are the file's; else they are triangles between its nodes.
    """

    source: str
    points: FloatArray
    cell_type: IntArray
    offsets: IntArray
    connectivity: IntArray
    at_points: Fields
    at_cells: Fields
    length_unit: str = ""
    has_elements: bool = True

    def packed(self) -> tuple[dict[str, Any], list[npt.NDArray[Any]]]:
        """Return names and arrays, to be sent."""
        told = {"source": self.source, "at_points": list(self.at_points), "at_cells": list(self.at_cells)}
        fields = (*self.at_points.values(), *self.at_cells.values())
        return told, [self.points, self.cell_type, self.offsets, self.connectivity, *fields]

    @classmethod
    def unpacked(cls, told: dict[str, Any], arrays: Iterator[npt.NDArray[Any]]) -> ForeignResult:
        """Return the result of which names and arrays were sent."""
        points, cell_type, offsets, connectivity = (next(arrays) for _ in range(4))
        return cls(
            source=told["source"],
            points=points,
            cell_type=cell_type,
            offsets=offsets,
            connectivity=connectivity,
            at_points={name: next(arrays) for name in told["at_points"]},
            at_cells={name: next(arrays) for name in told["at_cells"]},
        )


def numbers_only(fields: Fields) -> Fields:
    """Return the fields that hold numbers, as float64, each with a row a node or element."""
    return {
        name: values.reshape(len(values), -1).astype(np.float64)
        for name, values in fields.items()
        if values.dtype.kind in NUMBERS
    }
