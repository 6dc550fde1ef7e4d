"""Results to VTU and PVD for ParaView, and back.

The files have numbers only, since meshio 5.3.5, VisIt and vtk.js read no text arrays. Names of joints and rocks are
field arrays of one number, `kind:name`. The compressor is zlib, since meshio knows no LZ4. `stress` has six
components for ParaView; the stress out of the plane is 0, since rigid blocks in the plane have none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.array_units import unit_of
from bsm_mesh.converters.bolt_files import bolt_grid
from bsm_mesh.converters.contact_files import contact_grid, joint_grid, support_grid, water_grid
from bsm_mesh.converters.flow_files import flow_grid
from bsm_mesh.converters.stress_components import six_components
from bsm_mesh.converters.three_d.stage_grids import space_grid
from bsm_mesh.converters.vtk_files import Compression, Grid, spatial, write_pvd, write_vtu
from bsm_mesh.converters.vtk_library import POLYGON, numbered
from bsm_mesh.converters.zone_files import zone_grid
from bsm_mesh.errors import ModelError
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.submodel import some_blocks
from bsm_mesh.movements import PLANE
from bsm_mesh.results.clock import ends_of
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.stress import principal_stresses

SERIES = ("blocks", "contacts", "joints", "supports")
WATER, FLOW, BOLTS, ZONES = "water", "flow", "bolts", "zones"  # written where there are any
GIVEN_BLOCKS = "blocks_given.vtu"  # all blocks as given; written where some were taken away in the first stage
OF_STEPS = (*SERIES, BOLTS)  # the water stands still during a stage


@dataclass(frozen=True, slots=True)
class Instant:
    """A snapshot between the ends of stages.

    Attributes
    ----------
    time : int
        Accepted steps since the run began.
    stage, step : int
        Number of the stage, and of the step within it, from 0.
    moment : float
        As `bsm_mesh.results.clock.Clock` counts it.
    """

    time: int
    stage: int
    step: int
    moment: float

    def file(self, kind: str) -> str:
        """Return the name of the file of a kind."""
        return f"{kind}_{self.stage:04d}_{self.step:05d}.vtu"


def kinds_of(stage: StageResult) -> list[str]:
    """Return the kinds of files that a stage has; in space contacts are the faces of joints."""
    if stage.displacement.shape[1] != PLANE:
        return kinds_of_space(bolts=stage.bolts.count > 0)
    there = {
        WATER: len(stage.water_table),
        FLOW: stage.flow is not None,
        BOLTS: stage.bolts.count,
        ZONES: stage.zones is not None,
    }
    return [*SERIES, *(kind for kind, any_there in there.items() if any_there)]


def kinds_of_space(*, bolts: bool) -> list[str]:
    """Return the kinds of files that a stage of polyhedra has, with bolts or without."""
    return [*(kind for kind in SERIES if kind != "joints"), *([BOLTS] if bolts else [])]


def stage_file(kind: str, number: int) -> str:
    """Return the name of the file of a kind at the end of a stage."""
    return f"{kind}_{number:04d}.vtu"


def write_stage(results: Results, number: int, folder: Path, compression: Compression = "zlib") -> list[str]:
    """Write a VTU of each kind at the end of a stage; return their names.

    The first stage also writes the blocks as given (`GIVEN_BLOCKS`) if some of them are gone at its end.
    """
    stage = results.stages[number]
    names = []
    if number == 0 and not stage.present.all() and not in_space(results.blocks):
        everything = np.ones(results.blocks.count, dtype=bool)
        write_vtu(folder / GIVEN_BLOCKS, outline_grid(results.blocks, everything), compression=compression)
        names.append(GIVEN_BLOCKS)
    for kind in kinds_of(stage):
        grid = grid_of_stage(kind, results, stage, number)
        write_vtu(folder / stage_file(kind, number), grid, compression=compression)
        names.append(stage_file(kind, number))
    return names


def write_snapshot(results: Results, folder: Path, instant: Instant, compression: Compression = "zlib") -> list[str]:
    """Write a VTU of each kind of `OF_STEPS` that there is at an instant of the run; return their names."""
    stage = results.stages[-1]
    kinds = [kind for kind in OF_STEPS if kind in kinds_of(stage)]
    for kind in kinds:
        write_vtu(
            folder / instant.file(kind), grid_of_stage(kind, results, stage, instant.stage), compression=compression
        )
    return [instant.file(kind) for kind in kinds]


def write_lists(
    stages: Sequence[StageResult], folder: Path, instants: Sequence[Instant] | None = None, zero: float = 0.0
) -> list[str]:
    """Write a PVD for each kind of files that there is; return their names.

    PVD time is the number of the stage; where there are snapshots of `instants`, which are listed too, it is the number
    of steps since the run began. From the first shaken stage on it is 0 there and runs in seconds while blocks are
    shaken; steps before it then have times below 0, and each step after it adds 1.

    Parameters
    ----------
    stages : sequence of StageResult
        Those that are at their end.
    folder : Path
        Where to.
    instants : sequence of Instant, optional
        The snapshots between their ends.
    zero : float
        Moment of the first shaken stage's begin, where it has begun and not ended.
    """
    ends, begun = ends_of(stages)
    zero = begun or zero
    times = list(range(len(stages))) if instants is None else [end - zero for end in ends]
    names = []
    for kind in (*SERIES, WATER, FLOW, BOLTS, ZONES):
        listed = [
            (float(time), stage_file(kind, number))
            for number, (time, stage) in enumerate(zip(times, stages, strict=True))
            if kind in kinds_of(stage)
        ]
        listed += [
            (instant.moment - zero, instant.file(kind))
            for instant in instants or ()
            if kind in OF_STEPS and (folder / instant.file(kind)).is_file()
        ]
        if listed:
            write_pvd(folder / f"{kind}.pvd", sorted(listed))
            names.append(f"{kind}.pvd")
    return names


def block_grid(results: Results, stage: StageResult) -> Grid:
    """Return the blocks that are there, a polygon a block with points of its own at the original positions.

    The point array ``displacement`` is that of the corners by exact rotation, for ParaView's Warp By Vector.
    """
    blocks = results.blocks
    outlines = outline_grid(blocks, stage.present)
    here, corners = outlines.cell_data["block_id"], np.flatnonzero(stage.present[blocks.owner])
    sigma_1, sigma_3 = principal_stresses(stage.stress)
    unstable = np.zeros(blocks.count, dtype=np.uint8)
    unstable[stage.unstable_blocks] = 1
    cells: dict[str, Any] = {
        "displacement": spatial(stage.displacement[:, :2]),
        "rotation": stage.displacement[:, 2],
        "stage_displacement": spatial(stage.stage_displacement[:, :2]),
        "stage_rotation": stage.stage_displacement[:, 2],
        "origin": stage.origin,
        "stress": six_components(stage.stress),
        "stress_effective": six_components(stage.stress_effective),
        "sigma_1": sigma_1,
        "sigma_3": sigma_3,
        "unstable": unstable,
        "load": stage.loads,
        "reaction": stage.reactions,
        "water": stage.water,
    }
    if stage.proof is not None and stage.proof.witness is not None:
        cells["mechanism"] = spatial(stage.proof.witness.velocity[:, :2])
    moved = spatial(corner_displacement(blocks, stage.displacement)[corners])
    return replace(
        outlines,
        point_data={"displacement": moved, **outlines.point_data},
        cell_data={**outlines.cell_data, **{name: values[here] for name, values in cells.items()}},
    )


def outline_grid(blocks: Blocks, chosen: BoolArray) -> Grid:
    """Return some blocks (n,) as given: a polygon a block with points of its own, rocks and joints of the edges."""
    here, corners = np.flatnonzero(chosen), np.flatnonzero(chosen[blocks.owner])
    return Grid(
        points=blocks.vertices[corners],
        offsets=np.concatenate([[0], np.cumsum(np.diff(blocks.offsets)[here])]),
        connectivity=np.arange(len(corners)),
        cell_type=POLYGON,
        point_data={"edge_joint": blocks.edge_joint[corners]},
        cell_data={"block_id": here.astype(np.int32), "rock": blocks.rock[here].astype(np.int32)},
        names={**numbered("rock", blocks.rock_names), **numbered("edge_joint", blocks.joint_names)},
    )


def corner_displacement(blocks: Blocks, displacement: FloatArray) -> FloatArray:
    """Return the displacement of every corner, (n_vertices, 2) [m], by exact rotation about the centroid."""
    return displacement_of(blocks, displacement, blocks.owner, blocks.vertices)


def write_mechanism(blocks: Blocks, velocity: FloatArray, present: BoolArray, path: Path) -> None:
    """Write a collapse mechanism (n, 3): the point array ``velocity`` of the corners, and that of the centroids.

    Blocks that are not there, (n,) of `present`, are left out; ``block_id`` holds the numbers of the others.

    Raises
    ------
    ModelError
        If the file cannot be written.
    """
    blocks, velocity = some_blocks(blocks, present), velocity[present]
    arm = blocks.vertices - blocks.moments.centroid[blocks.owner]
    u, v, turn = velocity[blocks.owner].T
    corners = np.stack([u - turn * arm[:, 1], v + turn * arm[:, 0]], axis=1)
    grid = Grid(
        points=blocks.vertices,
        offsets=blocks.offsets,
        connectivity=np.arange(len(blocks.vertices)),
        cell_type=POLYGON,
        point_data={"velocity": spatial(corners)},
        cell_data={
            "block_id": np.flatnonzero(present).astype(np.int32),
            "centroid_velocity": spatial(velocity[:, :2]),
            "turn": velocity[:, 2],
        },
    )
    try:
        write_vtu(path, grid, parents=True)
    except OSError as error:
        raise ModelError(f"cannot write {path}: {error.strerror or error}; choose another folder") from error


_GRIDS = {
    "blocks": block_grid,
    "contacts": contact_grid,
    "joints": joint_grid,
    "supports": support_grid,
    WATER: water_grid,
    FLOW: flow_grid,
    BOLTS: bolt_grid,
    ZONES: zone_grid,
}


def grid_of_stage(kind: str, results: Results, stage: StageResult, number: int) -> Grid:
    """Return the grid of a kind with the stage's number and name, and the unit of every array that has one."""
    if in_space(results.blocks):
        grid = space_grid(kind, results, stage)
    else:
        grid = _GRIDS[kind](results, stage)
        units = {name: unit_of(kind, name) for name in (*grid.point_data, *grid.cell_data)}
        grid = replace(grid, units={name: unit for name, unit in units.items() if unit})
    return replace(grid, names={**grid.names, f"stage:{stage.name}": number})


def blocks_of_grid(grid: Grid) -> Blocks:
    """Return the outlines, rocks and joints of written blocks; boundaries and excavations are not in the file."""
    return Blocks(
        vertices=grid.points,
        offsets=grid.offsets.astype(np.int32),
        nodes=merge_points(grid.points, MERGE_TOLERANCE),
        rock=grid.cell_data["rock"],
        rock_names=grid.names_of("rock"),
        edge_joint=grid.point_data["edge_joint"],
        joint_names=grid.names_of("edge_joint"),
    )
