"""Hydraulic apertures from the displacements of blocks: without stress, less closure, plus opening and dilation."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.flow.joint_network import JointNetwork
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_stiffness import face_stiffness
from bsm_mesh.model.joint_laws.closure import overlap_at
from bsm_mesh.model.model import Model
from bsm_mesh.movements import turned
from bsm_mesh.results.contact_shares import cover_of, shares_of_contacts
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import ContactForces


class Apertures:
    """The apertures of a model's joints as its blocks move.

    The closure of a joint is the overlap of its blocks less the closure of their rock. With the opening o of the blocks
    since the start, the effective normal stress s and the compliance c of the rock on both sides the aperture is
    ``a0 + o + c s``, at least the residual one. That holds for any normal spring, and dilation, which moves blocks
    apart, is in the opening. Where an in-situ stress was there at the start, o lacks the closure under it, which is
    taken off by `set_in_situ`.

    Parameters
    ----------
    model : Model
        The model.
    joints : JointNetwork
        Its joints.
    """

    def __init__(self, model: Model, joints: JointNetwork) -> None:
        self.model, self.joints = model, joints
        given = np.array([[joint.aperture or 0.0, joint.residual_aperture] for joint in model.joints]).reshape(-1, 2)
        self.unstressed, self.residual = given[joints.joint].T
        of_joint = np.array([joint.contact_stiffness[0] for joint in model.joints])[joints.joint]
        self.stiffness = of_joint
        self.compliance = np.maximum(1 / face_stiffness(model, joints.faces).normal - 1 / of_joint, 0.0)
        self.closed_before = np.zeros((len(joints.joint), 2))

    @property
    def given(self) -> FloatArray:
        """Apertures without normal stress at both ends of every face, (k, 2) [m]."""
        return np.repeat(self.unstressed[:, None], 2, axis=1)

    def set_in_situ(self, pressure: FloatArray) -> None:
        """Take off the closure under the effective in-situ stress at both ends of every face (k, 2) [Pa]."""
        limits = np.array([np.inf if j.max_closure is None else j.max_closure for j in self.model.joints])
        limit = limits[self.joints.joint]
        for end in (0, 1):
            closure, curved = pressure[:, end] / self.stiffness, np.isfinite(limit)
            none = np.zeros(int(curved.sum()))
            closure[curved] = overlap_at(pressure[curved, end], self.stiffness[curved], limit[curved], none)
            self.closed_before[:, end] = closure + self.compliance * pressure[:, end]

    def after(self, contacts: ContactForces, moved: FloatArray, *, in_rows: bool) -> FloatArray:
        """Return the apertures at both ends of every face, (k, 2) [m].

        Parameters
        ----------
        contacts : ContactForces
            The contacts as the blocks are.
        moved : (n, 3) float64 [m, m, rad]
            Displacement of every block since it was given.
        in_rows : bool
            Whether contacts are those of the start, two a face, and displacements small (scheme ``linear``).
        """
        faces, blocks = self.joints.faces, self.model.blocks
        a, b = blocks.owner[faces.edge_a], blocks.owner[faces.edge_b]
        along = (faces.end - faces.start) / self.joints.face_length[:, None]
        normal = turned(along, (0.0 if in_rows else moved[b, 2]) - np.pi / 2)  # outwards from b
        move = _small_displacement if in_rows else displacement_of
        opening = np.stack(
            [
                ((move(blocks, moved, a, at) - move(blocks, moved, b, at)) * normal).sum(axis=1)
                for at in (faces.start, faces.end)
            ],
            axis=1,
        )
        pressure = self.pressures(contacts, moved, in_rows=in_rows)
        aperture = self.given + opening + self.compliance[:, None] * pressure - self.closed_before
        found: FloatArray = np.maximum(aperture, self.residual[:, None])
        return np.where(self.unstressed[:, None] > 0, found, 0.0)

    def pressures(self, contacts: ContactForces, moved: FloatArray, *, in_rows: bool) -> FloatArray:
        """Return the effective normal stress at both ends of every face, (k, 2) [Pa], compression positive."""
        faces, blocks = self.joints.faces, self.model.blocks
        at = np.zeros_like(moved) if in_rows else moved
        shares = shares_of_contacts(blocks, contacts, at, in_rows=2 if in_rows else 0)
        face = cover_of(blocks, faces, contacts, shares).face
        known = np.flatnonzero(face >= 0)
        of = face[known]
        vector = (faces.end - faces.start)[of]
        t = ((shares.centre[known] - faces.start[of]) * vector).sum(axis=1) / (vector**2).sum(axis=1)
        slot = 2 * of + (t > 0.5)
        count = 2 * len(faces.edge_b)
        force = np.bincount(slot, -contacts.normal_force[known], minlength=count)
        length = np.bincount(slot, contacts.length[known], minlength=count)
        pressure: FloatArray = np.maximum(force / np.where(length > 0, length, 1.0), 0.0)
        return pressure.reshape(-1, 2)


def _small_displacement(blocks: Blocks, moved: FloatArray, block: IntArray, point: FloatArray) -> FloatArray:
    """Return the displacement of points (k, 2) of blocks (k,) that turn by small angles."""
    x, y = (point - blocks.moments.centroid[block]).T
    u, v, theta = moved[block].T
    return np.stack([u - theta * y, v + theta * x], axis=1)
