"""A part of the blocks as a model of its own: those present at a stage, under the numbers of the whole."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np

from bsm_mesh import space
from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars, no_edge
from bsm_mesh.model.water import Water


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SubModel:
    """Some blocks of a model.

    Attributes
    ----------
    model : Model
        The blocks that are there, their supports and loads. Blocks and corners keep their order.
    present : (n,) bool
        Which blocks of the whole are there.
    block : (k,) int32
        Number of each block in the whole.
    corner : (l,) int32
        Number of each corner, and edge, in the whole; of polyhedra that of each face.
    bar : (b,) int32
        Number of each bar in the whole.
    """

    model: Model
    present: BoolArray
    block: IntArray
    corner: IntArray
    bar: IntArray

    def acting(self, forces: PointForces) -> PointForces:
        """Return forces on blocks of the whole as forces on those that are there; the others are left out."""
        number = np.cumsum(self.present, dtype=np.int32) - 1
        return _rows(forces, np.flatnonzero(self.present[forces.block]), number)

    def in_whole(self, rows: FloatArray) -> FloatArray:
        """Return one row a block of the whole: zeros for those that are not there."""
        whole = np.zeros((len(self.present), *rows.shape[1:]), dtype=rows.dtype)
        whole[self.block] = rows
        return whole


def submodel_of(
    model: Model,
    present: BoolArray,
    bars: Bars,
    forces: PointForces,
    water: Water | None,
    on_faces: FaceWater | None = None,
) -> SubModel:
    """Return the blocks that are there as a model of their own.

    Parameters
    ----------
    model : Model
        The whole.
    present : (n,) bool
        Which of its blocks are there.
    bars : Bars
        The supports of the whole.
    forces : PointForces
        The loads, on blocks of the whole; those on blocks that are not there are left out.
    water : Water or None
        The water.
    on_faces : FaceWater, optional
        The pressure of flow on edges of the whole.
    """
    number = np.cumsum(present, dtype=np.int32) - 1
    blocks, corner = blocks_and_corners(model.blocks, present)
    bar = np.flatnonzero(present[bars.block]).astype(np.int32)
    acting = present[forces.block]
    part = Model(
        blocks=blocks,
        rocks=model.rocks,
        joints=model.joints,
        default_joint=model.default_joint,
        supports=(dataclasses.replace(_rows(bars, bar, number), edge=no_edge(bar)),),
        loads=(_rows(forces, np.flatnonzero(acting), number),),
        gravity_direction=model.gravity_direction,
        gravity_horizontal=model.gravity_horizontal,
        gravity_vertical=model.gravity_vertical,
        gravity_trend=model.gravity_trend,
        contact_points=model.contact_points,
        water=water,
        face_water=None if on_faces is None else on_faces.of_corners(corner),
        title=model.title,
    )
    return SubModel(model=part, present=present, block=np.flatnonzero(present).astype(np.int32), corner=corner, bar=bar)


Table = TypeVar("Table", Bars, PointForces)


def _rows(table: Table, chosen: IntArray, number: IntArray) -> Table:
    columns = {field.name: getattr(table, field.name)[chosen] for field in dataclasses.fields(table)}
    columns["block"] = number[columns["block"]]
    return dataclasses.replace(table, **columns)


def some_blocks(blocks: Blocks, present: BoolArray) -> Blocks:
    """Return the blocks with ``present`` (n,) true, in their order, without excavation groups."""
    return blocks_and_corners(blocks, present)[0]


def blocks_and_corners(blocks: Blocks, present: BoolArray) -> tuple[Blocks, IntArray]:
    """Return the blocks with ``present`` (n,) true, without excavation groups, and the numbers of their corners.

    They keep their order. Of polyhedra the numbers are those of their faces.
    """
    if in_space(blocks):
        return cast(tuple[Blocks, IntArray], space.some_polyhedra(blocks, present))  # they answer to the same names
    corner = np.flatnonzero(present[blocks.owner]).astype(np.int32)
    if present.all():
        return blocks, corner
    new_corner = np.full(len(blocks.vertices), -1, dtype=np.int32)
    new_corner[corner] = np.arange(len(corner))
    boundaries = {name: new_corner[edges][new_corner[edges] >= 0] for name, edges in blocks.boundaries.items()}
    sizes = np.diff(blocks.offsets)[present]
    part = Blocks(
        vertices=blocks.vertices[corner],
        offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        nodes=blocks.nodes[corner],
        rock=blocks.rock[present],
        rock_names=blocks.rock_names,
        edge_joint=blocks.edge_joint[corner],
        joint_names=blocks.joint_names,
        boundaries={name: edges for name, edges in boundaries.items() if edges.size},
    )
    return part, corner
