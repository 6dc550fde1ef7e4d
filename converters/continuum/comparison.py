"""Results of the Block-Spring Model compared with the continuum solution of the same model, stage by stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.continuum.differences import Difference
from bsm_mesh.converters.continuum.history_values import HistoryValue
from bsm_mesh.converters.continuum.joint_movement import JointMovement
from bsm_mesh.converters.continuum.refinement import COARSE, Refinement
from bsm_mesh.converters.continuum.sections import Section
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.solve.zones.solution import ContinuumSolution


class Row(NamedTuple):
    """A line of the table: a value of both methods (None in lines of percentages) and their difference."""

    label: str
    bsm: float | None
    fem: float | None
    difference: float
    unit: str


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Comparison:
    """A stage of the Block-Spring Model and the continuum; differences are the first less the second.

    Attributes
    ----------
    present : (n,) bool
        Which blocks are there; arrays over blocks hold zeros for the others.
    stress : (n, 2, 2) float64 [Pa]
        Average stress of every block by the Block-Spring Model.
    displacement : (n, 3) float64 [m, m, rad]
        u, v and rotation of every block by the Block-Spring Model.
    nominal : ContinuumSolution
        With the rocks' own E and Poisson's ratio: the reference for stresses and joint forces.
    matched : ContinuumSolution
        With the elastic constants that the blocks really have: the only fair reference for displacements. Where all
        rock is rigid there are none, and this is `nominal`.
    stress_difference : (n, 2, 2) float64 [Pa]
        From `nominal`.
    displacement_difference : (n, 3) float64 [m, m, rad]
        From `matched`.
    stress_errors : tuple of Difference
        Of sigma_xx, sigma_yy, sigma_xy, sigma_1, and of the whole tensor (Frobenius norm). Only blocks of
        which `stress_is_known` count: statics does not tell where in others the reactions act.
    displacement_errors : tuple of Difference
        Of the displacement vector against `matched`, and against `nominal`; none where nothing moves.
    force_error : Difference or None
        Of the force between every two blocks; None where the continuum has no joints.
    worst_pair : (int, int) or None
        The blocks between which joint forces differ most.
    joint_movement : JointMovement or None
        Opening and slip by the Block-Spring Model at the points of ``nominal.contacts``; None where there are none.
    movement_errors : tuple of Difference
        Of opening and slip against `nominal`, over those points; none where nothing moves.
    bolts : BoltForces
        By the Block-Spring Model.
    bolt_error : Difference or None
        Of the tensions of all elements of bolts; None where there are no bolts, or none with a tension.
    worst_bolt : str
        The bolt in which they differ most.
    slipping : (float, float)
        Share of the joints' length that slips, is at 99 % of its strength or more, or is open: blocks, continuum.
    corners : str
        What corners that met others at nodes of the mesh bear in the blocks alone, in words; empty: next to nothing.
    histories : tuple of HistoryValue
        The model's histories at the end of the stage.
    refined : float or None
        L2 change of the continuum's displacements by finer elements and interfaces; None where that was not asked.
    refinement : Refinement or None
        What halving elements and interfaces does; None where that was not asked, or nothing moves.
    area : (n,) float64 [m2]
        Of the blocks.
    centroid : (n, 2) float64 [m]
        Of the blocks.
    bsm_seconds, fem_seconds : float
        Wall time of the run up to here, and of one continuum solution.
    notes : tuple of str
        Parts that the continuum leaves out or treats in its own way.
    """

    present: BoolArray
    stress: FloatArray
    displacement: FloatArray
    nominal: ContinuumSolution
    matched: ContinuumSolution
    stress_difference: FloatArray
    displacement_difference: FloatArray
    stress_errors: tuple[Difference, ...]
    displacement_errors: tuple[Difference, ...]
    force_error: Difference | None
    worst_pair: tuple[int, int] | None
    joint_movement: JointMovement | None
    movement_errors: tuple[Difference, ...]
    bolts: BoltForces
    bolt_error: Difference | None
    worst_bolt: str
    slipping: tuple[float, float]
    corners: str
    histories: tuple[HistoryValue, ...]
    refined: float | None
    refinement: Refinement | None
    area: FloatArray
    centroid: FloatArray
    bsm_seconds: float
    fem_seconds: float
    notes: tuple[str, ...]

    @property
    def errors(self) -> tuple[Difference, ...]:
        """All differences."""
        of_joints = (self.force_error, *self.movement_errors, self.bolt_error)
        return (*self.stress_errors, *self.displacement_errors, *(error for error in of_joints if error is not None))

    @property
    def is_rigid(self) -> bool:
        """Whether all rock is rigid: then refining tells of the contact points alone."""
        return self.matched is self.nominal

    def where(self, error: Difference) -> str:
        """Return where one of the differences is greatest."""
        if error is self.force_error and self.worst_pair is not None:
            return "blocks {} and {}".format(*self.worst_pair)
        if error in self.movement_errors:
            points, worst = self.nominal.contacts, error.worst_block
            one, other = sorted((int(points.block_a[worst]), int(points.block_b[worst])))
            return f"blocks {one} and {other}"
        return self.worst_bolt if error is self.bolt_error else f"block {error.worst_block}"

    def along(self, blocks: npt.ArrayLike) -> Section:
        """Return the stresses in the named blocks, for example along a section."""
        ids = np.asarray(blocks, dtype=np.int32)
        return Section(
            block=ids,
            area=self.area[ids],
            centroid=self.centroid[ids],
            bsm=self.stress[ids],
            fem=self.nominal.stress[ids],
        )

    def table(self) -> tuple[Row, ...]:
        """Return lines for a terminal: means and worst blocks, displacements, joint forces, times."""
        rows = []
        for error in self.errors:
            rows.append(Row(f"{error.name}, r.m.s.", error.rms_bsm, error.rms_fem, error.rms_difference, error.unit))
            rows.append(Row(f"{error.name}, L2 difference", None, None, 100 * error.l2, "%"))
            label = f"{error.name}, worst {self.where(error)}"
            rows.append(Row(label, error.worst_bsm, error.worst_fem, error.worst_difference, error.unit))
            rows.append(Row(f"{error.name}, largest difference", None, None, 100 * error.largest, "%"))
        if self.force_error is not None:
            blocks, fem = (100 * share for share in self.slipping)
            rows.append(Row("joints that slip or are open, by length", blocks, fem, blocks - fem, "%"))
        rows.append(Row("wall time", self.bsm_seconds, self.fem_seconds, self.bsm_seconds - self.fem_seconds, "s"))
        return tuple(rows)

    @property
    def sentence(self) -> str:
        """How far both lie apart, in words."""
        parts = []
        if self.displacement_errors:
            parts.append(f"{percent(self.displacement_errors[0].l2)} in displacement")
        if self.force_error is not None:
            parts.append(f"{percent(self.force_error.l2)} in joint forces")
        else:
            parts.append(f"{percent(self.stress_errors[-1].l2)} in stress")
        if self.bolt_error is not None:
            parts.append(f"{percent(self.bolt_error.l2)} in bolt forces")
        what = " with the same joints" if self.force_error is not None else ""
        begin = (
            f"{'' if self.displacement_errors else 'Nothing moves here. '}Blocks and finite elements{what} differ by "
        )
        refined = (
            f"; refining alone changes the elements' displacement by {percent(self.refined)}" if self.refined else ""
        )
        if self.refined is not None and self.refined > COARSE:
            coarse = "the contact points of both" if self.is_rigid else "the elements, or the contact points of both,"
            refined += f": {coarse} are too coarse for displacements"
        study = f"; {self.refinement.sentence}" if self.refinement else ""
        corners = f"; {self.corners}" if self.corners and self.force_error is not None else ""
        return f"{begin}{enumerated(parts)}{corners}{refined}{study}."


def enumerated(parts: Sequence[str]) -> str:
    """Return the parts of a list in words."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def percent(share: float) -> str:
    """Return a share as a percentage that is not more exact than it deserves."""
    return "less than 0.1 %" if share < 1e-3 else f"{100 * share:.1f} %" if share < 0.1 else f"{100 * share:.0f} %"
