"""A circular hole under sigma_v = 10 MPa, K = 0.5: Kirsch's stresses, and blocks round a quarter of it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss

import bsm_mesh as bsm

A, FAR = 1.0, 20.0
P, Q = 10e6, 5e6


def kirsch(x, y):
    """Return the stress (..., 2, 2) [Pa], tension positive, p vertical and q horizontal (Wang Eq. 3.46)."""
    r, t = np.hypot(x, y), np.arctan2(y, x)
    k = (A / r) ** 2
    s_r = -(P + Q) / 2 * (1 - k) + (P - Q) / 2 * (1 + 3 * k**2 - 4 * k) * np.cos(2 * t)
    s_t = -(P + Q) / 2 * (1 + k) - (P - Q) / 2 * (1 + 3 * k**2) * np.cos(2 * t)
    s_rt = -(P - Q) / 2 * (1 - 3 * k**2 + 2 * k) * np.sin(2 * t)
    c, s = np.cos(t), np.sin(t)
    xx, yy = s_r * c**2 + s_t * s**2 - 2 * s_rt * s * c, s_r * s**2 + s_t * c**2 + 2 * s_rt * s * c
    xy = (s_r - s_t) * s * c + s_rt * (c**2 - s**2)
    return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)


def block_averages(corners, field):
    """Return the mean of a field over quads (n, 4, 2) by 4 x 4 Gauss points."""
    points, weights = leggauss(4)
    total, area = 0.0, 0.0
    for u, wu in zip((points + 1) / 2, weights, strict=True):
        for v, wv in zip((points + 1) / 2, weights, strict=True):
            shape = np.array([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
            along_u = np.array([v - 1, 1 - v, v, -v]) @ corners
            along_v = np.array([u - 1, -u, u, 1 - u]) @ corners
            size = wu * wv * (along_u[:, 0] * along_v[:, 1] - along_u[:, 1] * along_v[:, 0])
            total = total + size[:, None, None] * field(*(shape @ corners).T)
            area = area + size
    return total / area[:, None, None]


def plate(around):
    """Return the quads of the quarter, `around` of them along the hole."""
    rings = round(np.log(FAR / A) / (np.pi / 2 / around))
    radius = A * (FAR / A) ** (np.arange(rings + 1) / rings)
    angle = np.linspace(0, np.pi / 2, around + 1)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ray[0, 1] = ray[-1, 0] = 0.0
    p = radius[:, None, None] * ray
    return np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], axis=2).reshape(-1, 4, 2)


def model_of(corners, stiffness):
    blocks = (
        bsm.Blocks.from_polygons(list(corners), rock="rock")
        .with_boundary("left", lambda x, y: x < 1e-9)
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("edge", lambda x, y: np.hypot(x, y) > FAR - 1e-6)
    )
    edges = blocks.boundaries["edge"]
    along = blocks.edge_vectors[edges]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    ends = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
    tractions = np.einsum("keij,kj->kei", kirsch(*np.moveaxis(ends, -1, 0)), normal)
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0, young=50e9, poisson=0.25, stiffness=stiffness)],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.EdgeTractions(boundary="edge", values=tractions)],
    )


def cut_by_stages(around):
    """Return the plate whose hole is cut in situ, Kirsch's averages over its blocks, and which are at the wall."""
    corners = plate(around)
    angle = np.linspace(0, np.pi / 2, around + 1)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rim[0, 1] = rim[-1, 0] = 0.0
    hole = [np.array([(0.0, 0.0), one, other]) for one, other in pairwise(rim)]
    count = len(corners)
    blocks = (
        bsm.Blocks.from_polygons([*corners, *hole], rock="rock")
        .with_boundary("left", lambda x, y: x < 1e-9)
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("edge", lambda x, y: np.hypot(x, y) > FAR - 1e-6)
    )
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0, young=50e9, poisson=0.25)],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.InSituTraction(boundary="edge")],
        in_situ=bsm.InSitu(stress={"xx": -Q, "yy": -P}),
        stages=[bsm.Stage(name="hole", excavate=tuple(range(count, len(blocks.offsets) - 1)))],
    )
    return model, block_averages(corners, kirsch), np.hypot(*corners.mean(axis=1).T) < 1.1 * A


def error_near(stress, corners):
    """Return the L2 difference from Kirsch's block averages for r < 3a, relative to them."""
    exact = block_averages(corners, kirsch)
    centroid, area = corners.mean(axis=1), np.linalg.det(corners[:, 2:] - corners[:, :2]) / 2  # half of d1 x d2
    near = np.hypot(*centroid.T) < 3 * A
    squares = [(area[near] * (s[near] ** 2).sum(axis=(1, 2))).sum() for s in (stress - exact, exact)]
    return np.sqrt(squares[0] / squares[1])
