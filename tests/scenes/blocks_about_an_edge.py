"""Blocks about a common edge, of which some are gone: a block on the edge alone falls past what is below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely.affinity import rotate, translate
from shapely.geometry import Polygon

import bsm_mesh as bsm
from tests.scenes.models import stiff_model
from tests.scenes.polyhedra import prism, rotation, turned

DEPTH = 1.0  # of the blocks below in space [m]
WIDEST = 2.6  # radians: the angle of a block at the edge
NARROWEST = 0.35


@dataclass(frozen=True, kw_only=True)
class BlocksAboutAnEdge:
    """The scene.

    Attributes
    ----------
    outlines : tuple of (k, 2) float64 [m]
        Of the blocks that are there, counter-clockwise, the edge first.
    held : tuple of bool
        Which supports hold: those below.
    friction : float [degrees]
        Of the joints.
    """

    outlines: tuple[np.ndarray, ...]
    held: tuple[bool, ...]
    friction: float

    @classmethod
    def drawn(cls, seed: int) -> BlocksAboutAnEdge:
        """Return a random one: of one block at least, that is not held, both neighbours are gone."""
        generator = np.random.default_rng([seed, 77])
        while True:
            count = int(generator.integers(4, 8))
            begin = np.sort(generator.uniform(0, 2 * np.pi, count))
            angle = np.diff(np.append(begin, begin[0] + 2 * np.pi))
            if angle.min() < NARROWEST or angle.max() > WIDEST:
                continue
            radii = generator.uniform(0.6, 1.4, count)
            below, gone = np.sin(begin + angle / 2) < 0, generator.random(count) < 0.4
            alone = ~below & ~gone & np.roll(gone, 1) & np.roll(gone, -1)
            if alone.any() and (below & ~gone).any():
                break
        there = np.flatnonzero(~gone)
        outlines = [_sector(begin[k], angle[k], radii[k], radii[(k + 1) % count]) for k in there]
        friction = float(generator.uniform(10, 45))
        return cls(outlines=tuple(outlines), held=tuple(below[there].tolist()), friction=friction)

    def model(self) -> bsm.Model:
        """Return it in the plane."""
        return self._model(bsm.Blocks.from_polygons(list(self.outlines), rock="rock"))

    def in_space(self, *, width: float = 1.0, aside: float = 0.5, direction: float = 0.0) -> bsm.Model:
        """Return it in space: what is loose has a share of the depth, aside by a share of the rest, all turned."""
        solids = []
        for outline, held in zip(self.outlines, self.held, strict=True):
            corners, sides = prism(outline, depth=DEPTH if held else width * DEPTH)
            shift = 0.0 if held else aside * (1 - width) * DEPTH
            solids.append((corners + np.array([0, shift, 0]), sides))
        return self._model(bsm.Polyhedra.from_solids(turned(solids, rotation(direction, 0)), rock="rock"))

    def depth(self, moved: np.ndarray, direction: float = 0.0) -> float:
        """Return how deep blocks overlap after movements (n, 3 or 6), area over half the outline [m].

        `direction` is that of `in_space`.
        """
        if moved.shape[1] == 6:
            a = np.radians(direction)
            along, across = (np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)]))
            moved = np.column_stack([moved[:, :2] @ along, moved[:, 2], -moved[:, 3:5] @ across])
        blocks = [Polygon(outline) for outline in self.outlines]
        there = [
            translate(rotate(block, turn, origin=block.centroid, use_radians=True), x, y)
            for block, (x, y, turn) in zip(blocks, moved.tolist(), strict=True)
        ]
        shared = [a.intersection(b) for k, a in enumerate(there) for b in there[:k]]
        return max((2 * area.area / area.length for area in shared if area.length > 0), default=0.0)

    def _model(self, blocks: bsm.Blocks | bsm.Polyhedra) -> bsm.Model:
        return stiff_model(blocks, friction=self.friction, held=np.flatnonzero(self.held).tolist())


def _sector(begin: float, angle: float, first: float, last: float) -> np.ndarray:
    """Return the outline of a block about the edge, with a corner more between its sides where it is wide."""
    end, middle = begin + angle, begin + angle / 2
    ways = [(begin, first), *([(middle, 1.1 * max(first, last))] if angle > np.pi / 2 else []), (end, last)]
    return np.array([(0.0, 0.0), *((radius * np.cos(way), radius * np.sin(way)) for way, radius in ways)])
