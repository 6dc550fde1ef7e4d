"""The result: contacts, supports, steps, stages, and the results of a run. Complete when they exist."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import IntEnum, StrEnum
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.movements import translations
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.evidence import Evidence, Proof
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.shaking import ShakingResult
from bsm_mesh.results.zones import ZoneResult

if TYPE_CHECKING:
    from bsm_mesh.model.submodel import SubModel


class Status(StrEnum):
    """The verdict on a stage or a run.

    A run that is not at its end has none: it is unfinished. Nor has an equilibrium of the linear scheme, in which
    nothing can fail.
    """

    STABLE = "stable"
    STABLE_AFTER_FALLS = "stable_after_falls"
    UNSTABLE = "unstable"
    NOT_CONVERGED = "not_converged"
    NO_VERDICT = "no_verdict"
    UNFINISHED = "unfinished"

    @property
    def is_stable(self) -> bool:
        """Whether the blocks that are there stand."""
        return self in (Status.STABLE, Status.STABLE_AFTER_FALLS)

    @property
    def is_at_rest(self) -> bool:
        """Whether an equilibrium was found, be it one in which nothing can fail."""
        return self.is_stable or self is Status.NO_VERDICT


class ContactStatus(IntEnum):
    """State of a contact."""

    STICKING = 0
    SLIPPING = 1
    OPEN = 2


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class ContactForces(Portable):
    """Forces in the contacts, one row a contact.

    Attributes
    ----------
    block_a, block_b : (m,) int32
        Block with the corner, block with the edge.
    point : (m, 2) float64 [m]
        Where the contact is.
    normal : (m, 2) float64
        Outward unit normal of `block_b`'s edge; t is the normal turned by +90 degrees.
    length : (m,) float64 [m]
        Share of the face's length.
    normal_force, shear_force : (m,) float64 [N/m]
        On `block_b` acts ``normal_force * n + shear_force * t``, on `block_a` its negative; tension positive.
    opening, slip : (m,) float64 [m]
        Displacement of a relative to b along n and t since the start; slip of faces that met later, since then.
    status : (m,) int8
        `ContactStatus`.
    utilisation : (m,) float64
        Shear force over shear strength; 0 where the strength is unlimited, at most `MAX_UTILISATION`.
    joint : (m,) int32
        Number of the joint in ``Results.joint_names``; -1 for unjointed rock.
    water_pressure : (m,) float64 [Pa]
        Of the water in the joint; the contact forces are the effective ones.
    """

    block_a: IntArray
    block_b: IntArray
    point: FloatArray
    normal: FloatArray
    length: FloatArray
    normal_force: FloatArray
    shear_force: FloatArray
    opening: FloatArray
    slip: FloatArray
    status: IntArray
    utilisation: FloatArray
    joint: IntArray
    water_pressure: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @classmethod
    def none(cls) -> ContactForces:
        """Return the record of no contact."""
        numbers, plane, whole = np.zeros(0), np.zeros((0, 2)), np.zeros(0, np.int32)
        return cls(
            block_a=whole,
            block_b=whole,
            point=plane,
            normal=plane,
            length=numbers,
            normal_force=numbers,
            shear_force=numbers,
            opening=numbers,
            slip=numbers,
            status=np.zeros(0, np.int8),
            utilisation=numbers,
            joint=whole,
            water_pressure=numbers,
        )

    def in_whole(self, part: SubModel) -> Self:
        """Return a part's contacts in the numbers of the whole."""
        return replace(self, block_a=part.block[self.block_a], block_b=part.block[self.block_b])

    @property
    def force(self) -> FloatArray:
        """Force on `block_b`, (m, 2) [N/m]."""
        n = self.normal
        tangent = n[:, ::-1] * (-1.0, 1.0)
        force: FloatArray = self.normal_force[:, None] * n + self.shear_force[:, None] * tangent
        return force


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class SupportForces(Portable):
    """Forces with which the supports hold the blocks, one row a held point.

    Attributes
    ----------
    block : (k,) int32
        The held block.
    point : (k, 2) float64 [m]
        Where it is held.
    reaction : (k, 2) float64 [N/m]
        Force on the block.
    moment : (k,) float64 [N]
        Moment on the block, where its rotation is held.
    """

    block: IntArray
    point: FloatArray
    reaction: FloatArray
    moment: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    @classmethod
    def none(cls) -> SupportForces:
        """Return the record of no support."""
        plane = np.zeros((0, 2))
        return cls(block=np.zeros(0, np.int32), point=plane, reaction=plane, moment=np.zeros(0))


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRecord:
    """One accepted step; one cycle of the scheme ``wang``.

    Attributes
    ----------
    stage, step : int
        Number of the stage, and of the step within it, from 0.
    residual : float
        Maximum norm of the residual: largest force (or moment over radius of gyration) on a block, over the reference
        weight.
    max_displacement : float [m]
        Greatest displacement of a centroid in the stage, without blocks too small to count (``falls.ignore_below``).
    newton_iterations, factorizations : int
        Spent on this step.
    open_contacts, slipping_contacts : int
        At its end.
    seconds : float
        Wall time of the step.
    method : str
        The method that ended it.
    tried : tuple of str
        Methods that were tried before, without success, in order.
    recorded : tuple of float
        The values of the model's histories at its end, in the order of ``Results.recorded``.
    time : float or None [s]
        Since the stage began, while it is shaken; else None.
    """

    stage: int
    step: int
    residual: float
    max_displacement: float
    newton_iterations: int
    factorizations: int
    open_contacts: int
    slipping_contacts: int
    seconds: float
    method: str
    tried: tuple[str, ...] = ()
    recorded: tuple[float, ...] = ()
    time: float | None = None


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class StageResult(Portable):
    """A stage at its end.

    Attributes
    ----------
    name : str
        Name of the stage; the first is ``initial``.
    status : Status
        The verdict.
    reason : str
        Why, in words.
    present : (n,) bool
        Which blocks are there; all arrays over blocks hold zeros for the others.
    displacement, stage_displacement : (n, 3) float64 [m, m, rad]
        u, v and theta of every block. The first counts from the ground's in-situ state if it is given, else from the
        start; the second from the stage's start. Those of a filled block count from its placement.
    origin : (n, 3) float64 [m, m, rad]
        Position from which `displacement` counts, less the given one: the displacement by the in-situ state; of filled
        blocks that by which they were placed.
    stress, stress_effective : (n, 2, 2) float64 [Pa]
        Average stress of every block (Wang Eq. 3.45), tension positive: the total, and that less the water's.
    loads, reactions : (n, 3) float64 [N/m, N/m, N]
        Weight, loads and water, and support forces on every block: Fx, Fy, moment about the centroid.
    water : (n, 3) float64 [N/m, N/m, N]
        The water's part of `loads`.
    water_table : (k, 2, 2) float64 [m]
        Both ends of the straight pieces of the water table over the model; none where there is no water.
    water_gradient : (k,) float64 [Pa/m]
        Pressure per metre of depth under each piece.
    joint_water : (j,) float64 [Pa]
        Pressure that was given in the faces of every joint of ``Results.joint_names``; NaN where it is the table's.
    flow : FlowResult or None
        Flow in the joints, where the model has one.
    contacts : ContactForces
        Forces in the contacts.
    supports : SupportForces
        Forces at the supports.
    bolts : BoltForces
        Forces in the bolts.
    unstable_blocks : (k,) int32
        Blocks that fall; empty where the stage is at rest.
    start_residual, residual : float
        As in `StepRecord`, before the first step and at the end.
    reference_weight : float [N/m]
        Reference of residuals. It is the greatest of a block's mean weight, a loaded block's mean load and the mean
        force of contacts at the start.
    steps : tuple of StepRecord
        How it got there.
    notes : tuple of str
        Notes for a reader, a sentence each.
    falls : tuple of Fall
        Blocks that fell in the stage and were taken away.
    evidence : Evidence or None
        What checking the verdict takes besides; every run gives it.
    proof : Proof or None
        What limit analysis says of the start, where it was asked: of a stage that is unstable.
    shaking : ShakingResult or None
        Energies, peaks and time steps, where the stage is shaken.
    small_blocks : (k,) int32
        Blocks that are too small to count for the verdict (``falls.ignore_below``).
    zones : ZoneResult or None
        Displacements and stresses within blocks, where rock has zones.
    """

    name: str
    status: Status
    reason: str
    present: BoolArray
    displacement: FloatArray
    stage_displacement: FloatArray
    origin: FloatArray
    stress: FloatArray
    stress_effective: FloatArray
    loads: FloatArray
    reactions: FloatArray
    water: FloatArray
    water_table: FloatArray
    water_gradient: FloatArray
    joint_water: FloatArray
    contacts: ContactForces
    supports: SupportForces
    bolts: BoltForces
    unstable_blocks: IntArray
    start_residual: float
    residual: float
    reference_weight: float
    steps: tuple[StepRecord, ...]
    notes: tuple[str, ...] = ()
    falls: tuple[Fall, ...] = ()
    evidence: Evidence | None = None
    proof: Proof | None = None
    flow: FlowResult | None = None
    shaking: ShakingResult | None = None
    small_blocks: IntArray = field(default_factory=lambda: np.zeros(0, np.int32))
    zones: ZoneResult | None = None

    def __post_init__(self) -> None:
        show_only(self)

    @classmethod
    def as_given(cls, **known: Any) -> StageResult:
        """Return the `known` state of a model that was not run: nothing moved, and no contact or support carries.

        `known` are fields by their names: ``present``, ``loads``, ``water`` and its table, ``bolts``, ``evidence``.
        """
        still = np.zeros_like(known["loads"])
        axes = translations(still).shape[1]
        tensors = np.zeros((len(still), axes, axes))
        return cls(
            name="as given",
            status=Status.UNFINISHED,
            reason="it was not run",
            displacement=still,
            stage_displacement=still,
            origin=still,
            stress=tensors,
            stress_effective=tensors,
            reactions=still,
            contacts=ContactForces.none(),
            supports=SupportForces.none(),
            unstable_blocks=np.zeros(0, np.int32),
            start_residual=0.0,
            residual=0.0,
            reference_weight=0.0,
            steps=(),
            **known,
        )

    @classmethod
    def of_submodel(cls, displacement: FloatArray, joints: int, **known: Any) -> StageResult:
        """Return the end of a stage in the numbers of its submodel: all blocks are present, and it has no name yet.

        `known` are the other fields by their names. Of the water, omitted fields are those of a dry model.
        """
        still = np.zeros_like(displacement)
        dry = {
            "water": still,
            "water_table": np.zeros((0, 2, 2)),
            "water_gradient": np.zeros(0),
            "joint_water": np.full(joints, np.nan),
        }
        present = np.ones(len(displacement), dtype=bool)
        return cls(name="", present=present, displacement=displacement, origin=still, **{**dry, **known})

    @property
    def seconds(self) -> float:
        """Wall time of the stage [s]."""
        return sum(step.seconds for step in self.steps)

    @property
    def total_load(self) -> FloatArray:
        """Sum of weights and loads, (2,) [N/m]; in space (3,) [N]."""
        total: FloatArray = translations(self.loads[self.present]).sum(axis=0)
        return total

    @property
    def total_reaction(self) -> FloatArray:
        """Sum of support forces, (2,) [N/m]; in space (3,) [N]."""
        total: FloatArray = translations(self.reactions[self.present]).sum(axis=0)
        return total

    @property
    def uplifted_blocks(self) -> IntArray:
        """Blocks on which the water pushes up more than weight and loads push down, (k,)."""
        water, load = (translations(each)[:, -1] for each in (self.water, self.loads))  # the last points up
        lifted = (water > 0) & (load > 1e-9 * water)
        found: IntArray = np.flatnonzero(lifted & self.present).astype(np.int32)
        return found

    @property
    def counts(self) -> BoolArray:
        """Which blocks are present and large enough to count for the verdict, (n,)."""
        counts = self.present.copy()
        counts[self.small_blocks] = False
        return counts

    @property
    def max_displacement(self) -> float:
        """Greatest displacement of the centroid of a block that counts [m]."""
        return _greatest(self.displacement[self.counts])

    @property
    def max_stage_displacement(self) -> float:
        """Greatest displacement since the stage's start of the centroid of a block that counts [m]."""
        return _greatest(self.stage_displacement[self.counts])


def _greatest(displacement: FloatArray) -> float:
    square = sum(along**2 for along in translations(displacement).T)
    return float(np.max(square, initial=0.0) ** 0.5)
