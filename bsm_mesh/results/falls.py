"""Blocks that fell and were taken away while the others stayed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Fall:
    """A block that fell and was taken away.

    Attributes
    ----------
    block : int
        Number of the block.
    origin : tuple of float [m]
        Its centroid in the model as given: where the block came from.
    place : tuple of float [m]
        Its centroid when it was taken away.
    moved : float [m]
        How far it moved in the stage.
    area : float [m2]
        Its area; in space its volume [m3].
    weight : float [N/m]
        Its weight.
    step : int
        The step of the stage in which it was taken away.
    reason : str
        Why, in words.
    ignored : bool
        Whether it is too small to count for the verdict.
    """

    block: int
    origin: tuple[float, ...]
    place: tuple[float, ...]
    moved: float
    area: float
    weight: float
    step: int
    reason: str
    ignored: bool

    @property
    def bulk(self) -> float:
        """Its area; in space its volume."""
        return self.area
