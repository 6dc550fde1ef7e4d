"""Elastic constants that the Block-Spring Model really has as a continuum."""

from __future__ import annotations

from typing import Literal

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_stiffness import least_depth
from bsm_mesh.model.materials import Rock
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.elasticity import (
    BlockElasticity,
    Elasticity,
    by_rock,
    nominal_constants,
    refuse_rigid,
    rigid_stiffness,
    rocks_in_use,
)

CellKind = Literal["triangle", "quad", "polygon"]
ElasticityName = Literal["nominal", "matched"]


def matched_elasticity(rock: Rock, cell_kind: CellKind) -> Elasticity:
    """Return the stiffness of the continuum that a fine mesh of rigid blocks tends to.

    With (E_N, E_T) the rock's `contact_moduli` (springs E_N / h and E_T / h per area):

    * triangles: G* = E_N E_T / (E_N + E_T), lambda* = E_N / 2 - G*;
    * quads: aligned rectangles in their own axes, c11 = E_N, c12 = 0, c66 = E_T / 2 (half of E_T, because blocks
      turn with the continuum and the shear is shared by two families of faces);
    * other polygons: lambda* = (E_N - E_T) / 4, G* = (E_N + E_T) / 4, the mean over all directions of a face if
      blocks move with the continuum, as those of a Voronoi mesh nearly do.

    Quads that are no rectangles, and polygons as they really lie, have the stiffness of `affine_stiffness`, of which
    the last two are special cases.

    Raises
    ------
    ModelError
        If the rock is rigid.
    """
    refuse_rigid(rock)
    E_N, E_T = rock.contact_moduli
    if cell_kind == "quad":
        return Elasticity(c11=E_N, c12=0.0, c66=E_T / 2)
    if cell_kind == "triangle":
        G = E_N * E_T / (E_N + E_T)
        lame = E_N / 2 - G
    else:
        lame, G = (E_N - E_T) / 4, (E_N + E_T) / 4
    return Elasticity(c11=lame + 2 * G, c12=lame, c66=G)


def affine_stiffness(blocks: Blocks, moduli: FloatArray) -> FloatArray:
    """Return the stiffness of a continuum made of many blocks like each one, (n, 3, 3) [Pa].

    The centroids move with the strain e and the block turns by r against the continuum, as moment equilibrium
    demands. On a face at d from the centroid, at the depth h = d . n, half of the springs' displacement is
    ``e d + r (n_z x d)``; so, with the sum over the faces of length L,

        W(e, r) = 1 / (2 A) sum L / h (E_N (n . delta)^2 + E_T (t . delta)^2),

    from which r is condensed. Exact for a lattice of equal parallelograms; nearly so for recombined quads and
    Voronoi cells; too stiff for triangles, whose neighbours lie turned round and move on their own.

    Parameters
    ----------
    blocks : Blocks
        Outlines.
    moduli : (n, 2) float64 [Pa]
        E_N and E_T of every block's rock.

    Returns
    -------
    (n, 3, 3) float64 [Pa]
        From (e_xx, e_yy, 2 e_xy) to (sigma_xx, sigma_yy, sigma_xy), in x and y.
    """
    along, moments = blocks.edge_vectors, blocks.moments
    length = np.hypot(*along.T)
    tangent = along / length[:, None]
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    x, y = (blocks.vertices + along / 2 - moments.centroid[blocks.owner]).T
    depth = x * normal[:, 0] + y * normal[:, 1]
    depth = np.maximum(depth, least_depth(blocks)[blocks.owner])
    zero = np.zeros_like(x)
    delta = np.stack([np.stack([x, zero, y / 2, -y], axis=1), np.stack([zero, y, x / 2, x], axis=1)], axis=1)
    weight = length / (depth * moments.area[blocks.owner])
    energy = np.zeros((len(length), 4, 4))
    for axis, modulus in ((normal, moduli[:, 0]), (tangent, moduli[:, 1])):
        part = np.einsum("ei,eij->ej", axis, delta)
        energy += (weight * modulus[blocks.owner])[:, None, None] * part[:, :, None] * part[:, None, :]
    M = np.add.reduceat(energy, blocks.offsets[:-1], axis=0)
    stiffness: FloatArray = M[:, :3, :3] - M[:, :3, 3:] * M[:, 3:, :3] / M[:, 3:, 3:]
    return stiffness


def cell_kind_of(blocks: Blocks) -> CellKind:
    """Return what most blocks are, by number."""
    corners = np.diff(blocks.offsets)
    counts: dict[CellKind, int] = {
        "triangle": int((corners == 3).sum()),
        "quad": int((corners == 4).sum()),
        "polygon": int((corners > 4).sum()),
    }
    return max(counts, key=lambda kind: counts[kind])


def constants_of(model: Model, elasticity: ElasticityName) -> BlockElasticity:
    """Return the rock's own constants ("nominal") or those that the blocks have ("matched")."""
    if elasticity not in ("nominal", "matched"):
        raise ModelError(f"elasticity = {elasticity!r} must be 'nominal' or 'matched'")
    return nominal_constants(model) if elasticity == "nominal" else matched_constants(model)


def matched_constants(model: Model) -> BlockElasticity:
    """Return the constants (n, 3, 3) [Pa] of the blocks as a continuum; notes state the choice.

    Where most blocks are triangles all are taken as such (`matched_elasticity`); else every block has its own
    `affine_stiffness`. Joints and the springs' place on an edge do not enter. Rigid rock has `rigid_stiffness`.
    """
    blocks, rigid = model.blocks, rigid_stiffness(model)
    kind = cell_kind_of(blocks)
    used = [rock for rock in model.rocks if rock.name in rocks_in_use(model) and not rock.is_rigid]
    notes = tuple(_matched_note(rock, kind) for rock in used)
    if kind == "triangle":
        matrices = by_rock(model, lambda rock: rigid if rock.is_rigid else matched_elasticity(rock, kind).matrix)
        return BlockElasticity(name="matched", stiffness=matrices[blocks.rock], notes=notes)
    moduli = by_rock(model, lambda rock: np.array(rock.contact_moduli))[blocks.rock]
    is_rigid = np.isinf(moduli[:, 0])
    stiffness = affine_stiffness(blocks, np.where(is_rigid[:, None], 1.0, moduli))
    stiffness[is_rigid] = rigid
    return BlockElasticity(name="matched", stiffness=stiffness, notes=notes)


def _matched_note(rock: Rock, kind: CellKind) -> str:
    e = matched_elasticity(rock, kind)
    what = {
        "triangle": "most blocks are triangles, isotropic with",
        "quad": "most blocks are quads, each with the stiffness of its own shape and direction; rectangles have",
        "polygon": "most blocks are polygons, each with the stiffness of its own shape and direction; on average",
    }[kind]
    return (
        f"rock '{rock.name}', matched: {what} E* = {e.modulus:.4g} Pa, nu* = {e.poisson:.4g}, G* = {e.shear:.4g} Pa "
        "(plane strain)"
    )
