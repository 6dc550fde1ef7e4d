"""The factor of strength: by how much strength may be divided until no forces within it balance the loads.

Beyond it the blocks must move, by the limit theorem, whatever stiffness, history and flow rule: it is an upper bound of
every factor of safety, and no factor of safety itself, for what exists need not come about.

For a part s = 1/F of the strength a linear program finds the least force t by which the strength falls short. Forces
exist where t is not positive; where it is, the multipliers are a mechanism that proves that there are none. So both
sides are known. The multipliers tell dt/ds too: Newton's method, held between the two sides.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.strength import ALL_JOINTS, OF_ROCK, with_bolt_capacities, with_strength
from bsm_mesh.model.values import Rules
from bsm_mesh.results.evidence import Proof
from bsm_mesh.solve.algebra.loads import external_loads
from bsm_mesh.solve.limit.program import LimitProgram, Shortfall, mean_force
from bsm_mesh.solve.limit.proof import left_out_of, witness_of

MOST = 1000.0  # greatest factor sought: friction of a thirtieth of a degree is none; 1 / MOST: the least
ACCURACY = 1e-5  # relative, of the factor: far below what strength is known to
STRIDE = 8.0  # from the side that is known where nothing tells how far


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class StrengthLimit:
    """Up to which factor strength may be divided, by statics alone.

    Attributes
    ----------
    factor : float
        Greatest factor at which forces in equilibrium and within strength were found; infinite where they exist at a
        thousandth of the strength still, 0 where a thousandfold strength does not suffice.
    beyond : float
        Least factor at which there are proved to be none; infinite where `factor` is.
    mechanism : (n, 3) float64
        Velocities u, v, theta of the blocks in the collapse just beyond, the greatest displacement of a centroid or
        rotation times radius of gyration being 1; zero where there is no limit.
    normal_force, shear_force : (m,) float64 [N/m]
        Admissible forces at the factor; zero where there are none.
    contacts : ContactTable
        The contacts that they belong to.
    bolt_force : (n_elements,) float64 [N]
        Tension of the bolts' elements in that field, of one bolt each; bolts that name a stage are not there.
    unlimited : int
        Number of contacts of unlimited strength, which no factor reduces.
    proof : Proof
        Of there being no forces at `beyond`, with the mechanism as its witness; or why there is none.
    programs : int
        Linear programs solved.
    seconds : float [s]
        Time that it took.
    """

    factor: float
    beyond: float
    mechanism: FloatArray
    normal_force: FloatArray
    shear_force: FloatArray
    contacts: ContactTable
    bolt_force: FloatArray
    unlimited: int
    proof: Proof
    programs: int
    seconds: float

    def __str__(self) -> str:
        """Return what is proved, in words."""
        return self.proof.text


def strength_limit(
    model: Model, joints: Sequence[str] | None = None, rocks: bool = True, bolts: bool = False
) -> StrengthLimit:
    """Return the greatest factor by which strength may be divided while forces that balance the loads exist.

    Divided are the tangent of friction angles, cohesion and tensile strength, of peak values.

    Parameters
    ----------
    model : Model
        What is given; the contacts are those of the geometry as it is, without stages.
    joints : sequence of str, optional
        Names of the joints whose strength is divided; all by default.
    rocks : bool
        Whether that of faces of rock without a joint is.
    bolts : bool
        Whether all that limits the bolts' forces is.

    Raises
    ------
    ModelError
        If the model has no weight and no load, nothing has a strength that could be divided, blocks overlap, or a
        linear program cannot be solved.
    """
    began = time.perf_counter()
    rules = Rules("limit analysis")
    rules.a_thing("model", model, Model)
    raise_faults(rules.faults)
    model = model.replace(contact_points="ends")
    search = _Search(model, joints, rocks=rocks, bolts=bolts)
    search.run()
    program, held, failed = search.program, search.held, search.failed
    m = program.contacts.count
    forces = np.zeros(program.unknowns) if held is None else held.forces
    limited = failed is not None and search.factor < math.inf
    return StrengthLimit(
        factor=search.factor,
        beyond=search.beyond,
        mechanism=failed.velocity if limited and failed is not None else np.zeros((model.blocks.count, 3)),
        normal_force=-forces[:m],
        shear_force=forces[m : 2 * m],
        contacts=program.contacts,
        bolt_force=program.bolt_force(forces),
        unlimited=int(program.strength.unlimited.sum()),
        proof=search.proof(),
        programs=search.programs,
        seconds=time.perf_counter() - began,
    )


class _Search:
    """The search for the least part of the strength that suffices, between a part that does and one that does not."""

    def __init__(self, model: Model, joints: Sequence[str] | None, *, rocks: bool, bolts: bool) -> None:
        self.model, self.bolts = model, bolts
        self.program, self.loads = LimitProgram(model), external_loads(model)
        self.names = [ALL_JOINTS] if joints is None else list(joints)
        self.names += [OF_ROCK + ALL_JOINTS] if rocks else []
        with_strength(model, dict.fromkeys(self.names, 1.0))  # refuses names that do not exist
        if not self.loads.any():
            raise ModelError("limit analysis: the model has neither weight nor load; nothing can fail")
        self.chosen = self._chosen(joints, rocks=rocks)
        one, (_, bound) = self._rows(1.0), self._rows(2.0)
        self.helps = (one[1] != bound).astype(np.float64)
        changed = abs(self._rows(2.0)[0] - one[0]).sum(axis=1) > 0
        self.helps = np.maximum(self.helps, np.asarray(changed).reshape(-1))
        if not self.helps.any():
            raise ModelError("limit analysis: nothing of what was chosen has a strength that could be divided")
        self.low, self.high, self.programs = 0.0, math.inf, 0
        self.held: Shortfall | None = None
        self.failed: Shortfall | None = None

    def _chosen(self, joints: Sequence[str] | None, *, rocks: bool) -> BoolArray:
        """Return the contacts whose strength is divided, (m,)."""
        of_joints = [joint.name for joint in self.model.joints]
        chosen = np.array([joints is None or name in joints for name in of_joints] + [rocks])
        return np.asarray(chosen[self.program.contacts.joint])  # the last, -1: no joint

    def _rows(self, part: float) -> tuple[csr_array, FloatArray]:
        return self._at(part).bounds()

    def _at(self, part: float) -> LimitProgram:
        """Return the program of a part of the strength."""
        return self.program.at(self.program.strength.times(part, self.chosen, bolts=self.bolts))

    def run(self) -> None:
        """Bring the two sides together."""
        part = 1.0
        while self.high > self.low * (1 + ACCURACY) and self.low < MOST and self.high > 1 / MOST:
            found = self.program.shortfall(self.loads, *self._rows(part), self.helps)
            self.programs += 1
            if not found.stands:
                self.low, self.failed = part, found
            else:
                self.high, self.held = part, found
            part = self._next(part, found)

    def _next(self, part: float, found: Shortfall) -> float:
        """Return the next part of the strength: a little beyond Newton's, so that the other side comes near too."""
        beyond = ACCURACY / 3 if not found.stands else -ACCURACY / 3
        slope = self._slope(part, found)
        guess = (part - found.lacking / slope) * (1 + beyond) if slope < 0 else math.nan
        if self.programs % 4 == 0 or not self.low < guess < self.high:
            guess = math.sqrt(self.low * self.high) if self.low > 0 and self.high < math.inf else math.nan
        if math.isnan(guess):
            guess = part * STRIDE if self.high == math.inf else part / STRIDE
        return min(max(guess, 1 / MOST), MOST)

    def _slope(self, part: float, found: Shortfall) -> float:
        """Return dt/ds, in mean forces: the bounds are quadratic in the part, so that differences are exact."""
        if not found.forces.any():
            return math.nan
        (rows, bound), (less, lower) = self._rows(1.5 * part), self._rows(0.5 * part)
        change = (rows - less) @ found.forces - (bound - lower)
        return float(found.of_bounds @ change) / part / mean_force(self.loads)

    @property
    def factor(self) -> float:
        if self.high <= 1 / MOST:
            return math.inf
        return 0.0 if self.held is None else 1 / self.high

    @property
    def beyond(self) -> float:
        return math.inf if self.low == 0 or self.factor == math.inf else 1 / self.low

    def proof(self) -> Proof:
        if math.isinf(self.factor):
            return Proof(text="no limit")
        assert self.failed is not None
        if left_out := left_out_of(self.model, self.program.contacts):
            return Proof(text=f"no proof was sought: {left_out}")
        text = (
            f"forces within strength exist up to the factor {self.factor:.5g}; beyond {self.beyond:.5g} the blocks "
            "must move, whatever stiffness and history"
        )
        try:
            weaker = with_strength(self.model, dict.fromkeys(self.names, self.low))
            if self.bolts:
                weaker = with_bolt_capacities(weaker, self.low)
        except ModelError as error:
            return Proof(text=f"{text}; no proof: {error}")
        program = self._at(self.low)
        return Proof(text=text, witness=witness_of(weaker, program, self.loads, self.failed.velocity, self.failed.slip))
