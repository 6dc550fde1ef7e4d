"""A slab that slides over a kink: two blocks of ground meet there, and the plane is flatter below it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.faces import find_faces
from tests.scenes.models import stiff_model
from tests.scenes.polyhedra import prism, rotation, turned

DEPTH = 3.0  # of the ground in space [m]


@dataclass(frozen=True, kw_only=True)
class KinkedPlane:
    """The scene.

    Attributes
    ----------
    friction, upper, lower : float [degrees]
        Angle of friction, and dips above and below the kink.
    length, height, gap : float [m]
        Of the slab, and its distance from the kink.
    loose : bool
        Whether the ground rests on a third block; else supports hold it.
    bare : bool
        Whether only faces between the slab, the ground and that block have a joint, and no outer face.
    """

    friction: float
    upper: float
    lower: float
    length: float = 3.0
    height: float = 1.0
    gap: float = 0.2
    loose: bool = False
    bare: bool = False

    @classmethod
    def drawn(cls, seed: int, *, loose: bool, bare: bool) -> KinkedPlane:
        """Return a random one, steeper than its friction above the kink and below it."""
        generator = np.random.default_rng(seed)
        friction, upper = generator.uniform(10, 30), generator.uniform(35, 55)
        lower = generator.uniform(friction + 3, upper - 2)
        length, height, gap = generator.uniform(2, 4), generator.uniform(0.8, 1.5), generator.uniform(0, 0.5)
        sizes = {"length": length, "height": height, "gap": gap}
        return cls(friction=friction, upper=upper, lower=lower, loose=loose, bare=bare, **sizes)

    @property
    def outlines(self) -> list[np.ndarray]:
        """Outlines of the ground above and below the kink, what it rests on, and the slab."""
        above, below = (np.array([np.cos(dip), np.sin(dip)]) for dip in np.radians([self.upper, self.lower]))
        top, end, across = 6 * above, -8 * below, self.height * np.array([-above[1], above[0]])
        low, high, under = self.gap * above, (self.gap + self.length) * above, end[1] - 2
        made = [[(0, 0), (0, under), (top[0], under), top], [end, (end[0], under), (0, under), (0, 0)]]
        base = [(end[0], under - 4), (top[0], under - 4), (top[0], under), (end[0], under)]
        slab = [low, high, high + across, low + across]
        return [np.array(outline, dtype=float) for outline in (*made, *([base] if self.loose else []), slab)]

    def model(self) -> bsm.Model:
        """Return it in the plane."""
        blocks = bsm.Blocks.from_polygons(self.outlines, rock="rock")
        if self.bare:
            faces, joint = find_faces(blocks), np.full(len(blocks.nodes), -1, dtype=np.int32)
            joint[faces.edge_a] = joint[faces.edge_b] = 0
            blocks = blocks.with_edge_joints(joint, ("joint",))
        return self._model(blocks)

    def in_space(self, *, width: float = 1.0, aside: float = 0.5, direction: float = 0.0) -> bsm.Model:
        """Return it in space: the slab has a share of the ground's width, aside by a share of the rest, all turned."""
        *ground, slab = self.outlines
        solids = [prism(outline, depth=DEPTH) for outline in ground]
        corners, sides = prism(slab, depth=width * DEPTH)
        corners = corners + np.array([0, aside * (1 - width) * DEPTH, 0])
        turn = rotation(direction, 0)
        cells = bsm.Polyhedra.from_solids(turned([*solids, (corners, sides)], turn), rock="rock")
        if not self.bare:
            return self._model(cells)
        height = cells.vertices @ turn @ (-np.sin(np.radians(self.upper)), 0, np.cos(np.radians(self.upper)))
        farthest = np.maximum.reduceat(np.abs(height[cells.face_vertices]), cells.face_offsets[:-1])
        joint = np.where(farthest < 1e-9, 0, -1).astype(np.int32)  # of faces in the plane above the kink
        return self._model(replace(cells, face_joint=joint, joint_names=("joint",)))

    def _model(self, blocks: bsm.Blocks | bsm.Polyhedra) -> bsm.Model:
        default_joint = None if self.bare else "joint"
        held = [2] if self.loose else [0, 1]
        return stiff_model(blocks, friction=self.friction, held=held, default_joint=default_joint)
