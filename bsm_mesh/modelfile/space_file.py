"""From a model file of three dimensions to polyhedral blocks, rocks and joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from pydantic import ValidationError

from bsm_mesh.errors import ModelError, nearest, placed, raise_faults
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.modelfile.build_parts import collected, make_joint, make_rock
from bsm_mesh.modelfile.model_file import read_toml, sentences
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_mesh import read_space_mesh, source_faults
from bsm_mesh.modelfile.space_tables import (
    BodyTable,
    DistributionTable,
    JointPlaneTable,
    JointSetTable,
    SlopeTable,
    SpaceFile,
)
from bsm_mesh.named_units import LENGTHS
from bsm_mesh.table_rows import read_rows
from bsm_mesh.three_d.blocks.polyhedra import SLOPE, Polyhedra

if TYPE_CHECKING:
    from bsm_mesh.geometries.three_d import Excavation, JointPlane, JointSet, Opening

Cutter: TypeAlias = "Callable[[SpaceFile, Path, Reach, list[Any], list[Any]], Polyhedra]"
"""Returns the blocks that joints and bodies cut: `blocks_of`, or what keeps what that returned."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedSpace:
    """A model of three dimensions as its file describes it.

    Attributes
    ----------
    path : Path
        The model file.
    file : SpaceFile
        Its content.
    blocks : Polyhedra
        The blocks.
    rocks, joints : tuple of Rock, of Joint
        Their materials.
    """

    path: Path
    file: SpaceFile
    blocks: Polyhedra
    rocks: tuple[Rock, ...]
    joints: tuple[Joint, ...]


def load_space_file(path: Path, *, scripts: bool = True) -> LoadedSpace:
    """Return the blocks and materials of a model file of three dimensions.

    Parameters
    ----------
    path : Path
        The file.
    scripts : bool
        Whether it may name any path. If not, nothing outside its folder is read or written.

    Raises
    ------
    ModelError
        With every fault of the file, or of the rock that it describes.
    """
    return cut_space_file(read_space_file(path), path, Reach(folder=path.parent, scripts=scripts))


def blocks_of(file: SpaceFile, path: Path, reach: Reach, joints: list[Any], bodies: list[Any]) -> Polyhedra:
    """Return the blocks: of a mesh, or of the box that joints and bodies cut."""
    if file.mesh.box is None:
        return read_space_mesh(file, path, reach)
    with placed(path.name):
        return _cut(file, joints, bodies)


def cut_space_file(file: SpaceFile, path: Path, reach: Reach, cutter: Cutter = blocks_of) -> LoadedSpace:
    """Return the blocks, by a `Cutter`, and materials of a model file of three dimensions that was read."""
    faults: list[str] = []
    rocks = collected(faults, [partial(make_rock, name, table) for name, table in file.rock.items()])
    joints = collected(faults, [partial(make_joint, name, table) for name, table in file.joint.items()])
    sets: list[Any] = collected(faults, [partial(_joint_set, table) for table in file.joint_set])
    sets += collected(faults, [partial(_joint_plane, table) for table in file.joint_plane])
    bodies: list[Any] = collected(faults, [partial(_excavation, table, reach) for table in file.excavation])
    bodies += collected(faults, [] if file.slope is None else [partial(_slope, file.slope)])
    faults += source_faults(file) or _name_faults(file)
    raise_faults([f"{path.name}: {fault}" for fault in faults])
    blocks = cutter(file, path, reach, sets, bodies)
    raise_faults([f"{path.name}: [key_blocks] {fault}" for fault in _unknown_to(blocks, file)])
    return LoadedSpace(path=path, file=file, blocks=blocks, rocks=tuple(rocks), joints=tuple(joints))


def read_space_file(path: Path) -> SpaceFile:
    """Return the content of a model file of three dimensions.

    Raises
    ------
    ModelError
        If it is one of the plane, or with every key and value that is wrong.
    """
    content = read_toml(path, "model file")
    if "dimensions" not in content:
        raise ModelError(
            f"{path.name}: is a model of the plane; key blocks are found in rock of three dimensions: write "
            "dimensions = 3, and [mesh] with a box or a file"
        )
    return validated_space(content, path.name)


def validated_space(content: dict[str, Any], name: str) -> SpaceFile:
    """Return the content of a model file of three dimensions, checked; `name` is the file's, for messages.

    Raises
    ------
    ModelError
        With every key and value that is wrong.
    """
    try:
        return SpaceFile.model_validate(content)
    except ValidationError as error:
        raise ModelError([f"{name}: {text}" for text in dict.fromkeys(sentences(error, SpaceFile))]) from None


def _name_faults(file: SpaceFile) -> list[str]:
    """Return a sentence for every name that leads nowhere."""
    named = {"[[joint_set]]": [t.name for t in file.joint_set], "[[joint_plane]]": [t.name for t in file.joint_plane]}
    used = {*named["[[joint_set]]"], *named["[[joint_plane]]"], file.mesh.default_joint}
    faults = [
        f"{kind} '{name}': there is no [joint.{name}]{nearest(name, file.joint)}"
        for kind, given in named.items()
        for name in dict.fromkeys(given)
        if name not in file.joint
    ]
    faults += (
        []
        if file.mesh.box is None
        else [
            f"[joint.{name}]: no [[joint_set]] or [[joint_plane]] has that name; leave it out, or give one"
            for name in file.joint
            if name not in used
        ]
    )
    faults += [
        f"[joint.{name}]: along and between lay joints into a mesh of the plane; give [[joint_set]] or [[joint_plane]]"
        for name, table in file.joint.items()
        if table.along is not None or table.between is not None
    ]
    if file.mesh.rock is None and len(file.rock) > 1 and file.mesh.box:
        faults.append(f"[mesh]: name the rock of the box: rock = one of {', '.join(map(repr, file.rock))}")
    elif file.mesh.rock is not None and file.mesh.rock not in file.rock:
        faults.append(f"[mesh] rock: there is no [rock.{file.mesh.rock}]{nearest(file.mesh.rock, file.rock)}")
    return faults


def _unknown_to(blocks: Polyhedra, file: SpaceFile) -> list[str]:
    """Return a sentence for every name asked of the key blocks that the blocks do not have."""
    return [
        f"{key}: there is no {kind} '{name}'{nearest(name, known)}"
        for key, kind, names, known in (
            ("free", "boundary", file.key_blocks.free, blocks.boundaries),
            ("joint_pressure", "joint", file.key_blocks.joint_pressure, blocks.joint_names),
        )
        for name in names
        if name not in known
    ]


def _cut(file: SpaceFile, joints: list[Any], bodies: list[Any]) -> Polyhedra:
    from bsm_mesh.geometries import GeometryError
    from bsm_mesh.geometries.three_d import RockMass, cut_cells

    low, high = file.mesh.box or ((), ())  # `source_faults` has seen to it
    name = file.mesh.rock or next(iter(file.rock))
    try:
        rock = RockMass(box=(low, high), joints=joints, bodies=bodies, rock=name, seed=file.mesh.seed)
        return Polyhedra.from_cells(cut_cells(rock))
    except GeometryError as error:
        raise ModelError(error.faults) from error


def _law(value: float | DistributionTable | None, thing: str) -> Any:
    """Return a number, or a distribution of spacings or radii."""
    from bsm_mesh.geometries import Exponential, Lognormal, Normal

    if not isinstance(value, DistributionTable):
        return value
    if (value.law == "exponential") != (value.deviation is None):
        needs = "has no deviation; leave it out" if value.law == "exponential" else "needs a deviation [m]"
        raise ModelError(f"{thing}: law '{value.law}' {needs}")
    if value.deviation is None:
        return Exponential(value.mean)
    return (Normal if value.law == "normal" else Lognormal)(value.mean, value.deviation)


def _joint_set(table: JointSetTable) -> JointSet:
    from bsm_mesh.geometries.three_d import JointSet

    thing = f"[[joint_set]] '{table.name}'"
    return JointSet(
        name=table.name,
        dip=table.dip,
        dip_direction=table.dip_direction,
        spacing=_law(table.spacing, f"{thing} spacing"),
        density=table.density,
        radius=_law(table.radius, f"{thing} radius"),
        origin=table.origin,
        scatter=None if table.scatter is None else table.scatter.fisher,
        persistence=table.persistence,
    )


def _joint_plane(table: JointPlaneTable) -> JointPlane:
    from bsm_mesh.geometries.three_d import JointPlane

    return JointPlane(**table.model_dump())


def _excavation(table: BodyTable, reach: Reach) -> Excavation:
    from bsm_mesh.geometries.errors import GeometryError
    from bsm_mesh.geometries.orientations import line_directions
    from bsm_mesh.geometries.three_d import Excavation, prism

    thing = f"[[excavation]] '{table.name}'"
    if (table.polygon is None) == (table.profile is None):
        raise ModelError(f"{thing}: give one of polygon and profile")
    if table.polygon is not None and len(table.polygon) != 1:
        raise ModelError(f"{thing}: polygon must be one outline, [[x, z], ...]")
    given = table.polygon or [_profile(reach.path(table.profile or "", "profile"))]
    if (table.start is None) != (table.end is None) or (
        table.start is not None and table.end is not None and table.end <= table.start
    ):
        raise ModelError(f"{thing}: from and to go together, and `to` lies beyond `from`")
    origin, length = np.array(table.origin), None
    if table.start is not None and table.end is not None:
        along = line_directions(np.array([table.axis.trend]), np.array([table.axis.plunge]))[0]
        origin, length = origin + table.start * along, table.end - table.start
    try:
        body = prism(
            given[0],
            trend=table.axis.trend,
            plunge=table.axis.plunge,
            origin=tuple(origin.tolist()),
            length=length,
        )
    except GeometryError as error:
        raise ModelError(f"{thing}: {error}") from error
    return Excavation(body=body, name=table.name)


def _profile(path: Path) -> list[tuple[float, float]]:
    """Return the outline in a table of the columns x and z [m], or of a unit of length in the header."""
    rows = read_rows(path, "x and z of a corner of the profile")
    columns, faults = rows.columns("x", "z"), list[str]()
    scale = [rows.factor(column, LENGTHS, "m") for column in columns]
    corners = [
        (rows.finite(row, columns[0], faults) * scale[0], rows.finite(row, columns[1], faults) * scale[1])
        for row in range(len(rows.cells))
    ]
    raise_faults(faults)
    return corners


def _slope(table: SlopeTable) -> Opening:
    from bsm_mesh.geometries.three_d import Opening, slope

    if table.face.dip_direction is None:
        raise ModelError("[slope]: face needs the key 'dip_direction' [degrees]")
    top = table.top
    body = slope(
        toe=table.toe,
        dip=table.face.dip,
        dip_direction=table.face.dip_direction,
        height=table.height,
        top_dip=0.0 if top is None else top.dip,
        top_direction=None if top is None else top.dip_direction,
    )
    return Opening(body=body, boundary=SLOPE)
