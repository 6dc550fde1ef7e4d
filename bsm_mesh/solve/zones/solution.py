"""Plane-strain solution of a model's domain by scikit-fem, stage by stage, averaged over the blocks."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import ContactForces


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContinuumSolution:
    """A stage of a continuum solution, averaged over the blocks, and its mesh.

    Attributes
    ----------
    name : str
        Of the stage; the first is ``initial``.
    converged : bool
        Whether equilibrium was found and no block moved more than its own size. It always is without joints that
        slip or open. Small displacements hold for far less: `compare` looks at that.
    elasticity : str
        Elastic constants: the rock's E and Poisson's ratio, or those of the continuum to which the
        Block-Spring Model tends (`converters.continuum.matched.matched_elasticity`).
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
        Parts that the continuum leaves out or treats in its own way, a sentence each.
    """

    name: str
    converged: bool
    elasticity: str
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
