"""Write the list of kernels that usual runs call (`bsm_mesh/kernels.txt`): ``python -m tools.kernels``.

Starters, examples and a few commands are run; each kernel that Python calls is listed with the types of its arguments,
the most expensive ones first.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import pkgutil
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numba
import numpy as np
from numba.core import event, types
from numba.core.dispatcher import Dispatcher

import bsm_mesh
from bsm_mesh.commands import cli, precompile
from bsm_mesh.commands.starters import starter_names
from bsm_mesh.files import write_text
from bsm_mesh.solve.algebra import pardiso
from docs.code_blocks import blocks_of, files_of, python_blocks

ROOT = Path(__file__).parents[1]
SHAKEN = "docs/zones_shaken.md"
SOLVERS = ("02_pushed_block/model", "tilted_wall/tilt_28", "04_bolted_opening/model")  # by Wang's scheme too


class Seconds(event.Listener):  # type: ignore[misc]
    """Processor seconds that each kernel took to be compiled, with those that it calls."""

    def __init__(self) -> None:
        self.taken: dict[tuple[Any, Any], float] = {}
        self._began: list[float] = []
        event.register("numba:compile", self)

    def on_start(self, event: Any) -> None:
        """Remember when it began."""
        self._began.append(time.process_time())

    def on_end(self, event: Any) -> None:
        """Note how long it took."""
        self.taken[event.data["dispatcher"], event.data["args"]] = time.process_time() - self._began.pop()


def kernels() -> list[tuple[str, Any]]:
    """Return name and kernel of all kernels of the package."""
    for module in pkgutil.walk_packages(bsm_mesh.__path__, "bsm_mesh."):
        if not any(part in module.name for part in ("__main__", "starters", "geometries", "converters", "mpi")):
            importlib.import_module(module.name)
    found = {
        id(value): (f"{value.py_func.__module__}.{value.py_func.__name__}", value)
        for name, module in sorted(sys.modules.items())
        if name.startswith("bsm_mesh")
        for value in vars(module).values()
        if isinstance(value, Dispatcher)
    }
    return sorted(found.values(), key=lambda one: one[0])


def records() -> dict[str, str]:
    """Return the names of the package's types of records, by Numba's text for them."""
    return {
        repr(numba.from_dtype(value)): f"{name}.{key}"
        for name, module in sorted(sys.modules.items(), reverse=True)
        if name.startswith("bsm_mesh")
        for key, value in vars(module).items()
        if isinstance(value, np.dtype) and value.names
    }


def text(kind: Any, names: dict[str, str]) -> str:
    """Return the type of an argument as `precompile` reads it."""
    if isinstance(kind, types.Record):
        return f"numba.from_dtype({names[repr(kind)]})"
    if isinstance(kind, types.Array):
        ends = "" if kind.mutable else ", readonly=True"
        ends += "" if kind.aligned else ", aligned=False"
        return f"Array({text(kind.dtype, names)}, {kind.ndim}, {kind.layout!r}{ends})"
    if isinstance(kind, types.BaseTuple):
        inner = "".join(f"{text(one, names)}, " for one in kind)
        named = isinstance(kind, types.BaseNamedTuple)
        cls = f", {kind.instance_class.__module__}.{kind.instance_class.__qualname__}" if named else ""
        return f"BaseTuple.from_types(({inner}){cls})"
    return repr(kind)


def run_all(folder: Path) -> None:
    """Run what users run, and with the solver that they have: MKL is there for developers alone."""
    pardiso.is_available = lambda: False
    for name in starter_names():
        command("new", name, str(folder / name))
        command("run", str(folder / name / "model.toml"))
    bsm_mesh.Results.load(folder / "roof/out/model").plot("model")
    command("safety", str(folder / "wall/model.toml"))
    command("joint-test", str(folder / "cavern/model.toml"), "--joint", "J1", "-o", str(folder / "tested"))
    for path in sorted((ROOT / "examples").glob("*/*.toml")):
        command("run", str(path), "-o", str(folder / "examples" / path.parent.name / path.stem))
    block = folder / "block.toml"  # of three dimensions: it slides in its last stage
    write_text(block, files_of((ROOT / "docs/three_dimensions.md").read_text(encoding="utf-8"))[block.name])
    command("run", str(block))
    (page,) = (each for each in blocks_of((ROOT / SHAKEN).read_text(encoding="utf-8")) if each.language == "python")
    exec(page.text, {})  # zones that are shaken
    for name in SOLVERS:
        model = bsm_mesh.load(ROOT / f"examples/{name}.toml")
        bsm_mesh.run(model, bsm_mesh.Options(scheme="wang"))
    with contextlib.chdir(folder):
        command("new", "slope", "s")
        for block in python_blocks():
            with contextlib.suppress(bsm_mesh.ModelError):
                exec(block, {})


def command(*words: str) -> None:
    """Run a command; what ends in a message is left out."""
    with contextlib.suppress(SystemExit):
        cli.main([*words, *(["--quiet"] if words[0] == "run" else [])])


def main() -> None:
    """Run twice: a kernel that is compiled brings those that it calls, one that is read does not."""
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-m", "tools.kernels", "once"]
        compiled, read = (
            json.loads(
                subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE).stdout.splitlines()[-1]
            )
            for _ in range(2)
        )
    order = sorted(read, key=lambda line: (-round(compiled[line], 1), line))
    write_text(precompile.LIST, "".join(f"{line}\n" for line in order))
    print(f"{len(order)} kernels and {len(compiled) - len(order)} that only they call")


def once() -> None:
    """Run everything and print the kernels with the seconds that it took to compile them."""
    seconds = Seconds()
    with TemporaryDirectory() as folder:
        run_all(Path(folder))
    found, names = kernels(), records()
    lines = {
        f"{name.removeprefix('bsm_mesh.')} ({''.join(f'{text(one, names)}, ' for one in args)})": (kernel, args)
        for name, kernel in found
        for args in kernel.overloads
    }
    print(json.dumps({line: seconds.taken.get(key, 0.0) for line, key in lines.items()}))


if __name__ == "__main__":
    once() if sys.argv[1:] else main()
