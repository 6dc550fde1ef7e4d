"""How long an element's edge is where: grading of unstructured and of structured meshes."""

from __future__ import annotations

import math

from bsm_mesh.geometries.session import load_gmsh


def grow_sizes_from(point: int, *, near: float, far: float, start: float, end: float) -> None:
    """Let the size in the current model grow evenly with the distance from a point.

    Parameters
    ----------
    point : int
        Tag of the point, after synchronising.
    near, far : float
        Length of an element's edge up to the distance `start` and from the distance `end` on [m].
    start, end : float
        Distances [m].
    """
    field = load_gmsh().model.mesh.field
    distance = field.add("Distance")
    field.setNumbers(distance, "PointsList", [point])
    threshold = field.add("Threshold")
    numbers = {"InField": distance, "DistMin": start, "DistMax": end, "SizeMin": near, "SizeMax": far}
    for name, value in numbers.items():
        field.setNumber(threshold, name, value)
    field.setAsBackgroundMesh(threshold)


def graded_layers(length: float, first: float, last: float) -> tuple[int, float]:
    """Return how many layers fill `length`, from thickness `first` to `last`, and the ratio of neighbours.

    The count is the integral of 1 / thickness where the thickness grows evenly with the distance, so
    that halving both thicknesses doubles it.

    Parameters
    ----------
    length, first, last : float
        In metres; `first` is at most `last`.

    Examples
    --------
    >>> graded_layers(9.0, 0.5, 0.5)
    (18, 1.0)
    >>> graded_layers(9.0, 0.26, 0.52)[0], graded_layers(9.0, 0.13, 0.26)[0]
    (24, 48)
    """
    ratio = last / first
    mean = first * (ratio - 1.0) / math.log(ratio) if ratio > 1.0 else first
    layers = max(1, round(length / mean))
    return layers, ratio ** (1.0 / max(1, layers - 1))
