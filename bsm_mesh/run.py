"""Run a model: from the input to the result."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.errors import MeshWarning, ModelError, one_line
from bsm_mesh.solving import Finished, Observer, Output, Snapshot, solve

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model
    from bsm_mesh.model.options import Options
    from bsm_mesh.results.results import Results
    from bsm_mesh.solve.stages.scheme import Reporter


def run(
    model: Model | str | os.PathLike[str],
    options: Options | None = None,
    observer: Observer | None = None,
    report: Reporter = lambda text: None,
    snapshot: Snapshot = lambda record, results: None,
    finished: Finished = lambda results: None,
    *,
    output: Output = None,
    scripts: bool = True,
    resume: bool = False,
) -> Results:
    """Return the results of a model, or of a model file, which is run as the command runs it.

    Parameters
    ----------
    model : Model or path
        The input; or a model file (TOML): it is read, solved as its ``[solver]`` says, and its results are written
        to the folder of its ``[output]``. Repairs of its mesh are warnings (`MeshWarning`).
    options : Options, optional
        How to solve it, instead of the model's own options, or a file's ``[solver]``.
    observer : callable, optional
        Gets the `StepRecord` of every accepted step.
    report : callable, optional
        Called with a short text on progress.
    snapshot : callable, optional
        Gets the `StepRecord` of every accepted step, and a function that returns the results at that step. These are
        of one stage, not yet in equilibrium. The function holds until the next step only, and takes time.
    finished : callable, optional
        Gets the results so far at the end of every stage, before the next begins; their status is ``unfinished``.
    output : path or False, optional
        With a model file: another folder for its results; False: nothing is written.
    scripts : bool
        With a model file: whether it may run a geometry script and name any path. If not, no code of its own is run,
        and nothing outside its folder is read or written.
    resume : bool
        With a model file: continue where an interrupted run of it was, and end as if it had not been interrupted; where
        there was none it begins at the start.

    Raises
    ------
    ModelError
        With every fault of the model: no load, no support, overlapping blocks, rigid rocks without a joint. In the
        linear scheme also parts that are free to move. With `resume` where an
        interrupted run is damaged, of another model or version, or the model's finished results are there already.

    Examples
    --------
    A block of 26 kN/m on a joint of 1 m and 1 GPa/m settles by 26e3 / 1e9 m.

    >>> import bsm_mesh as bsm
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (3, 0), (3, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="granite"
    ...     ),
    ...     rocks=[bsm.Rock("granite", unit_weight=26e3)],
    ...     joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
    ...     default_joint="J1",
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> results = bsm.run(model)
    >>> print(results.status, results.stages[0].displacement[1, 1].round(9))
    stable -2.6e-05
    """
    from bsm_mesh.model.model import Model
    from bsm_mesh.model.options import Options

    if not isinstance(options, Options | None):
        raise ModelError(f"run: options = {options!r} must be bsm.Options(...)")
    if isinstance(model, str | os.PathLike):
        from bsm_mesh.folder.run_file import run_file

        def warn(note: str) -> None:
            warnings.warn(one_line(note), MeshWarning, stacklevel=4)  # where this function was called

        given = options, observer, report, snapshot, finished
        return run_file(Path(model), *given, output=output, scripts=scripts, noted=warn, resume=resume).results
    if not isinstance(model, Model):
        raise ModelError(f"run: {type(model).__name__} is neither a bsm.Model nor the path of a model file")
    if output is not None:
        raise ModelError("run: output belongs to a model file; write the results of a model by results.save(folder)")
    if resume:
        raise ModelError("run: resume belongs to a model file: a run of a model leaves nothing to continue with")
    return solve(model, options or model.options or Options(), observer, report, snapshot, finished)
