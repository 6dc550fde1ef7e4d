"""The faces between blocks with what acts and moves on them: contacts that belong to one face put together."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_stiffness import joints_of_faces
from bsm_mesh.model.faces import Faces, find_faces
from bsm_mesh.movements import turned
from bsm_mesh.results.contact_shares import Cover, Shares, cover_of, joined_shares, shares_of_contacts
from bsm_mesh.results.movement import as_given, displacement_of
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult
from bsm_mesh.results.water_faces import wet_parts

if TYPE_CHECKING:
    from bsm_mesh.results.results import Results

SHORTEST = 0.01  # of a given face: a shorter part that no contact represents, or that has another state, is rounding
HELD = 1e-9  # of the face: blocks that move less against each other are both held, and have no contacts

AT_STRENGTH = 0.99  # utilisation: what reached rest after it slid stops just below its strength


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointFaces:
    """Faces between blocks at the end of a stage, one row a face: two contacts, the share of one, or a part apart.

    Attributes
    ----------
    start, end : (k, 2) float64 [m]
        Where they are in the given geometry.
    start_displacement, end_displacement : (k, 2) float64 [m]
        Of the ends, counted as ``StageResult.displacement`` counts.
    block_a, block_b : (k,) int32
        The two blocks.
    joint : (k,) int32
        Number of the joint in ``Results.joint_names``; -1 for unjointed rock.
    length : (k,) float64 [m]
        Length that the contacts represent; of a part that is apart its own.
    slip, opening : (k,) float64 [m]
        Displacement of a relative to b along the face (t) and away from it (n) since the start, mean over the length.
    pressure, shear_traction : (k,) float64 [Pa]
        Normal force over length, compression positive; shear force over length.
    utilisation : (k,) float64
        Shear force over shear strength, the greater one of the contacts.
    slipping, open : (k,) float64
        Share of the length that slips, or is at `AT_STRENGTH`, and that is open.
    water_pressure : (k,) float64 [Pa]
        Of the water in the joint, mean over the face where it is.
    """

    start: FloatArray
    end: FloatArray
    start_displacement: FloatArray
    end_displacement: FloatArray
    block_a: IntArray
    block_b: IntArray
    joint: IntArray
    length: FloatArray
    slip: FloatArray
    opening: FloatArray
    pressure: FloatArray
    shear_traction: FloatArray
    utilisation: FloatArray
    slipping: FloatArray
    open: FloatArray
    water_pressure: FloatArray

    @property
    def status(self) -> IntArray:
        """`ContactStatus` of every face, (k,) int8: open as a whole, slipping wherever it is closed, or sticking."""
        return status_of_shares(self.slipping, self.open)


def status_of_shares(slipping: FloatArray, is_open: FloatArray) -> IntArray:
    """Return `ContactStatus` of faces, (k,) int8, by the shares of them that slip and that are open."""
    whole = 1 - SHORTEST
    slips = (slipping > 0) & (slipping + is_open >= whole)
    status = np.where(slips, ContactStatus.SLIPPING, ContactStatus.STICKING)
    return np.where(is_open >= whole, ContactStatus.OPEN, status).astype(np.int8)


def slips_or_will(contacts: ContactForces) -> BoolArray:
    """Return which closed contacts (m,) slip or are at their strength."""
    status = contacts.status
    at_strength = (status != ContactStatus.OPEN) & (contacts.utilisation >= AT_STRENGTH)
    slips: BoolArray = at_strength | (status == ContactStatus.SLIPPING)
    return slips


def joint_faces(results: Results, stage: StageResult) -> JointFaces:
    """Return the faces of a stage: those with contacts, then the parts of given faces that have none left.

    A corner that is near an edge, open and alone, is none. A face that slides loses length, one that rocks a half: that
    part counts as open, and so does a whole face whose blocks parted.
    """
    blocks, contacts = results.blocks, stage.contacts
    moved = np.zeros_like(stage.origin) if results.has_small_displacements else stage.displacement + stage.origin
    given = find_faces(blocks)
    shares = shares_of_contacts(blocks, contacts, moved, in_rows=_contacts_in_a_row(results, stage))
    cover = cover_of(blocks, given, contacts, shares)
    one, other = joined_shares(contacts, shares, cover.face)
    is_face = (cover.face[one] >= 0) | (contacts.status[one] != ContactStatus.OPEN) | (other >= 0)
    touching = _touching(blocks, stage, moved, shares, (one[is_face], other[is_face]))
    apart = _apart(results, stage, moved, given, cover)
    names = [field.name for field in fields(JointFaces)]
    return JointFaces(**{name: np.concatenate([getattr(part, name) for part in (touching, apart)]) for name in names})


def _contacts_in_a_row(results: Results, stage: StageResult) -> int:
    """Return how many contacts that follow each other belong to one face; 0: any."""
    if stage.zones is not None:
        return 3 if stage.zones.cells.shape[1] == 6 else 2  # elements of order 2 and 1
    return 2 if results.scheme == "linear" else 0


def _touching(
    blocks: Blocks, stage: StageResult, moved: FloatArray, shares: Shares, joined: tuple[IntArray, IntArray]
) -> JointFaces:
    """Return the faces of contacts, each alone or with another one (-1: alone)."""
    one, other = joined
    c, pair = stage.contacts, other >= 0
    second = np.where(pair, other, one)
    rows, weight = np.stack([one, second]), np.stack([c.length[one], np.where(pair, c.length[second], 0.0)])
    length = weight.sum(axis=0)

    def mean(values: FloatArray) -> FloatArray:
        total: FloatArray = (weight * values[rows]).sum(axis=0) / length
        return total

    start, end, block = shares.first[one], shares.last[second], c.block_a[one]
    at = end + displacement_of(blocks, moved, c.block_a[second], end)  # the other corner may be of the other block
    end = as_given(blocks, moved, block, at)
    here = start + displacement_of(blocks, moved, block, start)
    is_open = c.status == ContactStatus.OPEN
    return JointFaces(
        start=start,
        end=end,
        start_displacement=displacement_of(blocks, stage.displacement, block, start),
        end_displacement=displacement_of(blocks, stage.displacement, block, end),
        block_a=block,
        block_b=c.block_b[one],
        joint=c.joint[one],
        length=length,
        slip=mean(c.slip),
        opening=mean(c.opening),
        pressure=mean(-c.normal_force / c.length) + 0.0,  # no negative zeros
        shear_traction=mean(c.shear_force / c.length),
        utilisation=c.utilisation[rows].max(axis=0),
        slipping=mean(slips_or_will(c).astype(float)),
        open=mean(is_open.astype(float)),
        water_pressure=wet_parts(stage, here, at, c.joint[one], np.stack([start, end], axis=1)).mean(len(one)),
    )


def _apart(results: Results, stage: StageResult, at: FloatArray, given: Faces, cover: Cover) -> JointFaces:
    """Return the parts of the given faces between blocks that are there which no contact represents.

    `at` (n, 3) is where the water meets the blocks: moved, but in the linear scheme.
    """
    blocks = results.blocks
    a, b = blocks.owner[given.edge_a], blocks.owner[given.edge_b]
    missing = np.hypot(*(given.end - given.start).T) - cover.length
    there = stage.present[a] & stage.present[b]
    chosen = np.flatnonzero(there & (missing > SHORTEST * (missing + cover.length)))
    a, b, missing, middle = a[chosen], b[chosen], missing[chosen], cover.middle[chosen]
    start, end = given.start[chosen], given.end[chosen]
    along = (end - start) / np.hypot(*(end - start).T)[:, None]
    at_end = np.hypot(*(end - middle).T) > np.hypot(*(start - middle).T)
    part = (cover.length[chosen] > 0)[:, None]
    whole_start, whole_end = start, end
    start = np.where(part & at_end[:, None], whole_end - missing[:, None] * along, whole_start)
    end = np.where(part & ~at_end[:, None], whole_start + missing[:, None] * along, whole_end)
    moved, centre = stage.displacement + stage.origin, (start + end) / 2
    of_a, of_b = (displacement_of(blocks, moved, block, centre) for block in (a, b))
    normal = turned(along, moved[b, 2] - np.pi / 2)
    stays = np.where(np.hypot(*of_a.T) < np.hypot(*of_b.T), a, b)  # an open joint is drawn with what moved less
    joint = joints_of_faces(blocks, results.joint_names, results.default_joint, given)[chosen]
    none = np.zeros(len(chosen))
    first, last = (point + displacement_of(blocks, at, stays, point) for point in (start, end))
    moved_apart = np.hypot(*(of_a - of_b).T) > HELD * missing
    return JointFaces(
        start=start,
        end=end,
        start_displacement=displacement_of(blocks, stage.displacement, stays, start),
        end_displacement=displacement_of(blocks, stage.displacement, stays, end),
        block_a=a,
        block_b=b,
        joint=joint,
        length=missing,
        slip=((of_a - of_b) * turned(normal, np.pi / 2)).sum(axis=1),
        opening=((of_a - of_b) * normal).sum(axis=1),
        pressure=none,
        shear_traction=none,
        utilisation=none,
        slipping=none,
        open=moved_apart.astype(float),
        water_pressure=wet_parts(stage, first, last, joint, np.stack([start, end], axis=1)).mean(len(chosen)),
    )
