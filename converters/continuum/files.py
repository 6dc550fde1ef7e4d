"""The comparison with the continuum as a VTU file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bsm_mesh.converters.continuum.comparison import Comparison
from bsm_mesh.converters.result_files import six_components
from bsm_mesh.converters.vtk_files import POLYGON, Grid, spatial, write_vtu
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
    there = np.flatnonzero(comparison.present)
    fem, bsm = comparison.nominal.stress[there], comparison.stress[there]
    ours, theirs = principal_stresses(bsm)[0], principal_stresses(fem)[0]
    cells = {
        "block_id": there.astype(np.int32),
        "stress": six_components(bsm),
        "stress_fem": six_components(fem),
        "stress_difference": six_components(bsm - fem),
        "sigma_1": ours,
        "sigma_1_fem": theirs,
        "sigma_1_difference": ours - theirs,
        "displacement": spatial(comparison.displacement[there, :2]),
        "displacement_fem": spatial(comparison.matched.displacement[there, :2]),
        "displacement_difference": spatial(comparison.displacement_difference[there, :2]),
    }
    left = some_blocks(blocks, comparison.present)
    grid = Grid(
        points=left.vertices,
        offsets=left.offsets,
        connectivity=np.arange(len(left.vertices)),
        cell_type=POLYGON,
        cell_data=cells,
    )
    try:
        write_vtu(path, grid, parents=True)
    except OSError as error:
        raise ModelError(f"cannot write {path}: {error.strerror or error}; choose another folder") from error
