"""The continuum beside the blocks: scikit-fem's plane-strain solution of a model, and the comparison with a run."""

from bsm_mesh.converters.continuum.comparison import Comparison, Difference, Row, compare
from bsm_mesh.converters.continuum.elasticity import (
    Elasticity,
    affine_stiffness,
    matched_elasticity,
    nominal_elasticity,
)
from bsm_mesh.converters.continuum.sections import Section, blocks_on_line
from bsm_mesh.converters.continuum.solution import ContinuumSolution, solve_continuum, solve_continuum_stages

__all__ = [
    "Comparison",
    "ContinuumSolution",
    "Difference",
    "Elasticity",
    "Row",
    "Section",
    "affine_stiffness",
    "blocks_on_line",
    "compare",
    "matched_elasticity",
    "nominal_elasticity",
    "solve_continuum",
    "solve_continuum_stages",
]
