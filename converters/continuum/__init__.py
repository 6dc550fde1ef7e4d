"""The continuum: scikit-fem's plane-strain solution of a model, and the comparison with a run."""

from bsm_mesh.converters.continuum.comparability import Comparability
from bsm_mesh.converters.continuum.compared_stages import ComparedStage, compare, compare_stages
from bsm_mesh.converters.continuum.comparison import Comparison, Row
from bsm_mesh.converters.continuum.differences import Difference
from bsm_mesh.converters.continuum.foreign_fields import FieldNames
from bsm_mesh.converters.continuum.matched import affine_stiffness, matched_elasticity
from bsm_mesh.converters.continuum.outside import OutsideComparison, compare_with
from bsm_mesh.converters.continuum.refinement import Refinement
from bsm_mesh.converters.continuum.sections import Section, blocks_on_line
from bsm_mesh.converters.continuum.solving import solve_continuum, solve_continuum_stages
from bsm_mesh.converters.meshes.foreign_files import read_foreign
from bsm_mesh.solve.zones.elasticity import Elasticity, nominal_elasticity
from bsm_mesh.solve.zones.mesh import Discretization
from bsm_mesh.solve.zones.solution import ContinuumSolution

__all__ = [
    "Comparability",
    "ComparedStage",
    "Comparison",
    "ContinuumSolution",
    "Difference",
    "Discretization",
    "Elasticity",
    "FieldNames",
    "OutsideComparison",
    "Refinement",
    "Row",
    "Section",
    "affine_stiffness",
    "blocks_on_line",
    "compare",
    "compare_stages",
    "compare_with",
    "matched_elasticity",
    "nominal_elasticity",
    "read_foreign",
    "solve_continuum",
    "solve_continuum_stages",
]
