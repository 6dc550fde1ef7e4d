"""Stability of excavations and slopes in jointed rock by the Block-Spring Model (B. Wang, 1992).

Conventions
-----------
SI units (N, m, Pa), forces per metre of thickness. x to the right, y up. Corners run counter-clockwise;
rotations are positive counter-clockwise. Angles are in degrees. Stresses and normal forces are positive in
tension (Wang Eq. 4.9); strength laws take the pressure, ``-normal_force >= 0``. On the block with the edge acts
``normal_force * n + shear_force * t`` with n its outward normal and t = n turned by +90 degrees.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bsm_mesh.errors import MeshWarning, ModelError, ResultsWarning
from bsm_mesh.lazy import names_from
from bsm_mesh.reading import as_path
from bsm_mesh.run import run
from bsm_mesh.solving import spread
from bsm_mesh.version import __version__ as __version__

if TYPE_CHECKING:
    from bsm_mesh.commands.study import StudyResults
    from bsm_mesh.model import (
        BartonBandis,
        Beside,
        Blocks,
        Bolt,
        Drain,
        EarthPressure,
        EdgeTractions,
        Filling,
        Fixed,
        Flow,
        FlowChange,
        Grout,
        HeadPlane,
        History,
        HoekBrown,
        InSitu,
        InSituTraction,
        Joint,
        JointResponse,
        LadanyiArchambault,
        Model,
        MohrCoulomb,
        NormalRoller,
        Patton,
        PointLoad,
        PrescribedDisplacement,
        Pressure,
        Rock,
        Roller,
        Shaking,
        Stage,
        Traction,
        Water,
        Well,
        Zones,
        bolt_patterns,
        library,
    )
    from bsm_mesh.model.falls import Falls
    from bsm_mesh.model.loads import Load
    from bsm_mesh.model.options import Options
    from bsm_mesh.results import Results
    from bsm_mesh.results.liner import liner_forces
    from bsm_mesh.safety import Failure, Measured, back_analysis, factor_of_safety, limit_value, newmark
    from bsm_mesh.solve.limit_analysis import LimitAnalysis
    from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
    from bsm_mesh.three_d.key_blocks.analysis import key_blocks
    from bsm_mesh.three_d.limit.of_model import SpaceLimit

# All other names are imported when they are first used: the command line must be able to take an interruption before
# NumPy is there, and a geometry script needs none of them. Here is where those are that `bsm_mesh.model` has not.
_HOME = {
    "Results": "bsm_mesh.results",
    "liner_forces": "bsm_mesh.results.liner",
    "Options": "bsm_mesh.model.options",
    "Falls": "bsm_mesh.model.falls",
    "Polyhedra": "bsm_mesh.three_d.blocks.polyhedra",
    "key_blocks": "bsm_mesh.three_d.key_blocks.analysis",
    "Failure": "bsm_mesh.safety",
    "Measured": "bsm_mesh.safety",
    "back_analysis": "bsm_mesh.safety",
    "factor_of_safety": "bsm_mesh.safety",
    "limit_value": "bsm_mesh.safety",
    "newmark": "bsm_mesh.safety",
}


def limit_analysis(
    model: Model, live: Sequence[Load] | None = None, *, stage: str | None = None
) -> LimitAnalysis | SpaceLimit:
    """Return whether a stage of the model, the last by default, is statically admissible, and the greatest load factor.

    See `bsm_mesh.solve.limit_analysis.limit_analysis`; its proof is one-sided.

    Examples
    --------
    A push at mid-height of a block of 26 kN/m on 35 degrees: it slides at 26 tan(35) kN/m.

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
    >>> push = bsm.PointLoad(block=1, point=(1, 1.5), force=(1e3, 0))
    >>> answer = bsm.limit_analysis(model, live=[push])
    >>> round(float(answer.factor), 2)
    18.21
    """
    from bsm_mesh.solve import limit_analysis as limit

    return limit.limit_analysis(model, live, stage=stage)


def load(path: str | os.PathLike[str], *, scripts: bool = True) -> Model:
    """Return the model of a model file (TOML), to be changed or run; ``model.options`` is what its ``[solver]`` says.

    Repairs of its mesh are warnings (`MeshWarning`). To run a file as it is, results folder and all:
    ``bsm.run("model.toml")``.

    A model file may run a geometry script, and name any path. With ``scripts=False`` it does neither: no code of its
    own is run, and nothing outside its folder is read.

    Raises
    ------
    ModelError
        With every fault found in the file, its mesh or the model as a whole.
    """
    from bsm_mesh.modelfile.build import load as load_model

    return load_model(as_path("load: path", path), scripts=scripts)


def study(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    processes: int | None = None,
    scheduler: str | None = None,
    scripts: bool = True,
) -> StudyResults:
    """Return the outcome of a study file (TOML): many runs of a model whose keys take other values.

    Parameters
    ----------
    path : path
        The study file.
    output : path, optional
        Folder for table, summary and pictures; by default ``out/NAME`` next to the file NAME.toml. Runs that are
        finished there are not done again.
    processes : int, optional
        How many runs at a time; by default as many as there are cores.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers do the runs instead.
    scripts : bool
        Whether the model may run a geometry script and name any path.

    Raises
    ------
    ModelError
        For faults of the study file and its model, and for a folder that holds another study.
    """
    from bsm_mesh.commands.study import run_study

    folder = None if output is None else as_path("study: output", output)
    return run_study(as_path("study: path", path), folder, processes=processes, scheduler=scheduler, scripts=scripts)


__all__ = [
    "BartonBandis",
    "Beside",
    "Blocks",
    "Bolt",
    "Drain",
    "EarthPressure",
    "EdgeTractions",
    "Failure",
    "Falls",
    "Filling",
    "Fixed",
    "Flow",
    "FlowChange",
    "Grout",
    "HeadPlane",
    "History",
    "HoekBrown",
    "InSitu",
    "InSituTraction",
    "Joint",
    "JointResponse",
    "LadanyiArchambault",
    "Measured",
    "MeshWarning",
    "Model",
    "ModelError",
    "MohrCoulomb",
    "NormalRoller",
    "Options",
    "Patton",
    "PointLoad",
    "Polyhedra",
    "PrescribedDisplacement",
    "Pressure",
    "Results",
    "ResultsWarning",
    "Rock",
    "Roller",
    "Shaking",
    "Stage",
    "Traction",
    "Water",
    "Well",
    "Zones",
    "back_analysis",
    "bolt_patterns",
    "factor_of_safety",
    "key_blocks",
    "library",
    "limit_analysis",
    "limit_value",
    "liner_forces",
    "load",
    "newmark",
    "run",
    "spread",
    "study",
]

if not TYPE_CHECKING:
    __getattr__ = names_from({**dict.fromkeys(__all__, "bsm_mesh.model"), **_HOME}, __name__)

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
