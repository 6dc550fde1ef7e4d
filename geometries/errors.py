"""What is raised when a geometry cannot be built. Of `bsm_mesh` only what reads, writes and shows texts is needed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

from bsm_mesh.errors import one_line


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
        lines = [one_line(fault) for fault in self.faults]  # files of traces name sets and layers as they like
        if len(lines) != 1:
            lines = [f"{len(lines)} faults:", *(f"  - {line}" for line in lines)]
        super().__init__("\n".join(lines))

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
