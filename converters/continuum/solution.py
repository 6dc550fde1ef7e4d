"""Plane-strain solution of a model's domain by scikit-fem, stage by stage, averaged over the blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict, Unpack

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.continuum.mesh import Discretization, Mesher
from bsm_mesh.model.model import Model
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import ContactForces


class DiscretizationKeys(TypedDict, total=False):
    """The fields of `Discretization`, as keyword arguments."""

    order: int
    joints: bool
    rock_breaks: bool
    elastic_bolts: bool
    refinements: int
    mesher: Mesher | None


ElasticityName = Literal["nominal", "matched"]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContinuumSolution:
    """A stage of a continuum solution, averaged over the blocks, and its mesh.

    Attributes
    ----------
    name : str
        Of the stage; the first is ``initial``.
    converged : bool
        Whether equilibrium was found, no block having moved farther than its own size; always so without joints that
        slip or open. Small displacements hold for far less: `compare` looks at that.
    elasticity : {"nominal", "matched"}
        Elastic constants: the rock's E and Poisson's ratio, or those of the continuum to which the
        Block-Spring Model tends (`converters.continuum.elasticity.matched_elasticity`).
    present : (n,) bool
        Which blocks are there; arrays over blocks hold zeros for the others.
    stress : (n, 2, 2) float64 [Pa]
        Average total stress of every block, tension positive.
    displacement : (n, 3) float64 [m, m, rad]
        Average of u, v and of the rotation (dv/dx - du/dy) / 2 over every block, counted as the blocks' own: from the
        end of the in-situ state where it is given.
    contacts : ContactForces
        Forces at the points of the joints; none where joints are ignored.
    bolts : BoltForces
        Forces of the bolts.
    points : (p, 2) float64 [m]
        Nodes: vertices of the cells, then middles of their sides (second order).
    point_displacement : (p, 2) float64 [m]
        Displacement of the nodes.
    cells : (t, 3), (t, 4), (t, 6) or (t, 8) int32
        Nodes of the triangles or quads, counter-clockwise: corners, then the middles of sides 0-1, 1-2, ... (VTK's).
    cell_block : (t,) int32
        Block of every cell.
    cell_stress : (t, 2, 2) float64 [Pa]
        Average total stress of every cell.
    total_load, total_reaction : (2,) float64 [N/m]
        Sum of weights, loads and water, and of the forces of the supports.
    unknowns : int
        Number of displacement components that were solved for.
    seconds : float
        Wall time of the solution up to here.
    notes : tuple of str
        What the continuum leaves out or treats in its own way, a sentence each.
    """

    name: str
    converged: bool
    elasticity: ElasticityName
    present: BoolArray
    stress: FloatArray
    displacement: FloatArray
    contacts: ContactForces
    bolts: BoltForces
    points: FloatArray
    point_displacement: FloatArray
    cells: IntArray
    cell_block: IntArray
    cell_stress: FloatArray
    total_load: FloatArray
    total_reaction: FloatArray
    unknowns: int
    seconds: float
    notes: tuple[str, ...]


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
        What is given. Without `joints` every rock in use must be elastic; with them a rigid rock is a very stiff one.
    elasticity : {"nominal", "matched"}
        Elastic constants, see `ContinuumSolution`.
    **discretization
        `Discretization`: by default elements of the second order, without joints. With `joints` those of the first
        order have them at the blocks' own contact points.

    Raises
    ------
    ModelError
        For rigid rocks without `joints`, bolts that end in the void, supports that contradict each other at a shared
        node, or a part free to move.
    """
    from bsm_mesh.converters.continuum.stages import Continuum

    return Continuum(model, Discretization(**discretization)).solve(elasticity)
