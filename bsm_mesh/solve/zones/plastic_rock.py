"""Rock that yields at the integration points of its cells.

The trial stress is the elastic one less the relief: the stress that yielding took before. Beyond the yield surface it
returns there, and the difference adds to the relief. So internal forces are those of elastic rock less those of the
relief.

In large displacement the strain is Green's and the stress the second Piola-Kirchhoff one (`large_rock`). Both turn with
the rock, and so does the relief. Strengths hold for the Cauchy stress. The two stresses differ by a part of up to twice
the strain, so strains have to be small, however far the rock turns.
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
from bsm_mesh.solve.zones.large_rock import green_strains, strain_rows, turning_entries
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
    large : bool
        Whether displacements are large.
    """

    def __init__(self, model: Model, basis: Any, block: IntArray, stiffness: FloatArray, *, large: bool) -> None:
        self.large = large
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

    def strains(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the strains xx, yy and 2 xy, (c, i, 3), and F (c, i, 2, 2), at nodal displacements (c, nodes, 2).

        F is the deformation gradient; 1 in small displacement.
        """
        H = np.matmul(u[:, None].swapaxes(-1, -2), self.gradient)  # d u_i / d X_j
        if self.large:
            return green_strains(H), H + np.eye(2)
        strain = np.stack([H[..., 0, 0], H[..., 1, 1], H[..., 0, 1] + H[..., 1, 0]], axis=-1)
        return strain, np.broadcast_to(np.eye(2), H.shape)

    def at_nodes(self, u: FloatArray) -> FloatArray:
        """Return displacements (N,) at the cells' nodes, (c, nodes, 2)."""
        own: FloatArray = u[self.dofs].reshape(len(self.cells), -1, 2)
        return own

    def forces(self, stress: FloatArray, F: FloatArray) -> FloatArray:
        """Return the internal forces (N,) [N/m] of a stress (c, i, 4) [Pa] at a deformation gradient (c, i, 2, 2)."""
        first = F @ _tensor(stress) * self.weight[:, :, None, None]
        nodal = np.matmul(self.gradient, first.swapaxes(-1, -2)).sum(axis=1).reshape(self.dofs.shape)
        return np.bincount(self.dofs.ravel(), nodal.ravel(), minlength=self.size).astype(np.float64)

    def matrix(self, cells: IntArray, tangent: FloatArray, F: FloatArray) -> Any:
        """Return the matrix (N, N) of tangents (k, i, 3, 3) [Pa] in some cells (k,), with their F (k, i, 2, 2)."""
        B = strain_rows(self.gradient[cells], F)
        weighed = self.weight[cells][:, :, None, None] * np.matmul(tangent, B)
        whole = (len(cells), 3 * self.points, B.shape[3])
        return self._assembled(cells, np.matmul(B.reshape(whole).transpose(0, 2, 1), weighed.reshape(whole)))

    def turning(self, stress: FloatArray) -> Any:
        """Return the derivatives (N, N) of the forces of a stress (c, i, 4) [Pa] as it turns with the rock."""
        entries = turning_entries(self.gradient, _tensor(stress), self.weight)
        return self._assembled(np.arange(len(self.cells)), entries)

    def _assembled(self, cells: IntArray, entries: FloatArray) -> Any:
        dofs = self.dofs[cells]
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
    without_stress : (c, i, 3) float64
        Strains without stress: rock may have been put back.
    relief : (c, i, 4) float64 [Pa]
        Stress that yielding took so far.
    """

    of: PlasticCells
    strength: tuple[tuple[int, YieldSurface], ...]
    there: BoolArray
    initial: FloatArray
    without_stress: FloatArray
    relief: FloatArray

    def evaluate(self, u: FloatArray) -> PlasticState:
        """Return the state at displacements u (N,)."""
        of = self.of
        strain, F = of.strains(of.at_nodes(u))
        strain = strain - self.without_stress
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
        return PlasticState(relief=relief, yields=yields, returns=tuple(returns), F=F)

    def relieved(self, state: PlasticState) -> FloatArray:
        """Return the internal forces (N,) [N/m] that yielding takes from those of elastic rock."""
        return self.of.forces(state.relief * self.there[:, None, None], state.F)

    def softer(self, state: PlasticState, *, positive: bool = False) -> Any:
        """Return the change (N, N) of the elastic stiffness by yielding.

        `positive`: its tangents are symmetric, and no strain has a negative stiffness. So plastic flow without dilation
        neither adds stiffness nor takes more than there is.
        """
        cells, changes = [], []
        for rows, strength, found in state.returns:
            chosen = np.flatnonzero(state.yields[rows].any(axis=1))
            points = (chosen[:, None] * self.of.points + np.arange(self.of.points)).ravel()
            tangent = strength.tangent(found, points)
            tangent = (_positive(tangent) if positive else tangent).reshape(len(chosen), self.of.points, 3, 3)
            change = tangent - self.of.stiffness[rows[chosen]][:, None]
            changes.append(change * state.yields[rows[chosen]][:, :, None, None])
            cells.append(rows[chosen])
        every = np.concatenate(cells)
        change = self.of.matrix(every, np.concatenate(changes), state.F[every])
        return change + self.turning(state) if self.of.large else change

    def turning(self, state: PlasticState) -> Any:
        """Return the change (N, N) of the stiffness in large displacement, as the relief turns with the rock."""
        return -self.of.turning(state.relief * self.there[:, None, None])

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
    F : (c, i, 2, 2) float64
        Deformation gradient; 1 in small displacement.
    """

    relief: FloatArray
    yields: BoolArray
    returns: tuple[tuple[IntArray, YieldSurface, Return], ...]
    F: FloatArray


def _tensor(stress: FloatArray) -> FloatArray:
    """Return the stress in the plane of xx, yy, xy, zz (c, i, 4) as (c, i, 2, 2)."""
    xx, yy, xy, _ = np.moveaxis(stress, -1, 0)
    return np.stack([xx, xy, xy, yy], axis=-1).reshape(*xx.shape, 2, 2)


def _positive(tangent: FloatArray) -> FloatArray:
    """Return the symmetric parts of tangents (k, 3, 3) without negative eigenvalues."""
    values, axes = np.linalg.eigh((tangent + tangent.swapaxes(-1, -2)) / 2)
    found: FloatArray = (axes * np.maximum(values, 0.0)[:, None, :]) @ axes.swapaxes(-1, -2)
    return found


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
