"""Ways to an equilibrium of which none is better: blocks in another order, another solver, another method first."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.solve.continuation.plan import OTHERS
from bsm_mesh.solving import solve

ORDERS = (1, 2)  # seeds


def reordered(model: bsm.Model, seed: int) -> bsm.Model:
    """Return the model with its blocks in another order.

    Raises
    ------
    ValueError
        If supports or loads name blocks by number.
    """
    numbered = [getattr(thing, name, None) for thing in (*model.supports, *model.loads) for name in ("block", "blocks")]
    if any(number is not None for number in numbered):
        raise ValueError("supports or loads of this model name blocks by number")
    return model.replace(blocks=_permuted(model.blocks, np.random.default_rng(seed).permutation(model.blocks.count)))


def _permuted(blocks: Blocks, order: np.ndarray) -> Blocks:
    sizes = np.diff(blocks.offsets)[order]
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    corner = np.arange(offsets[-1]) + np.repeat(blocks.offsets[:-1][order] - offsets[:-1], sizes)
    new_corner, new_block = np.argsort(corner), np.argsort(order)
    return dataclasses.replace(
        blocks,
        vertices=blocks.vertices[corner],
        offsets=offsets,
        nodes=blocks.nodes[corner],
        rock=blocks.rock[order],
        edge_joint=blocks.edge_joint[corner],
        boundaries={name: np.sort(new_corner[edges]) for name, edges in blocks.boundaries.items()},
        excavations={name: np.sort(new_block[ids]) for name, ids in blocks.excavations.items()},
    )


def other_routes(model: bsm.Model, options: bsm.Options) -> Iterator[tuple[str, Callable[[], bsm.Results]]]:
    """Yield the name of a route, and a function that runs the model by it."""
    for route in OTHERS:
        if model.in_situ is None or len(route.parts) == 1:  # in-situ stress acts from the start: nothing in parts
            yield route.name, lambda route=route: solve(model, options, route=route)
    yield "solver SuperLU", lambda: bsm.run(model, dataclasses.replace(options, linear_solver="superlu"))
    for seed in ORDERS:
        yield f"blocks in another order, {seed}", lambda seed=seed: bsm.run(reordered(model, seed), options)
