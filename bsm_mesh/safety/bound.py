"""The upper bound that limit analysis gives a factor of safety, with its proof."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.model import Model
from bsm_mesh.movements import in_mechanism
from bsm_mesh.results.evidence import Proof
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.solve.stages.as_built import as_built, part_of, small_blocks


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Limit:
    """The upper bound of a factor by limit analysis, or the reason for none.

    Attributes
    ----------
    factor : float
        No forces within the strength divided by a greater factor balance the loads; infinite: statics knows no limit.
    text : str
        That in words.
    proof : Proof or None
        With the mechanism.
    unproved : float
        A factor beyond which no forces were found, without a proof; infinite: there is none.
    mechanism : (n, axes) float64 or None
        Velocities of the blocks, as in `LimitAnalysis`.
    """

    factor: float
    text: str
    proof: Proof | None = None
    unproved: float = math.inf
    mechanism: FloatArray | None = None

    def __repr__(self) -> str:
        """Return the bound in one line."""
        return f"Limit: {self.text}"


def limit_of(model: Model, reduction: Reduction, falls: Falls) -> Limit:
    """Return the upper bound of limit analysis on the last stage of a model, or why there is none.

    Blocks that are too small to count are taken away where the mechanism moves nothing else, as a run takes them away.
    """
    from bsm_mesh.solve.limit_analysis import strength_limit

    try:
        part = as_built(model)
        small = small_blocks(part.model, falls)
        while True:
            found = strength_limit(part.model, reduction.joints, rocks=reduction.rocks, bolts=reduction.bolts)
            moves = in_mechanism(found.mechanism, part.model.blocks.moments.gyration)
            if not moves.any() or not small[moves].all() or moves.all():
                break
            part, small = part_of(part, ~moves), small[~moves]
    except ModelError as error:
        why = str(error).removeprefix("limit analysis: ")
        return Limit(factor=math.inf, text=f"no upper bound: {why}")
    if math.isinf(found.beyond):  # nothing is proved: no limit, or contacts that limit analysis leaves out
        text = f"no upper bound: {found.proof.text.removeprefix('no limit: ')}"
        return Limit(factor=math.inf, text=text, unproved=found.factor or math.inf)
    text = f"upper bound {found.beyond:.5g} (initial geometry): beyond it no forces within strength balance the loads"
    if found.factor == 0:
        text = "at any strength, no forces balance the loads where the blocks were given: they must move"
    mechanism = part.in_whole(found.mechanism)
    return Limit(factor=found.factor and found.beyond, text=text, proof=found.proof, mechanism=mechanism)
