"""The input at the nodes of a model's joints in a stage: levels, surfaces open to the air, drains, wells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.flow.joint_network import JointNetwork
from bsm_mesh.flow.steady import Conditions
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.flow import Flow
from bsm_mesh.results.flow import BARED


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Boundaries:
    """Conditions at the nodes in a stage, and where they are.

    Attributes
    ----------
    conditions : Conditions
        At the nodes.
    there : (m,) bool
        Pieces between two blocks that are there.
    place : (n,) int32
        Where water may enter or leave: number in `names`; -1: nowhere.
    names : tuple of str
        The places.
    """

    conditions: Conditions
    there: BoolArray
    place: IntArray
    names: tuple[str, ...]


def boundaries_of(joints: JointNetwork, blocks: Blocks, flow: Flow, present: BoolArray) -> Boundaries:
    """Return the input at the nodes where some blocks (n,) are there.

    Where places meet, a level counts more than a drain, that more than a surface open to the air; of levels the higher.
    """
    y = joints.network.point[:, 1]
    head, spill, pumped = np.full(len(y), np.nan), np.full(len(y), np.inf), np.zeros(len(y))
    names = (*flow.head, *_numbered("drain", len(flow.drains)), *flow.seepage, *_numbered("well", len(flow.wells)))
    place = np.full(len(y), -1, dtype=np.int32)
    there, bared = _there(joints, blocks, present)

    def opens(nodes: IntArray, number: int, level: float = -np.inf) -> None:
        spill[nodes] = np.minimum(spill[nodes], np.maximum(level, y[nodes]))
        place[nodes] = number

    if len(bared):
        names = (*names, BARED)
        opens(bared, len(names) - 1)
    for k, (node, well) in enumerate(zip(joints.at_well, flow.wells, strict=False)):
        pumped[node] += well.discharge
        place[node] = len(flow.head) + len(flow.drains) + len(flow.seepage) + k
    for k, name in enumerate(flow.seepage):
        opens(_on_boundary(joints, blocks, present, name), len(flow.head) + len(flow.drains) + k)
    for k, (nodes, drain) in enumerate(zip(joints.on_drain, flow.drains, strict=False)):
        opens(nodes, len(flow.head) + k, -np.inf if drain.level is None else drain.level)
    for k, (name, level) in sorted(enumerate(flow.head.items()), key=lambda entry: entry[1][1]):
        nodes = _on_boundary(joints, blocks, present, name)
        under = y[nodes] <= level
        opens(nodes[~under], k)
        head[nodes[under]] = level
        place[nodes] = k
    spill[~np.isnan(head)] = np.inf
    return Boundaries(
        conditions=Conditions(head=head, spill=spill, pumped=pumped), there=there, place=place, names=names
    )


def _numbered(what: str, count: int) -> tuple[str, ...]:
    return tuple(f"{what} {k + 1}" for k in range(count))


def _there(joints: JointNetwork, blocks: Blocks, present: BoolArray) -> tuple[BoolArray, IntArray]:
    """Return the pieces between two blocks that are there, (m,), and the nodes on faces where one is gone."""
    faces, network = joints.faces, joints.network
    of_a, of_b = present[blocks.owner[faces.edge_a]], present[blocks.owner[faces.edge_b]]
    bare = (of_a != of_b)[joints.face]
    of_rock = joints.at_unjointed[present[joints.unjointed].sum(axis=1) == 1]
    bared = np.unique(np.concatenate([network.first[bare], network.last[bare], of_rock[of_rock >= 0]]))
    return (of_a & of_b)[joints.face], bared


def _on_boundary(joints: JointNetwork, blocks: Blocks, present: BoolArray, name: str) -> IntArray:
    """Return the nodes at both ends of the edges of a boundary whose blocks are there."""
    edges = boundary_edges(blocks, present, name)
    points = np.concatenate([blocks.nodes[edges], blocks.nodes[blocks.following[edges]]])
    nodes = np.unique(joints.of_point[points])
    return nodes[nodes >= 0]


def boundary_edges(blocks: Blocks, present: BoolArray, name: str) -> IntArray:
    """Return the edges of a boundary whose blocks are there."""
    edges = blocks.boundaries[name]
    return edges[present[blocks.owner[edges]]]


def reservoir_parts(blocks: Blocks, flow: Flow, present: BoolArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return edge, ends of its part under water (k, 2) and pressure there (k, 2) [Pa], at boundaries with a level."""
    level = np.full(len(blocks.vertices), -np.inf)  # of every edge: the higher where boundaries share one
    for name, at in flow.head.items():
        edges = boundary_edges(blocks, present, name)
        level[edges] = np.maximum(level[edges], at)
    edge = np.flatnonzero(np.isfinite(level)).astype(np.int32)
    depth = np.stack([level[edge] - blocks.vertices[corner, 1] for corner in (edge, blocks.following[edge])], axis=1)
    ends, pressure = under_water(depth)
    wet = (depth > 0).any(axis=1)
    return edge[wet], ends[wet], flow.unit_weight * pressure[wet]


def under_water(depth: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of lines under a level surface, (k, 2) over their length, and the depth at its ends, (k, 2).

    `depth` (k, 2) is that of both ends of the lines, negative above.
    """
    first, last = depth.T
    drop = np.where(first == last, 1.0, first - last)
    crossing = np.clip(first / drop, 0.0, 1.0)
    ends = np.stack([np.where(first < 0, crossing, 0.0), np.where(last < 0, crossing, 1.0)], axis=1)
    return ends, np.maximum(depth, 0.0)
