"""Signs that are allowed and most likely slips: pressures that pull, ground in tension."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.model.in_situ import places_of
from bsm_mesh.model.loads import Pressure

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model


def of_signs(model: Model) -> Iterator[str]:
    """Say which pressures pull everywhere on their boundary, and that the ground is given in tension."""
    loads = [("", model.loads), *((f"stage '{stage.name}': ", stage.loads) for stage in model.stages)]
    for place, acting in loads:
        for number, load in enumerate(acting, start=1):
            if isinstance(load, Pressure) and load.pressure[0] < 0 and not any(load.pressure[1:]):
                yield (
                    f"{place}load {number} (Pressure): {load.pressure[0]:g} Pa pulls on '{load.boundary}': "
                    "a positive pressure acts into the blocks"
                )
    if model.in_situ is not None and model.in_situ.stress is not None:
        corners = model.blocks.vertices
        at = np.column_stack([np.ones(len(corners)), corners])
        given = model.in_situ.stress
        normal = [part for (row, column), part in zip(places_of(given), given, strict=True) if row == column]
        if all((at[:, : len(part)] @ np.array(part)).min() > 0 for part in normal):
            yield "in_situ: stress is tension in all directions: compression is negative, for example yy = -3e6"
