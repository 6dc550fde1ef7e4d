"""The comparison with the continuum as a VTU file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.continuum.comparison import Comparison
from bsm_mesh.converters.stress_components import six_components
from bsm_mesh.converters.vtk_files import Grid, spatial, write_vtu
from bsm_mesh.converters.vtk_library import LINE, POLYGON, VERTEX, numbered
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.submodel import some_blocks
from bsm_mesh.results.stress import principal_stresses


def write_comparison(comparison: Comparison, blocks: Blocks, path: Path) -> None:
    """Write stresses and displacements of both methods and their difference, a polygon a block that is there.

    Arrays without a suffix are the Block-Spring Model's; ``_fem`` are the continuum's (stresses with the rocks' own
    E and Poisson's ratio, displacements with the matched ones), ``_difference`` the first less the second.

    Raises
    ------
    ModelError
        If the file cannot be written.
    """
    write_sides(
        path,
        blocks,
        comparison.present,
        stress=(comparison.stress, comparison.nominal.stress),
        displacement=(comparison.displacement, comparison.matched.displacement),
    )


def write_sides(
    path: Path,
    blocks: Blocks,
    present: BoolArray,
    *,
    stress: tuple[FloatArray, FloatArray] | None,
    displacement: tuple[FloatArray, FloatArray] | None,
) -> None:
    """Write fields of two methods and their difference, with the names of `write_comparison`.

    Parameters
    ----------
    path : Path
        Of the file.
    blocks : Blocks
        As given.
    present : (n,) bool
        The blocks that are written.
    stress : pair of (n, 2, 2) float64 [Pa]
        Of both methods; None: neither is written.
    displacement : pair of (n, 2 or more) float64 [m]
        u and v first, of both methods; None: neither is written.

    Raises
    ------
    ModelError
        If the file cannot be written.
    """
    there = np.flatnonzero(present)
    cells: dict[str, Any] = {"block_id": there.astype(np.int32)}
    if stress is not None:
        bsm, fem = (of[there] for of in stress)
        ours, theirs = principal_stresses(bsm)[0], principal_stresses(fem)[0]
        cells |= _with_difference("stress", six_components(bsm), six_components(fem))
        cells |= _with_difference("sigma_1", ours, theirs)
    if displacement is not None:
        cells |= _with_difference("displacement", *(spatial(of[there, :2]) for of in displacement))
    left = some_blocks(blocks, present)
    grid = Grid(
        points=left.vertices,
        offsets=left.offsets,
        connectivity=np.arange(len(left.vertices)),
        cell_type=POLYGON,
        cell_data=cells,
        units=_units(stress="Pa", sigma_1="Pa", displacement="m"),
    )
    _write(path, grid)


def write_bolts(comparison: Comparison, path: Path) -> None:
    """Write the bolts with their tensions by both methods and the difference, a line an element at its first place.

    Raises
    ------
    ModelError
        If the file cannot be written.
    """
    ours, theirs = comparison.bolts, comparison.nominal.bolts
    first = ours.first_node
    grid = Grid(
        points=ours.original,
        offsets=2 * np.arange(len(first) + 1),
        connectivity=np.stack([first, first + 1], axis=1).reshape(-1),
        cell_type=LINE,
        cell_data={
            "bolt": ours.bolt,
            "alive": ours.alive.astype(np.uint8),
            **_with_difference("axial_force", ours.axial_force, theirs.axial_force),
            **_with_difference("shear_force", ours.shear_force, theirs.shear_force),
        },
        names=numbered("bolt", ours.names),
        units=_units(axial_force="N", shear_force="N"),
    )
    _write(path, grid)


def write_joints(comparison: Comparison, path: Path) -> None:
    """Write opening and slip of joints by both methods and the difference, a vertex a point of the interfaces.

    Pressure and shear there are the continuum's: blocks have them at points of their own.

    Raises
    ------
    ModelError
        If the file cannot be written.
    """
    points, ours = comparison.nominal.contacts, comparison.joint_movement
    assert ours is not None
    count = len(points.length)
    grid = Grid(
        points=points.point,
        offsets=np.arange(count + 1),
        connectivity=np.arange(count),
        cell_type=VERTEX,
        cell_data={
            "block_a": points.block_a,
            "block_b": points.block_b,
            "joint": points.joint,
            "length": points.length,
            **_with_difference("opening", ours.opening, points.opening),
            **_with_difference("slip", ours.slip, points.slip),
            "normal_force_fem": points.normal_force,
            "shear_force_fem": points.shear_force,
        },
        units=_units(opening="m", slip="m") | {"length": "m", "normal_force_fem": "N/m", "shear_force_fem": "N/m"},
    )
    _write(path, grid)


def _units(**units: str) -> dict[str, str]:
    """Return the units of arrays of both methods and of their differences."""
    return {f"{name}{end}": unit for name, unit in units.items() for end in ("", "_fem", "_difference")}


def _write(path: Path, grid: Grid) -> None:
    try:
        write_vtu(path, grid, parents=True)
    except OSError as error:
        raise ModelError(f"cannot write {path}: {error.strerror or error}; choose another folder") from error


def _with_difference(name: str, one: FloatArray, other: FloatArray) -> dict[str, FloatArray]:
    return {name: one, f"{name}_fem": other, f"{name}_difference": one - other}
