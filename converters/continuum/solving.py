"""The continuum solution of a model: its stages one after the other, or the last one."""

from __future__ import annotations

from typing import TypedDict, Unpack

from bsm_mesh.converters.continuum.matched import ElasticityName, constants_of
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.values import Rules
from bsm_mesh.solve.zones.mesh import Discretization, Mesher
from bsm_mesh.solve.zones.solution import ContinuumSolution
from bsm_mesh.solve.zones.stages import Continuum


class DiscretizationKeys(TypedDict, total=False):
    """The fields of `Discretization`, as keyword arguments."""

    order: int
    joints: bool
    rock_breaks: bool
    elastic_bolts: bool
    refinements: int
    mesher: Mesher | None


def solve_continuum(
    model: Model, *, elasticity: ElasticityName = "nominal", **discretization: Unpack[DiscretizationKeys]
) -> ContinuumSolution:
    """Return the last stage of the continuum solution of a model, as `solve_continuum_stages` finds it.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> square = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="granite")
    >>> square = square.with_boundary("bottom", lambda x, y: y < 1e-9)
    >>> rock = bsm.Rock("granite", unit_weight=26e3, young=50e9, poisson=0.0)
    >>> model = bsm.Model(blocks=square, rocks=[rock], supports=[bsm.Fixed(boundary="bottom")])
    >>> print(f"{solve_continuum(model).stress[0, 1, 1]:.0f} Pa")
    -13000 Pa
    """
    return solve_continuum_stages(model, elasticity=elasticity, **discretization)[-1]


def solve_continuum_stages(
    model: Model, *, elasticity: ElasticityName = "nominal", **discretization: Unpack[DiscretizationKeys]
) -> tuple[ContinuumSolution, ...]:
    """Return the continuum solution of all stages of a model: the same domain, supports, loads, water and stress.

    It ends with the first stage in which no equilibrium is found.

    Parameters
    ----------
    model : Model
        The model. Without `joints` every rock in use must be elastic; with them a rigid rock is a very stiff one.
    elasticity : {"nominal", "matched"}
        Elastic constants, see `ContinuumSolution`.
    **discretization
        `Discretization`: by default elements of the second order, without joints. With `joints` those of the first
        order have them at the blocks' own contact points.

    Raises
    ------
    ModelError
        For rigid rocks without `joints`, bolts that end in the void, and parts free to move. Supports that contradict
        each other at a shared node are a fault too.
    """
    rules = Rules("continuum")
    rules.a_thing("model", model, Model)
    raise_faults(rules.faults)
    return Continuum(model, Discretization(**discretization)).solve(constants_of(model, elasticity))
