"""The continuum solutions that a run is compared with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from bsm_mesh.converters.continuum.comparability import MAY_MOVE_FAR, continuum_obstacle, has_joints, rock_breaks
from bsm_mesh.converters.continuum.matched import matched_constants
from bsm_mesh.model.model import Model
from bsm_mesh.results.results import Results
from bsm_mesh.solve.zones.departures import is_all_rigid
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.mesh import Discretization, Mesher
from bsm_mesh.solve.zones.solution import ContinuumSolution
from bsm_mesh.solve.zones.stages import Continuum

Stages = tuple[ContinuumSolution, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """The problem to be solved, as `compare_stages` is asked."""

    order: int | None = None
    joints: bool | None = None
    refine: bool = True
    refinements: int = 0
    mesher: Mesher | None = None
    near_blocks: bool = False


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class References:
    """Continuum solutions of one model, stage by stage.

    Attributes
    ----------
    interfaces : bool
        Whether they have joints, or rock that breaks.
    nominal, matched : tuple of ContinuumSolution
        With the rocks' own elastic constants, and with those of the blocks; one where all rock is rigid.
    finer : tuple of ContinuumSolution
        Nominal, of the second order, as far as it finds equilibrium; none where that was not asked.
    halved : tuple of tuple of ContinuumSolution
        Nominal, with every side halved not at all, once, twice, ...; as far as they find equilibrium.
    asked : int
        How often sides were to be halved.
    may_move_far : bool
        Whether displacements are small by definition.
    """

    interfaces: bool
    nominal: Stages
    matched: Stages
    finer: Stages
    halved: tuple[Stages, ...]
    asked: int
    may_move_far: bool

    def obstacle(self, model: Model, number: int) -> str:
        """Return why the continuum's side of a stage cannot be compared; empty if it can."""
        return continuum_obstacle(model, self.nominal, number, self.may_move_far) or continuum_obstacle(
            model, self.matched, number, self.may_move_far
        )


def solve_references(model: Model, results: Results, count: int, asked: Request) -> References:
    """Return the continuum solutions of the first `count` stages of a run.

    Raises
    ------
    ModelError
        If the continuum cannot be solved.
    """
    solved, elements = continuum_of(model, results, count, asked)
    small, interfaces, order = results.scheme in MAY_MOVE_FAR, elements.joints, elements.order
    present = [stage.present for stage in results.stages[:count]]  # chips that came loose are taken away here too
    continuum = Continuum(solved, elements, present)
    near = [stage.displacement + stage.origin for stage in results.stages[:count]] if asked.near_blocks else []
    nominal = continuum.solve(nominal_constants(solved), count, near)
    matched = nominal if is_all_rigid(model) else continuum.solve(matched_constants(solved), count, near)
    halved, finer = [nominal], nominal[:0]
    for level in range(1, asked.refinements + 1):
        halved.append(_converged(Continuum(solved, replace(elements, refinements=level), present), halved[-1]))
    if asked.refine and interfaces and order == 1 and not asked.refinements:
        finer = _converged(Continuum(solved, replace(elements, order=2), present), nominal)
    return References(
        interfaces=interfaces,
        nominal=nominal,
        matched=matched,
        finer=finer,
        halved=tuple(halved),
        asked=asked.refinements,
        may_move_far=small,
    )


def continuum_of(model: Model, results: Results, count: int, asked: Request) -> tuple[Model, Discretization]:
    """Return the continuum solved for the first `count` stages of a run, and its elements as they are given."""
    small = results.scheme in MAY_MOVE_FAR
    breaks = not small and any(rock_breaks(stage.contacts) for stage in results.stages[:count])
    interfaces = (has_joints(model) or breaks) and asked.joints is not False
    order = (1 if interfaces else 2) if asked.order is None else asked.order
    elements = Discretization(
        order=order,
        joints=interfaces,
        rock_breaks=breaks and interfaces,
        elastic_bolts=small,
        mesher=asked.mesher,
    )
    return _elastic(model) if small else model, elements


def _converged(finer: Continuum, coarse: Sequence[ContinuumSolution]) -> Stages:
    """Return the stages of a finer continuum in which both find equilibrium."""
    count = sum(stage.converged for stage in coarse)
    return (
        tuple(stage for stage in finer.solve(nominal_constants(finer.model), count) if stage.converged) if count else ()
    )


def _elastic(model: Model) -> Model:
    """Return the model with joints that neither slip nor open and rock that does not break, as in the linear scheme."""
    return model.replace(
        joints=[joint.without_law() for joint in model.joints],
        rocks=[
            replace(
                rock,
                cohesion=None,
                friction=None,
                tensile_strength=None,
                residual_friction=None,
                residual_cohesion=None,
                softening_slip=None,
                residual_tensile_strength=0.0,
            )
            for rock in model.rocks
        ],
    )
