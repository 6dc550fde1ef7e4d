"""Permissions of a model file: run a geometry script and name any path, or neither (``--no-scripts``).

There are two states and no sandbox. A model file may do anything that its user may, or it runs no script and reads only
files in its folder. Scripts are the default, since geometries are made by them.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from bsm_mesh.errors import ModelError

BESIDE = (".running", ".interrupted", ".former")  # endings of folders that a run keeps beside its results
CURE = "if you trust the model file, leave out --no-scripts (in Python: scripts=False)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """How far a model file reaches.

    Attributes
    ----------
    folder : Path
        That of the model file; its paths are relative to it.
    scripts : bool
        Whether it may run a geometry script and name any path. If not, no code of its own is run, and nothing is read
        or written outside its folder, links followed.
    """

    folder: Path
    scripts: bool = True

    def path(self, name: str, key: str) -> Path:
        """Return the path that a key names.

        Raises
        ------
        ModelError
            If it may not be named.
        """
        path = self.folder / name
        if not self.scripts and not _lies_in(path, self.folder):
            raise ModelError(f'{key} = "{name}" leads out of the folder of the model file; put it there, or, {CURE}')
        return path

    def mesh(self, name: str) -> Path:
        """Return the path of the mesh file; without scripts it may not name further files either."""
        path = self.path(name, "[mesh] file")
        if not self.scripts:
            from bsm_mesh.converters.meshes.files import may_name_others

            if may_name_others(path):
                raise ModelError(
                    f'[mesh] file = "{name}": a mesh of this format may name further files; save it as .msh or .vtu, '
                    f"or, {CURE}"
                )
        return path

    def geometry(self, name: str) -> str | Path:
        """Return the name of a built-in geometry, or the path of a script."""
        if not self.scripts and not name.replace("-", "_").isidentifier():  # else it is a name of ours, or none
            raise ModelError(f'[mesh] geometry = "{name}" is a script, which is not run; {CURE}')
        return self.folder / name if name.endswith(".py") else name

    def output(self, name: str, key: str = "[output] folder") -> Path:
        """Return the folder for results; without scripts no link in it, or in a run's other folders, leads away."""
        folder = self.path(name, key)
        if not self.scripts:
            beside = [folder.with_name(f"{folder.name}{ending}") for ending in BESIDE] if folder.name else []
            for place in (folder, *(place for place in beside if not place.is_symlink())):  # links: `ResultsFolder`
                self._refuse_links_away(place, f'{key} = "{name}"', "it" if place == folder else place.name)
        return folder

    def _refuse_links_away(self, place: Path, given: str, called: str) -> None:
        for entry in place.rglob("*"):
            if not (_lies_in(entry, self.folder) or _lies_in(entry, place)):
                link = entry.relative_to(place)
                raise ModelError(f"{given}: the link {link} in {called} leads elsewhere; remove it, or, {CURE}")


def _lies_in(path: Path, folder: Path) -> bool:
    inside, around = os.path.realpath(path), os.path.realpath(folder)
    return Path(inside).is_relative_to(around)
