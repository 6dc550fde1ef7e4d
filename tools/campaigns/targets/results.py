"""Folders of results: a file damaged, missing, or that of another run."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path
from random import Random
from typing import Any

from tests.scenes.model_folders import BOLT_TABLE
from tests.scenes.small_models import MESH, model

from ..inputs import AcceptedError, Input, without_numbers
from ..mutations import mutate, mutate_tree
from .models import written

FORGED = 0.4  # of the changed folders, so many have right checksums
RUNS = (0, 2, 3)  # of small.MODELS: plain, staged with water, bolted


def prepare(folder: Path) -> None:
    """Run small models by the command, a folder of results each."""
    from bsm_mesh.commands.cli import main

    for number in RUNS:
        there = folder / f"run{number}"
        if (there / "out" / "summary.json").exists():
            continue
        there.mkdir(parents=True, exist_ok=True)
        (there / "mesh.msh").write_bytes(MESH)
        (there / "bolts.csv").write_bytes(BOLT_TABLE)
        (there / "model.toml").write_bytes(written(model(number)))
        try:
            main(["run", str(there / "model.toml"), "-o", str(there / "out"), "--json"])
        except SystemExit as leaving:
            if leaving.code:
                raise RuntimeError(
                    f"good model {number} is refused: python -m bsm_mesh.commands.cli run {there}"
                ) from None


_KNOWN: dict[Path, list[tuple[dict[str, bytes], str]]] = {}


def good(folder: Path) -> list[tuple[dict[str, bytes], str]]:
    """Return the files of every good folder, and the digest of what they say."""
    if folder not in _KNOWN:
        import bsm_mesh as bsm

        found = []
        for number in RUNS:
            out = folder / f"run{number}" / "out"
            files = {str(p.relative_to(out)): p.read_bytes() for p in sorted(out.rglob("*")) if p.is_file()}
            found.append((files, digest(bsm.Results.load(out))))
        _KNOWN[folder] = found
    return _KNOWN[folder]


def digest(results: Any) -> str:
    """Return a text that is the same for results that say the same."""
    import numpy as np

    told = hashlib.sha256()

    def add(value: Any) -> None:
        if isinstance(value, np.ndarray):
            told.update(repr((value.dtype.kind, value.shape)).encode() + np.ascontiguousarray(value).tobytes())
        elif isinstance(value, tuple | list):
            told.update(str(len(value)).encode())
            for part in value:
                add(part)
        elif hasattr(value, "__dataclass_fields__"):
            for name in value.__dataclass_fields__:
                add(getattr(value, name))
        else:
            told.update(repr(value).encode())

    add(results)
    return told.hexdigest()


def draw(random: Random, folder: Path) -> Input:
    """Return a folder of results with a file changed, gone, or taken from another folder."""
    there = good(folder)
    files, says = random.choice(there)
    changed = dict(files)
    name = random.choice([name for name in files if name != "model.toml" or random.random() < 0.3])
    kind = random.random()
    if kind < 0.08:
        del changed[name]
    elif kind < 0.14:
        changed[name] = random.choice(there)[0].get(name, b"")
    elif kind < 0.2:
        changed[name] = files[random.choice(list(files))]
    elif name.endswith(".json") and kind < 0.75:
        changed[name] = json.dumps(mutate_tree(random, json.loads(files[name]))).encode()
    else:
        changed[name] = mutate(random, files[name])
    if "summary.json" in changed and random.random() < FORGED:
        with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return Input(f"Results.load('out'), {name} forged", _look, _placed(forged(changed, name)))
    return Input(
        f"Results.load('out'), with {name} changed",
        lambda: _load(says, name),
        _placed(changed),
    )


def _placed(files: dict[str, bytes]) -> dict[str, bytes]:
    return {f"out/{name}": data for name, data in files.items()}


def forged(files: dict[str, bytes], name: str) -> dict[str, bytes]:
    """Return results with right checksums of a changed file and of the summary, as somebody would make them."""
    from bsm_mesh.folder.summary import _checksum

    told = json.loads(files["summary.json"])
    told.pop("checksum", None)
    if name in files and name in told["files"]:
        told["files"][name].update(bytes=len(files[name]), sha256=hashlib.sha256(files[name]).hexdigest())
    return {**files, "summary.json": json.dumps({**told, "checksum": _checksum(told)}).encode()}


def _look() -> None:
    import bsm_mesh as bsm

    bsm.Results.load("out").check()


def _load(says: str, name: str) -> None:
    import bsm_mesh as bsm

    results = bsm.Results.load("out")
    results.check()
    if digest(results) != says:
        raise AcceptedError(f"results: what changed in {without_numbers(name)} is not noticed")
