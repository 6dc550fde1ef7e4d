"""Rock that yields at the integration points of its cells.

The trial stress is the elastic one less the relief: the stress that yielding took before. Beyond the yield surface it
returns there, and the difference adds to the relief. So internal forces are those of elastic rock less those of the
relief.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.model.materials import Rock
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.hoek_brown import HoekBrownYielding
from bsm_mesh.solve.zones.mohr_coulomb import Yielding
from bsm_mesh.solve.zones.rock_faces import rocks_of
from bsm_mesh.solve.zones.yield_surface import Return, YieldSurface


class PlasticCells:
    """The cells whose rock yields.

    Parameters
    ----------
    model : Model
        Its rocks and blocks.
    basis : skfem.CellBasis
        Of the vector-valued element.
    block : (t,) int
        Block of every cell.
    stiffness : (t, 3, 3) float64 [Pa]
        Of its rock, isotropic.
    """

    def __init__(self, model: Model, basis: Any, block: IntArray, stiffness: FloatArray) -> None:
        yields = np.array([rock.yields for rock in rocks_of(model)], dtype=bool)[model.blocks.rock[block]]
        self.cells = np.flatnonzero(yields)
        self.rock = model.blocks.rock[block[self.cells]]
        self.block = block[self.cells]
        self.size, self.points = basis.N, basis.dx.shape[1]
        self.dofs = basis.element_dofs[:, self.cells].T
        self.stiffness = stiffness[self.cells]
        self.weight = basis.dx[self.cells]
        fields = [np.asarray(field[0].grad[0])[:, self.cells] for field in basis.basis[::2]]
        self.gradient = np.stack(fields, axis=-1).transpose(1, 2, 3, 0)  # (cells, points, nodes, 2)

    def strains(self, u: FloatArray) -> FloatArray:
        """Return the strains xx, yy and 2 xy under displacements of the cells' nodes (c, nodes, 2), (c, i, 3)."""
        H = np.matmul(self.gradient.transpose(0, 1, 3, 2), u[:, None])  # d u_j / d x_i
        return np.stack([H[..., 0, 0], H[..., 1, 1], H[..., 0, 1] + H[..., 1, 0]], axis=-1)

    def at_nodes(self, u: FloatArray) -> FloatArray:
        """Return displacements (N,) at the cells' nodes, (c, nodes, 2)."""
        own: FloatArray = u[self.dofs].reshape(len(self.cells), -1, 2)
        return own

    def forces(self, stress: FloatArray) -> FloatArray:
        """Return the internal forces (N,) [N/m] of a stress (c, i, 4) [Pa]."""
        xx, yy, xy = (stress[..., k] * self.weight for k in range(3))
        tensor = np.stack([xx, xy, xy, yy], axis=-1).reshape(*xx.shape, 2, 2)
        nodal = np.matmul(self.gradient, tensor).sum(axis=1).reshape(self.dofs.shape)
        return np.bincount(self.dofs.ravel(), nodal.ravel(), minlength=self.size).astype(np.float64)

    def matrix(self, cells: IntArray, tangent: FloatArray) -> Any:
        """Return the matrix (N, N) of tangents (k, i, 3, 3) [Pa] in some of the cells (k,)."""
        gradient, dofs = self.gradient[cells], self.dofs[cells]
        B = np.zeros((*gradient.shape[:2], 3, dofs.shape[1]))
        B[:, :, 0, 0::2] = B[:, :, 2, 1::2] = gradient[..., 0]
        B[:, :, 1, 1::2] = B[:, :, 2, 0::2] = gradient[..., 1]
        weighed = self.weight[cells][:, :, None, None] * np.matmul(tangent, B)
        whole = (len(cells), -1, dofs.shape[1])
        entries = np.matmul(B.reshape(whole).transpose(0, 2, 1), weighed.reshape(whole))
        rows, columns = np.repeat(dofs, dofs.shape[1], axis=1), np.tile(dofs, dofs.shape[1])
        return sp.csr_matrix((entries.ravel(), (rows.ravel(), columns.ravel())), shape=(self.size, self.size))

    def nothing(self) -> FloatArray:
        """Return the relief of rock that never yielded, (c, i, 4) [Pa]."""
        return np.zeros((len(self.cells), self.points, 4))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PlasticRock:
    """The cells that yield, in a stage.

    Attributes
    ----------
    of : PlasticCells
        The cells.
    strength : tuple of (rock number, YieldSurface)
        Of their rocks.
    there : (c,) bool
        Which are there.
    initial : (c, i, 4) float64 [Pa]
        Effective stress without strain: xx, yy, xy, zz.
    without_strain : (c, nodes, 2) float64 [m]
        Displacements without strain: rock may have been put back.
    relief : (c, i, 4) float64 [Pa]
        Stress that yielding took so far.
    """

    of: PlasticCells
    strength: tuple[tuple[int, YieldSurface], ...]
    there: BoolArray
    initial: FloatArray
    without_strain: FloatArray
    relief: FloatArray

    def evaluate(self, u: FloatArray) -> PlasticState:
        """Return the state at displacements u (N,)."""
        of = self.of
        strain = of.strains(of.at_nodes(u) - self.without_strain)
        trial = self.initial - self.relief
        trial[..., :3] += np.matmul(strain, of.stiffness)
        trial[..., 3] += of.stiffness[:, 0, 1, None] * (strain[..., 0] + strain[..., 1])
        relief, yields, returns = self.relief.copy(), np.zeros(trial.shape[:2], dtype=bool), []
        for number, strength in self.strength:
            rows = np.flatnonzero((of.rock == number) & self.there)
            found = strength.returned(trial[rows].reshape(-1, 4))
            yields[rows] = (found.set > 0).reshape(len(rows), -1)
            taken = trial[rows] - found.stress.reshape(len(rows), -1, 4)
            relief[rows] += taken * yields[rows][:, :, None]
            returns.append((rows, strength, found))
        return PlasticState(relief=relief, yields=yields, returns=tuple(returns))

    def relieved(self, state: PlasticState) -> FloatArray:
        """Return the internal forces (N,) [N/m] that yielding takes from those of elastic rock."""
        return self.of.forces(state.relief * self.there[:, None, None])

    def softer(self, state: PlasticState) -> Any:
        """Return the change (N, N) of the elastic stiffness where points yield."""
        cells, changes = [], []
        for rows, strength, found in state.returns:
            chosen = np.flatnonzero(state.yields[rows].any(axis=1))
            points = (chosen[:, None] * self.of.points + np.arange(self.of.points)).ravel()
            tangent = strength.tangent(found, points).reshape(len(chosen), self.of.points, 3, 3)
            change = tangent - self.of.stiffness[rows[chosen]][:, None]
            changes.append(change * state.yields[rows[chosen]][:, :, None, None])
            cells.append(rows[chosen])
        return self.of.matrix(np.concatenate(cells), np.concatenate(changes))

    def over_cells(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return the part of every cell that yielded, and its mean of the greatest plastic shear strain, (count,)."""
        of = self.of
        xx, yy, xy, zz = np.moveaxis(self.relief, -1, 0)
        middle, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
        principal = np.stack([middle + radius, middle - radius, zz])
        strain = (principal.max(axis=0) - principal.min(axis=0)) / (2 * of.stiffness[:, 2, 2, None])
        yielded = np.abs(self.relief).max(axis=2) > ROUNDING * of.stiffness[:, 0, 0, None]
        found = np.zeros((2, count))
        for row, values in zip(found, (yielded, strain), strict=True):
            row[of.cells] = (values * of.weight).sum(axis=1) / of.weight.sum(axis=1)
        return found[0], found[1]

    def after(self, state: PlasticState) -> PlasticRock:
        """Return the rock after a state of equilibrium."""
        return replace(self, relief=state.relief)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PlasticState:
    """Yielding at a displacement.

    Attributes
    ----------
    relief : (c, i, 4) float64 [Pa]
        Stress that yielding took so far.
    yields : (c, i) bool
        Points on the yield surface.
    returns : tuple of (rows, strength, return)
        By rock: its cells, its strength, where their points end.
    """

    relief: FloatArray
    yields: BoolArray
    returns: tuple[tuple[IntArray, YieldSurface, Return], ...]


def strength_of(model: Model, of: PlasticCells) -> tuple[tuple[int, YieldSurface], ...]:
    """Return the strength of the rocks of cells that yield, by the rocks of a stage."""
    found = []
    rocks = rocks_of(model)
    for number in np.unique(of.rock).tolist():
        stiffness = of.stiffness[np.flatnonzero(of.rock == number)[0]]
        found.append((number, _surface(rocks[number], float(stiffness[0, 1]), float(stiffness[2, 2]))))
    return tuple(found)


def _surface(rock: Rock, lame: float, shear: float) -> YieldSurface:
    assert rock.zones is not None
    if rock.hoek_brown is not None:
        return HoekBrownYielding(lame=lame, shear=shear, given=rock.hoek_brown, dilation=rock.zones.dilation)
    return Yielding(
        lame=lame,
        shear=shear,
        cohesion=rock.cohesion or 0.0,
        friction=rock.friction or 0.0,
        dilation=min(rock.zones.dilation, rock.friction or 0.0),
        tension=rock.tensile_strength or 0.0,
    )
