"""Kinds of blocks: polygons in the plane, and polyhedra in space with rooms of their own (`bsm_mesh.three_d`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

from bsm_mesh.errors import ModelError
from bsm_mesh.movements import PLANE

if TYPE_CHECKING:
    from bsm_mesh.model.blocks import Blocks
    from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

AnyBlocks: TypeAlias = "Blocks | Polyhedra"


def in_space(blocks: Any) -> TypeGuard[Polyhedra]:
    """Return whether blocks are polyhedra."""
    return bool(getattr(blocks, "axes", PLANE) != PLANE)


def refuse_space(blocks: Any, thing: str) -> None:
    """Raise a `ModelError` for polyhedra where a thing knows polygons alone."""
    if in_space(blocks):
        raise ModelError(f"{thing}: not available in three dimensions (these blocks are polyhedra)")
