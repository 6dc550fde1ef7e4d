"""Rules for single numbers in the model, each broken rule one sentence."""

from __future__ import annotations

import math


class Rules:
    """Collects what is wrong with the values of one named thing.

    Parameters
    ----------
    thing : str
        What the values belong to, for example ``"rock 'gneiss'"``.
    """

    def __init__(self, thing: str) -> None:
        self.thing = thing
        self.faults: list[str] = []

    def number(
        self,
        name: str,
        value: float | None,
        unit: str,
        *,
        above: float = -math.inf,
        least: float = -math.inf,
        below: float = math.inf,
        most: float = math.inf,
    ) -> None:
        """Demand a finite number in a range; None (not given) passes."""
        if value is None:
            return
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            self.faults.append(f"{self.thing}: {name} = {value!r} is not a finite number [{unit}]")
            return
        for holds, rule in (
            (value > above, f"be above {above:g}"),
            (value >= least, f"be {least:g} or more"),
            (value < below, f"be below {below:g}"),
            (value <= most, f"be {most:g} or less"),
        ):
            if not holds:
                self.faults.append(f"{self.thing}: {name} = {value:g} {unit}".rstrip() + f" must {rule}")

    def name(self, value: object) -> None:
        """Demand a non-empty text as the thing's name."""
        if not isinstance(value, str) or not value.strip():
            self.faults.append(f"{self.thing}: the name must be a non-empty text")
