"""Limit analysis, for scripts; it is done in `limit`, and of polyhedra in `three_d.limit`."""

from bsm_mesh.solve.limit.analysis import LimitAnalysis
from bsm_mesh.solve.limit.by_kind import limit_analysis, limit_tilt, strength_limit
from bsm_mesh.solve.limit.strength_factor import StrengthLimit

__all__ = ["LimitAnalysis", "StrengthLimit", "limit_analysis", "limit_tilt", "strength_limit"]
