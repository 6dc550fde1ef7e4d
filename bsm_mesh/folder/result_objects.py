"""Results as objects of other libraries: a meshio mesh, a PyVista grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bsm_mesh.errors import ModelError
from bsm_mesh.text.headings import stage_number

if TYPE_CHECKING:
    from bsm_mesh.converters.vtk_files import Grid
    from bsm_mesh.results.results import Results


def grid_of(results: Results, kind: str, stage: int | str) -> Grid:
    """Return the grid of a kind at the end of a stage.

    Raises
    ------
    ModelError
        If there is no such stage, or it has no such grid.
    """
    from bsm_mesh.converters.result_files import grid_of_stage, kinds_of

    number = stage_number(results, stage)
    known = kinds_of(results.stages[number])
    if kind not in known:
        raise ModelError(f"stage {number} has no '{kind}'; it has {', '.join(known)}")
    return grid_of_stage(kind, results, results.stages[number], number)


def to_meshio(results: Results, kind: str, stage: int | str) -> Any:
    """Return what ``meshio.read`` returns of the file of a kind; parameters and errors as for `grid_of`."""
    from bsm_mesh.converters.meshio_library import mesh_of_grid

    return mesh_of_grid(grid_of(results, kind, stage))


def to_pyvista(results: Results, kind: str, stage: int | str) -> Any:
    """Return what ``pyvista.read`` returns of the file of a kind, with names as text arrays besides.

    Raises
    ------
    ModelError
        As `grid_of`; or if PyVista is not there.
    """
    from bsm_mesh.converters.vtk_files import texts_of, vtk_of_grid

    grid = grid_of(results, kind, stage)
    try:
        import pyvista
    except ImportError:
        raise ModelError("to_pyvista needs the Python package 'pyvista'; install it: pip install pyvista") from None
    made = pyvista.wrap(vtk_of_grid(grid))
    for name, texts in texts_of(grid).items():
        made.cell_data[name] = texts
    return made
