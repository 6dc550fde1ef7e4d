"""Limit analysis by the kind of blocks: of polygons and of polyhedra.

It is in `limit.analysis` and `limit.strength_factor` by linear programs, and in `three_d.limit.of_model` by
programs with friction cones.
"""

from __future__ import annotations

from collections.abc import Sequence

from bsm_mesh import space
from bsm_mesh.model.kinds import in_space, refuse_space
from bsm_mesh.model.loads import Load
from bsm_mesh.model.model import Model
from bsm_mesh.solve.limit import analysis, strength_factor
from bsm_mesh.solve.limit.analysis import LimitAnalysis
from bsm_mesh.solve.limit.strength_factor import StrengthLimit


def limit_analysis(
    model: Model, live: Sequence[Load] | None = None, *, stage: str | None = None
) -> LimitAnalysis | space.SpaceLimit:
    """Return whether a stage is statically admissible, and the greatest factor on loads.

    Parameters, proof and errors are those of `limit.analysis.limit_analysis`.
    """
    if isinstance(model, Model) and in_space(model.blocks):
        return space.limit_in_space(model, live, stage)
    return analysis.limit_analysis(model, live, stage=stage)


def strength_limit(
    model: Model,
    joints: Sequence[str] | None = None,
    rocks: bool = True,
    bolts: bool = False,
    *,
    stage: str | None = None,
) -> StrengthLimit | space.SpaceLimit:
    """Return the greatest factor by which strength may be divided while forces balance a stage's loads.

    Parameters, proof and errors are those of `limit.strength_factor.strength_limit`.
    """
    if isinstance(model, Model) and in_space(model.blocks):
        return space.strength_in_space(model, joints, stage, rocks=rocks, bolts=bolts)
    return strength_factor.strength_limit(model, joints, rocks, bolts, stage=stage)


def limit_tilt(model: Model, *, stage: str | None = None, clockwise: bool = False, accuracy: float = 1e-6) -> float:
    """Return the tilt beyond which a stage of polygons is inadmissible [degrees], as `limit.analysis.limit_tilt`."""
    refuse_space(model.blocks, "a limit of tilt")
    return analysis.limit_tilt(model, stage=stage, clockwise=clockwise, accuracy=accuracy)
