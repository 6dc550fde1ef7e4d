"""The mesh that a model file of three dimensions names: its blocks, and what such a file cannot have besides."""

from __future__ import annotations

from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.quantities import UNIT_OF_LENGTH
from bsm_mesh.model.quantity import convert
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


def source_faults(file: SpaceFile) -> list[str]:
    """Return a sentence for what does not go together: a box and what cuts it, or a mesh and its groups."""
    mesh = file.mesh
    if (mesh.box is None) == (mesh.file is None):
        given = "neither is" if mesh.box is None else "both are"
        return [f"[mesh] needs one of the keys 'box' and 'file'; {given} given"]
    if mesh.box is not None:
        keys = [f"[mesh] {key}" for key in ("unit", "merge_tolerance", "blocks") if key in mesh.model_fields_set]
        keys += ["[groups]"] if file.groups else []
        return [f"{key} is for a mesh, and [mesh] has a box; leave it out" for key in keys]
    tables = {"[[joint_set]]": file.joint_set, "[[joint_plane]]": file.joint_plane, "[[excavation]]": file.excavation}
    tables["[slope]"] = [] if file.slope is None else [file.slope]
    return [
        f"{name} cuts a box, and [mesh] has a file; give the mesh groups joint:NAME, excavation:NAME, boundary:NAME"
        for name, given in tables.items()
        if given
    ]


def read_space_mesh(file: SpaceFile, reach: Reach) -> Polyhedra:
    """Return the blocks of the mesh.

    Raises
    ------
    ModelError
        If the mesh cannot be read, or it and the tables of rocks and joints name each other not.
    """
    from bsm_mesh.converters.three_d import read_polyhedra

    mesh = file.mesh
    try:
        scale = convert(f"1 {mesh.unit}", UNIT_OF_LENGTH)
    except ValueError as error:
        raise ModelError(f'[mesh] unit = "{mesh.unit}": {error}') from None
    only = next(iter(file.rock)) if len(file.rock) == 1 else None
    blocks = read_polyhedra(
        reach.mesh(mesh.file or ""),
        groups=file.groups,
        rock=mesh.rock or only,
        blocks=mesh.blocks,
        unit_scale=scale,
        merge_tolerance=mesh.merge_tolerance,
    )
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
    faults += [
        f"[joint.{name}]: the mesh has no group joint:{name}{nearest(name, blocks.joint_names)}; leave it out, or name "
        "it in [groups]"
        for name in file.joint
        if name not in (*blocks.joint_names, mesh.default_joint)
    ]
    raise_faults(faults)
    return blocks
