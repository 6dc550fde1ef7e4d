"""The results of a run: its stages, queries, and formats that others read."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, SupportsIndex, TypeAlias, overload

from bsm_mesh import doors
from bsm_mesh.arrays import IntArray, ReadOnlyMapping
from bsm_mesh.errors import UnknownNameError, counted, named_stage, nearest, numbered, shortened
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space, refuse_space
from bsm_mesh.reading import as_path
from bsm_mesh.results.movement import greatest_displacement, verdict_in_words
from bsm_mesh.results.records import StageResult, Status

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bsm_mesh.model.model import Model
    from bsm_mesh.model.options import Options
    from bsm_mesh.results.check import Check
    from bsm_mesh.results.histories import HistorySeries, Recorded
    from bsm_mesh.results.spread import RouteEnd


Source: TypeAlias = "str | os.PathLike[str] | Results"
"""Reference values of histories: a table (CSV), a results folder, or other results."""


class StageResults(tuple[StageResult, ...]):
    """The stages of a run in their order: a tuple whose items have names too, ``stages["bench 1"]``."""

    __slots__ = ()

    @overload
    def __getitem__(self, stage: SupportsIndex | str) -> StageResult: ...
    @overload
    def __getitem__(self, stage: slice) -> tuple[StageResult, ...]: ...
    def __getitem__(self, stage: SupportsIndex | str | slice) -> StageResult | tuple[StageResult, ...]:
        """Return the stage of a name or a number, or those of a slice."""
        if not isinstance(stage, str):
            return super().__getitem__(stage)
        names = [each.name for each in self]
        if stage not in names:
            raise UnknownNameError(f"there is no stage {stage!r}{nearest(stage, names)}")
        return self[names.index(stage)]


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class Results:
    """All stages of a run, or those finished so far.

    Attributes
    ----------
    blocks : Blocks
        The blocks at the start.
    joint_names : tuple of str
        Names for ``contacts.joint``.
    stages : tuple of StageResult
        At least one; the last gives the verdict, if the run is finished. ``stages["bench 1"]`` is found by its name.
    scheme, linear_solver : str
        Those of the run.
    tolerance : float
        Greatest force out of balance that counted as equilibrium, over the reference weight.
    model_digest : str
        SHA-256 of the model's content.
    title : str
        The model's title.
    default_joint : str or None
        Name of the joint of faces whose edges have none.
    recorded : tuple of Recorded
        Records of the model's histories.
    finished : bool
        Whether the run reached its end; if not, `status` is ``unfinished``, whatever the stages are.
    model : Model or None
        The model that was run; None for results that were read back.
    options : Options or None
        How it was solved; None for results that were read back.
    spread : tuple of RouteEnd
        Where other routes led, the usual one first; none where it was not asked.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (3, 0), (3, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="granite"
    ...     ),
    ...     rocks=[bsm.Rock("granite", unit_weight=26e3)],
    ...     joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
    ...     default_joint="J1",
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> results = bsm.run(model)
    >>> results.status.value, results.unstable_blocks.tolist()
    ('stable', [])
    >>> results.check().ok
    True
    """

    blocks: Blocks
    joint_names: tuple[str, ...]
    stages: StageResults
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

    def __repr__(self) -> str:
        stage = self.stages[-1]
        title = f"Results {self.title!r}" if self.title else "Results"
        earlier = shortened(
            "; ".join(f"{each.name} {verdict_in_words(self.blocks, each)}" for each in self.stages[:-1])
        )
        down = f"; {numbered('block', stage.unstable_blocks)} unstable" if stage.unstable_blocks.size else ""
        verdict = verdict_in_words(self.blocks, stage) if self.finished else self.status.value
        lines = [f"{title}: {verdict} ({stage.reason})"]
        lines += [f"earlier stages: {earlier}"] if earlier else []
        there = counted(int(stage.present.sum()), "block")
        most = greatest_displacement(stage)
        lines.append(f"{named_stage(stage.name)}: {there}, greatest displacement {most:.3g} m{down}")
        lines += [f"not computed: {shortened(', '.join(self.not_computed))}"] if self.not_computed else []
        return "\n".join(lines)

    @property
    def not_computed(self) -> tuple[str, ...]:
        """Names of the model's stages behind the last one of the results."""
        given = () if self.model is None else self.model.stages
        return tuple(stage.name for stage in given[len(self.stages) - 1 :])

    @property
    def has_small_displacements(self) -> bool:
        """Whether displacements are small: forces act where blocks were given."""
        return self.scheme in ("linear", "zones")

    @property
    def status(self) -> Status:
        """The verdict: that of the last stage; ``unfinished`` where the run did not reach its end."""
        return self.stages[-1].status if self.finished else Status.UNFINISHED

    @property
    def unstable_blocks(self) -> IntArray:
        """Blocks that fall in the last stage."""
        return self.stages[-1].unstable_blocks

    @property
    def histories(self) -> Mapping[str, HistorySeries]:
        """The histories over all steps, by name."""
        from bsm_mesh.results.histories import series_of

        return ReadOnlyMapping(series_of(self.recorded, self.stages))

    def plot(
        self,
        picture: str = "displacement",
        *,
        stage: int | str = -1,
        window: tuple[float, float, float, float] | None = None,
        figure: Figure | None = None,
        beside: Mapping[str, Source] | Sequence[Source] | Source = (),
        look: tuple[float, float] | None = None,
    ) -> Figure:
        """Return a picture of a stage, as ``bsm-mesh plot`` draws it, to continue with.

        Parameters
        ----------
        picture : str
            Its name: ``model``, ``displacement``, ``deformation``, ``sigma_1``, ``joints`` (their state),
            ``joints_slip``, ``thrust``, ``bolts``, ``bolt_forces``, ``histories``,
            ``extensometers``, ``profiles`` and ``points`` (of the whole run), ...; an unknown one is answered with all.
        stage : int or str
            Number or name; negative numbers count from the last stage.
        window : (x0, y0, x1, y1), optional [m]
            The visible part; not of charts, as ``bolt_forces`` and ``histories``, which show no place.
        figure : matplotlib.figure.Figure, optional
            The figure to draw on; by default one of its own, to be saved (``savefig``) or shown by a notebook.
        beside : path, Results, or several of them, or a mapping of names to them
            Values for comparison with the histories. They are tables (CSV), results folders or other results.
        look : (azimuth, plunge), optional [degrees]
            Direction in which polyhedra are seen: clockwise from north, and downwards; by default at those that fall.

        Raises
        ------
        ModelError
            If there is no such picture or stage, nothing to show in it, or the window is none, or of a chart.
        """
        return doors.plot_results(self, picture, stage, window, figure, beside, look)

    def _repr_html_(self) -> str | None:
        """Return the results as HTML for a notebook; None of polyhedra: their text."""
        return None if in_space(self.blocks) else doors.results_html(self)

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
        written a `ResultsWarning` names the missing parts.

        Raises
        ------
        ModelError
            If the folder holds what bsm-mesh did not write, or cannot be written to; the former results stay.
        """
        if tables:
            refuse_space(self.blocks, "Results.save: tables")
        form = doors.OutputForm(tables=tables, compression=compression)
        return doors.save_results(self, as_path("Results.save: folder", folder), form=form)

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
        refuse_space(self.blocks, "Results.to_meshio")
        return doors.to_meshio(self, kind, stage)

    def to_pyvista(self, kind: str = "blocks", stage: int | str = -1) -> Any:
        """Return a ``pyvista.UnstructuredGrid`` of a kind at the end of a stage; parameters as for `to_meshio`.

        It has the arrays of the VTU file, and names as text arrays besides: ``joint_name``, ``status_name``,
        ``rock_name``, ``bolt_name``.

        Raises
        ------
        ModelError
            As `to_meshio`, or if PyVista is not installed.
        """
        refuse_space(self.blocks, "Results.to_pyvista")
        return doors.to_pyvista(self, kind, stage)

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
        refuse_space(self.blocks, "Results.to_pandas")
        return doors.to_pandas(self, table)

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> Results:
        """Return the results in `folder`: of a run, of one under way, or of one that was interrupted (``unfinished``).

        Raises
        ------
        ModelError
            If the folder holds no results, or a file of them is not as it was written.
        """
        return doors.load_results(as_path("Results.load: folder", folder))
