"""Elastic constants of the rock in plane strain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.materials import Rock
from bsm_mesh.model.model import Model

RIGID = 1e13  # Pa: a hundred times the stiffest rock
BESIDE_JOINTS = 1e3  # of a joint's stiffness times a block's size: rock so stiff moves results by .1 % at most


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
    def matrix(self) -> FloatArray:
        """Stiffness (3, 3) [Pa] from (e_xx, e_yy, 2 e_xy) to (sigma_xx, sigma_yy, sigma_xy), in the axes."""
        return np.array([(self.c11, self.c12, 0.0), (self.c12, self.c11, 0.0), (0.0, 0.0, self.c66)])


def nominal_elasticity(rock: Rock) -> Elasticity:
    """Return the plane-strain stiffness of the rock's own E and Poisson's ratio.

    Raises
    ------
    ModelError
        If the rock is rigid.
    """
    refuse_rigid(rock)
    assert rock.young is not None
    assert rock.poisson is not None
    lame = rock.young * rock.poisson / ((1 + rock.poisson) * (1 - 2 * rock.poisson))
    G = rock.young / (2 * (1 + rock.poisson))
    return Elasticity(c11=lame + 2 * G, c12=lame, c66=G)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BlockElasticity:
    """Elastic constants of all blocks.

    Attributes
    ----------
    name : str
        Of the choice of constants.
    stiffness : (n, 3, 3) float64 [Pa]
        From (e_xx, e_yy, 2 e_xy) to (sigma_xx, sigma_yy, sigma_xy).
    notes : tuple of str
        Notes on them, a sentence each.
    """

    name: str
    stiffness: FloatArray
    notes: tuple[str, ...] = ()


def nominal_constants(model: Model) -> BlockElasticity:
    """Return the constants (n, 3, 3) [Pa] of every block's rock by its E and Poisson's ratio.

    Rigid rock has `rigid_stiffness`.
    """
    rigid = rigid_stiffness(model)
    matrices = by_rock(model, lambda rock: rigid if rock.is_rigid else nominal_elasticity(rock).matrix)
    return BlockElasticity(name="nominal", stiffness=matrices[model.blocks.rock])


def rigid_stiffness(model: Model) -> FloatArray:
    """Return the stiffness (3, 3) [Pa] that represents rigid rock.

    Its modulus is `RIGID`, or more where that would not be much compared with joints on blocks of their size.
    """
    stiffest = max((joint.contact_stiffness[0] for joint in model.joints), default=0.0)
    modulus = max(RIGID, BESIDE_JOINTS * stiffest * float(np.sqrt(model.blocks.moments.area.max())))
    return nominal_elasticity(Rock("rigid", unit_weight=0.0, young=modulus, poisson=0.0)).matrix


def rocks_in_use(model: Model) -> set[str]:
    """Return the names of the rocks of which there are blocks."""
    return {model.blocks.rock_names[number] for number in np.unique(model.blocks.rock)}


def by_rock(model: Model, value: Callable[[Rock], FloatArray]) -> FloatArray:
    """Return a value for every name in ``blocks.rock_names``; NaN where no block has that rock."""
    used = rocks_in_use(model)
    values = {rock.name: value(rock) for rock in model.rocks if rock.name in used}
    nothing = np.full_like(next(iter(values.values())), np.nan)
    return np.array([values.get(name, nothing) for name in model.blocks.rock_names])


def rigid_rock_faults(rocks: Sequence[Rock], used: set[str]) -> list[str]:
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


def refuse_rigid(rock: Rock) -> None:
    """Raise a `ModelError` for a rock without elastic constants."""
    faults = rigid_rock_faults((rock,), {rock.name})
    if faults:
        raise ModelError(faults)
