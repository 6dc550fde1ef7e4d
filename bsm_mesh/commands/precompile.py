"""Compile the kernels of usual runs before they are needed: ``python -m bsm_mesh.commands.precompile``.

`kernels.txt` lists them with the types of their arguments (``python -m tools.kernels`` writes it), the most expensive
ones first. They are compiled for `bsm_mesh.compiled.PORTABLE` where this machine runs such code, by several processes,
into the folder that all ways of calling use. A kernel that the list leaves out is compiled when it is first called.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import re
import sys
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from importlib import import_module
from pathlib import Path
from typing import Any

import numba

import bsm_mesh
from bsm_mesh import compiled, kernel_files
from bsm_mesh.files import remove
from bsm_mesh.solving import SILENCE
from bsm_mesh.text.progress import Progress

LIST = Path(__file__).parents[1] / "kernels.txt"
MAX_PROCESSES = 4
KEPT_FOR = 7 * 86400.0  # s; former versions of kernels, for who goes back to former sources


def listed() -> list[str]:
    """Return the lines of the list: a kernel and the types of its arguments each."""
    return LIST.read_text(encoding="utf-8").splitlines()


def kernel_of(line: str) -> tuple[Any, tuple[Any, ...]]:
    """Return a kernel and the types of its arguments."""
    name, _, types = line.partition(" ")
    module, _, function = f"bsm_mesh.{name}".rpartition(".")
    kernel = getattr(import_module(module), function)
    for named in re.findall(r"(bsm_mesh[.\w]+)\.[A-Z]", types):  # modules of records and named tuples
        import_module(named)
    names = {**vars(numba.types), "bool": numba.types.boolean, "bsm_mesh": bsm_mesh, "numba": numba}
    return kernel, eval(types, {"__builtins__": {}}, names)


def name_of(kernel: Any, types: tuple[Any, ...]) -> str:
    """Return the name of a kernel's file, as others can use it where this machine can make it."""
    name: str = kernel._cache.name(types, compiled.levels()[0])
    return name


def make(line: str) -> None:
    """Compile a kernel of the list, unless it is there."""
    kernel, types = kernel_of(line)
    kernel.compile(types)


def main() -> int:
    """Compile missing kernels, report progress, and remove former versions."""
    parser = argparse.ArgumentParser(prog="python -m bsm_mesh.commands.precompile", description=__doc__)
    parser.add_argument("--only", action="store_true", help="remove all other kernels, as for a wheel")
    given, began = parser.parse_args(), time.time()
    names = {line: name_of(*kernel_of(line)) for line in listed()}
    missing = [line for line, name in names.items() if not kernel_files.is_kept(name)]
    if missing:
        with Progress(total=len(missing)) as progress:
            for done in compile_all(missing):
                progress.often(f"compiling kernels, once on this machine: {done} of {len(missing)}", done)
    remove_former(set(names.values()), float("inf") if given.only else began - KEPT_FOR)
    return 0


def compile_all(lines: list[str]) -> Iterator[int]:
    """Yield how many of these kernels are compiled, at the start, at each one and every few seconds."""
    if len(compiled.levels()) > 1:  # set before Numba is imported there
        os.environ["NUMBA_CPU_NAME"] = compiled.PORTABLE
        os.environ["NUMBA_CPU_FEATURES"] = ",".join(f"+{name}" for name in compiled.PORTABLE_FEATURES)
    count = min(MAX_PROCESSES, len(lines), os.cpu_count() or 1)
    yield 0
    with ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn")) as processes:
        left = {processes.submit(make, line) for line in lines}
        while left:
            done, left = wait(left, timeout=SILENCE, return_when=FIRST_COMPLETED)
            for one in done:
                one.result()
            yield len(lines) - len(left)


def remove_former(names: set[str], before: float) -> None:
    """Remove the files of kernels that are not listed and were made before a time."""
    place = kernel_files.places().write
    for path in () if place is None else (place / compiled.VERSIONS).glob("*.nbc"):
        if f"{compiled.VERSIONS}/{path.name}" not in names and path.stat().st_mtime < before:
            remove(path)


if __name__ == "__main__":
    sys.exit(main())
