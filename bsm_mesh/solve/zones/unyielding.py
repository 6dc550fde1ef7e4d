"""Rock in large displacement that yields no further: elastic, less the stress that yielding took so far."""

from __future__ import annotations

from dataclasses import replace

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.zones.equilibrium import Equations


def yielding_no_further(equations: Equations, part: FloatArray | None = None) -> Equations:
    """Return equations in large displacement with the stress that yielding took so far, of rock that yields no further.

    `part` (t,) is that of the rock's stiffness which cells have.
    """
    large, plastic = equations.large, equations.plastic
    if large is None or plastic is None:
        return equations
    cells = plastic.of.cells
    relief = plastic.relief if part is None else plastic.relief * part[cells, None, None]
    return replace(equations, large=replace(large, rock=large.rock.relieved(cells, relief)), plastic=None)
