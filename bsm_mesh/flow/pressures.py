"""The pressure of flowing water on the faces: where there is any along a joint, and how much."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.flow.joint_network import JointNetwork
from bsm_mesh.flow.network import Network
from bsm_mesh.flow.steady import SteadyFlow
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_water import FaceWater

SHORTEST = 1e-12  # of an edge: a shorter part is rounding


def wet_pieces(network: Network, flow: SteadyFlow, conducts: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of every piece under pressure, (m, 2) over its length, and the pressure heads there, (m, 2) [m].

    Between two nodes under water that is all of it, and the head is linear. Where the upper node is not, water that
    trickles from it meets the water in the joint. That water reaches up to where its pressure ends: up to its level if
    nothing trickles (Wang Eq. 6.5), to the upper node if all the joint can lead does. With the height r from the lower
    node to the upper one, the pressure head p at the lower and the part w of the upper one, the wet part is
    ``p / (r - w (r - p))`` of the length.

    Parameters
    ----------
    network : Network
        Nodes and pieces.
    flow : SteadyFlow
        In it.
    conducts : (m,) bool
        Pieces that are not sealed. In a sealed one pressure runs linearly between those at its ends, as it does in the
        least permeable joint in the end.
    """
    y, pressure = network.point[:, 1], flow.pressure_head
    ends = np.stack([network.first, network.last], axis=1)
    part, heads = np.tile([0.0, 1.0], (len(ends), 1)), pressure[ends]
    for dry in (0, 1):  # the end that may be the dry one
        wet = 1 - dry
        below, above = ends[:, wet], ends[:, dry]
        rise = y[above] - y[below]
        reached = pressure[below]
        partly = (pressure[above] == 0) & (reached > 0) & (rise >= reached)
        slower = rise - np.where(conducts, flow.filled[above], 0.0) * (rise - reached)
        share = np.where(partly, reached / np.where(partly, slower, 1.0), 1.0)
        part[:, dry] = np.where(partly, np.where(dry, share, 1 - share), part[:, dry])
    return part, heads


def face_water(
    joints: JointNetwork,
    blocks: Blocks,
    there: BoolArray,
    wet: tuple[FloatArray, FloatArray],
    reservoirs: tuple[IntArray, FloatArray, FloatArray],
    unit_weight: float,
) -> FaceWater:
    """Return the pressure on both sides of the joints, and on boundaries with a level.

    Parameters
    ----------
    joints : JointNetwork
        The joints.
    blocks : Blocks
        The blocks.
    there : (m,) bool
        Pieces that are there.
    wet : ((m, 2), (m, 2)) float64
        As `wet_pieces` returns it.
    reservoirs : tuple
        Edges, parts and pressures of boundaries, as `reservoir_parts` returns them.
    unit_weight : float [N/m3]
        Of the water.
    """
    part, heads = wet
    chosen = np.flatnonzero(there & (heads > 0).any(axis=1))
    face = joints.face[chosen]
    within = joints.part[chosen]
    along = within[:, :1] + part[chosen] * np.diff(within, axis=1)
    start, vector = joints.faces.start[face], (joints.faces.end - joints.faces.start)[face]
    at = start[:, None] + along[:, :, None] * vector[:, None]
    edges, ends, pressure = [reservoirs[0]], [reservoirs[1]], [reservoirs[2]]
    for of_face, order in ((joints.faces.edge_b, [0, 1]), (joints.faces.edge_a, [1, 0])):
        edge = of_face[face]
        corner = blocks.vertices[edge]
        direction = blocks.vertices[blocks.following[edge]] - corner
        square = (direction**2).sum(axis=1)[:, None]
        ends.append((((at[:, order] - corner[:, None]) * direction[:, None]).sum(axis=2)) / square)
        pressure.append(unit_weight * heads[chosen][:, order])
        edges.append(edge)
    edge, end, of_end = np.concatenate(edges), np.concatenate(ends), np.concatenate(pressure)
    some = np.abs(np.diff(end, axis=1)[:, 0]) > SHORTEST
    return FaceWater(edge=edge[some].astype(np.int32), ends=end[some], pressure=of_end[some])
