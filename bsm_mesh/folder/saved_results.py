"""Results on disk: every file is compared with the summary before anything is made of it."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import MAX_NAMED, ModelError, gathered, raise_faults
from bsm_mesh.folder.own_files import OF_A_RUN, OF_A_STEP, SUMMARY, link_on_the_way, run_number
from bsm_mesh.folder.results_folder import ResultsFolder
from bsm_mesh.folder.summary import finished_stages, read_summary
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.reading import refuse_special, special_fault
from bsm_mesh.results.records import Status

if TYPE_CHECKING:
    from bsm_mesh.converters.vtk_files import Grid

PATIENCE = 2.0  # s; new results take the place of the former ones in a thousandth of that


class SavedResults:
    """Results on disk: of each file size and checksum are compared with the summary before anything is made of it.

    Parameters
    ----------
    folder : Path
        The folder of a run, one under way and an interrupted one as well.

    Attributes
    ----------
    folder : Path
        Where they are.
    told : dict
        The content of the summary.
    finished : bool
        Whether the run reached its end.

    Raises
    ------
    ModelError
        If the folder holds no results.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = find_results(folder)
        self.told = read_summary(self.folder)
        self.finished = self.told["status"] != Status.UNFINISHED

    def __contains__(self, name: str) -> bool:
        return name in self.told["files"]

    def check(self) -> None:
        """Raise for all files that are missing or of another size, and for changed ones that `grid` does not read.

        Of grids, which may be large, the content is compared when they are read.
        """
        faults = []
        for name, listed in self.told["files"].items():
            path = self.folder / name
            if link := link_on_the_way(self.folder, name):
                faults.append(f"{link} is a link, and {name} would lie elsewhere; run the model again")
            elif not path.is_file():
                if self.finished or not OF_A_STEP.fullmatch(name):  # a run under way gives up steps that it listed
                    faults.append(special_fault(path) or f"{path}: there is no such file; run the model again")
            elif name.endswith(".vtu") and OF_A_RUN.fullmatch(name):
                if path.stat().st_size != listed["bytes"]:
                    faults.append(_damaged(path))
            else:
                with gathered(faults):
                    self.content(name)
        raise_faults(faults)

    def content(self, name: str) -> bytes:
        """Return the content of a file; of a growing table that at the end of the last stage.

        Raises
        ------
        ModelError
            If that differs from the written file.
        """
        path, listed = self.folder / name, self.told["files"].get(name)
        if listed is None and self.finished:
            raise ModelError(f"{path} is not from this run; run the model again")
        refuse_special(path)
        if not path.is_file():
            raise ModelError(f"{path}: there is no such file; run the model again")
        try:
            with path.open("rb") as file:
                size = os.fstat(file.fileno()).st_size
                content = file.read(-1 if listed is None else listed["bytes"])
        except OSError as error:
            raise ModelError(f"{path} cannot be read: {error.strerror or error}") from None
        if listed is None:  # of a step of a run under way
            return content
        longer = self.finished and size != listed["bytes"]
        if longer or hashlib.sha256(content).hexdigest() != listed["sha256"]:
            raise ModelError(_damaged(path))
        return content

    def grid(self, name: str, needs: Sequence[str] = ()) -> Grid:
        """Return the grid of a VTU file, whose arrays have the components of those that are written.

        Its points have three coordinates where the blocks are polyhedra, else two.
        """
        from bsm_mesh.converters.vtk_files import grid_of
        from bsm_mesh.converters.vtk_library import COMPONENTS, COMPONENTS_IN_SPACE

        parts = COMPONENTS_IN_SPACE if self.in_space else COMPONENTS
        grid = grid_of(self.content(name), self.folder / name, needs=needs, coordinates=3 if self.in_space else 2)
        arrays = [*grid.point_data.items(), *grid.cell_data.items()]
        if any(values.shape[1:] != ((parts[key],) if key in parts else ()) for key, values in arrays):
            raise ModelError(_damaged(self.folder / name))
        return grid

    @property
    def in_space(self) -> bool:
        """Whether the blocks are polyhedra."""
        return bool(self.told.get("dimensions") == 3)

    def blocks(self) -> Blocks:
        """Return the blocks of the model, those that were taken away too."""
        if self.in_space:
            from bsm_mesh.folder.space_stages import polyhedra_of

            return cast(Blocks, polyhedra_of(self))  # they answer to the same names
        from bsm_mesh.converters.result_files import GIVEN_BLOCKS, blocks_of_grid, stage_file

        return blocks_of_grid(self.grid(GIVEN_BLOCKS if GIVEN_BLOCKS in self else stage_file("blocks", 0)))

    def water_table(self, stage: int) -> FloatArray:
        """Return the water table of a stage, (k, 2, 2) [m]; none where nothing was written."""
        from bsm_mesh.converters.result_files import WATER, stage_file

        name = stage_file(WATER, stage)
        return self.grid(name).points.reshape(-1, 2, 2) if name in self else np.zeros((0, 2, 2))

    def series(self, kind: str) -> list[tuple[float, str]]:
        """Return the (time, file name) pairs of a kind."""
        from bsm_mesh.converters.vtk_files import files_of

        path = self.folder / f"{kind}.pvd"
        return [(moment, file.name) for moment, file in files_of(self.content(path.name), path)]


def _damaged(path: Path) -> str:
    return f"{path} is damaged, or was changed after the run; run the model again"


@contextmanager
def damage_told(folder: Path) -> Iterator[None]:
    """Report every fault in the content of a results folder as one `ModelError`.

    Checksums prove that a folder is as it was written, and not by whom: its entries may be of any kind.
    """
    try:
        yield
    except ModelError:
        raise
    except (
        ArithmeticError,
        AttributeError,
        LookupError,
        RecursionError,
        StopIteration,
        TypeError,
        ValueError,
    ) as error:
        raise ModelError(f"{folder} is damaged ({error}); run the model again") from error


def find_results(folder: Path) -> Path:
    """Return where the results of a folder are: there, but for the moment in which new ones take their place.

    A change of place that a killed run left half done is ended first.

    Raises
    ------
    ModelError
        If the folder holds no results; the message says where unfinished ones are.
    """
    refuse_special(folder / SUMMARY)
    own, end = ResultsFolder(folder), time.monotonic() + PATIENCE
    while not (folder / SUMMARY).is_file():
        waiting = not own.strange() and (run_number(own.running) is not None or own.former.is_dir())
        if not waiting or time.monotonic() > end:
            break
        try:
            with own.locked():  # which puts right what was half done
                break
        except ModelError:  # held by the run that does it
            time.sleep(0.02)
        except OSError:  # nothing can be put right on this disk
            return own.former if own.former.is_dir() else own.running
    if (folder / SUMMARY).is_file():
        return folder
    hints = [
        f"; finished stages of a run {what} are in {own.told(place)}"
        for place, what in ((own.running, "under way"), (own.interrupted, "that was interrupted"))
        if finished_stages(place)
    ]
    what = "is no folder" if folder.exists() else "does not exist"
    what = f"holds no results (no {SUMMARY})" if folder.is_dir() else what
    inside = [str(place) for place in _results_within(folder if folder.is_dir() else folder.parent)]
    hints += (
        [f"; results are in {', '.join(inside[:MAX_NAMED])}{', ...' if len(inside) > MAX_NAMED else ''}"]
        if inside
        else []
    )
    raise ModelError(f"{folder} {what}; give the output folder of a run{''.join(hints)}")


def _results_within(folder: Path) -> list[Path]:
    """Return the folders of finished results in a folder, such as ``out/model`` next to a model file."""
    return sorted(
        place
        for pattern in (f"*/{SUMMARY}", f"*/*/{SUMMARY}")
        for place in (path.parent for path in folder.glob(pattern))
        if run_number(place) is not None
    )
