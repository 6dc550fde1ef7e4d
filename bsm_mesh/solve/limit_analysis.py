"""Limit analysis, for scripts; it is done in `limit.analysis`."""

from bsm_mesh.solve.limit.analysis import LimitAnalysis, limit_analysis, limit_tilt

__all__ = ["LimitAnalysis", "limit_analysis", "limit_tilt"]
