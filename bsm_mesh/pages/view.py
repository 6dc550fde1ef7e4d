"""The command ``view``: a results folder as one page to explore in a browser."""

from __future__ import annotations

from pathlib import Path

from bsm_mesh.files import write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.saved_results import SavedResults, damage_told, find_results
from bsm_mesh.pages.view_data import read_view
from bsm_mesh.pages.view_page import page_of
from bsm_mesh.pages.view_space import space_page_of, view_of_space
from bsm_mesh.text.headings import heading

VIEW = "view.html"


def write_view(out: Path) -> Path:
    """Write the page of a results folder into it and return its path.

    Raises
    ------
    ModelError
        If the folder holds no results, or they are damaged or too large for a page, or a library is not there.
    """
    find_results(out)
    added, saved = AddedFiles(out), SavedResults(out)
    with damage_told(out):
        data, title = read_view(saved), heading(saved.told)
        page = space_page_of(data, title, view_of_space(out)) if saved.in_space else page_of(data, title)
    with added.file(VIEW) as draft:
        write_text(draft, page)
    return out / VIEW
