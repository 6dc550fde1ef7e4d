"""The rule of the line search of Newton's method, of rigid blocks and of zones."""

from __future__ import annotations

import numpy as np


class Decrease:
    """The part of a correction that is taken: the first that reduces the residual, else the best.

    Parameters
    ----------
    most : float
        A norm of the residual below which a state is taken: that of the last state, or the greatest of the last few
        (Grippo et al.).
    enough : float
        Of a part: by how much of `most` the norm has to be less (Armijo's rule).

    References
    ----------
    Grippo, Lampariello & Lucidi (1986), A nonmonotone line search technique for Newton's method, SIAM J. Numer. Anal.
    23(4), 707-716.
    """

    def __init__(self, most: float, enough: float = 0.0) -> None:
        self._most, self._enough, self._taken = most, enough, False
        self._norms: list[float] = []

    def reached(self, norm: float, part: float) -> bool:
        """Return whether the norm after a part is low enough; NaN never is."""
        self._norms.append(norm)
        self._taken = norm < (1 - self._enough * part) * self._most
        return self._taken

    @property
    def chosen(self) -> int:
        """Number of the part that is taken, of those that were tried."""
        return len(self._norms) - 1 if self._taken else int(np.argmin(np.nan_to_num(self._norms, nan=np.inf)))
