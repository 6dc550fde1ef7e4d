"""Triangles of zones: the fewest that fill the blocks, halved at their longest sides until they are small enough.

References
----------
Rivara (1984), Algorithms for refining triangular grids suitable for adaptive and multigrid techniques, Int. J. Numer.
Meth. Engng 20(4), 745-756: a triangle is halved at its longest side first, so that no angle becomes less than half the
least one of the start.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model
from bsm_mesh.model.zones import zoned_blocks
from bsm_mesh.solve.zones.mesh import ContinuumMesh, build_continuum_mesh

MOST_ZONES = 2_000_000  # triangles of a model: more than the memory of a machine holds factors of


def zone_mesh(model: Model) -> ContinuumMesh:
    """Return triangles that fill all blocks, those of zoned blocks with no side longer than their rock's size.

    Sides of neighbours are halved with them: nodes of both sides of a face lie on each other. Rigid blocks have the
    fewest triangles that fill them so.

    Raises
    ------
    ModelError
        If the sizes ask for more triangles than a machine holds.
    """
    mesh = build_continuum_mesh(model.blocks, triangles=True)
    longest = _longest_sides(model)
    area = model.blocks.moments.area
    count = float((area / (0.433 * np.minimum(longest, 1e150) ** 2)).sum())
    if count > MOST_ZONES:
        raise ModelError(f"zones: their size asks for about {count:.2g} triangles, at most {MOST_ZONES:g} are taken")
    while True:
        sides = mesh.mesh.p[:, mesh.mesh.facets]
        length = np.hypot(*(sides[:, 1] - sides[:, 0]))
        allowed = np.full(len(length), np.inf)
        np.minimum.at(allowed, mesh.mesh.t2f.ravel(), np.tile(longest[mesh.block], 3))
        halved = length > allowed * (1 + 1e-9)
        if not halved.any():
            return mesh
        mesh = _halved(mesh, _with_longest_sides(mesh.mesh, length, halved))


def _longest_sides(model: Model) -> FloatArray:
    """Return the greatest side of the triangles of every block, (n,) [m]; infinite where nothing is asked."""
    sizes = {rock.name: rock.zones.size for rock in model.rocks if rock.zones is not None}
    of_rock = [sizes.get(name) or np.inf for name in model.blocks.rock_names]
    longest: FloatArray = np.where(zoned_blocks(model), np.array(of_rock)[model.blocks.rock], np.inf)
    return longest


def _with_longest_sides(mesh: Any, length: FloatArray, halved: BoolArray) -> BoolArray:
    """Return the sides to be halved so that every triangle which is halved is so at its longest side too."""
    longest = np.take_along_axis(mesh.t2f, length[mesh.t2f].argmax(axis=0)[None], axis=0)[0]
    while True:
        more = halved.copy()
        more[longest[halved[mesh.t2f].any(axis=0)]] = True
        if (more == halved).all():
            return halved
        halved = more


def _halved(mesh: ContinuumMesh, halved: BoolArray) -> ContinuumMesh:
    """Return the mesh with some of its sides (f,) halved, as `_with_longest_sides` chooses them."""
    import skfem

    old = mesh.mesh
    sides = old.p[:, old.facets]
    length = np.hypot(*(sides[:, 1] - sides[:, 0]))
    middle = old.p.shape[1] + np.cumsum(halved) - 1
    points = np.hstack([old.p, sides[:, :, halved].mean(axis=1)])
    # Sides of skfem's triangles are 0-1, 1-2, 0-2. Turned so that the longest comes first, the corners are a, b at its
    # ends and c; the others are b-c and c-a.
    first = length[old.t2f].argmax(axis=0)
    corners = np.array([(0, 1, 2), (1, 2, 0), (2, 0, 1)])[first].T
    others = np.array([(0, 1, 2), (1, 2, 0), (2, 0, 1)])[first].T
    a, b, c = np.take_along_axis(old.t, corners, axis=0)
    ab, bc, ca = np.take_along_axis(old.t2f, others, axis=0)
    m = middle[ab]
    whole = ~halved[ab]
    cells, owner = [old.t[:, whole]], [mesh.block[whole]]
    for one, other, side in ((a, c, ca), (c, b, bc)):  # the two halves, cut once more where their own side is halved
        plain, cut = ~whole & ~halved[side], ~whole & halved[side]
        half = middle[side]
        cells += [
            np.stack([one, m, other])[:, plain],
            np.stack([one, m, half])[:, cut],
            np.stack([half, m, other])[:, cut],
        ]
        owner += [mesh.block[plain], mesh.block[cut], mesh.block[cut]]
    begin, end = mesh.piece_ends.T
    cut = halved[mesh.piece_facet]
    place = np.where(cut, middle[mesh.piece_facet], end)
    pieces = np.stack([np.stack([begin, place], axis=1), np.stack([place, end], axis=1)], axis=1).reshape(-1, 2)
    kept = np.stack([np.ones_like(cut), cut], axis=1).ravel()
    start = np.concatenate([[0], np.cumsum(1 + cut)])[mesh.piece_start]
    new = skfem.MeshTri(np.ascontiguousarray(points), np.ascontiguousarray(np.hstack(cells)))
    return ContinuumMesh.of(new, np.concatenate(owner), pieces[kept], start)
