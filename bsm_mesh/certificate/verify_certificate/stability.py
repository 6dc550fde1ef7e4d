"""Directions in which blocks fall from an equilibrium."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import Arrays, cross, turned_left

NEUTRAL = 1e-3  # negative eigenvalue of the stiffness over the mass that counts as none, over the block size
MAX_DENSE = 1200  # blocks whose stability is checked here


def falling(a: Arrays, *, linear: bool) -> tuple[str, list[str]]:
    """Return whether blocks would fall from the equilibrium: its stiffness is not positive.

    Slipping contacts slip: they keep their shear, and turn it with them, but carry no more.
    """
    here = np.flatnonzero(a["present"])
    if len(here) > MAX_DENSE:
        return "falling directions are not looked for here in so large a model", []
    K = stiffness(a, here, linear=linear)
    weight = np.hypot(*a["weight"][here].T)
    weight = np.maximum(weight, 1e-3 * (weight.mean() or 1.0))
    shift = NEUTRAL / float(np.median(np.sqrt(a["area"][here])))
    mass = np.column_stack([weight, weight, weight * a["gyration"][here] ** 2])
    K[np.arange(len(K)), np.arange(len(K))] += shift * mass.reshape(-1)
    axes = free_axes(a, here)
    K = K.reshape(len(here), 3, len(here), 3).transpose(0, 2, 1, 3)
    K = (axes.transpose(0, 2, 1)[:, None] @ K @ axes[None, :]).transpose(0, 2, 1, 3).reshape(3 * len(here), -1)
    held = np.flatnonzero(~axes.any(axis=1).reshape(-1))
    K[held, held] = 1.0
    try:
        np.linalg.cholesky(K)
    except np.linalg.LinAlgError:
        return "", ["there is a direction in which blocks fall"]
    return "no direction in which blocks fall", []


def free_axes(a: Arrays, here: Any) -> Any:
    """Return the movements that the supports leave to every block, columns (n, 3, 3); zero where it is held."""
    axes = np.tile(np.eye(3), (len(here), 1, 1))
    for number in np.flatnonzero(np.isin(here, a["bar_block"])):
        bars = a["bar_block"] == here[number]
        arm, along = a["bar_point"][bars] - a["at"][here[number]], a["bar_direction"][bars]
        turn = np.where(a["bar_turns"][bars], a["gyration"][here[number]], cross(arm, along))
        rows = np.column_stack([along, turn / a["gyration"][here[number]]])
        _, size, directions = np.linalg.svd(np.vstack([rows, np.zeros((3, 3))]))
        axes[number] = np.where(size > 1e-9 * size[0], 0.0, directions.T)
    axes[:, 2] /= a["gyration"][here][:, None]
    return axes


def stiffness(a: Arrays, here: Any, *, linear: bool) -> Any:
    """Return the stiffness (3n, 3n) of the blocks (n,): closed contacts, loads, water, and bolts."""
    number = np.zeros(len(a["present"]), dtype=int)
    number[here] = np.arange(len(here))
    K = np.zeros((3 * len(here), 3 * len(here)))
    acts = np.flatnonzero((a["contact_status"] < 2) | a["near"])
    n = a["contact_normal"][acts]
    t = turned_left(n)
    blocks = [a[f"contact_block_{side}"][acts] for side in "ab"]
    arms = [a["contact_point"][acts] - a["at"][block] for block in blocks]
    place = np.column_stack([3 * number[block] + axis for block in blocks for axis in range(3)])
    for along, turned, name in (n, t, "normal"), (t, -n, "shear"):
        moves = np.column_stack([along, cross(arms[0], along), -along, -cross(arms[1], along)])
        slips = (a["contact_status"][acts] == 1) & (name == "shear")
        springs = np.where(slips, 0.0, a[f"{name}_stiffness"][acts])
        parts = springs[:, None, None] * moves[:, :, None] * moves[:, None, :]
        if not linear:
            parts += a[f"contact_{name}_force"][acts][:, None, None] * turning(along, turned, *arms)
        np.add.at(K, (place[:, :, None], place[:, None, :]), parts)
    if "load_stiffness" in a:
        own = 3 * np.arange(len(here))[:, None] + np.arange(3)
        K[own[:, :, None], own[:, None, :]] += a["load_stiffness"][here]
    for (row, column), block in zip(number[a["bolt_pair"]], a["bolt_tangent"], strict=True):
        K[3 * row : 3 * row + 3, 3 * column : 3 * column + 3] += block
    return (K + K.T) / 2


def turning(along: Any, turned: Any, arm_a: Any, arm_b: Any) -> Any:
    """Return the second derivatives (m, 6, 6) of the relative movement along a vector that turns with block b."""
    G = np.zeros((len(along), 6, 6))
    G[:, 2, 2], G[:, 5, 5] = -(arm_a * along).sum(axis=1), -(arm_b * along).sum(axis=1)
    G[:, :2, 5], G[:, 2, 5], G[:, 3:5, 5] = turned, cross(arm_a, turned), -turned
    G[:, 5, :5] = G[:, :5, 5]
    return G
