"""How far one quantity lies apart in two methods, over all blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.results.stress import principal_stresses

NEGLIGIBLE = 1e-6  # of the whole stress: a component of the continuum below it has no scale of its own


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
        R.m.s. and greatest value that take the place of the field's own where these are negligible compared with them.
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
