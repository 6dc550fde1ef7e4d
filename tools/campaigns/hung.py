"""A block that hangs on a bolt, and slabs on a plane of a mesh of triangles: more unstable models with their forms."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from tests.scenes.square_mesh import Group, msh_of

from .statics import Tree, beyond, gravity, si, strength

SUSPENDED = """
title = "A block that hangs on a bolt that is too weak"
[mesh]
file = "hung.msh"
[rock.rock]
unit_weight = "25 kN/m^3"
[joint.joint]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 30
[[support]]
blocks = [1]
fix = "all"
[[bolt]]
name = "A"
start = [1.0, 0.0]
end = [1.0, 3.0]
kind = "end_anchored"
diameter = "25 mm"
yield_strength = "500 MPa"
pretension = 0
anchor_capacity = "40 kN"
spacing = "1 m"
[solver]
scheme = "continuation"
displacement_limit = "2 m"
"""
_HUNG: list[Group] = [
    (1, "joint:joint", [(3, 2)]),
    (2, "rock:rock", [(0, 1, 2, 3), (3, 2, 4, 5)]),
]
HUNG = msh_of([(0, 0), (2, 0), (2, 1), (0, 1), (2, 4), (0, 4)], _HUNG, "4.1").encode()


def suspended(given: Tree) -> Callable[[Tree], bool | None]:
    """Return the form of a block of 2 m2 that only a bolt holds to the roof: its capacity against the weight."""

    def stands(tree: Tree) -> bool | None:
        if set(tree) - set(given) or any(tree.get(key) != given.get(key) for key in ("mesh", "support")):
            return None
        bolts = tree.get("bolt") or []
        if not bolts:
            return False
        bolt, joint = bolts[0], tree.get("joint", {}).get("joint", {})
        places = ("start", "end", "kind")
        if (
            len(bolts) > 1
            or any(bolt.get(key) != given["bolt"][0][key] for key in places)
            or set(bolt) - set(given["bolt"][0])
        ):
            return None
        if (
            {"tensile_strength", "cohesion"} & set(joint)
            or abs(math.cos(gravity(tree))) > 1e-9
            or math.sin(gravity(tree)) > 0
        ):
            return None
        weight = 2 * si(tree.get("rock", {}).get("rock", {}).get("unit_weight"), "N/m^3")
        steel = math.pi / 4 * si(bolt.get("diameter"), "m") ** 2 * si(bolt.get("yield_strength", 1e30), "Pa")
        capacity = min(steel, si(bolt.get("anchor_capacity", 1e30), "N"))
        return beyond(weight, capacity / si(bolt.get("spacing", 1), "m"))

    return stands


DIP = 15.0  # degrees, of the slabs' plane
SLAB = """
title = "A slab of rock on a plane"
[mesh]
file = "slab.msh"
blocks = "regions"
[rock.a]
unit_weight = "26 kN/m^3"
young = "20 GPa"
poisson = 0.25
[joint.f]
normal_stiffness = "10 GPa/m"
shear_stiffness = "10 GPa/m"
law = "mohr_coulomb"
friction = 5
[boundary.base]
below = 1e-3
[[support]]
boundary = "base"
fix = "all"
[solver]
scheme = "continuation"
displacement_limit = "1 m"
"""


def line() -> list[list[float]]:
    """Return the ends of the plane, beyond the rock."""
    from tests.scenes.cut_incline import plane

    return [[float(x), float(y)] for x, y in plane(DIP)]


@cache
def slab_mesh(*, cut: bool) -> bytes:
    """Return an irregular mesh of triangles: along the plane, with a group for it, or across it."""
    from tests.scenes.cut_incline import plane, write_section

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "slab.msh"
        write_section(path, 3.0, quads=False, joint=plane(DIP) if cut else None)
        return path.read_bytes()


def slab(given: Tree) -> Callable[[Tree], bool | None]:
    """Return the form of the slab: it slides where the plane is steeper than the friction."""

    def stands(tree: Tree) -> bool | None:
        known = ("mesh", "support", "boundary", "groups")
        if set(tree) - set(given) or any(tree.get(key) != given.get(key) for key in known):
            return None
        joint, before = tree.get("joint", {}).get("f", {}), given["joint"]["f"]
        turn, heavy = gravity(tree) + math.pi / 2, si(tree.get("rock", {}).get("a", {}).get("unit_weight"), "N/m^3")
        if turn != 0 or not heavy > 0 or {"cohesion", "tensile_strength"} & set(joint):
            return None
        if set(tree.get("joint", {})) != {"f"} or joint.get("along") != before.get("along"):
            return None
        answer = beyond(math.tan(math.radians(DIP)), strength(tree, "f").friction)
        return None if answer and set(joint) - set(before) else answer

    return stands
