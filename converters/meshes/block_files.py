"""Blocks written as a mesh of polygons, with their joints, boundaries and excavations."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bsm_mesh.converters.vtk_files import Grid, write_vtu
from bsm_mesh.converters.vtk_library import LINE, POLYGON, numbered
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.reading import as_path


def write_polygons(blocks: Blocks, path: str | os.PathLike[str]) -> Path:
    """Write the blocks as VTU: a polygon each, and lines along joints and boundaries; return the path.

    ``read_blocks`` gives equal blocks: the arrays ``rock``, ``joint``, ``boundary_<name>`` and ``excavation_<name>``
    with the names of their numbers (``Grid.names``) are found there as groups.

    Raises
    ------
    ModelError
        If the name does not end in ``.vtu``.
    """
    target = as_path("write_polygons: path", path)
    if target.suffix != ".vtu":
        raise ModelError(f"{target}: polygons are written as VTU; give a name that ends in .vtu")
    _, first, number = np.unique(blocks.nodes, return_index=True, return_inverse=True)
    number = number.reshape(-1)
    tagged = blocks.edge_joint >= 0
    for edges in blocks.boundaries.values():
        tagged[edges] = True
    lines = np.flatnonzero(tagged)
    no_block, no_line = np.full(blocks.count, -1), np.full(len(lines), -1)
    data = {
        "rock": np.concatenate([blocks.rock, no_line]),
        "joint": np.concatenate([no_block, blocks.edge_joint[lines]]),
    }
    names = {**numbered("rock", blocks.rock_names), **numbered("joint", blocks.joint_names)}
    for name, ids in blocks.boundaries.items():
        data[f"boundary_{name}"] = np.concatenate([no_block, np.where(np.isin(lines, ids), 0, -1)])
        names[f"boundary:{name}"] = 0
    for name, ids in blocks.excavations.items():
        data[f"excavation_{name}"] = np.concatenate([np.where(np.isin(np.arange(blocks.count), ids), 0, -1), no_line])
        names[f"excavation:{name}"] = 0
    ends = np.stack([number[lines], number[blocks.following[lines]]], axis=1)
    grid = Grid(
        points=blocks.vertices[first],
        offsets=np.concatenate([blocks.offsets, blocks.offsets[-1] + 2 * np.arange(1, len(lines) + 1)]),
        connectivity=np.concatenate([number, ends.ravel()]),
        cell_type=np.repeat([POLYGON, LINE], [blocks.count, len(lines)]),
        cell_data=data,
        names=names,
    )
    write_vtu(target, grid, parents=True)
    return target
