"""Limit analysis: is there any field of contact forces in equilibrium and within strength? A linear program.

It knows statics and strength, but neither stiffness nor movement. So it proves one thing only: where no such field
exists, this geometry cannot be at rest and its blocks must move. Where one exists nothing is proved: a block wedged
between two walls is "at rest" for it, and friction at which blocks would in fact slide is mobilised as needed. Where a
joint has tensile strength the convex hull of its strength is taken, a little more than it has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, Portable, show_only
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import ModelError, named_stage, raise_faults
from bsm_mesh.model.loads import GIVEN_LOADS, Load, PointForces, point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.model.supports import unit_vector
from bsm_mesh.model.values import Rules
from bsm_mesh.solve.algebra.loads import external_loads, force_sums
from bsm_mesh.solve.limit.program import LimitProgram, Optimum, Shortfall
from bsm_mesh.solve.stages.as_built import in_stage


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class LimitAnalysis(Portable):
    """Answer of the linear program for the geometry as it is given.

    Blocks, edges and contacts have the numbers of the whole model.

    Attributes
    ----------
    stage : str
        The stage in question.
    present : (n,) bool
        The blocks that are there.
    admissible : bool
        Whether forces in equilibrium and within strength exist. False proves that the blocks must move; True
        proves nothing.
    factor : float
        Greatest factor on the chosen loads (all of them, weights included, where none were chosen); infinite where
        there is no limit.
    mechanism : (n, 3) float64
        Velocities u, v, theta of the blocks in the collapse at that factor (the dual of equilibrium), the greatest
        displacement of a centroid or rotation times radius of gyration being 1; zero where there is no limit.
    normal_force, shear_force : (m,) float64 [N/m]
        An admissible field at the factor, or at 1 where there is no limit; zero where there is none.
    contacts : ContactTable
        The contacts that they belong to.
    unlimited : int
        Number of contacts of unlimited strength: joints without a law, faces of rock without strength.
    bolt_force : (n_elements,) float64 [N]
        Tension of the bolts' elements in that field, of one bolt each; bolts of later stages are not there.
    """

    stage: str
    present: BoolArray
    admissible: bool
    factor: float
    mechanism: FloatArray
    normal_force: FloatArray
    shear_force: FloatArray
    contacts: ContactTable
    unlimited: int
    bolt_force: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    def __str__(self) -> str:
        """Return the proof, in words."""
        where = f"in {named_stage(self.stage)}"
        if not self.admissible:
            return f"inadmissible {where}: no forces within strength balance the loads; this geometry must move"
        return f"admissible {where}: forces within strength exist; that does not prove that the blocks stay at rest"


def limit_analysis(model: Model, live: Sequence[Load] | None = None, *, stage: str | None = None) -> LimitAnalysis:
    """Return whether a stage of the model is statically admissible, and the greatest factor on loads.

    Parameters
    ----------
    model : Model
        The input; the contacts are those of the geometry as it is, of the blocks that are there in the stage.
    live : sequence of load, optional
        Loads that the factor multiplies, in addition to those of the model and its stages, which are constant. Without
        them the factor multiplies everything: weights and loads together.
    stage : str, optional
        The stage in question, ``initial`` for the first; None: the last.

    Raises
    ------
    ModelError
        If there is no such stage, or statics cannot determine what acts there; if there is no weight and no load,
        blocks overlap, or the linear program cannot be solved.

    References
    ----------
    Livesley (1978), Limit analysis of structures formed from rigid blocks, Int. J. Num. Meth. Engng 12.
    """
    rules = Rules("limit analysis")
    rules.a_thing("model", model, Model)
    chosen_loads = () if live is None else rules.things("live", live, *GIVEN_LOADS, derived=(PointForces,))
    raise_faults(rules.faults)
    name, part = in_stage(model.replace(contact_points="ends"), stage)
    chosen = None
    if live is not None:
        forces = point_forces_of(model.replace(loads=chosen_loads).acting_loads, model.blocks)
        chosen = force_sums(part.acting(forces), part.model.blocks.moments.centroid)
        if not chosen.any():
            raise ModelError(f"limit analysis: the chosen loads are zero in {named_stage(name)}")
    found = _analysed(part.model, chosen)
    return replace(
        found,
        stage=name,
        present=part.present,
        mechanism=part.in_whole(found.mechanism),
        contacts=found.contacts.in_whole(part),
    )


def _analysed(model: Model, live: FloatArray | None) -> LimitAnalysis:
    """Return the description of a model without stages, with a factor on loads (n, 3), or on all of them."""
    program, dead = LimitProgram(model), external_loads(model)
    if live is None:
        if not dead.any():
            raise ModelError("limit analysis: the model has neither weight nor load; nothing can fail")
        whole = program.balance(dead)
        if whole.stands:
            limit = None if program.strength.is_cone else program.maximise(np.zeros_like(dead), dead)
            return _admissible(program, whole, limit)
        return _inadmissible(program, dead, whole)
    unloaded = program.balance(dead)
    if not unloaded.stands:
        return replace(_inadmissible(program, dead, unloaded), factor=0.0)
    return _admissible(program, unloaded, program.maximise(dead, live))


def _admissible(program: LimitProgram, balance: Shortfall, limit: Optimum | None) -> LimitAnalysis:
    """Return the record of forces that balance the loads, and of the limit of loads where there is one."""
    if limit is None or math.isinf(limit.factor):
        return _result(program, math.inf, balance.forces, np.zeros_like(balance.velocity), admissible=True)
    return _result(program, limit.factor, limit.forces, limit.velocity, admissible=True)


def _inadmissible(program: LimitProgram, loads: FloatArray, balance: Shortfall) -> LimitAnalysis:
    """Return the record of loads that no forces balance."""
    limit = program.collapse(loads, balance)
    return _result(program, limit.factor, limit.forces, limit.velocity, admissible=False)


def _result(
    program: LimitProgram, factor: float, forces: FloatArray, mechanism: FloatArray, *, admissible: bool
) -> LimitAnalysis:
    m = program.contacts.count
    return LimitAnalysis(
        stage=INITIAL,
        present=np.ones(program.blocks.count, dtype=bool),
        admissible=admissible,
        factor=factor,
        mechanism=mechanism,
        normal_force=-forces[:m],
        shear_force=forces[m : 2 * m],
        contacts=program.contacts,
        unlimited=int(program.strength.unlimited.sum()),
        bolt_force=program.bolt_force(forces),
    )


def limit_tilt(model: Model, *, stage: str | None = None, clockwise: bool = False, accuracy: float = 1e-6) -> float:
    """Return the greatest angle by which gravity may turn before a stage of the model is inadmissible [degrees].

    Found by halving between 0 and 90 degrees; 0 where the model is inadmissible as given, 90 where it never is.

    Parameters
    ----------
    model : Model
        The input. Its loads keep their directions, a ground surface its place; an earthquake's part of gravity
        turns with it.
    stage : str, optional
        The stage in question, ``initial`` for the first; None: the last.
    clockwise : bool
        Turn gravity clockwise, as if the model were tilted counter-clockwise; else the other way.
    accuracy : float [degrees]
        Width of the last interval.
    """
    sense = -1.0 if clockwise else 1.0
    _, part = in_stage(model.replace(contact_points="ends"), stage)

    def stands(tilt: float) -> bool:
        turned = _with_gravity_turned(part.model, sense * tilt)
        return LimitProgram(turned).balance(external_loads(turned)).stands

    if not stands(0.0):
        return 0.0
    low, high = 0.0, 90.0
    if stands(high):
        return high
    while high - low > accuracy:
        middle = (low + high) / 2
        low, high = (middle, high) if stands(middle) else (low, middle)
    return (low + high) / 2


def _with_gravity_turned(model: Model, angle: float) -> Model:
    """Return a model whose gravity, with an earthquake's part, is turned by an angle [degrees]."""
    cosine, sine = unit_vector(angle)
    horizontal, vertical = model.gravity_horizontal, model.gravity_vertical
    return model.replace(
        gravity_direction=model.gravity_direction + angle,
        gravity_horizontal=float(cosine * horizontal - sine * vertical),
        gravity_vertical=float(sine * horizontal + cosine * vertical),
    )
