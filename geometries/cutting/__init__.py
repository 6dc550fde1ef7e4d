"""From joint sets and outlines to blocks: two engines, `shapely` for very many joints and `gmsh`."""

from __future__ import annotations

from bsm_mesh.geometries.cutting.block_cut import BlockCut, JointAccount
from bsm_mesh.geometries.cutting.cut import cut_blocks

__all__ = ["BlockCut", "JointAccount", "cut_blocks"]
