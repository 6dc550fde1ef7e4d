"""A specimen: a block on a wider one, with a joint between them, moved by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.contact_set import gather_contacts
from bsm_mesh.contact.forces import ContactSet, Evaluation
from bsm_mesh.contact.history import History, commit
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Fixed
from bsm_mesh.solve.step.block_system import BlockSystem

WIDER = 1.0  # of the upper block's length: by how much the lower one stands out at either side
BAND = 0.6  # of the specimen's length: movement in a step that the contact search reaches


class Specimen:
    """Two rigid blocks without weight, the upper one on the joint, the lower one wider and fixed.

    Parameters
    ----------
    joint : Joint
        The joint.
    length : float [m]
        Of the joint.
    height : float [m]
        Of either block.
    bolts : tuple of Bolt
        Bolts across the joint.

    Attributes
    ----------
    system : BlockSystem
        Its block system: block 0 is the lower one.
    history : History
        Of its contacts, after the movements so far.
    """

    def __init__(self, joint: Joint, length: float = 1.0, height: float = 1.0, bolts: tuple[Bolt, ...] = ()) -> None:
        beyond = WIDER * length
        polygons = [
            np.array([(-beyond, -height), (length + beyond, -height), (length + beyond, 0.0), (-beyond, 0.0)]),
            np.array([(0.0, 0.0), (length, 0.0), (length, height), (0.0, height)]),
        ]
        model = Model(
            blocks=Blocks.from_polygons(polygons, rock="rigid"),
            rocks=(Rock("rigid", unit_weight=0.0),),
            joints=(joint,),
            default_joint=joint.name,
            supports=(Fixed(blocks=(0,)),),
            bolts=tuple(replace(bolt, stage=None) for bolt in bolts),
        )
        self.length, self.system = length, BlockSystem(model)
        self.history: History = History.none()
        self._first = True

    def contacts(self, at: FloatArray) -> ContactSet:
        """Return the contacts for a step from a position (2, 3)."""
        system = self.system
        return gather_contacts(
            system.model,
            system.outlines,
            system.catalogue,
            self.history,
            at,
            BAND * self.length,
            first=self._first,
        )

    def keep(self, contacts: ContactSet, at: Evaluation) -> None:
        """Accept a step."""
        self.history, _ = commit(contacts, at, at.position, self.system.outlines.size)
        self._first = False


def position_of(shear: float, opening: float) -> FloatArray:
    """Return the positions (2, 3) at which the upper block is moved along the joint and off it [m]."""
    return np.array([(0.0, 0.0, 0.0), (shear, opening, 0.0)])
