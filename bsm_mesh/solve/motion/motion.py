"""Start and end of a continuation."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.results.records import Status, StepRecord
from bsm_mesh.solve.algebra.constraints import Constraints
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.step.system import Contacts, Evaluation, History


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Start:
    """Initial state of a run.

    Attributes
    ----------
    position : (n, axes) float64 [m, rad]
        Where blocks are.
    history : History
        Of the contacts.
    intact : bool
        Whether all contacts are intact.
    bolts : InstalledBolts
        The bolts.
    origin : (n, axes) float64 or None
        Where their movement counts from; None: `position`.
    velocity : (n, axes) float64 or None
        Of blocks that are followed, as in `Iterate`; None: at rest.
    """

    position: FloatArray
    history: History
    intact: bool
    bolts: InstalledBolts
    origin: FloatArray | None = None
    velocity: FloatArray | None = None


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Motion:
    """Final state, with the verdict: `down` are the blocks that come down, `small` which are too small to count."""

    status: Status
    reason: str
    position: FloatArray
    contacts: Contacts
    at: Evaluation
    bolts: InstalledBolts
    bolts_at: BoltEvaluation
    constraints: Constraints
    loads: FloatArray
    unstable_blocks: IntArray
    down: IntArray
    small: BoolArray
    velocity: FloatArray | None
    start_residual: float
    residual: float
    reference: float
    steps: tuple[StepRecord, ...]
    linear_solver: str
