"""Files that other commands than a run add to a results folder: whole, noted there, and of its present results."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bsm_mesh.errors import ModelError
from bsm_mesh.files import append_line, make_folder, remove, remove_empty, whole_file, write_text
from bsm_mesh.folder.own_files import HEADER, MARKER, SUMMARY, has_marker, own_files, place_in
from bsm_mesh.folder.results_folder import ResultsFolder, refuse_unwritable, told_fault


class AddedFiles:
    """Adds files to a results folder, to a new one as well; the next run into it replaces them.

    Parameters
    ----------
    folder : Path
        The folder. Added files belong to the present results: once others have taken their place
        nothing is added.

    Raises
    ------
    ModelError
        If it is no results folder, or cannot be written to.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = ResultsFolder(folder)
        if folder.is_file():
            raise ModelError(f"cannot write results to {folder}: it is not a folder; give a folder of results")
        refuse_unwritable(folder)
        if not (self.folder.place / SUMMARY).is_file():
            self.folder.refuse_foreign()
        self._there = self._identity()

    @contextmanager
    def file(self, name: str) -> Iterator[Path]:
        """Give a draft of a file to write to; it is added when the block ends.

        Raises
        ------
        ModelError
            If the file cannot be written, is there and not bsm-mesh's, or the results were replaced.
        """
        path, shown = place_in(self.folder.place, name), self.folder.path / name
        if os.path.lexists(path) and name not in own_files(self.folder.place):
            raise ModelError(f"{shown} is not from bsm-mesh and would be replaced; move it")
        try:
            made = make_folder(path.parent)
            try:
                self._note(name)
                with whole_file(path, settled=True) as draft:
                    yield draft
                    self._refuse_other_results()
                    written = draft.stat()
            except BaseException:
                if self.folder.place in made:
                    remove(self.folder.place / MARKER)
                remove_empty(made)
                raise
            if self._is_replaced() and path.is_file() and os.path.samestat(written, path.stat()):
                remove(path)
            self._refuse_other_results()
        except OSError as error:
            raise ModelError(f"cannot write {shown}: {told_fault(error)}") from error
        except ModelError as error:  # the name of a draft says nothing to the user
            raise ModelError([fault.replace(str(draft), str(shown)) for fault in error.faults]) from error

    def _note(self, name: str) -> None:
        """Note the name before the file is there: a file without a note counts as the user's."""
        marker = self.folder.place / MARKER
        if not has_marker(self.folder.place):  # a link is replaced: what is added to one ends elsewhere
            write_text(marker, HEADER)
        if name not in own_files(self.folder.place):
            append_line(marker, name)
        self._there = self._there or self._identity()

    def _identity(self) -> os.stat_result | None:
        return self.folder.place.stat() if self.folder.place.is_dir() else None

    def _is_replaced(self) -> bool:
        now = self._identity()
        return now is None or (self._there is not None and not os.path.samestat(now, self._there))

    def _refuse_other_results(self) -> None:
        if self._is_replaced():
            raise ModelError(f"{self.folder.path}: other results have taken the place of these meanwhile; do it again")
