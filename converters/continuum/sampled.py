"""Fields of another program averaged over blocks: sampled by VTK at integration points of the blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.continuum.foreign_fields import PlaneFields
from bsm_mesh.converters.meshes.foreign_result import ForeignResult
from bsm_mesh.converters.vtk_files import Grid, sample
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.solve.zones.mesh import Discretization, continuum_mesh

INTEGRATION = 4  # order of the polynomials that are averaged exactly
FINEST = 4  # halvings of the blocks' cells, where the other mesh is finer
LEAST = 2  # the same where fields jump from element to element
FLAT = 1e-6  # of the mesh's size: what nodes may lie off the plane z = constant


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BlockAverages:
    """Averages of fields over blocks.

    Attributes
    ----------
    fields : mapping of str to (n,) float64
        By name; 0 where nothing covers a block.
    covered : (n,) float64
        Share of each block's area that the other mesh covers.
    """

    fields: Mapping[str, FloatArray]
    covered: FloatArray


def block_averages_of(result: ForeignResult, fields: PlaneFields, blocks: Blocks, length: float) -> BlockAverages:
    """Return the averages over blocks of fields given on another mesh.

    Parameters
    ----------
    result : ForeignResult
        The mesh, in the plane of x and y.
    fields : PlaneFields
        At its nodes, between which they are interpolated, or constant in its elements.
    blocks : Blocks
        Over which is averaged.
    length : float [m]
        The unit of the mesh.

    Raises
    ------
    ModelError
        If the mesh is not in the plane of x and y, or covers no block.
    """
    import skfem

    points = result.points * length
    size = float(np.ptp(points, axis=0).max())
    if np.ptp(points[:, 2]) > FLAT * size:
        raise ModelError(f"{result.source}: its nodes lie not in a plane of x and y; turn it, or give a section")
    halvings = max(_halvings(blocks, size, len(result.cell_type)), LEAST if fields.cell else 0)
    mesh = continuum_mesh(blocks, Discretization(refinements=halvings))
    kind = skfem.ElementQuad1() if mesh.are_quads else skfem.ElementTriP1()
    basis = skfem.CellBasis(mesh.mesh, kind, intorder=INTEGRATION)
    x, y = np.asarray(basis.global_coordinates())
    valid, values = sample(grid_of(result, fields, length), np.column_stack([x.ravel(), y.ravel()]))
    weight = basis.dx * valid.reshape(basis.dx.shape)
    area = np.bincount(mesh.block, weight.sum(axis=1), minlength=blocks.count)
    if not area.any():
        raise ModelError(
            f"{result.source}: its mesh ({_extent(points)}) covers no block ({_extent(blocks.vertices)}); see to its "
            "unit of length (--length) and origin"
        )
    sums = {
        name: np.bincount(mesh.block, (weight * of.reshape(weight.shape)).sum(axis=1), minlength=blocks.count)
        for name, of in values.items()
    }
    divisor = np.where(area > 0, area, 1.0)
    return BlockAverages(
        fields={name: total / divisor for name, total in sums.items()}, covered=area / blocks.moments.area
    )


def grid_of(result: ForeignResult, fields: PlaneFields, length: float = 1.0) -> Grid:
    """Return a mesh in the plane with its fields, to be sampled; `length` [m] is the unit of the mesh."""
    return Grid(
        points=length * result.points[:, :2],
        offsets=result.offsets,
        connectivity=result.connectivity,
        cell_type=result.cell_type,
        point_data=dict(fields.point),
        cell_data=dict(fields.cell),
    )


def _halvings(blocks: Blocks, size: float, elements: int) -> int:
    """Return how often the blocks' cells are halved to be no larger than the elements of the other mesh, about."""
    own = float(np.sqrt(blocks.moments.area.mean() / 2))
    other = size / np.sqrt(max(elements, 1))
    return int(np.clip(np.ceil(np.log2(own / other)), 0, FINEST))


def _extent(points: FloatArray) -> str:
    (x0, y0), (x1, y1) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    return f"x {x0:.4g} to {x1:.4g}, y {y0:.4g} to {y1:.4g} m"
