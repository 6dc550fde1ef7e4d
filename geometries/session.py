"""Gmsh opened and closed in one place: ``with gmsh_session("name") as gmsh: ...; write_mesh(path)``.

Gmsh is global state. A session gives a script its own model and the options below, and restores
the former state, also when the script raises. Importing this module needs no Gmsh.

The same parameters give the same file, byte for byte. No configuration is read, Gmsh has one thread, and every option
of a plane mesh is set. `write_mesh` refuses a mesh that has lost a group: Gmsh drops groups of entities that are
fragmented after they were named.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from bsm_mesh.files import whole_file
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.physical_groups import parse_group_name
from bsm_mesh.geometries.reading import as_path

SYSTEM_LIBRARIES = ("libglu1-mesa", "libgl1", "libgomp1", "libxcursor1", "libxft2", "libxinerama1")

# What a mesh depends on is pinned, so that the same parameters give the same file on every machine,
# whatever a caller that uses Gmsh itself has set.
BASE_OPTIONS: Mapping[str, float] = {
    "General.Terminal": 0,
    "General.AbortOnError": 2,  # every error of Gmsh is raised
    "General.NumThreads": 1,
    "Geometry.Tolerance": 1e-8,
    "Mesh.MshFileVersion": 4.1,  # MSH 2.2 repeats the elements of a surface in two groups
    "Mesh.Binary": 1,
    "Mesh.SaveAll": 0,
    "Mesh.SaveParametric": 0,
    "Mesh.ScalingFactor": 1,
    "Mesh.Renumber": 1,
    "Mesh.FirstNodeTag": 1,
    "Mesh.FirstElementTag": 1,
    "Mesh.MaxNumThreads1D": 0,
    "Mesh.MaxNumThreads2D": 0,
    "Mesh.RandomSeed": 1,
    "Mesh.RandomFactor": 1e-9,
    "Mesh.Algorithm": 6,  # Frontal-Delaunay
    "Mesh.ElementOrder": 1,
    "Mesh.SecondOrderLinear": 0,
    "Mesh.SecondOrderIncomplete": 0,
    "Mesh.HighOrderOptimize": 0,
    "Mesh.MeshSizeFactor": 1,
    "Mesh.MeshSizeMin": 0,
    "Mesh.MeshSizeMax": 1e22,
    "Mesh.MeshSizeExtendFromBoundary": 1,
    "Mesh.MeshSizeFromPoints": 1,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.RecombineAll": 0,
    "Mesh.RecombinationAlgorithm": 1,
    "Mesh.RecombineOptimizeTopology": 5,
    "Mesh.RecombineNodeRepositioning": 1,
    "Mesh.SubdivisionAlgorithm": 0,
    "Mesh.TransfiniteTri": 0,
    "Mesh.FlexibleTransfinite": 0,
    "Mesh.Smoothing": 1,
    "Mesh.Optimize": 1,
}

ENTITIES = ("point", "curve", "surface", "volume")  # by their dimension
_LAST = "name groups last, after fragmenting and synchronising"
_ONE_AT_A_TIME = threading.RLock()  # Gmsh has one state for the whole process
_NUMBERS = itertools.count(1)
_NAMED: list[dict[tuple[int, int], int]] = []  # a session: how many curves or surfaces each group was given


def load_gmsh() -> ModuleType:
    """Return the module gmsh, or raise `GeometryError` that says what to install."""
    try:
        import gmsh
    except OSError as fault:  # the shared library was found, what it needs was not
        raise GeometryError(
            f"Gmsh cannot start: {fault}; it needs system libraries, on Debian or Ubuntu: "
            f"apt-get install {' '.join(SYSTEM_LIBRARIES)}"
        ) from fault
    except ImportError as fault:
        raise GeometryError(f"Gmsh is not installed ({fault}); to build a mesh: pip install gmsh") from fault
    module: ModuleType = gmsh
    return module


@contextlib.contextmanager
def gmsh_session(name: str = "geometry", options: Mapping[str, float] | None = None) -> Iterator[Any]:
    """Open Gmsh with an empty model, give the module gmsh, and close it at the end.

    If Gmsh is already initialised, the session adds a model and removes only that one. It restores the current model
    and the options that it changed. Other threads wait.

    Parameters
    ----------
    name : str
        Name of the geometry; part of the model's name and of error messages.
    options : mapping of str to float, optional
        Options of Gmsh for this session, over `BASE_OPTIONS`. Those that are set with
        ``gmsh.option.setNumber`` instead stay as they are after a session inside a caller's Gmsh.

    Yields
    ------
    module
        The module gmsh.

    Raises
    ------
    GeometryError
        Where Gmsh cannot start or reports an error; Gmsh's own exception is the ``__cause__``.

    Examples
    --------
    >>> with gmsh_session("square") as gmsh:
    ...     _ = gmsh.model.occ.addRectangle(0.0, 0.0, 0.0, 1.0, 1.0)
    ...     gmsh.model.occ.synchronize()
    ...     len(gmsh.model.getEntities(1))
    4
    """
    with _ONE_AT_A_TIME:
        gmsh = load_gmsh()
        with _translated_errors(name), contextlib.ExitStack() as closing:
            if not gmsh.isInitialized():
                # No signal handler: those can be set in the main thread only.
                gmsh.initialize(readConfigFiles=False, interruptible=False)
                closing.callback(_close)
            else:
                closing.callback(_return_to, gmsh, gmsh.model.getCurrent())
            closing.enter_context(_changed_options(gmsh, {**BASE_OPTIONS, **(options or {})}))
            _own_model(gmsh, name, closing)
            _NAMED.append({})
            closing.callback(_NAMED.pop)
            yield gmsh


@contextlib.contextmanager
def gmsh_as_found(name: str) -> Iterator[None]:
    """Let a script start Gmsh: it finds no entities of others, and leaves none to the next mesh.

    Gmsh is ended afterwards if it was not open before, also where the script fails. A caller's open Gmsh has its own
    model again, unless the script ended Gmsh. Other threads wait.
    """
    with _ONE_AT_A_TIME, contextlib.ExitStack() as closing:
        gmsh = sys.modules.get("gmsh")
        if gmsh is None or not gmsh.isInitialized():
            closing.callback(_close)
        else:
            closing.callback(_return_to, gmsh, gmsh.model.getCurrent())
            _own_model(gmsh, name, closing)
        yield


def name_groups(groups: Mapping[str, Sequence[int]], *, of_volumes: bool = False) -> None:
    """Make the physical groups of the current model, last of all: after fragmenting and synchronising.

    Parameters
    ----------
    groups : mapping of str to sequence of int
        Tags of curves or surfaces under a name ``kind:name``; the kind says which of the two.
    of_volumes : bool
        Whether blocks are volumes: tags are then those of surfaces or volumes.

    Raises
    ------
    GeometryError
        For a name of another form, a group of nothing, and a tag that the model does not have.
    """
    gmsh = load_gmsh()
    faults: list[str] = []
    for text, tags in groups.items():
        group = parse_group_name(text)
        if group is None:
            faults.append(f"group '{text}' is not of the form kind:name; write, for example, rock:gneiss")
            continue
        dimension = group.kind.dimension + of_volumes
        what = ENTITIES[dimension]
        missing = sorted(set(tags) - {tag for _, tag in gmsh.model.getEntities(dimension)})
        if missing:
            faults.append(f"group '{text}': the model has no {what} {missing[0]}; synchronise before naming")
        elif not tags:
            faults.append(f"group '{text}' is empty; leave it out or give it a {what}")
        else:
            number = gmsh.model.addPhysicalGroup(dimension, list(tags), name=str(group))
            if _NAMED:
                _NAMED[-1][dimension, number] = len(set(tags))
    _raise_faults(faults)


def write_mesh(path: str | os.PathLike[str]) -> Path:
    """Write the current model's mesh as binary MSH 4.1, whole or not at all.

    The file is written under another name in the same folder, then renamed; a folder that is not
    there is made.

    Parameters
    ----------
    path : str or path-like
        Where to; the name ends in ``.msh``.

    Raises
    ------
    GeometryError
        Where the folder or file cannot be written; where there are no elements; where a group has
        none or has lost curves or surfaces to a fragmentation that came after it was named; where a
        surface, or a volume where there are any, is in no group: Gmsh would leave its elements out without a word.
    """
    gmsh = load_gmsh()
    target = as_path("path", path)
    if target.suffix != ".msh":
        raise GeometryError(f"{target}: a mesh is written as .msh; give a name that ends in .msh")
    if target.is_dir():
        raise GeometryError(f"{target} is a folder; give the name of a file in it")
    _raise_faults(_group_faults(gmsh))
    changed = {key: BASE_OPTIONS[key] for key in ("Mesh.MshFileVersion", "Mesh.Binary", "Mesh.SaveAll")}
    try:
        with whole_file(target, parents=True) as draft:
            with _changed_options(gmsh, changed):
                gmsh.write(str(draft))
            content = draft.read_bytes()
            _refuse_cut_off(content)
            _raise_faults(_lost_groups(gmsh, content))
    except OSError as fault:
        reason = fault.strerror or fault
        raise GeometryError(f"{target} cannot be written: {reason}; choose another folder") from fault
    except Exception as fault:
        if type(fault) is not Exception:
            raise
        raise GeometryError(f"{target} cannot be written: {fault}; choose another folder") from fault
    return target


def _group_faults(gmsh: Any) -> list[str]:
    """Return the faults of the groups of the current model: without elements, or surfaces (volumes) in none."""

    def meshed_of(dimension: int) -> set[int]:
        entities = gmsh.model.getEntities(dimension)
        return {tag for _, tag in entities if len(gmsh.model.mesh.getElements(dimension, tag)[0])}

    volumes = meshed_of(3)
    top, meshed = (3, volumes) if volumes else (2, meshed_of(2))
    if not meshed:
        return ["there are no elements to write; call gmsh.model.mesh.generate(2) first"]
    faults: list[str] = []
    grouped: set[int] = set()
    for dimension, number in gmsh.model.getPhysicalGroups():
        tags = [int(tag) for tag in gmsh.model.getEntitiesForPhysicalGroup(dimension, number)]
        if dimension == top:
            grouped.update(tags)
        if dimension and not any(len(gmsh.model.mesh.getElements(dimension, tag)[0]) for tag in tags):
            faults.append(f"group '{gmsh.model.getPhysicalName(dimension, number)}' has no elements; {_LAST}")
    if left := sorted(meshed - grouped):
        faults.append(
            f"{len(left)} {ENTITIES[top]}(s) with elements are in no group, the first is {left[0]}; "
            f"put each in a group rock:name; {_LAST}"
        )
    return faults


def _refuse_cut_off(content: bytes) -> None:
    """Raise an `OSError` where a mesh file has no end: on a full disk Gmsh stops writing without a word."""
    if not content.rstrip().endswith(b"$EndElements"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _lost_groups(gmsh: Any, content: bytes) -> list[str]:
    """Return the groups that lost curves or surfaces after they were named: Gmsh keeps their names only."""
    left = {group: len(gmsh.model.getEntitiesForPhysicalGroup(*group)) for group in gmsh.model.getPhysicalGroups()}
    given = dict(_NAMED[-1]) if _NAMED else {}
    names: dict[tuple[int, int], str] = {}
    text = content.partition(b"$PhysicalNames\n")[2].partition(b"$EndPhysicalNames")[0].decode()
    for line in text.splitlines()[1:]:
        dimension, number, name = line.split(maxsplit=2)
        names[int(dimension), int(number)] = name.strip('"')
    return [
        f"group '{name}' lost {'all' if group not in left else 'some'} of its curves or surfaces; {_LAST}"
        for group, name in names.items()
        if left.get(group, 0) < given.get(group, 1)
    ]


def _raise_faults(faults: list[str]) -> None:
    if faults:
        raise GeometryError(faults)


@contextlib.contextmanager
def _translated_errors(name: str) -> Iterator[None]:
    try:
        yield
    except Exception as fault:
        # Gmsh raises bare Exception with the text of its last error.
        if type(fault) is not Exception:
            raise
        raise GeometryError(f"{name}: Gmsh reports: {fault}") from fault


@contextlib.contextmanager
def _changed_options(gmsh: Any, options: Mapping[str, float]) -> Iterator[None]:
    before: dict[str, float] = {}
    try:
        for key, value in options.items():
            before[key] = gmsh.option.getNumber(key)
            gmsh.option.setNumber(key, value)
        yield
    finally:
        if gmsh.isInitialized():
            for key, value in before.items():
                gmsh.option.setNumber(key, value)


def _own_model(gmsh: Any, name: str, closing: contextlib.ExitStack) -> None:
    own = f"{name} (session {next(_NUMBERS)})"
    gmsh.model.add(own)
    closing.callback(_remove_model, gmsh, own)


def _remove_model(gmsh: Any, own: str) -> None:
    if gmsh.isInitialized() and own in gmsh.model.list():
        gmsh.model.setCurrent(own)
        gmsh.model.remove()


def _return_to(gmsh: Any, name: str) -> None:
    if gmsh.isInitialized() and name in gmsh.model.list():
        gmsh.model.setCurrent(name)


def _close() -> None:
    gmsh = sys.modules.get("gmsh")
    if gmsh is not None and gmsh.isInitialized():
        gmsh.finalize()
