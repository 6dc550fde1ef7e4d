"""The in-situ stress of the ground in space: six components, or the weight of the ground with K along a trend."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.in_situ import IN_SPACE, places_of
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model


class SpaceStress:
    """The total stress of the ground, tension positive, wherever it is asked for.

    Parameters
    ----------
    model : Model
        Of polyhedra, with an ``in_situ`` that describes a field.
    """

    def __init__(self, model: Model) -> None:
        if model.in_situ is None or not model.in_situ.describes_field:
            raise ModelError("in_situ: no field is given; give surface with k0, or stress = {xx, yy, zz, xy, yz, xz}")
        self.given, self.unit_weight = model.in_situ, float(model.unit_weights.max(initial=0.0))

    def at(self, points: FloatArray) -> FloatArray:
        """Return the stress at points (k, 3), (k, 3, 3) [Pa]."""
        stress, given = np.zeros((len(points), 3, 3)), self.given
        if given.stress is not None:
            linear = np.column_stack([np.ones(len(points)), points])
            for (row, column), field in zip(places_of(given.stress), given.stress, strict=True):
                stress[:, row, column] = stress[:, column, row] = linear @ np.array(field)
            return stress
        depth = given.level(points[:, 0]) - points[:, 2]
        vertical = self.unit_weight * np.maximum(depth, 0.0) + given.surcharge
        along, across = (
            a * self.unit_weight + (b + c * depth) * vertical for a, b, c in (given.k0, given.k0_across or given.k0)
        )
        trend = np.radians(given.trend or 0.0)
        way = np.array([np.sin(trend), np.cos(trend), 0.0])
        level, up = np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])
        both = np.outer(way, way)
        covered = depth >= 0
        for size, tensor in ((along, both), (across, level - both), (vertical, up)):
            stress -= np.where(covered, size, 0.0)[:, None, None] * tensor
        return stress


def in_situ_faults(model: Model) -> Iterable[str]:
    """Return a sentence for every part of an in-situ stress that does not fit polyhedra."""
    given, blocks = model.in_situ, model.blocks
    if given is None:
        return
    assert in_space(blocks)
    if given.stress is not None and len(given.stress) != len(IN_SPACE):
        yield "in_situ: of polyhedra stress needs the components xx, yy and zz (and xy, yz, xz)"
    if given.surface is None:
        return
    if isinstance(given.surface, tuple):
        yield "in_situ: of polyhedra surface is one level [m], and the ground is level; give stress for other ground"
        return
    weights = [rock.unit_weight for rock in model.rocks if rock.name in blocks.rock_names]
    if len(set(weights)) > 1:
        yield "in_situ: surface with k0 needs one unit weight, and the rocks have several; give stress = {xx, ...}"
    if blocks.vertices[:, 2].min() >= given.surface:
        yield f"in_situ: the whole model lies above the surface, {given.surface:g} m; give the level of the ground"
