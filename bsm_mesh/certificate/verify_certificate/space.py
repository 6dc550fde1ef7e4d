"""The check of a stage of polyhedra: geometry, weights, balance, places and strength of the contact points."""

from __future__ import annotations

from typing import Any

import numpy as np

from .balance import residuals
from .geometry import AGREES, ROUNDING, Arrays, add_forces, scaled
from .given import GIVEN
from .space_water import water_faults
from .strength import own_laws, strength_faults

SIDES = ((0, 1.0), (1, -1.0))  # of a face, and whether its corners run counter-clockwise seen from outside
PARALLEL = 0.05  # sine: faces nearer to parallel touch flat, and have one normal
FACING = np.cos(np.radians(45) + 0.1)  # of faces that tilt: a normal of theirs with their mean, since they were found
CORNER = 0.05  # of the smaller block's size squared: area of a corner or an edge of faces that tilt
MORE = 1e-6  # by how much the points of a face may represent more than its area


def is_in_space(arrays: Arrays) -> bool:
    """Return whether the arrays are of polyhedra."""
    return "face_vertices" in arrays


def with_moments(arrays: Arrays) -> Arrays:
    """Return the arrays with volume, centroid and gyration of every block, where it is, and what faces are."""
    a = dict(arrays)
    sizes = np.diff(a["face_offsets"])
    first = np.repeat(a["face_offsets"][:-1], sizes - 2)
    face = np.repeat(np.arange(len(sizes)), sizes - 2)
    step = np.arange(len(face)) - np.repeat(np.cumsum(sizes - 2) - (sizes - 2), sizes - 2)
    corner = a["vertices"][a["face_vertices"]]
    p, q, r = corner[first], corner[first + step + 1], corner[first + step + 2]
    twice = np.cross(q - p, r - p)
    normal = summed(face, twice, len(sizes))
    area = np.linalg.norm(normal, axis=1)
    part = np.einsum("ij,ij->i", twice, normal[face]) / area[face]
    cells = np.where(a["face_cells"] >= 0, a["cell_block"][a["face_cells"]], -1)
    count = len(a["rock"])
    anchor = np.zeros((count, 3))
    for side, _ in SIDES:
        anchor[cells[cells[:, side] >= 0, side]] = corner[a["face_offsets"][:-1]][cells[:, side] >= 0]
    volume, moment, square = np.zeros(count), np.zeros((count, 3)), np.zeros(count)
    for side, sign in SIDES:
        rows = cells[face, side] >= 0
        block = cells[face[rows], side]
        x, y, z = (each[rows] - anchor[block] for each in (p, q, r))
        six = sign * np.einsum("ij,ij->i", x, np.cross(y, z))
        total = x + y + z
        volume += summed(block, six, count) / 6
        moment += summed(block, six[:, None] * total, count) / 24
        square += summed(block, six * sum((each**2).sum(axis=1) for each in (x, y, z, total)), count) / 120
    centre = moment / volume[:, None]
    polar = square / volume - (centre**2).sum(axis=1)  # mean square of the distance from the centroid
    a |= {"volume": volume, "centroid": anchor + centre, "gyration": np.sqrt(2 * polar / 3)}
    middle = summed(face, part[:, None] * (p + q + r) / 3, len(sizes)) / summed(face, part, len(sizes))[:, None]
    a |= {"face_blocks": cells, "face_area": area / 2, "face_normal": normal / area[:, None], "face_middle": middle}
    a["at"] = a["centroid"] + a["position"][:, :3]
    return a


def summed(row: Any, values: Any, count: int) -> Any:
    """Return the sums (count, ...) of values by their rows."""
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, row, values)
    return total


def turned(vectors: Any, turn: Any) -> Any:
    """Return vectors (k, 3) turned by rotation vectors (k, 3) [rad] (Rodrigues)."""
    angle = np.linalg.norm(turn, axis=1)[:, None]
    across = np.cross(turn, vectors)
    return vectors + np.sinc(angle / np.pi) * across + np.sinc(angle / (2 * np.pi)) ** 2 / 2 * np.cross(turn, across)


def given_faults(a: Arrays, reference: float) -> list[str]:
    """Return what acts on the blocks otherwise than by weights, loads and supports."""
    missing = [name for name in GIVEN if name not in a]
    if missing:
        return [f"the certificate has no {', '.join(missing)}: weights and loads cannot be followed"]
    faults = []
    off = np.abs((a["unit_weight"] * a["volume"])[:, None] * a["gravity"] - a["weight"])
    if not off.max(initial=0.0) <= AGREES * np.abs(a["weight"]).max(initial=0.0):
        faults.append(f"block {int(off.max(axis=1).argmax())} weighs otherwise than its volume and its unit weight say")
    push, nothing = a["support_reaction"], np.zeros((len(a["rock"]), 6))
    loads = add_forces(nothing.copy(), a, a["load_block"], a["load_point"], a["load_force"])
    reactions = add_forces(nothing, a, a["support_block"], a["support_point"], push, a["support_moment"])
    allowed = AGREES * (reference + max(np.abs(rows).max(initial=0.0) for rows in (a["load_force"], push)))
    if not np.abs(scaled(a, loads - a["applied"])).max(initial=0.0) <= allowed:
        faults.append("blocks are loaded otherwise than by the loads")
    if not np.abs(scaled(a, reactions - a["reactions"])).max(initial=0.0) <= allowed:
        faults.append("reactions are not the sum of the supports' forces")
    return faults + water_faults(a, reference)


def support_faults(a: Arrays, reference: float) -> list[str]:
    """Return which blocks the supports push where, or in a direction in which, no support holds them."""
    push = scaled(a, a["reactions"])
    allowed = AGREES * (reference + np.abs(push).max(initial=0.0))
    for block in np.flatnonzero((np.abs(push) > allowed).any(axis=1)):
        bars = a["bar_block"] == block
        along, turns = a["bar_direction"][bars], a["bar_turns"][bars][:, None]
        turn = np.where(turns, along, np.cross(a["bar_point"][bars] - a["at"][block], along) / a["gyration"][block])
        columns = np.hstack([np.where(turns, 0.0, along), turn]).T
        left = push[block] - columns @ np.linalg.lstsq(columns, push[block], rcond=None)[0]
        if np.abs(left).max() > allowed:
            return [f"supports push block {int(block)} in a direction in which none holds it"]
    return []


def place_faults(a: Arrays) -> list[str]:
    """Return which contact points do not lie on a face between their blocks, or along another normal."""
    face, own = a["contact_face"], a["contact_point_face"]
    one, other = a["contact_block_a"], a["contact_block_b"]
    point, normal = a["contact_point"], a["contact_normal"]
    size = float(np.cbrt(np.median(a["volume"])))
    near = AGREES * size + ROUNDING * np.abs(a["vertices"]).max()
    position, middle, own_middle = a["position"], a["face_middle"][face], a["face_middle"][own]
    given = a["centroid"][one] + turned(point - a["at"][one], -position[one, 3:])
    across = turned(a["face_normal"][face], position[other, 3:])
    across *= np.where(np.einsum("ij,ij->i", across, normal) < 0, -1.0, 1.0)[:, None]
    against = turned(a["face_normal"][own], position[one, 3:])
    flat = np.linalg.norm(np.cross(across, against), axis=1) < PARALLEL
    against *= np.where(np.einsum("ij,ij->i", against, across) < 0, -1.0, 1.0)[:, None]
    mean = (across + against) / np.linalg.norm(across + against, axis=1)[:, None]
    off = np.linalg.norm(normal - across, axis=1)
    away = np.where(flat, off > AGREES, np.einsum("ij,ij->i", normal, mean) < FACING)
    corner = a["vertices"][a["face_vertices"]]
    owner = np.repeat(np.arange(len(a["face_area"])), np.diff(a["face_offsets"]))
    reach = np.zeros(len(a["face_area"]))
    np.maximum.at(reach, owner, np.linalg.norm(corner - a["face_middle"][owner], axis=1))
    on_b = a["at"][other] + turned(middle - a["centroid"][other], position[other, 3:])
    gap = np.einsum("ij,ij->i", point - on_b, normal)
    shear = a["contact_shear"]
    least = AGREES * np.linalg.norm(shear, axis=1) + ROUNDING * np.abs(a["contact_normal_force"])
    length, side = a["contact_length"], np.cbrt(np.minimum(a["volume"][one], a["volume"][other]))
    used = summed(face, np.where(flat, length, 0.0), len(reach))
    most = np.where(flat, used[face], length), np.maximum(a["face_area"][face], np.where(flat, 0.0, CORNER * side**2))
    tests = (
        (one == other)
        | ~(a["face_blocks"][face] == other[:, None]).any(axis=1)
        | ~(a["face_blocks"][own] == one[:, None]).any(axis=1)
        | ~(a["present"][one] & a["present"][other]),
        np.linalg.norm(given - own_middle, axis=1) > reach[own] + near,
        np.abs(np.einsum("ij,ij->i", given - own_middle, a["face_normal"][own])) > near,
        away,
        (np.abs(gap - a["contact_opening"]) > near) & flat,
        np.abs(np.linalg.norm(shear, axis=1) - np.abs(a["contact_shear_force"])) > least,
        np.abs(np.einsum("ij,ij->i", shear, normal)) > least,
        most[0] > (1 + MORE) * most[1],
    )
    said = (
        "is between no two blocks that have its faces",
        "lies beyond its face",
        "does not lie on its face",
        "has another normal than its face",
        "has another opening than its blocks have",
        "has another shear force than its components",
        "has a shear force across its face",
        "represents more than its face with the others there",
    )
    return [f"contact {int(bad.argmax())} {text}" for bad, text in zip(tests, said, strict=True) if bad.any()]


def forces_in_space(told: dict[str, Any], stage: dict[str, Any], a: Arrays) -> tuple[str, list[str], Any]:
    """Return what supports a stage at rest, what speaks against its numbers, and which blocks (n,) are unbalanced."""
    reference = stage["reference_weight"]
    residual, rounding = residuals(a, reference)
    faults = given_faults(a, reference) + support_faults(a, reference) + strength_faults(stage, a)
    faults += place_faults(a)
    allowed, off = told["tolerance"], residual - rounding
    text = f"every block is in balance to {residual.max():.1e} of the reference weight ({allowed:.0e} is allowed); "
    text += "of polyhedra neither the stability of the equilibrium nor overlap is checked here"
    if stage["ground"] == "equilibrium" and not off.max() <= allowed:
        faults.append(f"block {int(off.argmax())} is out of balance by {residual.max():.1e} of the reference weight")
    if stage["ground"] == "best state":
        worst = int(residual.argmax())
        text = f"block {worst} is out of balance by {residual[worst]:.1e} of the reference weight; {stage['reason']}"
    return text + own_laws(stage, a), faults, off > allowed
