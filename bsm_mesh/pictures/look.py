"""From where a picture of space is seen: a direction, without perspective."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError

ASIDE = 25.0  # degrees: so far the view is turned from the faces that it is for, so that a box shows three sides
STEEPEST = 45.0  # degrees, up or down, that a view takes by itself


@dataclass(frozen=True, slots=True)
class Look:
    """A direction in which one looks.

    Attributes
    ----------
    azimuth : float [degrees]
        Clockwise from north.
    plunge : float [degrees]
        Downwards from the level; negative: upwards.

    Examples
    --------
    >>> Look(0.0, 90.0).flat(np.array([[1.0, 2.0, 3.0]])).round(9).tolist()
    [[1.0, 2.0]]
    """

    azimuth: float = 20.0
    plunge: float = 25.0

    @classmethod
    def checked(cls, azimuth: float, plunge: float) -> Self:
        """Return a direction that is given by a user.

        Raises
        ------
        ModelError
            If it is none.
        """
        if not np.isfinite(azimuth) or not -90 <= plunge <= 90:
            raise ModelError(
                f"plot: look {azimuth:g} {plunge:g}: give the azimuth in degrees from north and the plunge from -90 "
                "(up) to 90 (down)"
            )
        return cls(float(azimuth) % 360.0, float(plunge))

    @classmethod
    def along(cls, vector: FloatArray) -> Self:
        """Return the view along a vector (3,), turned a little aside, and not too steep."""
        level = float(np.hypot(vector[0], vector[1]))
        azimuth = float(np.degrees(np.arctan2(vector[0], vector[1]))) if level > 1e-9 * abs(vector[2]) else 0.0
        plunge = float(np.degrees(np.arctan2(-vector[2], level)))
        return cls((azimuth + ASIDE) % 360.0, float(np.clip(plunge, -STEEPEST, STEEPEST)))

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, up and ahead, (3, 3)."""
        alpha, fall = np.radians(self.azimuth), np.radians(self.plunge)
        ahead = np.array([np.cos(fall) * np.sin(alpha), np.cos(fall) * np.cos(alpha), -np.sin(fall)])
        right = np.array([np.cos(alpha), -np.sin(alpha), 0.0])
        return np.stack([right, np.cross(right, ahead), ahead])

    def flat(self, points: FloatArray) -> FloatArray:
        """Return points or vectors (k, 3) as they are seen: to the right and up, (k, 2)."""
        seen: FloatArray = points @ self.axes[:2].T
        return seen

    def distance(self, points: FloatArray) -> FloatArray:
        """Return how far points (k, 3) lie ahead, (k,)."""
        ahead: FloatArray = points @ self.axes[2]
        return ahead

    def __str__(self) -> str:
        way = "down" if self.plunge >= 0 else "up"
        return f"looking to {self.azimuth:03.0f}, {abs(self.plunge):.0f} degrees {way}"
