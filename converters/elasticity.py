"""Elastic constants of the continuum: those of the rock, and those that the Block-Spring Model really has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.materials import Rock

CellKind = Literal["triangle", "quad", "polygon"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Elasticity:
    """Plane-strain stiffness of cubic symmetry; isotropic where c11 - c12 = 2 c66.

    In its axes: ``sigma_xx = c11 e_xx + c12 e_yy``, ``sigma_yy = c12 e_xx + c11 e_yy``, ``sigma_xy = 2 c66 e_xy``.

    Attributes
    ----------
    c11, c12, c66 : float [Pa]
        Stiffnesses.
    """

    c11: float
    c12: float
    c66: float

    @property
    def modulus(self) -> float:
        """E* [Pa]: stress over strain along an axis with the other direction free, E / (1 - nu^2) if isotropic."""
        return self.c11 - self.c12**2 / self.c11

    @property
    def poisson(self) -> float:
        """nu*: cross strain over strain in that state, nu / (1 - nu) if isotropic."""
        return self.c12 / self.c11

    @property
    def shear(self) -> float:
        """G* [Pa] in the axes."""
        return self.c66

    @property
    def excess(self) -> float:
        """c11 - c12 - 2 c66 [Pa]: zero if isotropic."""
        return self.c11 - self.c12 - 2 * self.c66


def nominal_elasticity(rock: Rock) -> Elasticity:
    """Return the plane-strain stiffness of the rock's own E and Poisson's ratio.

    Raises
    ------
    ModelError
        If the rock is rigid.
    """
    _refuse_rigid(rock)
    assert rock.young is not None
    assert rock.poisson is not None
    lame = rock.young * rock.poisson / ((1 + rock.poisson) * (1 - 2 * rock.poisson))
    G = rock.young / (2 * (1 + rock.poisson))
    return Elasticity(c11=lame + 2 * G, c12=lame, c66=G)


def matched_elasticity(rock: Rock, cell_kind: CellKind) -> Elasticity:
    """Return the stiffness of the continuum that a fine mesh of rigid blocks tends to.

    With (E_N, E_T) the rock's `contact_moduli` (springs E_N / h and E_T / h per area):

    * triangles: G* = E_N E_T / (E_N + E_T), lambda* = E_N / 2 - G*;
    * quads: squares in their own axes, c11 = E_N, c12 = 0, c66 = E_T / 2 (half of E_T, because blocks turn with
      the continuum and each shear is shared by two families of faces);
    * other polygons: lambda* = (E_N - E_T) / 4, G* = (E_N + E_T) / 4, the mean over all directions of a face if
      blocks move with the continuum, as those of a Voronoi mesh nearly do.

    Raises
    ------
    ModelError
        If the rock is rigid.
    """
    _refuse_rigid(rock)
    E_N, E_T = rock.contact_moduli
    if cell_kind == "quad":
        return Elasticity(c11=E_N, c12=0.0, c66=E_T / 2)
    if cell_kind == "triangle":
        G = E_N * E_T / (E_N + E_T)
        lame = E_N / 2 - G
    else:
        lame, G = (E_N - E_T) / 4, (E_N + E_T) / 4
    return Elasticity(c11=lame + 2 * G, c12=lame, c66=G)


def cell_kind_of(blocks: Blocks) -> CellKind:
    """Return what most blocks are, by number."""
    corners = np.diff(blocks.offsets)
    counts: dict[CellKind, int] = {
        "triangle": int((corners == 3).sum()),
        "quad": int((corners == 4).sum()),
        "polygon": int((corners > 4).sum()),
    }
    return max(counts, key=lambda kind: counts[kind])


def block_axes(blocks: Blocks) -> FloatArray:
    """Return the angle of every block's axes, (n,) [rad], between -pi/4 and pi/4: the fourfold mean of its edges."""
    along = blocks.edge_vectors
    length, angle = np.hypot(*along.T), np.arctan2(along[:, 1], along[:, 0])
    mean = np.add.reduceat(length * np.exp(4j * angle), blocks.offsets[:-1])
    axes: FloatArray = np.angle(mean) / 4
    return axes


def rigid_rock_faults(rocks: tuple[Rock, ...], used: set[str]) -> list[str]:
    """Return one sentence for every rock in use that has no elasticity."""
    faults = []
    for rock in rocks:
        if rock.name in used and rock.is_rigid:
            cure = (
                "give it young and poisson"
                if rock.young is None
                else "its stiffness is 'rigid'; choose 'wang', 'homogeneous' or 'triangle'"
            )
            faults.append(f"rock '{rock.name}': a continuum solution needs an elastic rock; {cure}")
    return faults


def _refuse_rigid(rock: Rock) -> None:
    faults = rigid_rock_faults((rock,), {rock.name})
    if faults:
        raise ModelError(faults)
