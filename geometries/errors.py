"""What is raised when a geometry cannot be built. Of `bsm_mesh` only the writer of files is needed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence


class GeometryError(ValueError):
    """The geometry cannot be built: every fault found, each with its place, rule and cure.

    Parameters
    ----------
    faults : str or sequence of str
        One sentence per fault.

    Attributes
    ----------
    faults : tuple of str
        The sentences, in the order in which they were found.
    """

    def __init__(self, faults: str | Sequence[str]) -> None:
        self.faults: tuple[str, ...] = (faults,) if isinstance(faults, str) else tuple(faults)
        if len(self.faults) == 1:
            text = self.faults[0]
        else:
            text = "\n".join([f"{len(self.faults)} faults:", *(f"  - {fault}" for fault in self.faults)])
        super().__init__(text)

    def __reduce__(self) -> tuple[type[GeometryError], tuple[tuple[str, ...]]]:
        return type(self), (self.faults,)  # from another process too all faults, one by one


def nearest_name(name: str, known: Iterable[str]) -> str:
    """Return a hint such as ``"; did you mean 'radius'? (known: depth, radius)"`` for an unknown name."""
    names = sorted(known)
    if not names:
        return " (there are none)"
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    return f"{hint} (known: {', '.join(names)})"
