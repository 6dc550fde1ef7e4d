"""Starters with other values, for families of random models."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from bsm_mesh.commands.starters import write_starter
from bsm_mesh.modelfile.variation import Variation


@contextmanager
def starter(name: str, change: Callable[[str], str] = str) -> Iterator[Variation]:
    """Give the model file of a starter, whose text is changed first; what commands print meanwhile is dropped."""
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        write_starter(name, Path(folder) / name)
        path = Path(folder) / name / "model.toml"
        path.write_text(change(path.read_text("utf-8")), "utf-8")
        yield Variation(path)
