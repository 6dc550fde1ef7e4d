"""What came out of a run."""

from bsm_mesh.results.bolts import BoltForces, BoltStatus
from bsm_mesh.results.records import (
    ContactForces,
    ContactStatus,
    Results,
    StageResult,
    Status,
    StepRecord,
    SupportForces,
)

__all__ = [
    "BoltForces",
    "BoltStatus",
    "ContactForces",
    "ContactStatus",
    "Results",
    "StageResult",
    "Status",
    "StepRecord",
    "SupportForces",
]
