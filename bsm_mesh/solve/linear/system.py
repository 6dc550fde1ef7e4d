"""The linear system of a model: assembled, supports eliminated, solved and refined."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.kernels import add_contact_forces, spring_forces
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.solve.algebra.block_matrix import block_pattern, constrain, fill_stiffness
from bsm_mesh.solve.algebra.constraints import build_constraints
from bsm_mesh.solve.algebra.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.algebra.loads import external_loads, mean_force, reference_weight
from bsm_mesh.solve.algebra.mechanisms import FreePart, free_parts
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts

GOOD_RESIDUAL = 1e-11  # over the reference weight, at which refinement ends: five orders below the usual tolerance


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Solution:
    """Displacements and forces of a linear solution.

    Attributes
    ----------
    displacement : (n, 3) float64 [m, m, rad]
        u, v and theta of every block.
    normal_force, shear_force : (m,) float64 [N/m]
        Of every contact.
    bolts : BoltEvaluation
        Forces of the bolts.
    residual : (n, 3) float64 [N/m, N/m, N]
        Sum of loads, contact and bolt forces on every block; on constrained axes minus the reaction.
    linear_solver : str
        Name of the solver.
    factorizations : int
        How many it took.
    """

    displacement: FloatArray
    normal_force: FloatArray
    shear_force: FloatArray
    bolts: BoltEvaluation
    residual: FloatArray
    linear_solver: str
    factorizations: int


class LinearSystem:
    """The equations K U = P of a model with given contacts (Wang Eqs. 3.40, 3.41), supports eliminated.

    Parameters
    ----------
    model : Model
        The model.
    contacts : ContactTable
        Its contacts; all of them carry tension and shear.
    normal_force, shear_force : (m,) float64 [N/m], optional
        Contact forces at the start; zero where not given.
    bolts : InstalledBolts, optional
        The bolts, elastic about their pretension; one tensioned to its capacity keeps that force. The model's own,
        where not given.
    bolt_forces : (n_elements,) and (k,) float64 [N], optional
        Tension of the bolts' elements and shear of their crossings at the start; their pretension where not given.
    """

    def __init__(
        self,
        model: Model,
        contacts: ContactTable,
        normal_force: FloatArray | None = None,
        shear_force: FloatArray | None = None,
        bolts: InstalledBolts | None = None,
        bolt_forces: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self.model = model
        self.contacts = contacts
        nothing = np.zeros(contacts.count)
        self.start = (
            nothing if normal_force is None else normal_force,
            nothing if shear_force is None else shear_force,
        )
        given = np.zeros((model.blocks.count, 3))
        self.bolts = InstalledBolts.of(model, given) if bolts is None else bolts
        self.tensioned = self.bolts.evaluate(given)
        self.coupling = self.bolts.coupling(self.tensioned)
        at = self.tensioned
        self.bolts_at_start = at if bolt_forces is None else self.bolts.with_forces(at, *bolt_forces)
        lower, higher = self.bolts.pairs
        pattern = block_pattern(
            model.blocks.count, np.concatenate([contacts.block_a, lower]), np.concatenate([contacts.block_b, higher])
        )
        self.pattern = replace(pattern, place=pattern.place[: contacts.count])
        self.constraints = build_constraints(model)
        self.loads = external_loads(model)
        weight = reference_weight(model, self.loads, self.bolts_at_start.forces)
        self.reference = max(weight, mean_force(*self.start))

    def free_parts(self, names: IntArray | None = None) -> list[FreePart]:
        """Return the parts that their supports leave free; `names` (n,) number blocks in sentences."""
        return free_parts(self.model.blocks, self.constraints, self.pattern, names)

    def stiffness(self) -> FloatArray:
        """Return the blocks of K with the supports eliminated."""
        c, pattern, support = self.contacts, self.pattern, self.constraints
        data: FloatArray = fill_stiffness(
            pattern.row_start,
            c.block_a,
            c.block_b,
            pattern.place,
            len(pattern.column),
            c.point,
            c.normal,
            c.normal_stiffness,
            c.shear_stiffness,
            self.model.blocks.moments.centroid,
        )
        self.bolts.add_tangent(self.tensioned, self.bolts.places(pattern), data, turning=False)
        axes = support.number, support.basis, support.constrained
        constrain(pattern.row_start, pattern.column, pattern.diagonal, data, *axes)
        return data

    def solve(self, stiffness: FloatArray, options: Options) -> Solution:
        """Return displacements and contact forces in equilibrium, from what `stiffness` returned.

        Raises
        ------
        SingularMatrixError
            If the matrix is singular; the message says what to look for.
        ModelError
            If a solver is chosen that is not there.
        """
        solver = make_linear_solver(
            options.linear_solver, self.pattern, self.model.blocks.moments.centroid, options.threads, once=True
        )
        try:
            solver.factorize(stiffness)
            return self._refine(solver)
        except SingularMatrixError as error:
            raise SingularMatrixError(
                f"the stiffness matrix is singular ({error}): a part of the model can move without resistance; "
                "look for blocks that touch at a corner only, and for stiffnesses many orders apart"
            ) from error
        finally:
            solver.close()

    def _refine(self, solver: LinearSolver) -> Solution:
        """Return the solution after iterative refinement.

        Contact forces are summed increment by increment, not computed from the total displacements: where hard rock on
        soft ground sinks by metres, their rounding times the stiffness of hard rock would be a residual.
        """
        best = self.at_start(solver.name)
        U, normal_force, shear_force, bolts = best.displacement, best.normal_force, best.shear_force, best.bolts
        size = self._residual_norm(best)
        while not size <= GOOD_RESIDUAL * self.reference:  # once (Skeel 1980), or more often: stiffnesses differ
            dU = self.constraints.expand(solver.solve(self.constraints.free_part(best.residual)))
            normal_part, shear_part = self.spring_forces(dU)
            U = U + dU
            normal_force, shear_force = normal_force + normal_part, shear_force + shear_part
            bolts = self.bolts.strained(bolts, self.coupling, dU)
            found = self._solution(solver.name, U, normal_force, shear_force, bolts)
            before, size = size, self._residual_norm(found)
            if not size < before:
                break
            best = found
        return best

    def at_start(self, linear_solver: str) -> Solution:
        """Return the state before the solution: prescribed displacements applied, nothing else moved."""
        U = self.constraints.prescribed
        if not U.any():
            return self._solution(linear_solver, U, *self.start, self.bolts_at_start)
        normal_part, shear_part = self.spring_forces(U)
        bolts = self.bolts.strained(self.bolts_at_start, self.coupling, U)
        return self._solution(linear_solver, U, self.start[0] + normal_part, self.start[1] + shear_part, bolts)

    def _solution(
        self,
        linear_solver: str,
        U: FloatArray,
        normal_force: FloatArray,
        shear_force: FloatArray,
        bolts: BoltEvaluation,
    ) -> Solution:
        return Solution(
            displacement=U,
            normal_force=normal_force,
            shear_force=shear_force,
            bolts=bolts,
            residual=self.residual(normal_force, shear_force) + bolts.forces,
            linear_solver=linear_solver,
            factorizations=1,
        )

    def _residual_norm(self, solution: Solution) -> float:
        return float(np.abs(self.constraints.free_part(solution.residual)).max())

    def reference_of(self, solution: Solution) -> float:
        """Return what residuals are relative to [N/m].

        Where displacements are prescribed they bring forces of their own, without any weight or load: then the
        mean contact force counts too.
        """
        if not self.constraints.bars.value.any():
            return self.reference
        return max(self.reference, mean_force(solution.normal_force, solution.shear_force))

    def spring_forces(self, U: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the normal and shear force of every contact for displacements U (n, 3)."""
        c, centroid = self.contacts, self.model.blocks.moments.centroid
        forces: tuple[FloatArray, FloatArray] = spring_forces(
            c.block_a, c.block_b, c.point, c.normal, c.normal_stiffness, c.shear_stiffness, centroid, U
        )
        return forces

    def residual(self, normal_force: FloatArray, shear_force: FloatArray) -> FloatArray:
        """Return loads plus contact forces on every block, (n, 3)."""
        c, total = self.contacts, self.loads.copy()
        centroid = self.model.blocks.moments.centroid
        add_contact_forces(c.block_a, c.block_b, c.point, c.normal, normal_force, shear_force, centroid, total)
        return total
