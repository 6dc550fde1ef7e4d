"""Where small displacements do not hold: blocks that move far, and blocks that touch others with corners alone."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.contact.corners_on_edges import corners_on_edges
from bsm_mesh.contact.outlines import Outlines
from bsm_mesh.contact.search import key_of
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.model import Model
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.solve.zones.rock_faces import rocks_of

MOVED = 0.01  # of a block's size, or a radian: beyond it rotations and new contacts matter


def on_a_corner(model: Model, chosen: BoolArray, present: BoolArray) -> str:
    """Return which block touches which other one with a corner alone, as given, one of them of some (n,).

    The text is empty where none does. Small displacements have contacts on faces. Corners at a node have other blocks
    between, and do not count.
    """
    blocks, faces = model.blocks, find_faces(model.blocks)
    both = blocks.owner[np.stack(corners_on_edges(blocks, Outlines.of(blocks, ~chosen)), axis=1)]
    faced = blocks.owner[np.stack([faces.edge_a, faces.edge_b], axis=1)]
    alone = ~np.isin(key_of(*np.sort(both, axis=1).T), key_of(*np.sort(faced, axis=1).T))
    rows = np.flatnonzero(alone & present[both].all(axis=1) & chosen[both].any(axis=1))
    if not len(rows):
        return ""
    one, other = both[rows[0]]
    return f"{one} touches block {other} with a corner alone, where zones in small displacement have no contact"


def moved_far(model: Model, position: FloatArray, present: BoolArray, most: float = MOVED) -> str:
    """Return which block moved how far where small displacements do not hold; empty where they do.

    Movements common to all blocks do not count, and neither do strains of one piece of rock that yields. A block moves
    far that turns by more than `most`, or whose faces move against those of a neighbour by more than that part of its
    size.

    Parameters
    ----------
    model : Model
        Its blocks, as given.
    position : (n, 3) float64 [m, m, rad]
        Their movement.
    present : (n,) bool
        Which of them are there, and large enough to count for a verdict.
    most : float [-; rad]
        How far they may move.
    """
    blocks = model.blocks
    size, faces = np.sqrt(blocks.moments.area), find_faces(blocks)
    a, b = blocks.owner[faces.edge_a], blocks.owner[faces.edge_b]
    apart = np.zeros(len(a))
    for end in (faces.start, faces.end):
        relative = displacement_of(blocks, position, a, end) - displacement_of(blocks, position, b, end)
        apart = np.maximum(apart, np.hypot(*relative.T))
    yields = np.array([rock.yields for rock in rocks_of(model)], dtype=bool)[blocks.rock]
    whole = yields[a] & yields[b] & (face_joints(model, faces) < 0)
    share = apart / np.minimum(size[a], size[b]) * (present[a] & present[b] & ~whole)
    turned = np.abs(position[:, 2]) * present
    limit = f"and small displacements hold up to {100 * MOVED:g} %"
    if share.max(initial=0.0) > max(most, turned.max()):
        worst = int(share.argmax())
        one, other = (a[worst], b[worst]) if size[a[worst]] <= size[b[worst]] else (b[worst], a[worst])
        return f"{one} moved {100 * share[worst]:.3g} % of its size against block {other}, {limit}"
    if turned.max() > most:
        return f"{int(turned.argmax())} turned by {turned.max():.3g} rad, {limit}"
    return ""
