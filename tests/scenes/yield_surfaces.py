"""Trial stresses for yield surfaces, and their tangents beside differences."""

from __future__ import annotations

import numpy as np

TANGENT = 1e-8  # of the stiffness: differences over strains of 1e-8, of stresses of 1e7 Pa
LAME, SHEAR = 2e9, 2.8e9


def trials(count=1000):
    """Return stresses (2 count, 4) [Pa], many of them beyond faces, edges and corners."""
    rng = np.random.default_rng(1773)
    return np.concatenate([rng.normal(-5e6, 8e6, (count, 4)), rng.normal(-1e6, 2e7, (count, 4))])


def tangent_error(rock, trial):
    """Return the greatest difference of the tangent from differences, over the stiffness, and the part compared.

    Trials whose ends lie on two faces are left out.
    """
    step = 1e-8
    elastic = np.array([(LAME + 2 * SHEAR, LAME, 0), (LAME, LAME + 2 * SHEAR, 0), (0, 0, SHEAR), (LAME, LAME, 0)])
    found = rock.returned(trial)
    tangent = rock.tangent(found, np.arange(len(trial)))
    same = np.ones(len(trial), dtype=bool)
    differences = np.zeros_like(tangent)
    for k in range(3):
        ends = [rock.returned(trial + sign * step * elastic[:, k]) for sign in (1, -1)]
        differences[:, :, k] = (ends[0].stress - ends[1].stress)[:, :3] / (2 * step)
        for end in ends:
            same &= (end.set == found.set) & (end.order == found.order).all(axis=1)
    return np.abs(tangent - differences)[same].max() / (LAME + 2 * SHEAR), same.mean()
