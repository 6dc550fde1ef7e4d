"""Meshes of volume elements with physical groups: blocks of tetrahedra, hexahedra, prisms and pyramids."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.converters.meshes.cells import PHYSICAL
from bsm_mesh.converters.meshes.files import refuse_unreadable
from bsm_mesh.converters.meshes.from_msh import MshContent, is_msh40, is_msh41, msh_content, node_numbers
from bsm_mesh.converters.three_d.elements import CORNERS, ElementCells, ElementFaces, element_faces
from bsm_mesh.errors import MeshWarning, ModelError, counted, one_line, place, raise_faults, shortened
from bsm_mesh.geometries.physical_groups import GroupKind, GroupName, parse_group_name
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.model.edges import LongArray
from bsm_mesh.reading import as_path
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

OF_VOLUMES = (GroupKind.ROCK, GroupKind.EXCAVATION)
OF_SURFACES = (GroupKind.JOINT, GroupKind.BOUNDARY)
Groups = dict[GroupName, list[int]]  # parts of the file, by their places


def read_polyhedra(
    path: str | os.PathLike[str],
    *,
    groups: Mapping[str, str] | None = None,
    rock: str | None = None,
    blocks: Literal["elements", "regions"] = "regions",
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
) -> Polyhedra:
    """Return the blocks of a mesh of volume elements, MSH 4.1.

    Groups of volumes are ``rock:NAME`` and ``excavation:NAME``, groups of surfaces ``joint:NAME`` and
    ``boundary:NAME``. Elements of higher order are reduced to their corners.

    Parameters
    ----------
    path : path
        The file.
    groups : mapping of str to str, optional
        ``kind:name`` of groups that are called otherwise; a group without a name is ``gmsh:physical=NUMBER``.
    rock : str, optional
        Rock of the elements in no group of a rock.
    blocks : {"regions", "elements"}
        Whether a region between joints is a block, or every element.
    unit_scale : float [m]
        Unit of length of the mesh.
    merge_tolerance : float [m]
        Nodes nearer than this are one.

    Raises
    ------
    ModelError
        If the file is no MSH 4.1 with volume elements, elements are bent or do not share whole faces, or groups lead
        nowhere.

    Warns
    -----
    MeshWarning
        For groups that are not used.
    """
    file = as_path("mesh", path)
    refuse_unreadable(file)
    if not is_msh41(file) or is_msh40(file):
        raise ModelError(
            f"{file}: volume elements are read from MSH 4.1 alone; convert it: gmsh {file.name} -save -format msh41 "
            "-o mesh.msh"
        )
    content = msh_content(file, solid=True)
    cells, unknown = _cells(file, content, groups or {}, rock, unit_scale, merge_tolerance)
    if unknown:
        warnings.warn(_unused(file, unknown), MeshWarning, stacklevel=2)
    return Polyhedra.from_cells(cells, whole=blocks == "elements")


def _cells(
    file: Path, content: MshContent, renamed: Mapping[str, str], rock: str | None, scale: float, tolerance: float
) -> tuple[ElementCells, dict[str, int]]:
    """Return the elements of a file as cells, and the groups that are not understood, with their dimensions."""
    solids = [k for k, (entity, _, _) in enumerate(content.elements) if entity[0] == 3]
    if not solids:
        raise ModelError(
            f"{file}: holds no volume elements; generate(3) in Gmsh, and put the volumes into groups rock:NAME"
        )
    merged = merge_points(content.points * scale, tolerance)
    _, kept = np.unique(merged, return_index=True)
    number = node_numbers(content)

    def corners(part: int, count: int) -> LongArray:
        at = number(content.elements[part][2][:, 1 : 1 + count])
        if (at < 0).any():
            raise ModelError(f"{file}: elements name nodes that are not in the file; write the mesh again")
        return np.asarray(merged[at], dtype=np.int64)

    kinds = [content.elements[k][1] for k in solids]
    points = content.points[kept] * scale
    elements = [(kind, corners(k, CORNERS[kind])) for k, kind in zip(solids, kinds, strict=True)]
    faces = element_faces(str(file), points, elements)
    sizes = [len(content.elements[k][2]) for k in solids]
    found, unknown = _groups(file, content, renamed)
    rocks, of_rock = _of_elements(file, found, GroupKind.ROCK, solids, sizes)
    excavations, excavated = _of_elements(file, found, GroupKind.EXCAVATION, solids, sizes)
    if (of_rock < 0).any():
        if rock is None:
            raise ModelError(_without_rock(file, int((of_rock < 0).sum()), unknown))
        rocks = rocks if rock in rocks else (*rocks, rock)
        of_rock = np.where(of_rock < 0, rocks.index(rock), of_rock).astype(np.int32)
    on_faces = _of_faces(file, content, found, faces, corners, points)
    joints = tuple(name.name for name in on_faces if name.kind is GroupKind.JOINT)
    face_joint = np.full(len(faces.loops), -1, dtype=np.int32)
    for k, name in reversed(list(enumerate(joints))):  # the first in the file names a face of two
        face_joint[on_faces[GroupName(GroupKind.JOINT, name)]] = k
    inside = faces.loops >= 0
    cells = ElementCells(
        vertices=points,
        face_vertices=faces.loops[inside].astype(np.int32),
        face_offsets=np.append(0, np.cumsum(inside.sum(axis=1))).astype(np.int32),
        face_cells=faces.cells,
        face_joint=face_joint,
        cell_rock=of_rock,
        cell_excavation=excavated,
        joint_names=joints,
        rock_names=rocks,
        excavation_names=excavations,
        boundaries={name.name: at for name, at in on_faces.items() if name.kind is GroupKind.BOUNDARY},
    )
    return cells, unknown


def _groups(file: Path, content: MshContent, renamed: Mapping[str, str]) -> tuple[Groups, dict[str, int]]:
    """Return the parts of the file in every group, and those that are not understood, with their dimensions."""
    found, unknown, faults, seen = Groups(), dict[str, int](), list[str](), set[str]()
    for part, (entity, _, _) in enumerate(content.elements):
        for tag in content.physicals.get(entity, ()) if entity[0] >= 2 else ():
            text = content.names.get((entity[0], tag), f"{PHYSICAL}={tag}")
            seen.add(text)
            name = parse_group_name(renamed.get(text, text))
            if name is None:
                unknown[text] = entity[0]
            elif name.kind not in (OF_VOLUMES if entity[0] == 3 else OF_SURFACES):
                given, right = ("volumes", "surfaces") if entity[0] == 3 else ("surfaces", "volumes")
                faults.append(f"group '{text}' holds {given}; {name.kind.value}:NAME is for {right}")
            else:
                found.setdefault(name, []).append(part)
    faults += [f"there is no group '{text}' of surfaces or volumes in the mesh" for text in renamed if text not in seen]
    raise_faults([f"{file}: {fault}" for fault in dict.fromkeys(faults)])
    return found, unknown


def _of_elements(
    file: Path, found: Groups, kind: GroupKind, solids: list[int], sizes: list[int]
) -> tuple[tuple[str, ...], IntArray]:
    """Return the names of one kind, and the index of every element's among them, or -1."""
    names = [name for name in found if name.kind is kind]
    of_part = dict.fromkeys(solids, -1)
    for k, name in enumerate(names):
        for part in found[name]:
            if of_part[part] >= 0:
                raise ModelError(f"{file}: a volume is in {names[of_part[part]]} and in {name}; leave it in one")
            of_part[part] = k
    return tuple(name.name for name in names), np.repeat([of_part[k] for k in solids], sizes).astype(np.int32)


def _of_faces(
    file: Path,
    content: MshContent,
    found: Groups,
    faces: ElementFaces,
    corners: Callable[[int, int], LongArray],
    points: np.ndarray,
) -> dict[GroupName, IntArray]:
    """Return the faces of every joint, between two elements, and of every boundary, of one element."""
    of_name, faults = dict[GroupName, IntArray](), list[str]()
    for name, parts in found.items():
        if name.kind not in OF_SURFACES:
            continue
        loops = []
        for part in parts:
            count = 4 if content.elements[part][1].startswith("quad") else 3
            loops.append(np.pad(corners(part, count), ((0, 0), (0, 4 - count)), constant_values=-1))
        loop = np.concatenate(loops)
        at = faces.find(loop)
        if (at < 0).any():
            where = place(points[loop[at < 0][0, :3]].mean(axis=0))
            faults.append(
                f"group '{name}': {counted(int((at < 0).sum()), 'surface element')} of {len(at)}, the first at {where} "
                "m, no face of a volume element; embed the surface in the volumes, by fragment in Gmsh"
            )
            continue
        inner = faces.cells[at, 1] >= 0
        chosen = np.unique(at[inner if name.kind is GroupKind.JOINT else ~inner]).astype(np.int32)
        of_name[name] = chosen
        if not len(chosen):
            right = (
                "between two volume elements; volumes on both sides share their nodes, by fragment in Gmsh"
                if name.kind is GroupKind.JOINT
                else "on the outside"
            )
            faults.append(f"group '{name}': none of its {len(at)} surface elements lies {right}")
    raise_faults([f"{file}: {fault}" for fault in faults])
    return of_name


def _without_rock(file: Path, count: int, unknown: dict[str, int]) -> str:
    named = f" (groups that are not used: {shortened(', '.join(unknown))})" if unknown else ""
    return (
        f"{file}: {counted(count, 'volume element')} in no group of a rock{named}; call the group rock:NAME, name it "
        "in [groups], or give one rock for them all"
    )


def _unused(file: Path, unknown: dict[str, int]) -> str:
    """Return the sentence on groups of surfaces and volumes that are not understood."""
    first, dimension = next(iter(unknown.items()))
    target = "NAME" if first.startswith(PHYSICAL) else first.rpartition(":")[2]
    kinds = OF_VOLUMES if dimension == 3 else OF_SURFACES
    examples = " or ".join(f'"{kind.value}:{target}"' for kind in kinds)
    return one_line(
        f"{file}: groups that are not used: {shortened(', '.join(unknown))}; to use one, name it kind:name, or under "
        f'[groups], for example "{first}" = {examples}'
    )
