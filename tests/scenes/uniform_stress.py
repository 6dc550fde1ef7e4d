"""Blocks under uniform stresses on their whole outline, and the elastic constants that they answer with."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

import bsm_mesh as bsm

STRESSES = np.array([[(1.0, 0), (0, 0)], [(0, 0), (0, 1)], [(0, 1), (1, 0)]]) * 1e6


def model_under(blocks: bsm.Blocks, rock: bsm.Rock, stress: np.ndarray) -> bsm.Model:
    """Return the blocks under tractions of a uniform stress on their whole outline, one block in the middle held."""
    edges = blocks.boundaries["outline"]
    along = blocks.edge_vectors[edges]
    tractions = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None] @ stress
    centroid = blocks.moments.centroid
    middle = int(np.argmin(np.hypot(*(centroid - centroid.mean(axis=0)).T)))
    return bsm.Model(
        blocks=blocks,
        rocks=[rock],
        supports=[bsm.Fixed(blocks=[middle])],
        loads=[bsm.EdgeTractions(boundary="outline", values=np.repeat(tractions[:, None], 2, axis=1))],
    )


def effective_stiffness(
    blocks: bsm.Blocks, rock: bsm.Rock, inner: np.ndarray, solve: Callable[[bsm.Model], Any]
) -> np.ndarray:
    """Return the 3 x 3 stiffness [Pa] from the mean strains of the inner blocks under three stresses."""
    plane = np.column_stack([np.ones(inner.sum()), blocks.moments.centroid[inner]])
    strains = []
    for stress in STRESSES:
        displacement = solve(model_under(blocks, rock, stress)).displacement
        H = np.linalg.lstsq(plane, displacement[inner, :2], rcond=None)[0][1:].T
        strains.append((H[0, 0], H[1, 1], H[0, 1] + H[1, 0]))
    return 1e6 * np.linalg.inv(np.array(strains).T)


def with_outline(polygons: Iterable[np.ndarray]) -> bsm.Blocks:
    """Return blocks of rock whose outer edges are the boundary `outline`."""
    blocks = bsm.Blocks.from_polygons(list(polygons), rock="rock", merge_tolerance=1e-7)
    return bsm.Blocks(
        **{n: getattr(blocks, n) for n in ("vertices", "offsets", "nodes", "rock", "rock_names", "edge_joint")},
        boundaries={"outline": blocks.outer_edges},
    )


def parallelograms(n: int, first: tuple[float, float], second: tuple[float, float]) -> list[np.ndarray]:
    """Return n by n equal cells with the sides `first` and `second`."""
    corners = np.array([(i, j) for j in range(n) for i in range(n)])[:, None] + [(0, 0), (1, 0), (1, 1), (0, 1)]
    return list(corners @ np.array([first, second]))
