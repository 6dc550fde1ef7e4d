"""Results of the Block-Spring Model beside the continuum solution of the same model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.continuum.sections import Section
from bsm_mesh.converters.continuum.solution import ContinuumSolution
from bsm_mesh.converters.continuum.stages import Continuum
from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Results
from bsm_mesh.results.stress import principal_stresses

NEGLIGIBLE = 1e-6  # of the whole stress: a component of the continuum below it has no scale of its own


class Row(NamedTuple):
    """A line of the table: a value of both methods (None in lines of percentages) and their difference."""

    label: str
    bsm: float | None
    fem: float | None
    difference: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """How far one quantity of the two methods lies apart, over all blocks.

    Attributes
    ----------
    name : str
        The quantity.
    unit : str
        Of the values below that are not relative.
    rms_bsm, rms_fem, rms_difference : float
        Root of the area-weighted mean square (of the magnitude, for tensors and vectors).
    l2 : float
        `rms_difference` over `rms_fem`.
    largest : float
        Greatest magnitude of the difference over the greatest magnitude in the continuum solution.
    worst_block : int
        Where the difference is greatest.
    worst_bsm, worst_fem, worst_difference : float
        Values (magnitudes, for tensors and vectors) there.

    A stress component that is below 1e-6 of the continuum's whole stress has no scale of its own; `l2` and
    `largest` are then relative to the whole stress.
    """

    name: str
    unit: str
    rms_bsm: float
    rms_fem: float
    rms_difference: float
    l2: float
    largest: float
    worst_block: int
    worst_bsm: float
    worst_fem: float
    worst_difference: float


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Comparison:
    """The Block-Spring Model beside the continuum; differences are the first less the second.

    Attributes
    ----------
    stress : (n, 2, 2) float64 [Pa]
        Average stress of every block by the Block-Spring Model.
    displacement : (n, 3) float64 [m, m, rad]
        u, v and rotation of every block by the Block-Spring Model.
    nominal : ContinuumSolution
        With the rocks' own E and Poisson's ratio: the reference for stresses.
    matched : ContinuumSolution
        With the elastic constants that the blocks really have: the only fair reference for displacements.
    stress_difference : (n, 2, 2) float64 [Pa]
        From `nominal`.
    displacement_difference : (n, 3) float64 [m, m, rad]
        From `matched`.
    stress_errors : tuple of Difference
        Of sigma_xx, sigma_yy, sigma_xy, sigma_1, and of the whole tensor (Frobenius norm).
    displacement_errors : tuple of Difference
        Of the displacement vector against `matched`, and against `nominal`.
    area : (n,) float64 [m2]
        Of the blocks.
    centroid : (n, 2) float64 [m]
        Of the blocks.
    bsm_seconds, fem_seconds : float
        Wall time of the run, and of one continuum solution.
    notes : tuple of str
        What the continuum leaves out or treats in its own way.
    """

    stress: FloatArray
    displacement: FloatArray
    nominal: ContinuumSolution
    matched: ContinuumSolution
    stress_difference: FloatArray
    displacement_difference: FloatArray
    stress_errors: tuple[Difference, ...]
    displacement_errors: tuple[Difference, ...]
    area: FloatArray
    centroid: FloatArray
    bsm_seconds: float
    fem_seconds: float
    notes: tuple[str, ...]

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
        """Return lines for a terminal: means and worst blocks, displacements, times."""
        rows = []
        for error in (*self.stress_errors, *self.displacement_errors):
            rows.append(Row(f"{error.name}, r.m.s.", error.rms_bsm, error.rms_fem, error.rms_difference, error.unit))
            rows.append(Row(f"{error.name}, L2 difference", None, None, 100 * error.l2, "%"))
            label = f"{error.name}, worst block {error.worst_block}"
            rows.append(Row(label, error.worst_bsm, error.worst_fem, error.worst_difference, error.unit))
            rows.append(Row(f"{error.name}, largest difference", None, None, 100 * error.largest, "%"))
        rows.append(Row("wall time", self.bsm_seconds, self.fem_seconds, self.bsm_seconds - self.fem_seconds, "s"))
        return tuple(rows)


def compare(model: Model, results: Results, *, order: int = 2, joints: bool = False) -> Comparison:
    """Return the last stage of a run beside the continuum solutions of its model.

    Parameters
    ----------
    model : Model
        What was run.
    results : Results
        What came out.
    order : {1, 2}
        Polynomial order of the continuum's displacements.
    joints : bool
        Whether the continuum's joints are elastic interface elements; else they are ignored.

    Raises
    ------
    ModelError
        If the results are another model's, blocks were excavated, or the continuum cannot be solved.
    """
    if results.model_digest != model.digest:
        raise ModelError("the results are not those of this model; run it again")
    stage = results.stages[-1]
    if not stage.present.all():
        raise ModelError("the continuum solution knows no excavation; compare a model without stages")
    continuum = Continuum(model, order, joints)
    nominal, matched = continuum.solve("nominal")[-1], continuum.solve("matched")[-1]
    moments = model.blocks.moments
    return Comparison(
        stress=stage.stress,
        displacement=stage.displacement,
        nominal=nominal,
        matched=matched,
        stress_difference=stage.stress - nominal.stress,
        displacement_difference=stage.displacement - matched.displacement,
        stress_errors=stress_errors(stage.stress, nominal.stress, moments.area),
        displacement_errors=tuple(
            measure_difference(
                f"displacement, {name}",
                "m",
                stage.displacement[:, :2],
                solution.displacement[:, :2],
                moments.area,
            )
            for name, solution in (("matched E*", matched), ("nominal E", nominal))
        ),
        area=moments.area,
        centroid=moments.centroid,
        bsm_seconds=stage.seconds,
        fem_seconds=nominal.seconds,
        notes=matched.notes,
    )


def stress_errors(bsm: FloatArray, fem: FloatArray, area: FloatArray) -> tuple[Difference, ...]:
    """Return the differences of sigma_xx, sigma_yy, sigma_xy, sigma_1 and the whole tensor.

    Parameters
    ----------
    bsm, fem : (n, 2, 2) float64 [Pa]
        Stresses of the blocks by both methods.
    area : (n,) float64 [m2]
        Areas of the blocks, the weights of the mean squares.
    """
    whole = measure_difference("stress", "Pa", bsm.reshape(-1, 4), fem.reshape(-1, 4), area)
    parts = {
        "sigma_xx": (bsm[:, 0, 0], fem[:, 0, 0]),
        "sigma_yy": (bsm[:, 1, 1], fem[:, 1, 1]),
        "sigma_xy": (bsm[:, 0, 1], fem[:, 0, 1]),
        "sigma_1": (principal_stresses(bsm)[0], principal_stresses(fem)[0]),
    }
    greatest = float(np.linalg.norm(fem, axis=(1, 2)).max())
    return (
        *(measure_difference(name, "Pa", *pair, area, (whole.rms_fem, greatest)) for name, pair in parts.items()),
        whole,
    )


def measure_difference(
    name: str,
    unit: str,
    bsm: FloatArray,
    fem: FloatArray,
    area: FloatArray,
    whole: tuple[float, float] = (0.0, 0.0),
) -> Difference:
    """Return how far two fields (n,) or (n, components) over the blocks lie apart.

    Parameters
    ----------
    name, unit : str
        Of the quantity.
    bsm, fem : (n,) or (n, components) float64
        The fields.
    area : (n,) float64 [m2]
        The weights of the mean squares.
    whole : pair of float
        R.m.s. and greatest value that take the place of the field's own where these are negligible beside them.
    """
    difference = bsm - fem
    size, fem_size = _magnitude(difference), _magnitude(fem)
    rms_fem, rms_difference = _rms(fem_size, area), _rms(size, area)
    own = rms_fem > NEGLIGIBLE * whole[0]
    scale, greatest = (rms_fem, float(fem_size.max())) if own else whole
    worst = int(size.argmax())
    values = (bsm, fem, difference) if bsm.ndim == 1 else (_magnitude(bsm), fem_size, size)
    return Difference(
        name=name,
        unit=unit,
        rms_bsm=_rms(_magnitude(bsm), area),
        rms_fem=rms_fem,
        rms_difference=rms_difference,
        l2=rms_difference / scale if scale > 0 else rms_difference,
        largest=float(size[worst]) / greatest if greatest > 0 else float(size[worst]),
        worst_block=worst,
        worst_bsm=float(values[0][worst]),
        worst_fem=float(values[1][worst]),
        worst_difference=float(values[2][worst]),
    )


def _magnitude(values: FloatArray) -> FloatArray:
    size: FloatArray = np.abs(values) if values.ndim == 1 else np.linalg.norm(values, axis=1)
    return size


def _rms(size: FloatArray, area: FloatArray) -> float:
    return float(np.sqrt((area * size**2).sum() / area.sum()))
