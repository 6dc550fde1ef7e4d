"""Which coordinates in space are right and up in the section of a drawing or mesh."""

from __future__ import annotations

from collections.abc import Sequence

PLANE_TOLERANCE = 1e-6  # of the size: single-precision coordinates are that exact


def section_axes(extent: Sequence[float]) -> tuple[int, int] | None:
    """Return which coordinate is right and which is up; None if no coordinate is the same everywhere.

    Parameters
    ----------
    extent : sequence of float
        Along x, y and z, in any unit of length. A section in the xy plane keeps its axes; in the other two z is up.

    Examples
    --------
    >>> section_axes((10, 5, 0)), section_axes((10, 0, 5)), section_axes((0, 10, 5)), section_axes((10, 5, 2))
    ((0, 1), (0, 2), (1, 2), None)
    """
    for constant, axes in ((2, (0, 1)), (1, (0, 2)), (0, (1, 2))):
        if extent[constant] <= PLANE_TOLERANCE * max(extent):
            return axes
    return None
