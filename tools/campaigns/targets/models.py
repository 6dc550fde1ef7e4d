"""Model files: trees of keys and values changed, then at times the text as well."""

from __future__ import annotations

import tomllib
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import tomli_w

from tests.scenes.model_folders import BOLT_TABLE
from tests.scenes.more_models import PLANE, SPACE
from tests.scenes.small_models import MESH, MODELS

from ..inputs import Input, demand_finite
from ..mutations import mutate, mutate_tree
from ..seeds import models as models_of_others

_OURS: list[tuple[dict[str, Any], dict[str, bytes]]] = [(tree, {}) for tree in MODELS]
GIVEN = 5 * (_OURS + PLANE + SPACE) + models_of_others(MODELS[0])
RUNS = 0.1  # of the models that load, so many are run as well


def draw(random: Random, folder: Path) -> Input:
    """Return a model file with a few changes, to be loaded and at times run."""
    given, beside = random.choice(GIVEN)
    tree = mutate_tree(random, given) if random.random() < 0.85 else given
    data = written(tree)
    if tree is given or random.random() < 0.15:
        data = mutate(random, data, binary=False)
    runs = random.random() < RUNS
    return Input(
        told="bsm.load('model.toml')" + (", bsm.run of it" if runs else ""),
        act=lambda: _load(runs),
        files={"model.toml": data, "mesh.msh": MESH, "bolts.csv": BOLT_TABLE, **beside},
    )


def written(tree: dict[str, Any]) -> bytes:
    """Return a tree as TOML; what TOML cannot hold is left out."""
    try:
        return tomli_w.dumps(tree).encode("utf-8", "surrogatepass")
    except (TypeError, ValueError, AttributeError):
        return tomli_w.dumps({str(key): value for key, value in tree.items() if _fits({"x": value})}).encode()


def _fits(tree: dict[str, Any]) -> bool:
    try:
        tomllib.loads(tomli_w.dumps(tree))
    except (TypeError, ValueError, AttributeError):
        return False
    return True


def _load(runs: bool) -> None:
    import bsm_mesh as bsm

    model = bsm.load("model.toml")
    demand_finite(model.blocks.vertices, "a corner of a model file's block")
    demand_finite(model.weights, "a weight of a model file's block")
    if runs:
        look_at(bsm.run(model, bsm.Options(max_steps=60)))


def look_at(results: Any) -> None:
    """Demand finite numbers of results that have a verdict."""
    for stage in results.stages:
        if stage.status.value == "stable":
            for name in ("displacement", "reactions"):
                demand_finite(getattr(stage, name), f"{name} of a stable stage")
            open_ones = np.isnan(stage.stress).all(axis=(1, 2))  # of fixed blocks
            demand_finite(stage.stress[~open_ones], "stress of a stable stage")
    results.check()
