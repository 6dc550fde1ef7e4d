"""Exceptions of geometries that cannot be built. Of `bsm_mesh` only what reads, writes and shows texts is needed."""

from __future__ import annotations

from bsm_mesh.errors import InputError


class GeometryError(InputError):
    """A geometry cannot be built."""
