"""What `Model` and `Results` hand themselves to: pictures, notebooks, files and other forms.

The one place where data name what lies above them (`tests/test_architecture.py`); imported when first asked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bsm_mesh.lazy import names_from

if TYPE_CHECKING:
    from bsm_mesh.folder.result_objects import to_meshio, to_pyvista
    from bsm_mesh.folder.result_tables import OutputForm, to_pandas
    from bsm_mesh.folder.storage import load_results, save_results
    from bsm_mesh.pages.notebook import model_html, results_html, safety_html
    from bsm_mesh.pictures.plotting import plot_model, plot_results

__all__ = [
    "OutputForm",
    "load_results",
    "model_html",
    "plot_model",
    "plot_results",
    "results_html",
    "safety_html",
    "save_results",
    "to_meshio",
    "to_pandas",
    "to_pyvista",
]

HOMES = {
    "OutputForm": "bsm_mesh.folder.result_tables",
    "load_results": "bsm_mesh.folder.storage",
    "model_html": "bsm_mesh.pages.notebook",
    "plot_model": "bsm_mesh.pictures.plotting",
    "plot_results": "bsm_mesh.pictures.plotting",
    "results_html": "bsm_mesh.pages.notebook",
    "safety_html": "bsm_mesh.pages.notebook",
    "save_results": "bsm_mesh.folder.storage",
    "to_meshio": "bsm_mesh.folder.result_objects",
    "to_pandas": "bsm_mesh.folder.result_tables",
    "to_pyvista": "bsm_mesh.folder.result_objects",
}

if not TYPE_CHECKING:
    __getattr__ = names_from(HOMES, __name__)
