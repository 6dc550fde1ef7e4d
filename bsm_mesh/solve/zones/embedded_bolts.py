"""Bolts as bars embedded in the continuum (Phillips & Zienkiewicz 1976): their nodes move with the rock around them.

The bars are those of the Block-Spring Model, `InstalledBolts`, with the same nodes, bond, yield and dowels; where its
nodes are fixed to rigid blocks, these take the displacement of the elements at their place.

References
----------
Phillips & Zienkiewicz (1976), Finite element non-linear analysis of concrete structures, Proc. Instn Civ. Engrs 61(1),
59-88.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.bolt_layout import BoltLayout, lay_out_bolts
from bsm_mesh.model.model import Model
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.memory import BoltMemory
from bsm_mesh.solve.bolts.record import bolt_forces
from bsm_mesh.solve.zones.mesh import ContinuumMesh
from bsm_mesh.solve.zones.points import sampling


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ElasticState:
    """What bolts carry that are elastic about their pretension.

    Attributes
    ----------
    position : (bodies, 3) float64 [m, m, 0]
        Of the bodies.
    tension, shear : (n_elements,), (k,) float64 [N]
        In the elements, and in the crossings, there.
    """

    position: FloatArray
    tension: FloatArray
    shear: FloatArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class EmbeddedBolts:
    """The bolts of a model in its continuum, with their state after the last equilibrium.

    Attributes
    ----------
    bolts : InstalledBolts
        The bars; each node, and each side of a crossing, is a body of its own.
    block : (n_nodes,) int32
        Block of every node.
    rows : pair of sparse (bodies, N)
        Give the bodies' displacements in x and y.
    elastic : ElasticState or None
        Forces of the bolts in the linear scheme, where nothing gives way; None: they slip, slacken and yield.
    """

    bolts: InstalledBolts
    block: IntArray
    rows: tuple[Any, Any]
    elastic: ElasticState | None

    @classmethod
    def of(
        cls, model: Model, mesh: ContinuumMesh, basis: Any, *, elastic: bool = False, straight: bool = False
    ) -> EmbeddedBolts:
        """Return the bolts of a model, none of them installed; elastic ones as in the linear scheme.

        `straight` bars keep their direction: of their nodes' displacements only those along them count.

        Raises
        ------
        ModelError
            For bolts that end in the void or run along an edge.
        """
        layout = lay_out_bolts(model.bolts, model.blocks, model.stages)
        bolts = InstalledBolts.at_points(layout)
        body, point = _bodies(bolts, layout.block)
        rows = sampling(mesh, basis, point, body)
        if straight:
            rows = _along_bars(rows, layout)
        state = None
        if elastic:
            shear = np.zeros(len(bolts.dowels.element))
            state = ElasticState(position=np.zeros((len(point), 3)), tension=np.zeros(len(bolts.alive)), shear=shear)
        return cls(bolts=bolts, block=layout.block, rows=rows, elastic=state)

    @property
    def bodies(self) -> tuple[IntArray, FloatArray]:
        """Block (k,) and place as given (k, 2) [m] of every body."""
        return _bodies(self.bolts, self.block)

    def install(self, stage: int, u: FloatArray) -> EmbeddedBolts:
        """Return a copy with the bolts of a stage installed at displacements u (N,), which do not strain them."""
        position = self._position(u)
        if self.elastic is None:
            return replace(self, bolts=self.bolts.install(stage, position))
        bolts = self.bolts.install(stage, np.zeros_like(position))
        fresh, at = bolts.alive & ~self.bolts.alive, bolts.evaluate(np.zeros_like(position))
        state = ElasticState(
            position=position,
            tension=np.where(fresh, at.tension, self.elastic.tension),
            shear=np.where(fresh[bolts.dowels.element], at.dowels.force, self.elastic.shear),
        )
        return replace(self, bolts=bolts, elastic=state)

    def without(self, gone: BoolArray) -> EmbeddedBolts:
        """Return a copy cut where blocks (n,) are not there."""
        bodies = np.zeros(self.rows[0].shape[0], dtype=bool)
        bodies[: len(self.block)] = gone[self.block]
        bolts, state = self.bolts.without(bodies), self.elastic
        if state is not None:
            shear = state.shear * bolts.alive[bolts.dowels.element]
            state = replace(state, tension=state.tension * bolts.alive, shear=shear)
        return replace(self, bolts=bolts, elastic=state)

    def evaluate(self, u: FloatArray) -> BoltEvaluation:
        """Return the forces at displacements u (N,)."""
        position = self._position(u)
        if self.elastic is None:
            return self.bolts.evaluate(position)
        as_installed = self.bolts.evaluate(np.zeros_like(position))
        start = self.bolts.with_forces(as_installed, self.elastic.tension, self.elastic.shear)
        return self.bolts.strained(start, self.bolts.coupling(as_installed), position - self.elastic.position)

    def forces(self, at: BoltEvaluation) -> FloatArray:
        """Return the forces on the rock, (N,) [N/m]."""
        x, y = self.rows
        forces: FloatArray = x.T @ at.forces[:, 0] + y.T @ at.forces[:, 1]
        return forces

    def tangent(self, at: BoltEvaluation) -> Any:
        """Return the derivative (N, N) of minus the forces, with the turning of the bars under their tension."""
        layout, dowels = self.bolts.layout, self.bolts.dowels
        first, across = layout.first_node, at.direction[:, ::-1] * (-1.0, 1.0)
        spacing = layout.spacing[layout.bolt_of_element]
        law, bent = at, at.tension
        if self.elastic is not None:
            law, bent = self.bolts.evaluate(np.zeros_like(self.elastic.position)), np.zeros_like(at.tension)
        along, sideways = (self._relative(first, first + 1, axes) for axes in (at.direction, across))
        pull = np.divide(bent, at.length * spacing, out=np.zeros_like(bent), where=at.length > 0)
        sheared = self._relative(dowels.near, dowels.far, at.dowels.across)
        stiffness = dowels.tangent(law.dowels, self.bolts.alive) / dowels.spacing
        return (
            along.T @ (sp.diags(1 / spacing) @ self._coupling(law)) @ along
            + sideways.T @ sp.diags(pull) @ sideways
            + sheared.T @ sp.diags(stiffness) @ sheared
        )

    def commit(self, at: BoltEvaluation, u: FloatArray) -> EmbeddedBolts:
        """Return the bolts after a state of equilibrium at displacements u (N,)."""
        if self.elastic is None:
            return replace(self, bolts=self.bolts.commit(at))
        state = ElasticState(position=self._position(u), tension=at.tension, shear=at.dowels.force)
        return replace(self, elastic=state)

    def recalled(self, memory: BoltMemory) -> EmbeddedBolts:
        """Return a copy of bolts that slip, slacken and yield, with a memory."""
        return replace(self, bolts=memory.recalled(self.bolts))

    def record(self, model: Model, at: BoltEvaluation) -> BoltForces:
        """Return the record of the forces, as of the bolts between rigid blocks."""
        found = bolt_forces(model.bolts, self.bolts, at)
        return replace(found, block=self.block, displacement=at.point - self.bolts.layout.point)

    def _position(self, u: FloatArray) -> FloatArray:
        x, y = (rows @ u for rows in self.rows)
        return np.stack([x, y, np.zeros_like(x)], axis=1)

    def _relative(self, near: IntArray, far: IntArray, direction: FloatArray) -> Any:
        """Return the sparse matrix (k, N) of the far bodies' displacement against the near ones' in directions."""
        return sum(sp.diags(part) @ (rows[far] - rows[near]) for part, rows in zip(direction.T, self.rows, strict=True))

    def _coupling(self, at: BoltEvaluation) -> Any:
        """Return the derivatives (n_elements, n_elements) of the tensions by the stretches."""
        layout = self.bolts.layout
        bolt = layout.bolt_of_element
        size = np.diff(layout.node_start).astype(np.int64)[bolt] - 1  # rows and columns of the bolt of each element
        first = layout.node_start[bolt] - bolt
        row = np.repeat(np.arange(len(bolt)), size)
        column = np.arange(len(row)) - np.repeat(np.cumsum(size) - size - first, size)
        return sp.csr_matrix((self.bolts.coupling(at), (row, column)), shape=(len(bolt), len(bolt)))


def _bodies(bolts: InstalledBolts, block: IntArray) -> tuple[IntArray, FloatArray]:
    """Return block and place of the nodes of bolts, in blocks (n_nodes,), then of both sides of every crossing."""
    near = bolts.layout.first_node[bolts.dowels.element]
    sides = np.stack([block[near], block[near + 1]], axis=1).ravel()
    point = np.concatenate([bolts.layout.point, np.repeat(bolts.dowels.crossing, 2, axis=0)])
    return np.concatenate([block, sides]), point


def _along_bars(rows: tuple[Any, Any], layout: BoltLayout) -> tuple[Any, Any]:
    """Return the rows of the bodies with those of bolts' nodes replaced by their parts along the bolts."""
    first = layout.first_node
    along = np.zeros((rows[0].shape[0], 2))
    for node in (first, first + 1):
        along[node] = layout.point[first + 1] - layout.point[first]
    length = np.hypot(*along.T)
    is_node = length > 0
    x, y = (along / np.where(is_node, length, 1.0)[:, None]).T
    plain = sp.diags((~is_node).astype(float))
    part = sp.diags(x) @ rows[0] + sp.diags(y) @ rows[1]
    return sp.csr_matrix(sp.diags(x) @ part + plain @ rows[0]), sp.csr_matrix(sp.diags(y) @ part + plain @ rows[1])
