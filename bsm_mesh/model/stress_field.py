"""The in-situ stress field of a model, and the forces that it makes on faces and edges (Wang 4.5.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.errors import ModelError
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.water_pressure import WaterLoad

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model

INWARD = 1e-6  # of the way to the centroid: on which side of an interface a face's end counts
ROUNDING = 1e-9  # m and over the level: a corner this far above the surface lies on it


@njit()
def add_interfaces(
    x: FloatArray,
    y: FloatArray,
    side_x: FloatArray,
    side_y: FloatArray,
    surface: FloatArray,
    start: FloatArray,
    end: FloatArray,
    jump: FloatArray,
    stress: FloatArray,
    top: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add to `stress` and `top` the change of the column's weight by the interfaces above every point.

    A column of the point's own unit weight up to the surface weighs too little by the jump (above less below) times
    the height of the surface over each interface on the way. (side_x, side_y) lies next to the point, off all
    interfaces, and says which of them are above.
    """
    for k in range(start.shape[0]):
        x0, x1 = start[k, 0], end[k, 0]
        low, high = min(x0, x1), max(x0, x1)
        slope = (end[k, 1] - start[k, 1]) / (x1 - x0) if x1 != x0 else 0.0
        for p in range(x.size):
            if side_x[p] < low or side_x[p] >= high:
                continue
            if start[k, 1] + slope * (side_x[p] - x0) <= side_y[p]:
                continue
            at = start[k, 1] + slope * (x[p] - x0)
            if at < surface[p]:
                stress[p] += jump[k] * (surface[p] - max(at, y[p]))
                top[p] += jump[k]


class StressField:
    """The total stress of the ground, tension positive, wherever it is asked for.

    Parameters
    ----------
    model : Model
        With an ``in_situ`` that describes a field.
    """

    def __init__(self, model: Model) -> None:
        if model.in_situ is None or not model.in_situ.describes_field:
            raise ModelError("in_situ: no field is given; give surface with k0, or stress = {xx, yy, xy}")
        self.model, self.given = model, model.in_situ
        self.water = WaterLoad(model)
        self._start, self._end, self._jump = _interfaces(model) if self.given.surface is not None else _NONE

    def at(self, points: FloatArray, block: IntArray) -> FloatArray:
        """Return the components xx, yy, xy at points (k, 2) of blocks (k,), their outlines included, (k, 3) [Pa]."""
        x, y = points.T
        if self.given.stress is not None:
            return np.stack([c + ax * x + ay * y for c, ax, ay in self.given.stress], axis=1)
        surface = self.given.level(x)
        weight = self.model.unit_weights[block]
        side = points + INWARD * (self.model.blocks.moments.centroid[block] - points)
        covered = y - surface <= ROUNDING * (1 + np.abs(surface))
        depth = np.maximum(surface - y, 0.0)
        vertical, top = weight * depth, weight.copy()
        add_interfaces(x, y, *side.T.copy(), surface, self._start, self._end, self._jump, vertical, top)
        vertical += self.given.surcharge
        a, b, c = self.given.k0
        horizontal = np.where(covered, a * top + (b + c * depth) * vertical, 0.0)
        vertical = np.where(covered, vertical, 0.0)
        return np.stack([-horizontal, -vertical, np.zeros(len(x))], axis=1)

    def end_forces(
        self,
        start: FloatArray,
        end: FloatArray,
        normal: FloatArray,
        blocks: tuple[IntArray, ...],
        joint: IntArray | None = None,
    ) -> FloatArray:
        """Return the forces at both ends of faces, (k, 2 ends, 2) [N/m], with resultant and moment of the traction.

        The traction is the effective one: the total less the water's pressure, which acts on the face besides.
        Simpson's rule along the face is exact for a traction that is quadratic there.

        Parameters
        ----------
        start, end : (k, 2) float64 [m]
            Ends of the faces.
        normal : (k, 2) float64
            Outward unit normals; the force is that on the block they point out of.
        blocks : tuple of (k,) int
            The blocks on either side; where they differ (at a vertical interface) the mean is taken.
        joint : (k,) int, optional
            Number of each face's joint, which may have a water pressure of its own; outer faces have none.
        """
        samples = []
        for points in (start, (start + end) / 2, end):
            stress = sum(self.at(points, block) for block in blocks) / len(blocks)
            xx, yy, xy = np.asarray(stress).T
            n = normal
            samples.append(np.stack([xx * n[:, 0] + xy * n[:, 1], xy * n[:, 0] + yy * n[:, 1]], axis=1))
        first, middle, last = samples
        length = np.hypot(*(end - start).T)[:, None]
        forces = np.stack([length * (first + 2 * middle) / 6, length * (2 * middle + last) / 6], axis=1)
        water: FloatArray = self.water.on_faces(start, end, joint)
        effective: FloatArray = forces + water[:, :, None] * normal[:, None, :]
        return effective

    def edge_forces(self, edges: IntArray) -> FloatArray:
        """Return the forces on the blocks at both ends of outer edges (k,), (k, 2 ends, 2) [N/m]."""
        blocks = self.model.blocks
        start, along = blocks.vertices[edges], blocks.edge_vectors[edges]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        return self.end_forces(start, start + along, normal, (blocks.owner[edges],))

    def equivalent_tractions(self, edges: IntArray) -> FloatArray:
        """Return tractions at both ends of outer edges, (k, 2 ends, 2) [Pa], which run linearly between them."""
        forces = self.edge_forces(edges)
        length = np.hypot(*self.model.blocks.edge_vectors[edges].T)[:, None, None]
        tractions: FloatArray = (4 * forces - 2 * forces[:, ::-1]) / length
        return tractions


_NONE = (np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))


def _interfaces(model: Model) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return start, end (k, 2) and jump (k,) of the unit weight, above less below, of faces between other weights."""
    weights = model.unit_weights
    if np.ptp(weights) == 0:
        return _NONE
    faces = find_faces(model.blocks)
    owner = model.blocks.owner
    of_a, of_b = weights[owner[faces.edge_a]], weights[owner[faces.edge_b]]
    chosen: BoolArray = of_a != of_b
    start, end = faces.start[chosen], faces.end[chosen]
    # The face runs in the direction of b's edge, b to its left: to the right b is above.
    jump = (of_b - of_a)[chosen] * np.where(end[:, 0] > start[:, 0], 1.0, -1.0)
    return start, end, jump
