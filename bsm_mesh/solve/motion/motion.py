"""Start and end of a continuation."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.algebra.constraints import Constraints
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.contacts.forces import ContactSet, Evaluation
from bsm_mesh.solve.contacts.history import History


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Start:
    """Initial state: position (n, 3), history of contacts, bolts, and whether all contacts are intact."""

    position: FloatArray
    history: History
    intact: bool
    bolts: InstalledBolts


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Motion:
    """Final state, with the verdict."""

    status: Status
    reason: str
    position: FloatArray
    contacts: ContactSet
    at: Evaluation
    bolts: InstalledBolts
    bolts_at: BoltEvaluation
    constraints: Constraints
    loads: FloatArray
    unstable_blocks: IntArray
    start_residual: float
    residual: float
    reference: float
    steps: tuple[StepRecord, ...]
    linear_solver: str
