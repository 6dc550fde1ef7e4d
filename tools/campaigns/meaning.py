"""Changes of meaning: a mesh and its model file are changed together, as other programs and hands change them.

Some say the same in other words (a group in several parts, another origin, fewer digits, another unit with its name),
and the answer stays what it was. Others say something else (a name is gone, a unit is not named), and a message must
name it. Files of these kinds came from users of other programs.
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from typing import Any

from tests.scenes.square_mesh import Group

from .sections import Point, Section
from .statics import Tree, scaled
from .unstable import Example

POINTS = ("start", "end", "point", "table", "along", "centre")  # keys of the model file that hold coordinates
LEVELS = {"left": 0, "right": 0, "below": 1, "above": 1}  # and one coordinate: x or y
UNITS = {"mm": 1e-3, "cm": 1e-2, "ft": 0.3048, "inch": 0.0254, "km": 1e3}
SHIFTS = (1e6, -1e6, 512345.0, 4501234.0)  # m
JITTER = 1e-3  # of the shortest side at a node
UNNAMED = ("gmsh:physical", "without a name", "in no rock")


@dataclass
class Meaning:
    """A model file and its mesh, as they are changed.

    Attributes
    ----------
    example : Example
        What they were.
    random : Random
        Of the changes.
    done : list of str
        What was done, for people.
    words : list of str
        A message that has one of them says what is otherwise; empty where the meaning is the same.
    stands : bool or None
        What statics says of the model as it is now.
    """

    example: Example
    random: Random
    tree: Tree = field(init=False)
    section: Section = field(init=False)
    done: list[str] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    stands: bool | None = False
    decimals: int | None = None

    def __post_init__(self) -> None:
        self.tree, self.section = self.example.filed, self.example.section

    @property
    def files(self) -> dict[str, bytes]:
        """The mesh, in one of two versions, and what else the model needs."""
        version = self.random.choice(("4.1", "2.2"))
        self.done.append(f"MSH {version}")
        section, decimals = self.section, self.decimals
        if decimals is not None:
            section = section.at(lambda p: (round(p[0], decimals), round(p[1], decimals)))
        return {"mesh.msh": section.written(version)}

    def group(self) -> tuple[int, Group] | None:
        """Return a group of more than one element, by chance, if there is any."""
        there = [(k, group) for k, group in enumerate(self.section.groups) if len(group[2]) > 1]
        return self.random.choice(there) if there else None

    def parts(self, group: Group) -> list[list[Any]]:
        """Return the elements of a group in two to four parts; surfaces keep their order, for blocks have numbers."""
        dimension, _, elements = group
        rows = list(elements)
        if dimension == 1 and self.random.random() < 0.5:
            self.random.shuffle(rows)
        count = self.random.randint(2, min(4, len(rows)))
        cuts = [0, *sorted(self.random.sample(range(1, len(rows)), count - 1)), len(rows)]
        return [rows[a:b] for a, b in itertools.pairwise(cuts)]


def changed(random: Random, example: Example) -> Meaning:
    """Return a model with one or two changes of meaning."""
    made = Meaning(example, random)
    for change in random.sample(CHANGES, random.choice((1, 1, 2))):
        change(made)
    return made


def _split(made: Meaning) -> None:
    """Put a group into several of its name: added up, the meaning is the same."""
    found = made.group()
    if found:
        number, (dimension, name, elements) = found
        parts = made.parts((dimension, name, elements))
        made.section = made.section.with_groups(number, *((dimension, name, part) for part in parts))
        made.done.append(f"{name} in {len(parts)} groups of its name")


def _split_apart(made: Meaning) -> None:
    """Put parts of a group into groups of other names: mapped by [groups] to one, or told by a message."""
    found = made.group()
    if found:
        number, (dimension, name, elements) = found
        parts = made.parts((dimension, name, elements))
        names = [f"{name}_{k}" if k else name for k in range(len(parts))]
        made.section = made.section.with_groups(
            number, *((dimension, new, part) for new, part in zip(names, parts, strict=True))
        )
        _say(made, {str(new): str(name) for new in names[1:]})
        made.done.append(f"{name} in groups {names}")


def _rename(made: Meaning) -> None:
    number = made.random.randrange(len(made.section.groups))
    dimension, name, elements = made.section.groups[number]
    new = made.random.choice((f"{name}2", str(name).partition(":")[2], str(name).upper(), f"{name} ", "curve 7"))
    made.section = made.section.with_groups(number, (dimension, new, elements))
    _say(made, {new: str(name)})
    made.done.append(f"{name} is called {new!r}")


def _say(made: Meaning, names: dict[str, str]) -> None:
    """Say in the model file what new names represent, half of the time; otherwise a message must name one."""
    if made.random.random() < 0.5:
        made.tree["groups"] = {**made.tree.get("groups", {}), **names}
    else:
        made.words += [*names, *names.values(), "in no rock"]


def _unname(made: Meaning) -> None:
    """Leave a group, or a part of it, without a name."""
    found = made.group()
    if found and made.random.random() < 0.6:
        number, (dimension, name, elements) = found
        parts = made.parts((dimension, name, elements))
        bare = made.random.randrange(len(parts))
        groups = [(dimension, None if k == bare else name, part) for k, part in enumerate(parts)]
        made.section = made.section.with_groups(number, *groups)
    else:
        number = made.random.randrange(len(made.section.groups))
        dimension, name, elements = made.section.groups[number]
        made.section = made.section.with_groups(number, (dimension, None, elements))
    made.words += [str(name), *UNNAMED]
    made.done.append(f"{name}: a part without a name, or all")


def _move(made: Meaning) -> None:
    """Move the mesh, and at times the model file's coordinates with it."""
    dx, dy = (made.random.choice((0.0, *SHIFTS)) for _ in range(2))
    made.section = made.section.at(lambda p: (p[0] + dx, p[1] + dy))
    held = sorted(_coordinates(made.tree))
    if not held or made.random.random() < 0.7:
        made.tree = _placed(made.tree, lambda p: (p[0] + dx, p[1] + dy))
    else:
        made.words += held
        made.stands = None
    made.done.append(f"moved by ({dx:g}, {dy:g})")


def _round(made: Meaning) -> None:
    made.decimals = made.random.randint(4, 9)
    made.done.append(f"coordinates to {made.decimals} decimals")


def _scale(made: Meaning) -> None:
    """Write the mesh in another unit, with the unit in the model file or without it."""
    unit = made.random.choice(list(UNITS))
    size = UNITS[unit]
    made.section = made.section.at(lambda p: (p[0] / size, p[1] / size))
    if made.decimals is not None:
        made.decimals += round(math.log10(size))
    if made.random.random() < 0.6:
        made.tree["mesh"]["unit"] = unit
        made.done.append(f"in {unit}, and says so")
        return
    made.words += ["unit", *_coordinates(made.tree)]
    made.done.append(f"in {unit}, and does not say so")
    if made.stands is False and made.random.random() < 0.7:
        made.tree = _placed(made.tree, lambda p: (p[0] / size, p[1] / size))
        made.stands = made.example.stands(scaled(made.example.tree, 1 / size))
    else:
        made.stands = None


def _jitter(made: Meaning) -> None:
    """Put nodes a thousandth of an element beside: inner ones, or those of joints, along the joint or across."""
    section, random = made.section, made.random
    kind = random.choice(("inner", "along", "across", "all"))
    moved: dict[int, Point] = {}
    for node, length in section.shortest.items():
        step = random.uniform(-JITTER, JITTER) * length
        if kind in ("along", "across") and node in section.directions:
            x, y = section.directions[node]
            moved[node] = (step * x, step * y) if kind == "along" else (-step * y, step * x)
        elif kind == "all" or (kind == "inner" and node in section.inner and node not in section.directions):
            moved[node] = (step, random.uniform(-JITTER, JITTER) * length)
    nodes = enumerate(section.nodes)
    made.section = Section(
        tuple((x + moved[k][0], y + moved[k][1]) if k in moved else (x, y) for k, (x, y) in nodes), section.groups
    )
    made.done.append(f"{len(moved)} nodes jittered: {kind}")


def _coordinates(tree: Any) -> set[str]:
    """Return the keys of a model file that hold coordinates."""
    if isinstance(tree, list):
        return set().union(*(_coordinates(part) for part in tree))
    if not isinstance(tree, dict):
        return set()
    held = {key for key in tree if key in (*POINTS, *LEVELS) and isinstance(tree[key], list | float | int)}
    return held.union(*(_coordinates(tree[key]) for key in tree if key not in held))


def _placed(tree: Any, place: Callable[[Point], Point]) -> Any:
    """Return a model file with its coordinates elsewhere."""
    if isinstance(tree, list):
        return [_placed(part, place) for part in tree]
    if not isinstance(tree, dict):
        return copy.deepcopy(tree)
    made: Tree = {}
    for key, value in tree.items():
        if key in POINTS and isinstance(value, list):
            made[key] = _points(value, place)
        elif key in LEVELS and isinstance(value, int | float):
            made[key] = place((value, value))[LEVELS[key]]
        else:
            made[key] = _placed(value, place)
    return made


def _points(value: list[Any], place: Callable[[Point], Point]) -> list[Any]:
    if value and isinstance(value[0], list):
        return [_points(part, place) for part in value]
    return list(place((value[0], value[1])))


CHANGES: tuple[Callable[[Meaning], None], ...] = (
    _split,
    _split_apart,
    _rename,
    _unname,
    _move,
    _round,
    _scale,
    _jitter,
)
