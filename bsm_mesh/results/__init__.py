"""The result of a run."""

from bsm_mesh.results.bolts import BoltForces, BoltStatus
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult, Status, StepRecord, SupportForces
from bsm_mesh.results.results import Results

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
