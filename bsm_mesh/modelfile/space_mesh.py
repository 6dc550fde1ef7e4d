"""The mesh that a model file of three dimensions names: its blocks, and what such a file cannot have besides."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from bsm_mesh.errors import ModelError, counted, nearest, placed, raise_faults
from bsm_mesh.modelfile.build_mesh import mesh_source, unit_scale
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_tables import RockBoxTable, SpaceFile
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.model.notes import joints_between


def source_faults(file: SpaceFile) -> list[str]:
    """Return a sentence for what does not go together: a box and what cuts it, or a mesh and its groups."""
    mesh = file.mesh
    sources = [key for key in ("box", "file", "geometry") if getattr(mesh, key) is not None]
    if len(sources) != 1:
        given = f"given: {', '.join(sources) or 'none'}"
        return [f"[mesh] needs one of the keys 'box', 'file' and 'geometry'; {given}"]
    if mesh.box is not None:
        of_mesh = ("parameters", "unit", "merge_tolerance", "blocks")
        usual = RockBoxTable()  # as the model as run is written
        keys = [f"[mesh] {key}" for key in of_mesh if getattr(mesh, key) != getattr(usual, key)]
        keys += ["[groups]"] if file.groups else []
        return [f"{key} is for a mesh, and [mesh] has a box; leave it out" for key in keys]
    tables = {"[[joint_set]]": file.joint_set, "[[joint_plane]]": file.joint_plane, "[[excavation]]": file.excavation}
    tables["[slope]"] = [] if file.slope is None else [file.slope]
    return [
        f"{name} cuts a box, and [mesh] has a {sources[0]}; give the mesh groups joint:NAME, excavation:NAME, "
        "boundary:NAME"
        for name, given in tables.items()
        if given
    ]


def read_space_mesh(file: SpaceFile, path: Path, reach: Reach) -> Polyhedra:
    """Return the blocks of the mesh, or of the geometry, that the model file's `path` names.

    Raises
    ------
    ModelError
        If the mesh cannot be read, or it and the tables of rocks and joints name each other not.
    """
    from bsm_mesh.converters.three_d import read_polyhedra, read_polyhedra_file, read_stones
    from bsm_mesh.converters.three_d.surface_files import ENDINGS

    mesh = file.mesh
    only = next(iter(file.rock)) if len(file.rock) == 1 else None
    with mesh_source(mesh, path, reach) as source, placed(path.name):
        if source.suffix.lower() in ENDINGS:
            rock = mesh.rock or only
            raise_faults(_stone_faults(file, rock))
            return read_stones(
                source, rock=str(rock), unit_scale=unit_scale(mesh.unit), merge_tolerance=mesh.merge_tolerance
            )
        reader: Callable[..., Polyhedra] = partial(read_polyhedra, groups=file.groups)
        if source.suffix.lower() == ".vtu":
            if file.groups:
                raise ModelError("[groups] are of MSH files; name groups in the VTU file, and leave it out")
            reader = read_polyhedra_file
        blocks = reader(
            source,
            rock=mesh.rock or only,
            blocks=mesh.blocks,
            unit_scale=unit_scale(mesh.unit),
            merge_tolerance=mesh.merge_tolerance,
        )
        raise_faults(_unmatched(file, blocks))
    return blocks


def default_of_blocks(file: SpaceFile, blocks: Polyhedra) -> tuple[str, ...]:
    """Return a note where a file leaves out ``blocks``, and the elements of its mesh are joined to fewer blocks."""
    elements, is_given = len(blocks.cell_block), "blocks" in file.mesh.model_fields_set
    if file.mesh.box is not None or is_given or elements == blocks.count:
        return ()
    return (
        f"{counted(blocks.count, 'block')} of {elements} elements: by default every region between joints is a block; "
        'with [mesh] blocks = "elements" every element is one, and blocks = "regions" removes this note',
    )


def _stone_faults(file: SpaceFile, rock: str | None) -> list[str]:
    """Return a sentence for each key that separate stones need or cannot have."""
    faults = (
        [] if rock in file.rock else [f"[mesh] rock must name the rock of the stones{nearest(str(rock), file.rock)}"]
    )
    if file.groups:
        faults.append("[groups] are of a mesh of volumes, and stones have none; leave it out")
    if file.mesh.default_joint is None:
        faults.append("[mesh] default_joint must name the joint between stones")
    return faults


def _unmatched(file: SpaceFile, blocks: Polyhedra) -> list[str]:
    """Return a sentence for rocks and joints that only one of mesh and model file names."""
    mesh = file.mesh
    faults = [
        f"rock:{name} of the mesh: there is no [rock.{name}]{nearest(name, file.rock)}"
        for name in blocks.rock_names
        if name not in file.rock
    ]
    faults += [
        f"joint:{name} of the mesh: there is no [joint.{name}]{nearest(name, file.joint)}"
        for name in blocks.joint_names
        if name not in file.joint
    ]
    if mesh.allow_unused:
        return faults
    faults += [
        f"[joint.{name}]: the mesh has no group joint:{name}{nearest(name, blocks.joint_names)}; leave it out, or name "
        "it in [groups]"
        for name in file.joint
        if name not in (*blocks.joint_names, mesh.default_joint)
    ]
    bounding = joints_between(blocks) | {mesh.default_joint}
    faults += [
        f"joint:{name} of the mesh bounds no two blocks; extend its surfaces to other joints or to the outside, or "
        f"leave out both the group and [joint.{name}]"
        for name in blocks.joint_names
        if name in file.joint and name not in bounding
    ]
    return faults
