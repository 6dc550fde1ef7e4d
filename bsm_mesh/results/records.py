"""What came out: contacts, supports, steps, stages, and the results of a run. Complete when they exist."""

from __future__ import annotations

import os
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.reading import as_path
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.evidence import Evidence, Proof
from bsm_mesh.results.falls import Fall

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bsm_mesh.model.model import Model
    from bsm_mesh.results.check import Check
    from bsm_mesh.results.histories import HistorySeries, Recorded
    from bsm_mesh.results.spread import RouteEnd
    from bsm_mesh.solve.options import Options


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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
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
        Displacement of a relative to b along n and t since the start.
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

    @property
    def force(self) -> FloatArray:
        """Force on `block_b`, (m, 2) [N/m]."""
        n = self.normal
        tangent = n[:, ::-1] * (-1.0, 1.0)
        force: FloatArray = self.normal_force[:, None] * n + self.shear_force[:, None] * tangent
        return force


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
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
        Greatest displacement of a centroid so far.
    newton_iterations, factorizations : int
        Spent on this step.
    open_contacts, slipping_contacts : int
        At its end.
    seconds : float
        Wall time of the step.
    method : str
        The method that ended it.
    tried : tuple of str
        Methods that were tried before, in vain, in order.
    recorded : tuple of float
        The values of the model's histories at its end, in the order of ``Results.recorded``.
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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
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
        u, v and theta of every block, since the ground's in-situ state where it is given (else since the start), and
        since the stage's start. Of a filled block since it was placed.
    origin : (n, 3) float64 [m, m, rad]
        Where `displacement` counts from, less where the blocks were given: what the in-situ state moved them by.
    stress, stress_effective : (n, 2, 2) float64 [Pa]
        Average stress of every block (Wang Eq. 3.45), tension positive: the total, and that less the water's.
    loads, reactions : (n, 3) float64 [N/m, N/m, N]
        Weight, loads and water, and support forces on every block: Fx, Fy, moment about the centroid.
    water : (n, 3) float64 [N/m, N/m, N]
        The water's part of `loads`.
    water_table : (k, 2, 2) float64 [m]
        Both ends of the straight pieces of the water table over the model; none where there is no water.
    contacts : ContactForces
        Forces in the contacts.
    supports : SupportForces
        Forces at the supports.
    bolts : BoltForces
        Forces in the bolts.
    unstable_blocks : (k,) int32
        Blocks that come down; empty where the stage is at rest.
    start_residual, residual : float
        As in `StepRecord`, before the first step and at the end.
    reference_weight : float [N/m]
        What residuals are relative to: the greatest of a block's mean weight, a loaded block's mean load and the mean
        force of contacts at the start.
    steps : tuple of StepRecord
        How it got there.
    notes : tuple of str
        What a reader should know, a sentence each.
    falls : tuple of Fall
        Blocks that came down in the stage and were taken away.
    evidence : Evidence or None
        What checking the verdict takes besides; every run gives it.
    proof : Proof or None
        What limit analysis says of the start, where it was asked: of a stage that is unstable.
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

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def seconds(self) -> float:
        """Wall time of the stage [s]."""
        return sum(step.seconds for step in self.steps)

    @property
    def total_load(self) -> FloatArray:
        """Sum of weights and loads, (2,) [N/m]."""
        total: FloatArray = self.loads[self.present, :2].sum(axis=0)
        return total

    @property
    def total_reaction(self) -> FloatArray:
        """Sum of support forces, (2,) [N/m]."""
        total: FloatArray = self.reactions[self.present, :2].sum(axis=0)
        return total

    @property
    def uplifted_blocks(self) -> IntArray:
        """Blocks on which the water pushes up more than weight and loads push down, (k,)."""
        lifted = (self.water[:, 1] > 0) & (self.loads[:, 1] > 1e-9 * self.water[:, 1])
        found: IntArray = np.flatnonzero(lifted & self.present).astype(np.int32)
        return found

    @property
    def max_displacement(self) -> float:
        """Greatest displacement of a centroid [m]."""
        return _greatest(self.displacement)

    @property
    def max_stage_displacement(self) -> float:
        """Greatest displacement of a centroid since the stage's start [m]."""
        return _greatest(self.stage_displacement)


def _greatest(displacement: FloatArray) -> float:
    u, v, _ = displacement.T
    return float((u**2 + v**2).max(initial=0.0) ** 0.5)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Results:
    """All stages of a run, or those finished so far.

    Attributes
    ----------
    blocks : Blocks
        The blocks at the start.
    joint_names : tuple of str
        Names for ``contacts.joint``.
    stages : tuple of StageResult
        At least one; the last gives the verdict, if the run is finished.
    scheme, linear_solver : str
        What was used.
    tolerance : float
        Greatest force out of balance that counted as equilibrium, over the reference weight.
    model_digest : str
        SHA-256 of the model's content.
    title : str
        The model's title.
    default_joint : str or None
        Name of the joint of faces whose edges have none.
    recorded : tuple of Recorded
        What the model's histories record.
    finished : bool
        Whether the run came to its end; if not, `status` is ``unfinished``, whatever the stages are.
    model : Model or None
        What was run; None for results that were read back.
    options : Options or None
        How it was solved; None for results that were read back.
    spread : tuple of RouteEnd
        Where other routes led, the usual one first; none where it was not asked.
    """

    blocks: Blocks
    joint_names: tuple[str, ...]
    stages: tuple[StageResult, ...]
    scheme: str
    linear_solver: str
    tolerance: float
    model_digest: str
    title: str = ""
    default_joint: str | None = None
    recorded: tuple[Recorded, ...] = ()
    finished: bool = True
    model: Model | None = None
    options: Options | None = None
    spread: tuple[RouteEnd, ...] = ()

    @property
    def status(self) -> Status:
        """The verdict: that of the last stage; ``unfinished`` where the run did not come to its end."""
        return self.stages[-1].status if self.finished else Status.UNFINISHED

    @property
    def unstable_blocks(self) -> IntArray:
        """Blocks that come down in the last stage."""
        return self.stages[-1].unstable_blocks

    @property
    def histories(self) -> dict[str, HistorySeries]:
        """The histories over all steps, by name."""
        from bsm_mesh.results.histories import series_of

        return series_of(self.recorded, self.stages)

    def plot(
        self,
        picture: str = "displacement",
        *,
        stage: int | str = -1,
        window: tuple[float, float, float, float] | None = None,
        figure: Figure | None = None,
    ) -> Figure:
        """Return a picture of a stage, as ``bsm-mesh plot`` draws it, to go on with.

        Parameters
        ----------
        picture : str
            Its name: ``model``, ``displacement``, ``deformation``, ``sigma_1``, ``joints`` (their state),
            ``joints_slip``, ``thrust``, ``bolts``, ...; an unknown one is answered with all. Not the charts
            ``bolt_forces`` and ``histories``, which show no part of the model.
        stage : int or str
            Number or name; negative numbers count from the last stage.
        window : (x0, y0, x1, y1), optional [m]
            What is seen.
        figure : matplotlib.figure.Figure, optional
            What is drawn on; by default a figure of its own, to be saved (``savefig``) or shown by a notebook.

        Raises
        ------
        ModelError
            If there is no such picture or stage, nothing to show in it, or the window is none.
        """
        from bsm_mesh.app.plotting import plot_results

        return plot_results(self, picture, stage, window, figure)

    def _repr_html_(self) -> str:
        """Return what a notebook shows of them."""
        from bsm_mesh.app.notebook import results_html

        return results_html(self)

    def check(self) -> Check:
        """Return how well every stage is in equilibrium, computed anew from the forces alone."""
        from bsm_mesh.results.check import check_results

        return check_results(self)

    def save(
        self,
        folder: str | os.PathLike[str],
        *,
        tables: bool | Literal["csv", "parquet"] = False,
        compression: Literal["zlib", "lz4"] = "zlib",
    ) -> Path:
        """Write the results into `folder` and return it: VTU, PVD, CSV and JSON files, the model as ``model.toml``.

        With `tables` blocks, contacts, supports and joint sets as CSV (True) or Parquet too (``contacts.csv``, ...).
        VTU compressed by zlib is read by everything, by LZ4 only by VTK, ParaView and PyVista, and written quicker.
        The folder may be new, empty, or one of former results, which are replaced as a whole. Where the model cannot be
        written a `ResultsWarning` says what is missing.

        Raises
        ------
        ModelError
            If the folder holds what bsm-mesh did not write, or cannot be written to; the former results stay.
        """
        from bsm_mesh.app.result_tables import OutputForm
        from bsm_mesh.app.storage import save_results

        form = OutputForm(tables=tables, compression=compression)
        return save_results(self, as_path("Results.save: folder", folder), form=form)

    def to_meshio(self, kind: str = "blocks", stage: int | str = -1) -> Any:
        """Return a ``meshio.Mesh`` of a kind at the end of a stage, as ``meshio.read`` gives it of the VTU file.

        Parameters
        ----------
        kind : str
            blocks, contacts, joints, supports; water and bolts where there are any.
        stage : int or str
            Number or name; negative numbers count from the last stage.

        Raises
        ------
        ModelError
            If there is no such stage, or nothing of the kind in it.
        """
        from bsm_mesh.app.result_objects import to_meshio

        return to_meshio(self, kind, stage)

    def to_pyvista(self, kind: str = "blocks", stage: int | str = -1) -> Any:
        """Return a ``pyvista.UnstructuredGrid`` of a kind at the end of a stage; parameters as for `to_meshio`.

        It has the arrays of the VTU file, and names as text arrays besides: ``joint_name``, ``status_name``,
        ``rock_name``, ``bolt_name``.
        """
        from bsm_mesh.app.result_objects import to_pyvista

        return to_pyvista(self, kind, stage)

    def to_pandas(self, table: str = "blocks") -> Any:
        """Return a ``pandas.DataFrame`` of all stages, one below the other, with units in ``attrs["units"]``.

        Parameters
        ----------
        table : str
            blocks, contacts, supports, bolts (a row a node), joints (a row a joint set) or steps.

        Raises
        ------
        ModelError
            If there is no such table, or pandas is not installed.
        """
        from bsm_mesh.app.result_tables import to_pandas

        return to_pandas(self, table)

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> Results:
        """Return the results in `folder`: of a run, of one under way, or of one that was interrupted (``unfinished``).

        Raises
        ------
        ModelError
            If the folder holds no results, or a file of them is not as it was written.
        """
        from bsm_mesh.app.storage import load_results

        return load_results(as_path("Results.load: folder", folder))
