"""A random model of a family: its scene, its parameters, and what is known of it beforehand."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.campaign.scene import Scene

Value = float | int | str
Parameters = Mapping[str, Value]


@dataclass(frozen=True, kw_only=True)
class Expected:
    """The answer of a closed form.

    Attributes
    ----------
    form : str
        Its name.
    margin : float
        Distance to the exact limit, over the limit; positive where the blocks rest, negative where they must move.
    tolerance : float
        Margins below it are not judged: there the springs, which the form leaves out, decide.
    moved : float or None
        How far the blocks move to their rest, over the size of a block; None: the form does not say.
    moved_within : float
        By how much of a block's size, beside a twentieth of the movement, the springs may make it another.
    """

    form: str
    margin: float
    tolerance: float
    moved: float | None = None
    moved_within: float = 0.0

    @property
    def rests(self) -> bool | None:
        """Whether the blocks rest; None: too near to the limit to say."""
        return None if abs(self.margin) < self.tolerance else self.margin > 0


@dataclass(frozen=True, kw_only=True)
class Draft:
    """What a family makes of random numbers."""

    scene: Scene
    parameters: Parameters
    expected: Expected | None = None


Draw = Callable[[np.random.Generator], Draft]


@dataclass(frozen=True, kw_only=True)
class Family:
    """Models of one kind.

    Attributes
    ----------
    name, title : str
        Short, and what it is.
    draw : callable
        ``generator -> Draft``.
    models : int
        How many a whole campaign has.
    """

    name: str
    title: str
    draw: Draw
    models: int


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A model of a family: the same family and seed always make the same one."""

    family: str
    seed: int
    scene: Scene
    parameters: Parameters
    expected: Expected | None


def generator_of(purpose: str, family: str, seed: int) -> np.random.Generator:
    """Return random numbers that belong to a model and a purpose alone."""
    return np.random.default_rng([zlib.crc32(purpose.encode()), zlib.crc32(family.encode()), seed])


def trial_of(family: Family, seed: int) -> Trial:
    """Return the model of a family with a seed."""
    draft = family.draw(generator_of("model", family.name, seed))
    parameters = {
        key: round(value, 6) if isinstance(value, float) else value for key, value in draft.parameters.items()
    }
    return Trial(family=family.name, seed=seed, scene=draft.scene, parameters=parameters, expected=draft.expected)
