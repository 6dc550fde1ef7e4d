"""Limit analysis, for scripts; it is done in `limit.analysis` and `limit.strength_factor`."""

from bsm_mesh.solve.limit.analysis import LimitAnalysis, limit_analysis, limit_tilt
from bsm_mesh.solve.limit.strength_factor import StrengthLimit, strength_limit

__all__ = ["LimitAnalysis", "StrengthLimit", "limit_analysis", "limit_tilt", "strength_limit"]
