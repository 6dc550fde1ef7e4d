"""Small models that are unstable, and what statics says of each when a number of it is another.

`stands` of a tree answers from closed forms alone: True where the blocks stay, False where they cannot, None where the
form does not know. Values are read here, by Pint, and not by the program.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from .hung import HUNG, SLAB, SUSPENDED, line, slab, slab_mesh, suspended
from .inputs import ROOT
from .sections import Section, section_of
from .statics import NEAR, Tree, beyond, both, gravity, si, strength, weakens

ADDED = ("support", "load", "bolt", "water", "stage")  # tables with which the simple forms do not hold


@dataclass(frozen=True)
class Example:
    """An unstable model: its file, scripts it needs, and whether it is stable when changed."""

    name: str
    text: str
    stands: Callable[[Tree], bool | None]
    files: dict[str, bytes]

    @property
    def tree(self) -> Tree:
        """The model file's content."""
        return tomllib.loads(self.text)

    @cached_property
    def section(self) -> Section:
        """The mesh."""
        return section_of(self.tree["mesh"], self.files)

    @property
    def filed(self) -> Tree:
        """The model file's content, with the mesh in the file ``mesh.msh`` and no choice of output."""
        tree = self.tree
        tree.pop("output", None)
        of_geometry = ("file", "geometry", "parameters")
        tree["mesh"] = {"file": "mesh.msh"} | {k: v for k, v in tree["mesh"].items() if k not in of_geometry}
        return tree


def _is_simple(tree: Tree, given: Tree) -> bool:
    """Return whether the tables that the form takes for granted are as they were."""
    return all(tree.get(name) == given.get(name) for name in ADDED)


def column(given: Tree) -> Callable[[Tree], bool | None]:
    """Return the form of equal blocks on an inclined base: they slide on it, or topple about its lower corner."""

    def stands(tree: Tree) -> bool | None:
        mesh, before = tree.get("mesh", {}), given["mesh"]
        sizes = {**before["parameters"], **mesh.get("parameters", {})}
        if not _is_simple(tree, given) or mesh.get("geometry") != "column" or "groups" in tree:
            return None
        count, width, height, dip = (
            float(sizes.get(key, d)) for key, d in (("count", 4), ("width", 1), ("height", 2), ("dip", 0))
        )
        if any(key not in mesh.get("parameters", {}) for key in before["parameters"]):
            count, width, height, dip = _defaults(mesh.get("parameters", {}))
        scale = si(f"1 {mesh.get('unit', 'm')}", "m")
        joint = strength(tree, "joint")
        weight = (
            si(tree.get("rock", {}).get("rock", {}).get("unit_weight"), "N/m^3") * width * height * count * scale**2
        )
        fall, slope = gravity(tree), math.radians(dip)
        pull = weight * math.cos(fall + slope)  # along the base, downhill to the right
        press = -weight * math.sin(fall + slope)
        if press <= 0:
            return False if weight > 0 else None
        half = beyond(abs(pull), press * joint.friction + joint.cohesion * width * scale / 2)
        slides = beyond(abs(pull), press * joint.friction + joint.cohesion * width * scale)
        if slides and not half:  # cohesion acts where the joint is closed, and that may be a part of it
            slides = None
        topples = beyond(abs(pull) * count * height / 2, press * width / 2)
        if joint.cohesion or si(tree["joint"]["joint"].get("tensile_strength", 0), "Pa") > 0:
            topples = topples or None
        answer = both(slides, topples)
        return None if answer and weakens(tree, "joint") else answer

    return stands


def _defaults(parameters: Tree) -> tuple[float, float, float, float]:
    return tuple(
        float(parameters.get(key, default))
        for key, default in (("count", 4), ("width", 1.0), ("height", 2.0), ("dip", 0.0))
    )  # type: ignore[return-value]


def arch(given: Tree) -> Callable[[Tree], bool | None]:
    """Return the form of the arch of 16 voussoirs: its least thickness is 0.10708 of its radius."""

    def stands(tree: Tree) -> bool | None:
        mesh = tree.get("mesh", {})
        sizes = mesh.get("parameters", {})
        if not _is_simple(tree, given) or mesh.get("geometry") != "voussoir_arch" or sizes.get("count", 16) != 16:
            return None
        if math.sin(gravity(tree)) > 0:
            return False
        if abs(math.cos(gravity(tree))) > 1e-9:
            return None
        thin = beyond(0.10708, float(sizes.get("thickness", 0.15)) / float(sizes.get("radius", 1.0)))
        joint = strength(tree, "joint")
        if joint.cohesion or si(tree.get("joint", {}).get("joint", {}).get("tensile_strength", 0), "Pa") > 0:
            return None
        return thin if thin is False else None

    return stands


def wall(given: Tree) -> Callable[[Tree], bool | None]:
    """Return what is known of the tilted wall: it falls beyond 29 degrees, or steeper than the friction."""

    def stands(tree: Tree) -> bool | None:
        if not _is_simple(tree, given) or tree.get("mesh") != given["mesh"]:
            return None
        if any(strength(tree, name).cohesion != 0 for name in ("bed", "head")):
            return None
        if any(
            si(tree.get("joint", {}).get(name, {}).get("tensile_strength", 0), "Pa") > 0 for name in ("bed", "head")
        ):
            return None
        tilt = abs(gravity(tree) + math.pi / 2)
        bed, head = strength(tree, "bed").friction, strength(tree, "head").friction
        if tilt >= math.pi / 2 or math.tan(tilt) > bed * (1 + NEAR):
            return False
        fails = tilt > math.radians(29) and max(bed, head) <= math.tan(math.radians(35)) * (1 + 1e-9)
        return False if fails else None

    return stands


def pushed(given: Tree) -> Callable[[Tree], bool | None]:
    """Return the form of the block pushed over the end of another: it slides where P exceeds W tan phi."""

    def stands(tree: Tree) -> bool | None:
        mesh, load = tree.get("mesh", {}), (tree.get("load") or [{}])[0]
        if mesh != given["mesh"] or tree.get("support") != given["support"] or len(tree.get("load") or []) != 1:
            return None
        if set(tree) - set(given) or abs(math.cos(gravity(tree))) > 1e-9 or load.get("block") != 1:
            return None
        force = load.get("force") or [0, 0]
        across, up = (si(part, "N/m") for part in [*force, 0, 0][:2])
        joint = strength(tree, "joint")
        weight = si(tree.get("rock", {}).get("rock", {}).get("unit_weight"), "N/m^3")
        press = -weight * math.sin(gravity(tree)) - up
        if press <= 0:
            return None
        if abs(across) * 0.3 > press * 0.5 or across < 0:
            return None
        answer = beyond(abs(across), press * joint.friction + joint.cohesion)
        return None if answer and joint.cohesion else answer

    return stands


def wedge(given: Tree) -> Callable[[Tree], bool | None]:
    """Return the form of plane failure (Hoek and Bray): the wedge of examples/falling_table after the drawdown."""

    def stands(tree: Tree) -> bool | None:
        if any(tree.get(key) != given.get(key) for key in ("mesh", "support", "stage", "load", "bolt", "gravity")):
            return None
        water = tree.get("water", {})
        if set(water) - {"table", "unit_weight"} or water.get("table") != given["water"]["table"]:
            return None
        if strength(tree, "crack") != strength(given, "crack") or "tensile_strength" in tree["joint"]["bedding"]:
            return None
        joint = strength(tree, "bedding")
        heavy = si(tree.get("rock", {}).get("rock", {}).get("unit_weight"), "N/m^3")
        wet = si(water.get("unit_weight", 9810), "N/m^3")
        corners = [(0.0, 0.0), (10.928, 7.652), (10.928, 12.0), (6.928, 12.0)]
        area = sum(a * d - b * c for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1], strict=True)) / 2
        dip, length, crack = math.atan2(7.652, 10.928), math.hypot(7.652, 10.928), 12 - 7.652
        weight, thrust, uplift = heavy * area, wet * crack**2 / 2, wet * crack * length / 2
        press = weight * math.cos(dip) - uplift - thrust * math.sin(dip)
        pull = weight * math.sin(dip) + thrust * math.cos(dip)
        if press <= 0:
            return False if joint.cohesion * length < pull else None
        return beyond(pull, joint.cohesion * length + press * joint.friction)

    return stands


def _of_file(name: str, form: Callable[[Tree], Callable[[Tree], bool | None]], *scripts: str) -> Example:
    path: Path = ROOT / "examples" / name
    text = path.read_text(encoding="utf-8")
    return Example(
        name, text, form(tomllib.loads(text)), {script: (path.parent / script).read_bytes() for script in scripts}
    )


@cache
def examples() -> tuple[Example, ...]:
    """Return the unstable models."""
    return (
        _of_file("incline/slides.toml", column),
        _of_file("incline/topples.toml", column),
        _of_file("incline/tall_slides.toml", column),
        _of_file("toppling_column/steeper.toml", column),
        _of_file("arch/thin.toml", arch),
        _of_file("tilted_wall/tilt_30.toml", wall),
        _of_file("02_pushed_block/apart.toml", pushed),
        _of_file("falling_table/rapid.toml", wedge, "slope.py"),
        Example("suspended block", SUSPENDED, suspended(tomllib.loads(SUSPENDED)), {"hung.msh": HUNG}),
        Example("slab on a group", SLAB, slab(tomllib.loads(SLAB)), {"slab.msh": slab_mesh(cut=True)}),
        _along("slab along a line", "regions"),
        _along("slab of elements along a line", "elements"),
    )


def _along(name: str, blocks: str) -> Example:
    """Return the slab whose plane is a line of the model file, through the elements."""
    text = SLAB.replace("[boundary.base]", f"along = {line()}\n[boundary.base]").replace("regions", blocks)
    return Example(name, text, slab(tomllib.loads(text)), {"slab.msh": slab_mesh(cut=False)})
