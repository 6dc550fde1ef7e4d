"""Limit analysis of a model of polyhedra: whether a stage is admissible, factors on its loads and on its strength."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, Portable, show_only
from bsm_mesh.errors import ModelError, named_stage, raise_faults
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import GIVEN_LOADS, Load, PointForces, point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.values import Rules
from bsm_mesh.movements import cross
from bsm_mesh.results.evidence import Proof
from bsm_mesh.solve.stages.as_built import in_stage
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.limit.analysis import MOST, ConeAnalysis, LimitAnalysis3D
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.strength import ConeStrength, cone_strength
from bsm_mesh.three_d.limit.ties import Ties
from bsm_mesh.three_d.step.block_system import BlockSystem

MARGINS = (1e-4, 1e-3)  # beyond a factor of strength, where a mechanism is to prove that there are no forces


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ModelProgram:
    """The conic program of a model without stages.

    Attributes
    ----------
    analysis : LimitAnalysis3D
        With the model's supports and bolts.
    loads : (n, 6) float64 [N, N m]
        Weights, loads and water.
    strength : ConeStrength
        Of the contact points, and of the bolts.
    """

    analysis: LimitAnalysis3D
    loads: FloatArray
    strength: ConeStrength

    @classmethod
    def of(cls, model: Model, most: float = math.inf) -> ModelProgram:
        """Return the program of blocks as they were given, with at most so many contact points.

        Raises
        ------
        ModelError
            If a law has no straight lines, or there are too many points.
        """
        assert in_space(model.blocks)
        blocks, system = model.blocks, BlockSystem(model)
        held = system.prescribed_blocks
        rule = "corners" if model.contact_points == "corners" else "both"
        points = LimitPoints.of(blocks.contact_polygons, rule)
        points = points.with_more(LimitPoints.touching(blocks, system.touching, system.size))
        analysis = LimitAnalysis3D(blocks.moments, points, held, Ties.of(model, held))
        if analysis.points.count > most:
            raise ModelError(f"limit analysis: {analysis.points.count} contact points are too many for one in a run")
        materials = Materials.checked(blocks, model.rocks, model.joints, model.default_joint)
        strength = cone_strength(materials, blocks, analysis.points)
        return cls(analysis=analysis, loads=system.loads, strength=strength)

    def analyse(self) -> ConeAnalysis:
        """Return whether forces within strength balance the loads."""
        return self.analysis.analyse(self.loads, self.strength)


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class SpaceLimit(Portable):
    """Answer of limit analysis for a stage of polyhedra, in the geometry as given.

    Attributes
    ----------
    stage : str
        The stage in question.
    present : (n,) bool
        The blocks that are there.
    admissible : bool
        Whether forces within strength balance the loads. False proves movement, True proves nothing.
    factor : float
        Greatest factor on the chosen loads, or on the strength; infinite where there is no limit.
    beyond : float
        Factor on the strength beyond which there are proved to be no forces; infinite where nothing is proved.
    mechanism : (n, 6) float64
        Velocities of the blocks in the collapse, and rates of rotation; zero where there is none.
    points : int
        Number of contact points.
    unlimited : int
        Number of those without a limit of strength.
    bolt_force : (n_elements,) float64 [N]
        Tension of the bolts' elements, bolts of later stages left out.
    text : str
        The proved statement.
    """

    stage: str
    present: BoolArray
    admissible: bool
    factor: float
    beyond: float = math.inf
    mechanism: FloatArray
    points: int
    unlimited: int
    bolt_force: FloatArray
    text: str

    def __post_init__(self) -> None:
        show_only(self)

    @property
    def proof(self) -> Proof:
        """The proved statement, as a proof without a witness in a file."""
        return Proof(text=self.text)

    def __str__(self) -> str:
        """Return the proof, in words."""
        return f"in {named_stage(self.stage)}: {self.text}"


def limit_in_space(model: Model, live: Sequence[Load] | None, stage: str | None) -> SpaceLimit:
    """Return whether a stage of polyhedra is admissible, and the greatest factor on loads, or on all of them.

    As `bsm_mesh.solve.limit.analysis.limit_analysis`; friction is associated, so factors are upper bounds.

    Raises
    ------
    ModelError
        As there, and as `ModelProgram.of`.
    """
    rules = Rules("limit analysis")
    chosen = () if live is None else rules.things("live", live, *GIVEN_LOADS, derived=(PointForces,))
    raise_faults(rules.faults)
    name, part = in_stage(model, stage)
    program = ModelProgram.of(part.model)
    whole, of_loads = program.analyse(), np.zeros_like(program.loads)
    if live is not None:
        forces = part.acting(point_forces_of(model.worked_out(chosen), model.blocks))
        arm = forces.point - part.model.blocks.moments.centroid[forces.block]
        np.add.at(of_loads, forces.block, np.hstack([forces.force, cross(arm, forces.force)]))
        if not of_loads.any():
            raise ModelError(f"limit analysis: the chosen loads are zero in {named_stage(name)}")
    analysis, strength = program.analysis, program.strength
    if whole.admissible or live is None:
        dead = program.loads if live is not None else of_loads
        best = analysis.load_factor(dead, of_loads if live is not None else program.loads, strength)
        factor, mechanism, ties = best.value, best.velocity, best.ties
    else:
        factor, mechanism, ties = 0.0, whole.witness.velocity, whole.ties
    return SpaceLimit(
        stage=name,
        present=part.present,
        admissible=whole.admissible,
        factor=factor,
        mechanism=part.in_whole(mechanism),
        points=analysis.points.count,
        unlimited=_unlimited(strength),
        bolt_force=ties[analysis.program.ties.tensions],
        text=str(whole),
    )


def strength_in_space(
    model: Model, joints: Sequence[str] | None, stage: str | None, *, rocks: bool = True, bolts: bool = False
) -> SpaceLimit:
    """Return the greatest factor by which strength may be divided, of faces of rock where `rocks` says so.

    Forces still balance the stage's loads there. It is an upper bound of the factor of safety: 5 to 16 % above that of
    a wedge on two planes.

    Raises
    ------
    ModelError
        For joints that do not exist, and as `limit_in_space`.
    """
    name, part = in_stage(model, stage)
    program = ModelProgram.of(part.model)
    analysis, strength = program.analysis, program.strength
    chosen = _points_of(part.model, analysis, joints, rocks=rocks)
    factor = analysis.strength_factor(program.loads, strength, chosen, bolts=bolts)
    beyond, mechanism, ties = math.inf, np.zeros_like(program.loads), np.zeros(analysis.program.ties.count)
    text = "no limit: forces within strength exist at a thousandth of the strength chosen"
    if math.isfinite(factor):
        text = f"forces within strength exist up to the factor {factor:.6g}"
        for margin in MARGINS:
            divisor = max(factor, 1 / MOST) * (1 + margin)
            weaker = strength.divided(divisor, chosen, bolts=bolts)
            found = analysis.analyse(program.loads, weaker)
            mechanism, ties = found.witness.velocity, found.ties
            if not found.admissible and found.witness.proves:
                beyond = divisor
                text += f"; beyond {beyond:.6g} the blocks must move (proved), whatever stiffness and history"
                break
    return SpaceLimit(
        stage=name,
        present=part.present,
        admissible=factor >= 1,
        factor=factor,
        beyond=beyond,
        mechanism=part.in_whole(mechanism),
        points=analysis.points.count,
        unlimited=_unlimited(strength),
        bolt_force=ties[analysis.program.ties.tensions],
        text=text,
    )


def _points_of(model: Model, analysis: LimitAnalysis3D, joints: Sequence[str] | None, *, rocks: bool) -> BoolArray:
    """Return the contact points on joints of these names, all if None, and on faces of rock if `rocks`, (m,)."""
    known = {joint.name for joint in model.joints}
    if strange := [name for name in joints or () if name not in known]:
        raise ModelError(f"limit analysis: there is no joint '{strange[0]}'; joints: {', '.join(sorted(known))}")
    names = [*model.blocks.joint_names, model.default_joint]  # the last: faces without a joint, -1
    chosen = np.array([rocks if name is None else joints is None or name in joints for name in names])
    found: BoolArray = chosen[analysis.points.joint]
    return found


def _unlimited(strength: ConeStrength) -> int:
    return int((np.isinf(strength.intercept).all(axis=1) & np.isinf(strength.tension)).sum())
