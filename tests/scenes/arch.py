"""A semicircular arch of equal straight-sided voussoirs under their weight."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tests.scenes.models import model_of


def arch(n, thickness, friction=89.0, **given):
    """Return n stones, radius 1 m to the centre line, on two fixed springings."""
    angle = np.linspace(np.pi, 0, n + 1)
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    stones = [[inner * a, inner * b, outer * b, outer * a] for a, b in pairwise(ray)]
    springings = [[(s * inner, 0), (s * outer, 0), (s * outer, -0.2), (s * inner, -0.2)] for s in (-1, 1)]
    return model_of([*stones, *springings], friction=friction, **{"kn": 1e10} | given, fixed=(n, n + 1))
