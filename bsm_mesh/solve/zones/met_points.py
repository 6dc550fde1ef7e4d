"""Points where faces come upon blocks that they did not touch before: joints of the model without cohesion.

The contact search of rigid blocks finds corners and nodes near edges of other blocks. Two faces that are nearly
parallel have points at the nodes of both. Each point represents half the distance to the next node on either side, of
whichever face. So the points represent the common length once, also where nodes do not match. A corner on a face that
is not parallel has the length of such a contact of rigid blocks. Lengths that points of given joints represent are left
out.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.corner_joints import edges_of_corners
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ActiveContacts, Candidates, Slid, key_of
from bsm_mesh.model.face_stiffness import joints_of_edges
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState
from bsm_mesh.solve.zones.moving_points import SLID, Met, MovingPoints, Places
from bsm_mesh.solve.zones.placed_points import springs_of
from bsm_mesh.solve.zones.rock_faces import number_between, whole_rock
from bsm_mesh.solve.zones.zone_faces import ZoneFaces


class Meetings(NamedTuple):
    """Corners on edges of other blocks, (k,) each.

    Attributes
    ----------
    corner, edge : (k,) int
        Of `ZoneFaces`.
    offset, gap : (k,) float64 [m]
        Gap without force, and the gap.
    length : (k,) float64 [m]
        That each represents.
    known : (k,) int
        Number of the later point that continues there; -1: none.
    """

    corner: IntArray
    edge: IntArray
    offset: FloatArray
    gap: FloatArray
    length: FloatArray
    known: IntArray


def with_met(joints: MovingPoints, met: Met) -> MovingPoints:
    """Return the points of given joints with others behind them; their places are set by `MovingPoints.facing`."""
    count, faces = len(joints.own), joints.faces
    if not len(met.corner) and len(joints.length) == count:
        return joints
    more = len(met.corner)

    def joined(given: Any, new: Any) -> Any:
        return np.concatenate([given[:count], new.astype(given.dtype)])

    joint, length = joined(joints.joint, met.joint), joined(joints.length, met.length)
    block = joined(joints.block, met.block)
    springs = springs_of(faces.model, joint, length, block)
    zero = np.zeros(more)
    places = {field.name: joined(getattr(joints.places, field.name), zero) for field in fields(Places)}
    longer = replace(
        joints,
        point=joined(joints.point, joints.as_given[faces.node[met.corner]]),
        normal=joined(joints.normal, np.zeros((more, 2))),
        length=length,
        joint=joint,
        block=block,
        normal_stiffness=springs["normal_stiffness"],
        shear_stiffness=springs["shear_stiffness"],
        tension=joined(joints.tension, zero),
        residual_tension=joined(joints.residual_tension, zero),
        closure_limit=joined(joints.closure_limit, np.full(more, np.inf)),
        growing=springs["growing"],
        node=joined(joints.node, faces.node[met.corner]),
        met=met,
    )
    return longer.facing(Places(**places))


def met(
    joints: MovingPoints,
    history: JointHistory,
    u: FloatArray,
    present: BoolArray,
    state: JointState,
    band: float = 0.0,
    *,
    keeps_lengths: bool = False,
) -> tuple[MovingPoints, JointHistory, BoolArray] | None:
    """Return joints and history with the points where blocks have met at displacements u (N,); None: as they are.

    Which points are new is returned too.

    Parameters
    ----------
    joints, history : MovingPoints, JointHistory
        As they are.
    u : (N,) float64 [m]
        Displacements.
    present : (n,) bool
        Which blocks are there.
    state : JointState
        Of the points there.
    band : float [m]
        How near blocks that move count as met: their points are open at first. 0: blocks at rest, that overlap.
    keeps_lengths : bool
        Closed points keep their lengths, in time: others would add energy.
    """
    count, moves = len(joints.own), band > 0
    where, closed = joints.as_given + u[joints.nodes], (state.closed & ~joints.over)[count:]
    pressure = state.pressure[count:] * closed
    found = _meetings(joints, where, present, pressure, joints.relative(u)[0], band)
    old, again = joints.met, found.known >= 0
    same = again & (_taken(old.corner, found.known) == found.corner)
    rows = np.flatnonzero(closed & ~np.isin(np.arange(len(closed)), found.known[again]))  # hidden, and closed
    before = _taken(old.length, found.known)
    length = np.where(same & _taken(closed, found.known) & keeps_lengths, before, found.length)
    changed = ~same | (np.abs(length - before) > SLID * before)
    if not changed.any() and (not moves or len(rows) + same.sum() == len(old.corner)) and not joints.over[count:].any():
        return None
    blocks = np.stack([joints.faces.block[found.edge], joints.faces.block[found.corner]], axis=1)
    known = Met(**{name: getattr(old, name)[rows] for name in Met.__slots__})
    points = Met(
        corner=np.concatenate([known.corner, found.corner]).astype(np.int32),
        length=np.concatenate([known.length, length]),
        joint=np.concatenate([known.joint, _joint_of(joints.faces, found, where)]).astype(np.int32),
        block=np.concatenate([known.block, blocks]).astype(np.int32),
    )
    every = np.concatenate([np.arange(count), count + rows, np.where(again, count + found.known, -1)])
    stays = np.concatenate([np.ones(count + len(rows), dtype=bool), same])
    moved = with_met(joints, points).facing(_places(joints, found, every, stays, where, present, state))
    offset = np.zeros(len(every))
    offset[count + len(rows) :] = np.where(moves, np.minimum(found.gap, found.offset), found.offset)
    return moved, _history(history, every, offset), every < 0


def begun_between(
    joints: MovingPoints, history: JointHistory, fresh: BoolArray, start: FloatArray, u: FloatArray
) -> JointHistory:
    """Return the history whose new points (q,) slide from where blocks met between displacements (N,) on.

    Blocks that overlapped at the first of these displacements, without a point, have no force there.
    """
    (before, at), (after, there) = joints.relative(start), joints.relative(u)
    part = np.clip(before / np.maximum(before - after, np.finfo(float).tiny), 0.0, 1.0)
    slip = np.where(fresh, at + part * (there - at), history.slip)
    return replace(history, slip=slip, offset=np.where(fresh, np.minimum(history.offset, before), history.offset))


def _joint_of(faces: ZoneFaces, found: Meetings, where: FloatArray) -> IntArray:
    """Return the joints of meetings at places of nodes (n, 2): as contacts of rigid blocks have them."""
    model, e, v = faces.model, found.edge, found.corner
    names, jointed = [joint.name for joint in model.joints], model.blocks.edge_joint[faces.edge] >= 0
    own = edges_of_corners(_directions(faces, where)[0], jointed, faces.preceding, v, e)
    joint = joints_of_edges(model.blocks, names, model.default_joint, faces.edge[own], faces.edge[e])
    rock = number_between(model, faces.block[e], faces.block[v])
    return np.where(joint >= 0, joint, np.where(rock >= 0, rock, whole_rock(model)))


def _places(
    joints: MovingPoints,
    found: Meetings,
    source: IntArray,
    stays: BoolArray,
    where: FloatArray,
    present: BoolArray,
    state: JointState,
) -> Places:
    """Return the places of points by their rows before (q,), -1: new; points of `stays` (q,) keep their place."""
    faces, new = joints.faces, np.flatnonzero(~stays)
    row = new - (len(source) - len(found.corner))
    edge, corner = found.edge[row], found.corner[row]
    at, own, both = where[faces.node[corner]], faces.block[corner], np.zeros(len(edge), dtype=int)
    start, no_lip = edge // faces.halves, lambda on, _: np.zeros(len(on))
    piece, share = faces.chains.facing(at, own, start, where, present, both, no_lip)
    columns = {field.name: _taken(getattr(joints.places, field.name), source) for field in fields(Places)}
    columns["piece"][new], columns["share"][new], columns["over"][new] = piece, share, False
    columns["slid"][new] = _taken(state.slip, source[new])
    return Places(**columns)


def _history(history: JointHistory, source: IntArray, offset: FloatArray) -> JointHistory:
    """Return the history of points by their rows before (q,), and of new ones (-1), which have no cohesion."""
    columns = {field.name: _taken(getattr(history, field.name), source) for field in fields(JointHistory)}
    for name, values in columns.items():
        values[source < 0] = name in {"failed", "parted", "present"}
    columns["offset"] = np.where(source < 0, offset, columns["offset"])
    return JointHistory(**columns)


def _meetings(
    joints: MovingPoints, where: FloatArray, present: BoolArray, pressure: FloatArray, gap: FloatArray, band: float
) -> Meetings:
    """Return the corners that lie on edges of other blocks, or within a band [m], and no given point represents.

    `pressure` (k,) [N/m]: of the later points so far; closed ones take precedence. `gap` (q,) [m]: of all points.
    """
    faces = joints.faces
    reach = max(band, RULES.new_penetration * faces.size)
    active, order = _active(joints, where, pressure)
    has, represented = _represented(joints, where, gap, reach)
    on_block = np.stack(represented, axis=1).astype(np.int32)
    near = faces.near(where, reach, active, Slid(joints.as_given[faces.node], on_block))
    a, b, v, e = near.block_a, near.block_b, near.corner, near.edge
    size = np.minimum(np.sqrt(faces.model.blocks.moments.area), faces.size)
    h = np.minimum(size[a], size[b])
    deep = near.gap < -RULES.new_penetration * h
    lengths, covered = _lengths(faces, near, where, RULES.dual_distance * reach, represented, deep)
    covered |= (has[0][v] == b) | (has[1][faces.preceding[v]] == b)
    lengths[lengths < RULES.min_overlap * h / 2] = 0.0
    meets_corner = near.corner_gap > 0
    diagonal = near.corner_gap > RULES.min_overlap * h * (1 + RULES.rounding)
    offset = -np.where(diagonal, RULES.new_penetration * h, near.corner_gap)
    lone = (near.parallel_edge < 0) | meets_corner
    length = np.where(lone, np.where(covered, 0.0, RULES.corner_share * h), lengths)
    slack = np.where(near.history >= 0, RULES.detach_tol, RULES.rounding) * h
    on = (near.tangential >= -slack) & (near.tangential <= near.edge_length + slack) & present[a] & present[b]
    face = faces.chains.plane
    on &= ~(meets_corner & _leaves_over_another(near, on, face[e // faces.halves]))
    on &= ~faces.inner[e] & ~faces.share_nodes(v, b) & (length > 0) & (near.entering_edge < 0)
    touches = on & (near.gap <= np.where(meets_corner, offset, band))
    rows = np.flatnonzero(touches & ~_opposed(near, on))
    place = np.stack([v, face[e // faces.halves]])[:, rows]
    once = np.unique(place, axis=1, return_index=True)[1]  # a node at a node of the other face is on two edges
    rows, place = rows[once], place[:, once]
    known = _known(joints, near, rows, place, order)
    known[_again(known)] = -1
    return Meetings(v[rows], e[rows], offset[rows], near.gap[rows], length[rows], known)


def _known(joints: MovingPoints, near: Candidates, rows: IntArray, place: IntArray, order: IntArray) -> IntArray:
    """Return the later points that continue as candidates `rows` (k,), (k,); -1: none.

    `place` (2, k): corner and face of each; `order`: rows of the later points by their number in the search.
    """
    known = np.where(near.history >= 0, near.history, near.predecessor)[rows]
    known = np.where(known >= 0, _taken(order, known), -1)
    old = np.stack([joints.met.corner, joints.faces.chains.plane[joints.places.piece[len(joints.own) :]]])
    found: IntArray = np.where(known >= 0, known, _rows_of(old, place))
    return found


def _again(rows: IntArray) -> BoolArray:
    """Return which rows (k,) are there before."""
    found = np.ones(len(rows), dtype=bool)
    found[np.unique(rows, return_index=True)[1]] = False
    return found


def _active(joints: MovingPoints, where: FloatArray, pressure: FloatArray) -> tuple[ActiveContacts, IntArray]:
    """Return the points that came later as contacts of the search takes them, and their rows in its order, (k,)."""
    faces, count = joints.faces, len(joints.own)
    piece, share = joints.places.piece[count:], joints.places.share[count:]
    edge = faces.halves * piece + (faces.halves * share >= 1) * (faces.halves - 1)
    own = joints.met.block[:, 1]
    ends = where[faces.chains.node[piece, :2]]
    along = ends[:, 1] - ends[:, 0]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    pair = key_of(np.minimum(own, faces.block[edge]), np.maximum(own, faces.block[edge]))
    order = np.argsort(pair, kind="stable")
    active = ActiveContacts(
        pair=pair[order],
        key=key_of(joints.met.corner, edge)[order],
        pressure=pressure[order],
        point=where[faces.node[joints.met.corner]][order],
        normal=normal[order],
    )
    return active, order


def _opposed(near: Candidates, on: BoolArray) -> BoolArray:
    """Return which of two opposing candidates `on` (m,) is deeper: the corner leaves over the other's edge.

    Both would wedge the corner between them.
    """
    other = near.opposing_candidate
    both = (other >= 0) & on & on[other]
    less = (near.gap < near.gap[other]) | ((near.gap == near.gap[other]) & (other < np.arange(len(other))))
    found: BoolArray = both & less
    return found


def _leaves_over_another(near: Candidates, on: BoolArray, face: IntArray) -> BoolArray:
    """Return which corners lie less deep behind another face (m,) of the same block, or before it: they leave there.

    `on` (m,): corners that are within the ends of the edge; points of given joints may represent that other face.
    """
    rows = np.flatnonzero(on)
    _, pair = np.unique(np.stack([near.corner, near.block_b]), axis=1, return_inverse=True)
    rows, pair = rows[np.argsort(near.gap[rows], kind="stable")], pair.reshape(-1)
    least = np.full(pair.max(initial=-1) + 1, -1)
    least[pair[rows]] = rows  # the last one is written last
    other = least[pair]
    found: BoolArray = (other >= 0) & (near.gap < near.gap[other]) & (face != face[other])
    return found


def _lengths(
    faces: ZoneFaces,
    near: Candidates,
    where: FloatArray,
    tolerance: float,
    represented: tuple[IntArray, IntArray],
    deep: BoolArray,
) -> tuple[FloatArray, BoolArray]:
    """Return the lengths of corners on faces along their own, (m,) [m], and which have a point, (m,).

    Given points at both ends of an edge represent all of it, also where they lie on two blocks. A corner between these
    that is `deep` (m,) has its own point, or the edge would turn into it.
    """
    following, preceding = faces.following, faces.preceding
    corner, (along, span) = where[faces.node], _directions(faces, where)
    v, e, t = near.corner, near.edge, along[near.edge]
    turn = _sine(along[preceding[v]], along[v])
    flat = np.abs(turn) <= RULES.parallel
    starts, ends = represented
    total, covered = np.zeros(len(v)), np.zeros(len(v), dtype=bool)
    for own, far, way, edge in (
        (v, following[v], -1.0, preceding),
        (preceding[v], preceding[v], 1.0, following),
    ):
        lies = ((along[own] * t).sum(axis=1) < 0) & (np.abs(_sine(along[own], t)) <= RULES.parallel)
        room = near.tangential if way < 0 else near.edge_length - near.tangential
        beyond = edge[e]
        goes_on = (room <= tolerance) & (np.abs(_sine(along[beyond], t)) <= RULES.parallel)
        goes_on &= (along[beyond] * t).sum(axis=1) > 0
        room = np.maximum(room, 0.0) + goes_on * span[beyond]
        on = np.where(goes_on, beyond, e)
        reach = ((corner[far] - corner[v]) * t).sum(axis=1) * way
        known = (starts if way < 0 else ends)[own] == near.block_b
        begun, ended = (of[on] >= 0 for of in (starts, ends))
        whole = begun & ended & ((starts[on] == ends[on]) | ~deep)
        known |= whole | (flat & (begun | ended))
        covered |= whole
        total += np.where(lies & ~known, np.minimum(room, np.maximum(reach, 0.0)), 0.0) / 2
    begun, ended = (of[e] >= 0 for of in (starts, ends))
    return total, covered | (flat & (begun | ended)) | flat


def _directions(faces: ZoneFaces, where: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit directions (v, 2) and lengths (v,) [m] of the edges that start at corners, at places of nodes."""
    corner = where[faces.node]
    along = corner[faces.following] - corner
    span: FloatArray = np.hypot(*along.T)
    return along / span[:, None], span


def _represented(
    joints: MovingPoints, where: FloatArray, gap: FloatArray, reach: float
) -> tuple[tuple[IntArray, IntArray], tuple[IntArray, IntArray]]:
    """Return the blocks that points of given joints face at starts and ends of edges, (v,) each; -1: no point.

    The second pair has the blocks on which the edges lie there. A point that left a face over its end faces another
    one. The edge does not lie on that face. A point out of reach [m] faces nothing.
    """
    faces, count = joints.faces, len(joints.own)
    facing = np.where((joints.over | (gap > reach))[:count], -1, joints.block[:count, 0])
    ends = where[faces.chains.node[joints.places.piece[:count], :2]]
    side = ends[:, 1] - ends[:, 0]
    side, along = side / np.hypot(*side.T)[:, None], _directions(faces, where)[0]
    has, lies = np.full((2, 2, len(faces.node)), -1)
    for k, edge in enumerate(joints.own.T):
        on = np.flatnonzero(edge >= 0)
        has[k, edge[on]] = facing[on]
        flat = np.abs(_sine(along[edge[on]], side[on])) <= RULES.parallel
        lies[k, edge[on]] = np.where(flat, facing[on], -1)
    return (has[0], has[1]), (lies[0], lies[1])


def _taken(values: Any, rows: IntArray) -> Any:
    """Return rows of values, and 0 for rows of -1."""
    return np.append(values, np.zeros(1, values.dtype))[rows]


def _sine(one: FloatArray, other: FloatArray) -> FloatArray:
    found: FloatArray = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return found


def _rows_of(old: IntArray, new: IntArray) -> IntArray:
    """Return for every column of `new` (2, k) its number in `old` (2, l); -1: none."""
    known = {(int(a), int(b)): k for k, (a, b) in enumerate(old.T)}
    return np.array([known.get((int(a), int(b)), -1) for a, b in new.T], dtype=np.int64)
