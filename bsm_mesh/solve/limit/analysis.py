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

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.loads import GIVEN_LOADS, Load, PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import unit_vector
from bsm_mesh.model.values import Rules
from bsm_mesh.solve.algebra.loads import external_loads
from bsm_mesh.solve.limit.program import LimitProgram, Optimum, Shortfall


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LimitAnalysis:
    """What the linear program says of the geometry as it is given.

    Attributes
    ----------
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
        Tension of the bolts' elements in that field, of one bolt each; bolts that name a stage are not there.
    """

    admissible: bool
    factor: float
    mechanism: FloatArray
    normal_force: FloatArray
    shear_force: FloatArray
    contacts: ContactTable
    unlimited: int
    bolt_force: FloatArray

    def __str__(self) -> str:
        """Return what is proved, in words."""
        if not self.admissible:
            return "inadmissible: no forces within strength balance the loads; this geometry must move"
        return "admissible: forces within strength exist; that alone does not prove that the blocks stay at rest"


def limit_analysis(model: Model, live: Sequence[Load] | None = None) -> LimitAnalysis:
    """Return whether the model is statically admissible, and the greatest factor on loads.

    Parameters
    ----------
    model : Model
        What is given; the contacts are those of the geometry as it is.
    live : sequence of load, optional
        Loads that the factor multiplies, beside the model's own, which stay as they are. Without them the factor
        multiplies everything: weights and loads together.

    Raises
    ------
    ModelError
        If the model has no weight and no load, blocks overlap, or the linear program cannot be solved.

    References
    ----------
    Livesley (1978), Limit analysis of structures formed from rigid blocks, Int. J. Num. Meth. Engng 12.
    """
    rules = Rules("limit analysis")
    rules.a_thing("model", model, Model)
    chosen_loads = () if live is None else rules.things("live", live, *GIVEN_LOADS, derived=(PointForces,))
    raise_faults(rules.faults)
    program = LimitProgram(model.replace(contact_points="ends"))
    dead = external_loads(model)
    if live is None:
        if not dead.any():
            raise ModelError("limit analysis: the model has neither weight nor load; nothing can fail")
        whole = program.balance(dead)
        if whole.stands:
            limit = None if program.strength.is_cone else program.maximise(np.zeros_like(dead), dead)
            return _admissible(program, whole, limit)
        return _inadmissible(program, dead, whole)
    chosen = external_loads(model.replace(loads=chosen_loads)) - external_loads(model.replace(loads=()))
    if not chosen.any():
        raise ModelError("limit analysis: the chosen loads are zero")
    unloaded = program.balance(dead)
    if not unloaded.stands:
        return replace(_inadmissible(program, dead, unloaded), factor=0.0)
    return _admissible(program, unloaded, program.maximise(dead, chosen))


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
        admissible=admissible,
        factor=factor,
        mechanism=mechanism,
        normal_force=-forces[:m],
        shear_force=forces[m : 2 * m],
        contacts=program.contacts,
        unlimited=int(program.strength.unlimited.sum()),
        bolt_force=program.bolt_force(forces),
    )


def limit_tilt(model: Model, *, clockwise: bool = False, accuracy: float = 1e-6) -> float:
    """Return the greatest angle by which gravity may turn before the model is inadmissible [degrees].

    Found by halving between 0 and 90 degrees; 0 where the model is inadmissible as it stands, 90 where it never is.

    Parameters
    ----------
    model : Model
        What is given. Its loads keep their directions; what an earthquake adds to gravity turns with it.
    clockwise : bool
        Turn gravity clockwise, as if the model were tilted counter-clockwise; else the other way.
    accuracy : float [degrees]
        Width of the last interval.
    """
    sense = -1.0 if clockwise else 1.0
    bolts = tuple(bolt for bolt in model.bolts if bolt.stage is None)
    # a ground surface is not tilted
    model = model.replace(loads=model.acting_loads, bolts=bolts, in_situ=None, stages=())

    def stands(tilt: float) -> bool:
        turned = _with_gravity_turned(model, sense * tilt)
        return LimitProgram(turned.replace(contact_points="ends")).balance(external_loads(turned)).stands

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
    """Return a model whose gravity, with what an earthquake adds, is turned by an angle [degrees]."""
    cosine, sine = unit_vector(angle)
    horizontal, vertical = model.gravity_horizontal, model.gravity_vertical
    return model.replace(
        gravity_direction=model.gravity_direction + angle,
        gravity_horizontal=float(cosine * horizontal - sine * vertical),
        gravity_vertical=float(sine * horizontal + cosine * vertical),
    )
