"""The folders ``geometries/`` and ``converters/`` of a checkout, imported by their own names.

Links in ``bsm_mesh/`` make these folders the packages `bsm_mesh.geometries` and `bsm_mesh.converters`. In a checkout
``import geometries`` finds the folder as well, and has to give the very same modules. If they were loaded twice, an
error raised in one would not be caught by its name in the other. In an installed wheel this module is never used.

Links, and not `package-dir` for the two names: that works in an installed package only, and no type checker reads it.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType


class _PartOfPackage(MetaPathFinder, Loader):
    """Answers for every module below `geometries` (or `converters`) with the one below `bsm_mesh.geometries`."""

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname.startswith(f"{self.folder}.") else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = import_module(f"bsm_mesh.{spec.name}")
        spec.loader_state = module.__spec__  # the import system is about to put `spec` in its place
        return module

    def exec_module(self, module: ModuleType) -> None:
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


def hand_over(folder: str) -> None:
    """Let the name `folder`, which is being imported, mean the package `bsm_mesh.<folder>` from now on."""
    sys.meta_path.insert(0, _PartOfPackage(folder))
    sys.modules[folder] = import_module(f"bsm_mesh.{folder}")
