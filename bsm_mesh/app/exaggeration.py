"""How many times movements are drawn larger than they are."""

from __future__ import annotations

import numpy as np

SEEN = 0.02  # of the model's size: the greatest movement that is drawn; half of that is seen with ease
FACTORS = (1, 2, 5)  # times powers of ten


def round_factor(factor: float) -> float:
    """Return 1, 2 or 5 times a power of ten, not above `factor`, and at least 1.

    Examples
    --------
    >>> round_factor(77.0), round_factor(0.3)
    (50.0, 1.0)
    """
    if factor < 1:
        return 1.0
    power = 10.0 ** np.floor(np.log10(factor))
    return float(max(step for step in FACTORS if step * power <= factor * (1 + 1e-9)) * power)


def exaggeration(greatest: float, size: float) -> float:
    """Return the factor on movements at which the greatest of them is seen, and nothing looks like a collapse.

    Parameters
    ----------
    greatest : float [m]
        The greatest movement.
    size : float [m]
        Of the model.
    """
    return round_factor(SEEN * size / greatest) if greatest > 0 else 1.0


def factors_up_to(greatest: float) -> list[float]:
    """Return 0 and the round factors from 1 to `greatest`.

    Examples
    --------
    >>> factors_up_to(20)
    [0.0, 1.0, 2.0, 5.0, 10.0, 20.0]
    """
    powers = range(int(np.floor(np.log10(max(greatest, 1.0)))) + 1)
    return [0.0, *(float(step * 10**power) for power in powers for step in FACTORS if step * 10**power <= greatest)]
