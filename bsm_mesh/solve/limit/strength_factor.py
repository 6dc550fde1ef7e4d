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
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import ModelError, named_stage, raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.strength import ALL_JOINTS, OF_ROCK, with_bolt_capacities, with_strength
from bsm_mesh.model.values import Rules
from bsm_mesh.results.evidence import Proof
from bsm_mesh.solve.algebra.loads import external_loads
from bsm_mesh.solve.limit.program import LimitProgram, Shortfall
from bsm_mesh.solve.limit.proof import witness_of
from bsm_mesh.solve.stages.as_built import in_stage

MOST = 1000.0  # greatest factor sought: friction of a thirtieth of a degree is none; 1 / MOST: the least
ACCURACY = 1e-5  # relative, of the factor: far below what strength is known to
STRIDE = 8.0  # from the side that is known where nothing shows how far
FARTHER, NEAR = 1.5, 1e-3  # steps to a side where nothing is known yet go further, unless they are so short
HALVING = 6  # every so many programs the middle is asked, in case Newton's method creeps
MARGINS = 1e-4, 1e-3  # beyond the factor, where rounding spoils a proof at ACCURACY
ENORMOUS = 1e6  # times all loads together: forces that no rock carries


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class StrengthLimit:
    """Up to which factor strength may be divided, by statics alone.

    Blocks, edges and contacts have the numbers of the whole model.

    Attributes
    ----------
    stage : str
        The stage in question.
    present : (n,) bool
        The blocks that are there.
    factor : float
        Greatest factor at which forces in equilibrium and within strength were found; infinite where they exist at a
        thousandth of the strength still, 0 where a thousandfold strength does not suffice.
    beyond : float
        Factor beyond which there are proved to be none; infinite where that is proved of no factor: `proof` says why.
    mechanism : (n, 3) float64
        Velocities u, v, theta of the blocks in the collapse just beyond, the greatest displacement of a centroid or
        rotation times radius of gyration being 1; zero where there is no limit.
    normal_force, shear_force : (m,) float64 [N/m]
        Admissible forces at the factor; zero where there are none.
    contacts : ContactTable
        The contacts that they belong to.
    bolt_force : (n_elements,) float64 [N]
        Tension of the bolts' elements in that field, of one bolt each; bolts of later stages are not there.
    unlimited : int
        Number of contacts of unlimited strength, which no factor reduces.
    proof : Proof
        Of there being no forces at `beyond`, with the mechanism as its witness; or why there is none.
    programs : int
        Linear programs solved.
    seconds : float [s]
        Time that it took.
    """

    stage: str
    present: BoolArray
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
        """Return the proof, in words."""
        return f"in {named_stage(self.stage)}: {self.proof.text}"


def strength_limit(
    model: Model,
    joints: Sequence[str] | None = None,
    rocks: bool = True,
    bolts: bool = False,
    *,
    stage: str | None = None,
) -> StrengthLimit:
    """Return the greatest factor by which strength may be divided while forces that balance a stage's loads exist.

    Divided are the tangent of friction angles, cohesion and tensile strength, of peak values.

    Parameters
    ----------
    model : Model
        The input; the contacts are those of the geometry as it is, of the blocks that are there in the stage.
    joints : sequence of str, optional
        Names of the joints whose strength is divided; all by default.
    rocks : bool
        Whether that of faces of rock without a joint is.
    bolts : bool
        Whether all that limits the bolts' forces is.
    stage : str, optional
        The stage in question, ``initial`` for the first; None: the last.

    Raises
    ------
    ModelError
        If there is no such stage, or statics cannot determine what acts there; if there is no weight and no load,
        nothing has a strength that could be divided, blocks overlap, or a linear program cannot be solved.
    """
    began = time.perf_counter()
    rules = Rules("limit analysis")
    rules.a_thing("model", model, Model)
    raise_faults(rules.faults)
    name, part = in_stage(model.replace(contact_points="ends"), stage)
    search = _Search(part.model, joints, rocks=rocks, bolts=bolts)
    search.run()
    proof = search.proof()
    program, failed, m = search.program, search.failed, search.program.contacts.count
    forces = np.zeros(program.unknowns) if search.held is None else search.held.forces
    still = np.zeros((part.model.blocks.count, part.model.blocks.axes))
    return StrengthLimit(
        stage=name,
        present=part.present,
        factor=search.factor,
        beyond=math.inf if proof.witness is None else 1 / search.low,
        mechanism=part.in_whole(still if failed is None or search.factor == math.inf else failed.velocity),
        normal_force=-forces[:m],
        shear_force=forces[m : 2 * m],
        contacts=program.contacts.in_whole(part),
        bolt_force=program.bolt_force(forces),
        unlimited=int(program.strength.unlimited.sum()),
        proof=proof if proof.witness is None else replace(proof, witness=proof.witness.in_whole(part)),
        programs=search.programs,
        seconds=time.perf_counter() - began,
    )


class _Search:
    """The search for the least part of the strength that suffices, between a part that does and one that does not."""

    def __init__(self, model: Model, joints: Sequence[str] | None, *, rocks: bool, bolts: bool) -> None:
        self.model, self.bolts = model, bolts
        self.names = [ALL_JOINTS] if joints is None else list(joints)
        self.names += [OF_ROCK + ALL_JOINTS] if rocks else []
        with_strength(model, dict.fromkeys(self.names, 1.0))  # refuses names that do not exist
        self.program, self.loads = LimitProgram(model), external_loads(model)
        if not self.loads.any():
            raise ModelError("limit analysis: the model has neither weight nor load; nothing can fail")
        of_joints = [joints is None or joint.name in joints for joint in model.joints]
        self.chosen = np.array([*of_joints, rocks])[self.program.contacts.joint]  # the last, -1: no joint
        (rows, bound), (more, raised) = self._at(1.0).bounds(), self._at(2.0).bounds()
        self.yields = (raised != bound) | np.asarray(abs(more - rows).sum(axis=1) > 0).reshape(-1)
        if not self.yields.any():
            raise ModelError(self._nothing())
        self.low, self.high, self.programs = 0.0, math.inf, 0
        self.guesses = math.nan, math.nan  # from the side where forces fail, and from that where they exist
        self.held: Shortfall | None = None
        self.failed: Shortfall | None = None

    def _nothing(self) -> str:
        text = "limit analysis: no chosen contact has a strength that could be divided"
        return f"{text}; choose joints with a law, rocks with strength, or bolts"

    def _at(self, part: float) -> LimitProgram:
        """Return the program of a part of the strength."""
        return self.program.at(self.program.strength.times(part, self.chosen, bolts=self.bolts))

    def run(self) -> None:
        """Bring the two sides together."""
        part = 1.0
        while self.high > self.low * (1 + ACCURACY) and self.low < MOST and self.high > 1 / MOST:
            part = self._next(part, self._ask(part))

    def _ask(self, part: float) -> Shortfall:
        """Return the shortfall at a part of the strength, and move a side there."""
        found = self.program.shortfall(self.loads, *self._at(part).bounds(), self.yields)
        self.programs += 1
        if found.stands:
            self.high, self.held = part, found
        else:
            # where nothing helps no greater part does, and the mechanism is that of them all
            self.low, self.failed = MOST if math.isinf(found.lacking) else part, found
        return found

    def _next(self, part: float, found: Shortfall) -> float:
        """Return the next part of the strength: Newton's from the one side or the other, and a little across.

        From the side where forces fail first: the missing strength has a kink where they begin to, and is steeper
        there.
        """
        slope, across = self._slope(part, found), -ACCURACY / 3 if found.stands else ACCURACY / 3
        step = -found.lacking / slope if slope < 0 else math.nan
        step *= FARTHER if self.low == 0 and abs(step) > NEAR * part else 1.0
        guess = (part + step) * (1 + across)
        self.guesses = (self.guesses[0], guess) if found.stands else (guess, self.guesses[1])
        for guess in self.guesses:
            if self.low < guess < self.high and self.programs % HALVING:
                return min(max(guess, 1 / MOST), MOST)
        if self.low > 0 and self.high < math.inf:
            return math.sqrt(self.low * self.high)
        return max(part / STRIDE, 1 / MOST) if found.stands else min(part * STRIDE, MOST)

    def _slope(self, part: float, found: Shortfall) -> float:
        """Return the derivative of the missing strength; bounds are quadratic in the part, so differences are exact."""
        if not found.forces.any():
            return math.nan
        (rows, bound), (less, lower) = self._at(1.5 * part).bounds(), self._at(0.5 * part).bounds()
        return float(found.of_bounds @ ((rows - less) @ found.forces - (bound - lower))) / part

    @property
    def factor(self) -> float:
        """Greatest factor at which forces exist, as `StrengthLimit` says."""
        if self.high <= 1 / MOST:
            return math.inf
        return 0.0 if self.held is None else 1 / self.high

    def proof(self) -> Proof:
        """Return the proof that there are no forces beyond, which may move that side."""
        if self.failed is None or math.isinf(self.factor):
            return Proof(text="no limit: forces within strength exist at a thousandth of the strength chosen")
        for margin in MARGINS:
            if self.failed.least < ENORMOUS and self.held is not None:
                self._ask(self.high / (1 + margin))
        if self.failed.least < ENORMOUS:
            return Proof(text=f"{self._exist()}; rounding spoils the proof that there are none beyond")
        try:
            weaker = with_strength(self.model, dict.fromkeys(self.names, self.low))
            weaker = with_bolt_capacities(weaker, self.low) if self.bolts else weaker
        except ModelError as error:
            return Proof(text=f"{self._exist()}; the proof that there are none beyond cannot be written down: {error}")
        witness = witness_of(weaker, self._at(self.low), self.loads, self.failed.velocity, self.failed.slip)
        what = f"beyond {1 / self.low:.6g} the blocks must move (proved), whatever stiffness and history"
        return Proof(text=f"{self._exist()}; {what}", witness=witness)

    def _exist(self) -> str:
        if self.held is None:
            return f"no forces within strength exist, not at {MOST:g} times the strength chosen"
        return f"forces within strength exist up to the factor {self.factor:.6g}"
