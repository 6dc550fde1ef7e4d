"""Calls from Python: one or two arguments of a good call are exchanged for values of any kind."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from tests.scenes.good_calls import flat_blocks, good_calls

from ..inputs import Input
from ..values import spoil
from .models import look_at

ADDRESS = re.compile(r" at 0x[0-9a-f]+")  # in the texts of objects; another in every process
USED = 0.25  # of the things that were accepted, so many are put into a model
RUNS = 0.08  # and of those models so many are run


def draw(random: Random, folder: Path) -> Input:
    """Return a call with one to three changed arguments."""
    name, function, good, part = random.choice(good_calls())
    arguments = dict(good)
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        key = random.choice(list(arguments))
        arguments[key] = spoil(random, arguments[key])
    told = ", ".join(
        f"{key}={value!r}"[:500] if value is not good[key] else f"{key}=..." for key, value in arguments.items()
    )
    used, runs = random.random() < USED, random.random() < RUNS
    return Input(
        f"{name}({ADDRESS.sub('', told)})"
        + (f", in a model as {part}" if used and part else "")
        + (", run" if used and runs else ""),
        lambda: call(function, arguments, part if used else "", runs),
    )


def call(function: Callable[..., Any], arguments: dict[str, Any], part: str, runs: bool) -> None:
    """Call a function, put what it makes into a model where it has a part there, and at times run that."""
    made = function(**arguments)
    if not part:
        return
    model, options = _in_model(made, part)
    if runs:
        import bsm_mesh as bsm

        look_at(bsm.run(model, options or bsm.Options(max_steps=60)))


def _in_model(made: Any, part: str) -> tuple[Any, Any]:
    """Return the small model with what was made in the place of its own, and the options."""
    model = _model()
    if part == "options":
        return model, made
    if part == "model":
        return made, None
    if part == "law":
        import bsm_mesh as bsm

        return model.replace(joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=made)]), None
    if part == "filling":
        import bsm_mesh as bsm

        return model.replace(joints=[bsm.Joint("J1", filling=made, law=bsm.MohrCoulomb(friction=30))]), None
    alone = ("blocks", "in_situ", "water")
    return model.replace(**{part: made if part in alone or isinstance(made, list) else [made]}), None


@cache
def _model() -> Any:
    import bsm_mesh as bsm

    return bsm.Model(
        blocks=bsm.Blocks(**flat_blocks()),
        rocks=[bsm.Rock("gneiss", unit_weight=26e3)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
        default_joint="J1",
        supports=[bsm.Fixed(blocks=[0, 1])],
    )
