"""Which files of a results folder bsm-mesh wrote: those that the summary lists, and those that the marker names.

A folder may come from anywhere. Writing, moving or removing by a name in it goes through `place_in`: no link in
the folder is followed to another place.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path, PurePath
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.files import is_draft, keep, make_folder, remove, remove_empty, remove_tree
from bsm_mesh.modelfile.reach import BESIDE

MARKER, SUMMARY, CHECKPOINT = ".bsm-mesh-results", "summary.json", ".bsm-mesh-checkpoint.npz"
HEADER = (
    "# bsm-mesh writes this folder. The next run into it replaces the files that summary.json lists\n"
    "# and those named here; all other files stay.\n"
)
OF_A_RUN = re.compile(
    r"(blocks|contacts|joints|supports|water|flow|bolts|zones)(\.pvd|_\d{4,}(_\d{5,})?\.vtu)|(blocks|bolts|contacts|flow|joints|supports)\.(csv|parquet)|history(_[\w.+-]+)?\.csv|energy\.csv|time_history\.csv|shaken_blocks\.csv|summary\.json|model\.toml"
    r"|certificate(\.json|_\d{4,}\.npz)|blocks_given\.vtu"
)

OF_A_STEP = re.compile(r"(blocks|contacts|joints|supports|bolts)_\d{4,}_\d{5,}\.vtu")


def read_json(path: Path) -> dict[str, Any]:
    """Return the content of a JSON file; nothing where it is none."""
    try:
        told = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    except (OSError, ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def run_number(folder: Path) -> int | None:
    """Return the how-manieth run into its place the finished results in a folder are; None where there are none."""
    told = read_json(folder / SUMMARY)
    number = told.get("run")
    return number if isinstance(number, int) and told.get("status") != "unfinished" else None


def own_files(folder: Path) -> set[str]:
    """Return the names of what bsm-mesh wrote into a folder: a run, and the commands that add to it."""
    listed = read_json(folder / SUMMARY).get("files")
    names = set(listed) if isinstance(listed, dict) else set()
    with suppress(OSError):
        marker = folder / MARKER
        lines = marker.read_text(encoding="utf-8", errors="replace").splitlines() if has_marker(folder) else []
        names.update(line for line in lines if line and not line.startswith("#"))
    if folder.name.endswith(BESIDE) and folder.is_dir():  # a killed run has not listed what it wrote last
        names.update(entry.name for entry in folder.iterdir() if OF_A_RUN.fullmatch(entry.name))
    inside = {name for name in names if is_inside(name) and link_on_the_way(folder, name) is None}
    return inside | {MARKER, SUMMARY, CHECKPOINT}


def has_marker(folder: Path) -> bool:
    """Return whether a folder has the marker of a run: a file of its own, no link to one."""
    return (folder / MARKER).is_file() and not (folder / MARKER).is_symlink()


def is_left_by_a_run(folder: Path) -> bool:
    """Return whether a folder next to results is one that a run made, or is not there; a link is none.

    The marker is the first file of a run and the last one to go: a killed run leaves it, or an empty folder.
    """
    if not os.path.lexists(folder):
        return True
    if folder.is_symlink() or not folder.is_dir():
        return False
    return has_marker(folder) or all(is_draft(entry.name) for entry in os.scandir(folder))


def is_inside(name: str) -> bool:
    """Return whether a listed name is of a file in its folder: lists are files too, and may come from anywhere."""
    parts = PurePath(name).parts
    return bool(parts) and not PurePath(name).is_absolute() and ".." not in parts and "\0" not in name


def link_on_the_way(folder: Path, name: str, *, itself: bool = False) -> Path | None:
    """Return the link in a folder that a name in it leads through, `itself` counted if it is to be; None without one.

    A file that is a link is replaced or removed as a link. A folder, and a file that is added to, would be followed.
    """
    steps = [folder / part for part in reversed(PurePath(name).parents[:-1])]
    return next((step for step in (*steps, *([folder / name] if itself else [])) if step.is_symlink()), None)


def place_in(folder: Path, name: str, *, itself: bool = False) -> Path:
    """Return the path of a name in a folder, to be written, moved or removed.

    Raises
    ------
    ModelError
        If the name, or a link in the folder, leads elsewhere.
    """
    if not is_inside(name):
        raise ModelError(f"{name!r} leads out of {folder}; give a name in it")
    if link := link_on_the_way(folder, name, itself=itself):
        raise ModelError(f"{link} is a link to another place, and files would be written there; remove the link")
    return folder / name


def foreign_files(folder: Path) -> list[str]:
    """Return the names of files, and of whole folders, that bsm-mesh did not write; drafts are its own."""
    own = own_files(folder)

    def look(place: Path, above: str) -> Iterator[str]:
        for entry in sorted(os.scandir(place), key=lambda entry: entry.name):
            name = f"{above}{entry.name}"
            if entry.is_dir(follow_symlinks=False):
                if any(known.startswith(f"{name}/") for known in own):
                    yield from look(place / entry.name, f"{name}/")
                else:
                    yield name
            elif name not in own and not is_draft(entry.name):
                yield name

    return list(look(folder, "")) if folder.is_dir() else []


def is_lasting(name: str) -> bool:
    """Return whether a file of a run is written once: a grid, and no table or list that grows."""
    return name.endswith(".vtu") and OF_A_RUN.fullmatch(name) is not None


def retire(folder: Path, heir: Path) -> None:
    """Remove a folder that another one replaces; files of others are moved to the other one first."""
    for name in foreign_files(folder):
        keep_in(folder, heir, name)
    remove_tree(folder, last=MARKER)


def clear(folder: Path) -> None:
    """Remove what bsm-mesh wrote from a folder, and the folder if nothing else is in it."""
    if not foreign_files(folder):
        remove_tree(folder, last=MARKER)
        return
    for name in sorted(own_files(folder)):
        remove(folder / name)
    remove_empty(sorted({(folder / name).parent for name in own_files(folder)} - {folder}))


def tidy(folder: Path, kept: Collection[str] = ()) -> None:
    """Remove drafts, and files of a stage that was not finished, from the folder of a run that is over.

    Files that are `kept` by their names stay: a checkpoint needs them.
    """
    lists = [path.read_text(encoding="utf-8", errors="replace") for path in folder.glob("*.pvd")]
    listed = read_json(folder / SUMMARY).get("files", {})
    for path in sorted(folder.iterdir()):
        mine = OF_A_RUN.fullmatch(path.name) and path.suffix in (".vtu", ".npz")
        named = path.name in kept or path.name in listed or any(f'"{path.name}"' in text for text in lists)
        if is_draft(path.name) or (mine and not named):
            remove(path)


def is_same(one: Path, other: Path) -> bool:
    """Return whether two names are of one file."""
    return os.path.exists(one) and os.path.exists(other) and os.path.samefile(one, other)


def keep_in(source: Path, target: Path, name: str) -> None:
    """Give a file of one folder to another one, unless that has one of its name."""
    place = place_in(target, name)
    if not os.path.lexists(place):
        make_folder(place.parent)
        keep(place_in(source, name), place)
