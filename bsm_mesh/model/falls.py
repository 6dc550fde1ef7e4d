"""The treatment of unstable blocks: the run ends, or they are taken away and the others continue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.quantities import SHARE
from bsm_mesh.model.values import Rules

OnFall = Literal["stop", "remove"]
MOST_OF_A_CHIP = 0.1  # of the mean area: the largest `ignore_below` that a note suggests


@dataclass(frozen=True, slots=True, kw_only=True)
class Falls:
    """The treatment of unstable blocks.

    Attributes
    ----------
    ignore_below : float
        Share of the mean area (in space: volume). Smaller blocks, such as slivers of a mesh, do not count for the
        verdict and are removed when they are loose. 0: every block counts.
    on_fall : {"stop", "remove"}
        ``"stop"``: the stage is unstable, and the run ends. ``"remove"``: every unstable block is listed and
        removed, as a roof is scaled. The stage is stable after falls if the other blocks reach rest.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Falls().ignore_below, bsm.Falls(on_fall="remove").on_fall
    (0.01, 'remove')
    """

    ignore_below: Annotated[float, SHARE] = 0.01
    on_fall: OnFall = "stop"

    def __post_init__(self) -> None:
        rules = Rules("falls")
        rules.numbers(self)
        rules.choice("on_fall", self.on_fall, get_args(OnFall))
        raise_faults(rules.faults)

    def small(self, blocks: Blocks, counted_blocks: BoolArray, pieces: FloatArray | None = None) -> BoolArray:
        """Return which blocks (n,) are too small to count; the mean is that of the blocks (n,) that may move.

        `pieces` (n,) is the bulk of the piece that a block is a part of, where blocks share nodes of zones.
        """
        bulk = blocks.moments.bulk
        mean = float(bulk[counted_blocks].mean()) if counted_blocks.any() else 0.0
        small: BoolArray = (bulk if pieces is None else pieces) < self.ignore_below * mean
        return small

    def takes_away(self, small: BoolArray) -> bool:
        """Return whether the run continues without unstable blocks, (k,) of which are small."""
        return small.size > 0 and (self.on_fall == "remove" or bool(small.all()))
