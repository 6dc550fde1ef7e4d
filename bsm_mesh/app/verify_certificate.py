"""Check the certificates of a results folder from its files alone: ``python verify_certificate.py OUT``.

It stands alone: of this package it imports nothing, only NumPy. What each ground proves is in docs/theory.md,
section 9; what the arrays are in docs/user_guide.md. Exit code 0: every verdict bears out; 1: one does not.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

Arrays = dict[str, Any]
GROUNDS = {
    "stable": ("equilibrium",),
    "stable_after_falls": ("equilibrium",),
    "unstable": ("proved", "followed"),
    "not_converged": ("best state",),
    "no_verdict": ("equilibrium",),
}
ROUNDING = 4.0 * np.finfo(float).eps  # of coordinates, in an arm
USED = 1e-9  # by how much more than its strength a contact may bear: rounding
OPEN = 1e-12  # of the coordinates: by rounding of the gap
AGREES = 1e-6  # relative: numbers of the certificate that follow from others
OVERLAP = 1.3e-3  # of a block's area, beyond the closure of contacts: what touching within a thousandth allows
NEUTRAL = 1e-3  # negative eigenvalue of the stiffness over the mass that counts as none, over the block size
LINEAR = 1e-9  # tolerance of the linear scheme: rounding
ENORMOUS = 1e6  # times all loads together: forces that no rock bears
CURVED = ("barton_bandis", "ladanyi_archambault")
MAX_DENSE, MAX_PAIRED = 1200, 20_000  # blocks whose stability, and whose overlap, is checked here


def main(folder: Path) -> int:
    """Check a results folder, print a line a stage, and return the exit code."""
    told, summary = (json.loads((folder / name).read_text("utf-8")) for name in ("certificate.json", "summary.json"))
    verdicts = [(stage["name"], stage["status"]) for stage in summary["stages"]]
    holds = verdicts == [(stage["name"], stage["verdict"]) for stage in told["stages"]]
    if not holds:
        print("DOES NOT HOLD: summary.json and certificate.json give different verdicts")
    for stage in told["stages"]:
        with np.load(folder / Path(stage["arrays"]).name, allow_pickle=False) as file:
            text, faults = check_stage(told, stage, {name: file[name] for name in file.files})
        holds = holds and not faults
        said = f"DOES NOT HOLD: {'; '.join(faults)}" if faults else text
        print(f"{stage['name']!a}: {stage['verdict']}, {stage['ground']}: {said}")
    return 0 if holds else 1


def check_stage(told: dict[str, Any], stage: dict[str, Any], arrays: Arrays) -> tuple[str, list[str]]:
    """Return what bears the verdict of a stage, in words, and what speaks against it."""
    try:
        return _checked(told, stage, arrays)
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        return "", [f"the numbers do not fit together ({type(error).__name__}: {error})"]


def _checked(told: dict[str, Any], stage: dict[str, Any], a: Arrays) -> tuple[str, list[str]]:
    a = {**a, **moments(a["vertices"], a["offsets"])}
    a["at"] = a["centroid"] + a["position"][:, :2]
    if stage["ground"] not in GROUNDS.get(stage["verdict"], ()):
        return "", [f"the ground '{stage['ground']}' is none for '{stage['verdict']}'"]
    linear = told["scheme"] == "linear"
    if stage["ground"] == "equilibrium" and linear != (stage["verdict"] == "no_verdict"):
        return "", [f"an equilibrium of scheme '{told['scheme']}' is none for '{stage['verdict']}'"]
    residual, rounding = residuals(a, stage["reference_weight"])
    faults = reaction_faults(a, stage["reference_weight"]) + (strength_faults(stage, a) if not linear else [])
    if stage["ground"] == "best state":
        worst = int(residual.argmax())
        text = f"block {worst} lacks {residual[worst]:.1e} of the reference weight ({told['tolerance']:.0e} is allowed)"
        return f"{text}; {stage['reason']}", faults
    if stage["verdict"] == "unstable":
        text, found = movement(stage, a, residual - rounding > told["tolerance"])
        if stage["ground"] == "proved":
            proof, more = proved(stage, a, linear=linear)
            return f"{proof}; {text}", faults + found + more
        return text, faults + found
    allowed = min(told["tolerance"], LINEAR) if linear else told["tolerance"]
    worst = int((residual - rounding).argmax())
    if not residual[worst] - rounding[worst] <= allowed:
        faults.append(f"block {worst} is out of balance by {residual[worst]:.1e} of the reference weight")
    text = f"every block is in balance to {residual.max():.1e} of the reference weight ({allowed:.0e} is allowed)"
    for told_more, found in ("", []) if linear else overlap(a), falling(a, linear=linear):
        text, faults = f"{text}{'; ' if told_more else ''}{told_more}", faults + found
    return text + own_laws(stage, a), faults


def is_curved(law: dict[str, Any]) -> bool:
    """Return whether straight lines can only bound a law's strength."""
    return is_curved(law["law"]) if law["kind"] == "reduced" else law["kind"] in CURVED


def own_laws(stage: dict[str, Any], a: Arrays) -> str:
    """Say of which laws no numbers tell the strength."""
    used = [stage["laws"][number] for number in np.unique(a["law"])]
    names = sorted({law["name"] for law in used if law["kind"] == "own"})
    told = f"; the strength of laws of the user's own cannot be checked by numbers alone: {', '.join(names)}"
    return told if names else ""


def moments(vertices: Any, offsets: Any) -> Arrays:
    """Return area, centroid, polar radius of gyration of polygons, and the owner of every corner and the next one."""
    count = len(offsets) - 1
    owner = np.repeat(np.arange(count), np.diff(offsets))
    following = np.arange(1, len(vertices) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    anchor = vertices[offsets[:-1]]
    x, y = (vertices - anchor[owner]).T
    u, v = x[following], y[following]
    cross = x * v - u * y

    def summed(values: Any) -> Any:
        return np.bincount(owner, values, minlength=count)

    area = summed(cross) / 2
    centre = np.column_stack([summed((x + u) * cross), summed((y + v) * cross)]) / (6 * area)[:, None]
    polar = summed((x * x + x * u + u * u + y * y + y * v + v * v) * cross) / 12 - area * (centre**2).sum(axis=1)
    gyration = np.sqrt(polar / area)
    return {"area": area, "centroid": anchor + centre, "gyration": gyration, "owner": owner, "following": following}


def turned_left(vectors: Any) -> Any:
    """Return vectors (k, 2) turned by +90 degrees."""
    return vectors[:, ::-1] * (-1.0, 1.0)


def cross(one: Any, other: Any) -> Any:
    """Return the plane cross products of vectors (k, 2)."""
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def residuals(a: Arrays, reference: float) -> tuple[Any, Any]:
    """Return what every block lacks to balance, (n,), and what rounding makes of it, over the reference weight."""
    total = a["applied"] + a["water"] + a["reactions"]
    total[:, :2] += a["weight"]
    force = a["contact_normal_force"][:, None] * a["contact_normal"]
    force = force + a["contact_shear_force"][:, None] * turned_left(a["contact_normal"])
    borne = np.zeros(len(total))
    for block, point, push in (
        (a["contact_block_b"], a["contact_point"], force),
        (a["contact_block_a"], a["contact_point"], -force),
        (a["bolt_block"], a["bolt_point"], a["bolt_force"]),
    ):
        moment = cross(point - a["at"][block], push)
        np.add.at(total, block, np.column_stack([push, moment]))
        np.add.at(borne, block, np.hypot(*push.T))
    total[:, 2] /= a["gyration"]
    far = float(np.abs(a["at"][a["present"]]).max())
    size = np.where(a["present"], np.abs(total).max(axis=1), 0.0)
    return np.nan_to_num(size, nan=np.inf) / reference, ROUNDING * far * borne / a["gyration"] / reference


def reaction_faults(a: Arrays, reference: float) -> list[str]:
    """Return where the reactions are not the sum of the supports' forces."""
    total, block = np.zeros_like(a["reactions"]), a["support_block"]
    moment = a["support_moment"] + cross(a["support_point"] - a["at"][block], a["support_reaction"])
    np.add.at(total, block, np.column_stack([a["support_reaction"], moment]))
    off = np.abs(total - a["reactions"]) / np.column_stack([np.ones((len(total), 2)), a["gyration"]])
    allowed = AGREES * (reference + np.abs(a["reactions"]).max(initial=0.0))
    return [] if off.max(initial=0.0) <= allowed else ["reactions are not the sum of the supports' forces"]


def strength_of(law: dict[str, Any], pressure: Any, length: Any, failed: Any, slid: Any) -> Any:
    """Return the shear strength (m,) [N/m] at pressures (m,) [N/m], not a number for laws of the user's own.

    `slid` (m,) [m] is how far contacts have slid.
    """
    if law["kind"] == "weaker":
        return np.minimum(*(strength_of(one, pressure, length, failed, slid) for one in law["laws"]))
    if law["kind"] == "reduced":
        return strength_of(law["law"], pressure, length, failed, slid) / law["factor"]
    if law["kind"] == "barton_bandis":
        return barton_bandis(law, pressure, length, failed, slid)
    if law["kind"] == "ladanyi_archambault":
        return ladanyi_archambault(law, pressure, length, failed)
    if law["kind"] == "elastic":
        return np.full(len(pressure), np.inf)
    if law["kind"] == "own":
        return np.full(len(pressure), np.nan)
    first, left = law["friction"], law.get("residual_cohesion") or 0.0
    last = first if law["residual_friction"] is None else law["residual_friction"]
    slope, residual = np.tan(np.radians(first + law.get("dilation", 0.0))), np.tan(np.radians(last))
    line = slope * pressure
    if law["kind"] == "patton":  # the lower of two lines; once the asperities are sheared off friction is left
        return np.where(failed, residual * pressure, np.minimum(line, law["cohesion"] * length + residual * pressure))
    gone = failed.astype(float)
    if law.get("softening_slip"):  # both values fall while it slides that far
        gone = np.maximum(gone, np.minimum(slid / law["softening_slip"], 1.0))
    return (1 - gone) * (law["cohesion"] * length + line) + gone * (left * length + residual * pressure)


def barton_bandis(law: dict[str, Any], pressure: Any, length: Any, failed: Any, slid: Any) -> Any:
    """Return Barton and Bandis's shear strength (m,) [N/m] (Barton and Choubey 1977, Barton et al. 1985)."""
    scale = law["joint_length"] / 0.1
    rough, wall = law["jrc"] * scale ** (-0.02 * law["jrc"]), law["jcs"] * scale ** (-0.03 * law["jrc"])
    left = np.ones(len(pressure))
    if law["roughness_wears"] and rough > 0:
        peak = law["joint_length"] / 500 * (rough / law["joint_length"]) ** 0.33
        left = np.interp(1 + slid / peak, (1.0, 2.0, 4.0, 10.0, 100.0), (1.0, 0.85, 0.7, 0.5, 0.0))
    left = np.where(failed, 0.0, left)
    decades = np.log10(np.maximum(wall * length, pressure) / np.maximum(pressure, 1e-300))
    return pressure * np.tan(np.radians(np.minimum(law["residual_friction"] + left * rough * decades, 70.0)))


def ladanyi_archambault(law: dict[str, Any], pressure: Any, length: Any, failed: Any) -> Any:
    """Return Ladanyi and Archambault's shear strength (m,) [N/m] (1970), with Fairhurst's strength of rock."""
    wall, smooth = law["jcs"] * length, np.tan(np.radians(law["friction"]))
    x = pressure / wall
    climbs = np.maximum(1 - x, 0.0) ** 1.5
    rate = np.maximum(1 - x, 0.0) ** 4 * np.tan(np.radians(law["dilation"]))
    rock = (np.sqrt(11.0) - 1) / 10 * np.sqrt(1 + 10 * x)
    found = (x * climbs * (rate + smooth) + (1 - climbs) * rock) / (1 - climbs * rate * smooth)
    return np.where(failed, smooth * pressure, wall * found)


def strength_faults(stage: dict[str, Any], a: Arrays) -> list[str]:
    """Return which contacts bear more than their strength, or another part of it than they are said to."""
    normal, shear, length, used = (
        a[f"contact_{name}"] for name in ("normal_force", "shear_force", "length", "utilisation")
    )
    pressure, strength = np.maximum(-normal, 0.0), np.full(len(normal), np.nan)
    for number, law in enumerate(stage["laws"]):
        rows = a["law"] == number
        strength[rows] = strength_of(law, pressure[rows], length[rows], a["failed"][rows], a["slip_path"][rows])
    known = ~np.isnan(strength)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(shear == 0, 0.0, np.minimum(np.abs(shear) / strength, 999.0))
    bears_open = np.zeros(len(normal), dtype=bool)
    if "closed_at" in a:
        slope, last = a.get("dilation", np.zeros((len(normal), 2))).T
        most = a["closed_at"] + slope * np.minimum(a["slip_path"], last)  # walls part as they slide, up to that
        bears_open = (normal < 0) & (a["contact_opening"] > most + OPEN * np.abs(a["vertices"]).max(initial=0.0))
    tests = (
        (bears_open, "bears pressure and is open"),
        (known & ~(found <= 1 + USED), "bears more than its shear strength"),
        (known & ~(np.abs(found - used) <= AGREES * np.maximum(used, 1.0)), "has another strength than is said"),
        (~(normal <= a["tension"] * (1 + USED)), "bears more than its tensile strength"),
        (a["failed"] & (a["tension"] > a.get("residual_tension", 0.0)), "has failed and bears tension"),
    )
    return [f"contact {int(bad.argmax())} {text}" for bad, text in tests if bad.any()]


def overlap(a: Arrays) -> tuple[str, list[str]]:
    """Return by how much blocks share area beyond the closure of their contacts, and whether that is too much.

    What lies under an edge, signed by its direction, sums up to a block; under the lower of two edges, to what two
    blocks share.
    """
    if a["present"].sum() > MAX_PAIRED:
        return "whether blocks overlap is not checked here in so large a model", []
    x, y = (a["vertices"] - a["centroid"][a["owner"]]).T
    turn = a["position"][a["owner"], 2]
    cosine, sine = np.cos(turn), np.sin(turn)
    corner = (a["at"] - a["at"][0])[a["owner"]] + np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
    one, other = pairs_of_edges(corner, a)
    edges = [(*corner[k].T, *corner[a["following"][k]].T) for k in (one, other)]
    left = np.maximum(*(np.minimum(x, u) for x, _, u, _ in edges))
    width = np.minimum(*(np.maximum(x, u) for x, _, u, _ in edges)) - left
    edges, left, width = [tuple(v[width > 0] for v in edge) for edge in edges], left[width > 0], width[width > 0]
    begin, end = (np.array([y + (v - y) / (u - x) * (at - x) for x, y, u, v in edges]) for at in (left, left + width))
    sign = np.prod([np.sign(x - u) for x, _, u, _ in edges], axis=0)
    shared = float((sign * width * mean_of_lower(begin - begin[1], end - end[1], (begin[1] + end[1]) / 2)).sum())
    closure = float((np.maximum(-a["contact_opening"], 0.0) * a["contact_length"]).sum())
    excess = (shared - closure) / float(np.median(a["area"]))
    told = f"overlap by {max(excess, 0.0):.1e} of a block's area beyond the closure of joints"
    return f"blocks {told}", [] if excess <= OVERLAP else [f"blocks {told}"]


def mean_of_lower(begin: Any, end: Any, mean: Any) -> Any:
    """Return the mean of the lower of two lines, from what the first begins and ends above the second of a mean."""
    d, e = begin[0], end[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = np.where(d < 0, d * d, -e * e) / (d - e) / 2
    below = np.where(np.maximum(d, e) <= 0, (d + e) / 2, np.where(np.minimum(d, e) >= 0, 0.0, crossing))
    return mean + below


def pairs_of_edges(corner: Any, a: Arrays) -> tuple[Any, Any]:
    """Return the edges (k,) of one and of the other block of all pairs of blocks whose boxes meet."""
    low, high = (bound.reduceat(corner, a["offsets"][:-1], axis=0) for bound in (np.minimum, np.maximum))
    meet = a["present"][:, None] & a["present"][None, :]
    for axis in range(2):
        meet &= (low[:, None, axis] <= high[None, :, axis]) & (high[:, None, axis] >= low[None, :, axis])
    first, second = np.nonzero(np.triu(meet, 1))
    sides = np.diff(a["offsets"])
    count = sides[first] * sides[second]
    pair = np.repeat(np.arange(len(first)), count)
    within = np.arange(len(pair)) - (np.cumsum(count) - count)[pair]
    across = sides[second][pair]
    return a["offsets"][first][pair] + within // across, a["offsets"][second][pair] + within % across


def falling(a: Arrays, *, linear: bool) -> tuple[str, list[str]]:
    """Return whether blocks would fall from the equilibrium: its stiffness is not positive.

    Slipping contacts slip: they keep their shear, and turn it with them, but bear no more.
    """
    here = np.flatnonzero(a["present"])
    if len(here) > MAX_DENSE:
        return "falling directions are not looked for here in so large a model", []
    K = stiffness(a, here, linear=linear)
    weight = np.hypot(*a["weight"][here].T)
    weight = np.maximum(weight, 1e-3 * (weight.mean() or 1.0))
    shift = NEUTRAL / float(np.median(np.sqrt(a["area"][here])))
    mass = np.column_stack([weight, weight, weight * a["gyration"][here] ** 2])
    K[np.arange(len(K)), np.arange(len(K))] += shift * mass.reshape(-1)
    axes = free_axes(a, here)
    K = K.reshape(len(here), 3, len(here), 3).transpose(0, 2, 1, 3)
    K = (axes.transpose(0, 2, 1)[:, None] @ K @ axes[None, :]).transpose(0, 2, 1, 3).reshape(3 * len(here), -1)
    held = np.flatnonzero(~axes.any(axis=1).reshape(-1))
    K[held, held] = 1.0
    try:
        np.linalg.cholesky(K)
    except np.linalg.LinAlgError:
        return "", ["there is a direction in which blocks fall"]
    return "no direction in which blocks fall", []


def free_axes(a: Arrays, here: Any) -> Any:
    """Return the movements that the supports leave to every block, columns (n, 3, 3); zero where it is held."""
    axes = np.tile(np.eye(3), (len(here), 1, 1))
    for number in np.flatnonzero(np.isin(here, a["bar_block"])):
        bars = a["bar_block"] == here[number]
        arm, along = a["bar_point"][bars] - a["at"][here[number]], a["bar_direction"][bars]
        turn = np.where(a["bar_turns"][bars], a["gyration"][here[number]], cross(arm, along))
        rows = np.column_stack([along, turn / a["gyration"][here[number]]])
        _, size, directions = np.linalg.svd(np.vstack([rows, np.zeros((3, 3))]))
        axes[number] = np.where(size > 1e-9 * size[0], 0.0, directions.T)
    axes[:, 2] /= a["gyration"][here][:, None]
    return axes


def stiffness(a: Arrays, here: Any, *, linear: bool) -> Any:
    """Return the stiffness (3n, 3n) of the blocks (n,): closed contacts, and bolts."""
    number = np.zeros(len(a["present"]), dtype=int)
    number[here] = np.arange(len(here))
    K = np.zeros((3 * len(here), 3 * len(here)))
    acts = np.flatnonzero((a["contact_status"] < 2) | a["near"])
    n = a["contact_normal"][acts]
    t = turned_left(n)
    blocks = [a[f"contact_block_{side}"][acts] for side in "ab"]
    arms = [a["contact_point"][acts] - a["at"][block] for block in blocks]
    place = np.column_stack([3 * number[block] + axis for block in blocks for axis in range(3)])
    for along, turned, name in (n, t, "normal"), (t, -n, "shear"):
        moves = np.column_stack([along, cross(arms[0], along), -along, -cross(arms[1], along)])
        slips = (a["contact_status"][acts] == 1) & (name == "shear")
        springs = np.where(slips, 0.0, a[f"{name}_stiffness"][acts])
        parts = springs[:, None, None] * moves[:, :, None] * moves[:, None, :]
        if not linear:
            parts += a[f"contact_{name}_force"][acts][:, None, None] * turning(along, turned, *arms)
        np.add.at(K, (place[:, :, None], place[:, None, :]), parts)
    for (row, column), block in zip(number[a["bolt_pair"]], a["bolt_tangent"], strict=True):
        K[3 * row : 3 * row + 3, 3 * column : 3 * column + 3] += block
    return (K + K.T) / 2


def turning(along: Any, turned: Any, arm_a: Any, arm_b: Any) -> Any:
    """Return the second derivatives (m, 6, 6) of the relative movement along a vector that turns with block b."""
    G = np.zeros((len(along), 6, 6))
    G[:, 2, 2], G[:, 5, 5] = -(arm_a * along).sum(axis=1), -(arm_b * along).sum(axis=1)
    G[:, :2, 5], G[:, 2, 5], G[:, 3:5, 5] = turned, cross(arm_a, turned), -turned
    G[:, 5, :5] = G[:, :5, 5]
    return G


def movement(stage: dict[str, Any], a: Arrays, unbalanced: Any) -> tuple[str, list[str]]:
    """Return how the blocks that come down were followed, and what of it is not so; `unbalanced` (n,): what moves."""
    blocks, moved = stage["unstable_blocks"], np.hypot(*a["displacement"][:, :2].T)
    if not blocks or [one["block"] for one in stage["movement"]] != blocks or not a["present"][blocks].all():
        return "", ["the blocks that come down are not named"]
    faults = []
    if any(abs(one["moved"] - moved[one["block"]]) > AGREES * moved[one["block"]] for one in stage["movement"]):
        faults.append("blocks have not moved as far as is said")
    if not unbalanced[blocks].any():
        faults.append("every block that is to come down is in balance")
    farthest = max(stage["movement"], key=lambda one: one["moved"])
    speed = "" if farthest["speed"] is None else f", at {farthest['speed']:.2g} m/s"
    methods = ", ".join(
        f"{one['name']} ended {one['ended']} and failed in {one['in_vain']}" for one in stage["methods"]
    )
    text = f"block {farthest['block']} was followed over {farthest['moved']:.3g} m{speed} ({len(blocks)} come down); "
    why = f"; {stage['proof']['text']}" if "proof" in stage and stage["ground"] == "followed" else ""
    return f"{text}{stage['reason']}; of {stage['steps']} steps {methods}{why}", faults


def proved(stage: dict[str, Any], a: Arrays, *, linear: bool) -> tuple[str, list[str]]:
    """Return what the mechanism proves by virtual work where the blocks were given, and whether it does not."""
    p = {name.removeprefix("proof_"): values for name, values in a.items() if name.startswith("proof_")}
    v, centroid, gyration = p["velocity"], a["centroid"], a["gyration"]

    def at(block: Any, point: Any) -> Any:
        return v[block, :2] + v[block, 2:] * turned_left(point - centroid[block])

    power = float((p["loads"] * v).sum())
    past = at(p["block_a"], p["point"]) - at(p["block_b"], p["point"])
    taken, loose = dissipation((past * p["normal"]).sum(axis=1), np.abs(cross(p["normal"], past)), p)
    held = (at(p["bar_block"], p["bar_point"]) * p["bar_direction"]).sum(axis=1)
    loose += float(np.abs(np.where(p["bar_turns"], v[p["bar_block"], 2] * gyration[p["bar_block"]], held)).sum())
    first, nodes = p["element_node"], at(p["node_block"], p["node_point"])
    along = p["node_point"][first + 1] - p["node_point"][first]
    along = along / np.hypot(*along.T)[:, None]
    longer = ((nodes[first + 1] - nodes[first]) * along).sum(axis=1) - p["node_slip"][first] + p["node_slip"][first + 1]
    across = (at(p["dowel_block"][:, 0], p["dowel_point"]) - at(p["dowel_block"][:, 1], p["dowel_point"])) * p[
        "dowel_across"
    ]
    for speed, most in (
        (np.maximum(longer, 0.0), p["element_yield"]),
        (np.abs(p["node_slip"]), p["node_capacity"]),
        (np.abs(across.sum(axis=1)), p["dowel_strength"]),
    ):
        taken += float((speed * np.where(np.isfinite(most), most, 0.0)).sum())
        loose += float(speed[np.isinf(most)].sum())
    every = float(np.hypot(*p["loads"][:, :2].T).sum())
    left = (power - taken) / every
    least = left / loose if loose > 0 else np.copysign(np.inf, left)
    faults = witness_faults(stage, a, p, linear=linear)
    if not (power > 0 and least >= ENORMOUS):
        faults.append("the mechanism proves nothing: forces within strength can take up the power of the loads")
    text = (
        f"in the mechanism the loads do {power:.6g} W/m and all that strength allows takes up {taken:.6g}: forces that "
        f"balance would have to be {least:.1e} times all loads together"
    )
    return text, faults


def dissipation(opens: Any, slips: Any, p: Arrays) -> tuple[float, float]:
    """Return the power that contacts can take up at most (velocities (m,)), and what rounding leaves per force.

    Under the pressure p a contact takes up ``-p * opens + strength(p) * slips``: concave in p, greatest at a corner of
    the strength, and bounded where it opens fast enough.
    """
    slope, intercept = p["lines"][:, :, 0], p["lines"][:, :, 1]
    bounded = np.isfinite(intercept)
    free = ~bounded.any(axis=1) | np.isinf(p["tension"])
    tension = np.where(free & np.isinf(p["tension"]), 0.0, p["tension"])
    intercept = intercept + slope * tension[:, None]  # the convex hull of the strength in tension
    flattest = np.where(bounded, slope, np.inf).min(axis=1, initial=np.inf)
    lacks = np.where(free, np.where(np.isinf(p["tension"]), np.abs(opens), np.maximum(-opens, 0.0)) + slips, 0.0)
    with np.errstate(invalid="ignore"):
        lacks = np.where(free, lacks, np.maximum(slips * flattest - opens, 0.0))
    pressures = [-tension]
    for one in range(slope.shape[1]):
        for other in range(one):
            with np.errstate(divide="ignore", invalid="ignore"):
                meet = (intercept[:, other] - intercept[:, one]) / (slope[:, one] - slope[:, other])
            pressures.append(np.where(np.isfinite(meet), np.maximum(meet, -tension), -tension))
    taken = np.zeros(len(opens))
    for pressure in pressures:
        line = np.where(bounded, intercept + slope * pressure[:, None], np.inf).min(axis=1, initial=np.inf)
        strength = np.where(free, 0.0, line)
        taken = np.maximum(taken, -pressure * (opens + np.where(free, 0.0, lacks)) + slips * strength)
    return float(taken.sum()), float(lacks.sum())


def witness_faults(stage: dict[str, Any], a: Arrays, p: Arrays, *, linear: bool) -> list[str]:
    """Return where loads and strength of the mechanism are not those of the certificate."""
    faults = []
    moves = p["velocity"].any(axis=1) & (not a["water"].any())  # water presses where the blocks have come to
    forces = (a["weight"] + a["applied"][:, :2] - p["loads"][:, :2])[moves]
    if np.abs(forces).max(initial=0.0) > AGREES * np.abs(p["loads"]).max(initial=0.0):
        faults.append("the mechanism is loaded otherwise than the blocks")
    used = [stage["proof"]["laws"][number] for number in np.unique(p["law"])]
    if not linear and any(law not in stage["laws"] for law in used):  # that scheme knows no strength
        faults.append("the mechanism has laws that the contacts have not")
    for number, law in enumerate(stage["proof"]["laws"]):
        rows, lines = p["law"] == number, p["lines"][p["law"] == number]
        for pressure in (0.0, 1e3, 1e6, 1e9):
            told = (lines[:, :, 1] + lines[:, :, 0] * pressure).min(axis=1, initial=np.inf)
            length = p["length"][rows]
            none = np.zeros(len(length))
            known = strength_of(law, np.full(len(length), pressure), length, none > 0, none)
            with np.errstate(invalid="ignore"):
                off = np.where(np.isfinite(known), told - known, 0.0)
                off = off if is_curved(law) else -np.abs(off)  # tangents lie above: what holds for more strength
                wrong = (off < -AGREES * np.abs(known)).any()
            if wrong:
                faults.append(f"the lines of law {number} are not its strength")
                break
    return faults


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
