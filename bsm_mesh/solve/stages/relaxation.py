"""Relaxation: forces of excavated blocks on those that stay, released in parts (Wang 4.5.2)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.model.loads import PointForces
from bsm_mesh.results.records import ContactForces
from bsm_mesh.solve.stages.scheme import Scheme


class Relaxation:
    """The excavation forces that still act on new faces.

    Parameters
    ----------
    held : iterable of (PointForces, float)
        Forces of every excavation so far, and the part of them that is released.
    """

    def __init__(self, held: Iterable[tuple[PointForces, float]] = ()) -> None:
        self.held = tuple(held)

    def add(self, forces: PointForces) -> None:
        """Add the forces of an excavation, none of them released."""
        self.held = (*self.held, (forces, 0.0))

    def release(self, part: float) -> None:
        """Release all forces up to a part of them."""
        self.held = tuple((forces, max(released, part)) for forces, released in self.held)

    def forget_released(self) -> None:
        """Forget the forces that are released as a whole."""
        self.held = tuple((forces, released) for forces, released in self.held if released < 1)

    @property
    def acting(self) -> list[PointForces]:
        """The part of the forces of every excavation that is not released."""
        left = [(forces, 1 - released) for forces, released in self.held if released < 1]
        return [replace(forces, force=part * forces.force) for forces, part in left]


def forces_on_new_faces(scheme: Scheme, contacts: ContactForces, stays: BoolArray, leaves: BoolArray) -> PointForces:
    """Return the excavation forces: those of the removed blocks on the others."""
    on_b, on_a = (
        np.flatnonzero(stays[one] & leaves[other])
        for one, other in ((contacts.block_b, contacts.block_a), (contacts.block_a, contacts.block_b))
    )
    block = np.concatenate([contacts.block_b[on_b], contacts.block_a[on_a]])
    point = np.concatenate([contacts.point[on_b], contacts.point[on_a]])
    force = np.concatenate([contacts.force[on_b], -contacts.force[on_a]])
    return PointForces(block=block, point=scheme.as_given(block, point), force=force)
