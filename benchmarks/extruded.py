"""The plane's own models as slices of space, 1 m thick: verdicts side by side (``python -m benchmarks.extruded``).

Corners that touch the middle of an edge become corners of it, so that slices share whole faces. Models whose blocks are
not convex, or with bolts, water, flow, loads or prescribed displacements, are left out.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.stages import presence
from bsm_mesh.model.supports import bars_of
from bsm_mesh.three_d.blocks.solids import arrays_of_solids

ROOT = Path(__file__).parents[1]
ON_EDGE = 1e-7  # of the model's size: distance of a corner that lies on an edge
SMALL = 1e-6  # of the displacement: less is rounding
NOT_IN_SPACE = ("bolts", "water", "flow", "loads", "in_situ", "face_water")


class NoSliceError(ValueError):
    """A model of the plane that has no slice, and why."""


def extruded(model: bsm.Model) -> bsm.Model:
    """Return a model of the plane as a slice of space from y = 0 to 1 m; x stays, the plane's y is z.

    Raises
    ------
    NoSliceError
        For a model with parts that polyhedra do not have.
    """
    given = [name for name in NOT_IN_SPACE if getattr(model, name)]
    given += ["shaking, water or loads of a stage" for s in model.stages if s.shaking or s.water or s.loads or s.flow]
    if given:
        raise NoSliceError(f"has {', '.join(given)}")
    blocks, turn = model.blocks, np.radians(-90.0 - model.gravity_direction)
    bars = bars_of(model.supports, blocks)
    held = np.unique(bars.block)
    if (np.bincount(bars.block)[held] < 3).any() or bars.value.any():
        raise NoSliceError("supports do not hold blocks in all directions")
    corners = blocks.vertices @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    outlines, joints = _outlines(blocks, corners)
    rocks = [blocks.rock_names[number] for number in blocks.rock]
    arrays = arrays_of_solids([_prism(outline) for outline in outlines], rocks, None, 1e-9)
    arrays |= {"joint_names": blocks.joint_names, "face_joint": _joints_of_faces(arrays, joints)}
    here = presence(model.stages, blocks)
    stages = [
        replace(
            stage,
            excavate=tuple(np.flatnonzero(before & ~now).tolist()),
            fill=tuple(np.flatnonzero(now & ~before).tolist()),
        )
        for stage, before, now in zip(model.stages, here, here[1:], strict=False)
    ]
    return bsm.Model(
        blocks=bsm.Polyhedra(**arrays),  # type: ignore[arg-type]  # polyhedra answer to the same names
        rocks=model.rocks,
        joints=model.joints,
        default_joint=model.default_joint,
        supports=[bsm.Fixed(blocks=held.tolist())],
        gravity_horizontal=model.gravity_horizontal,
        gravity_vertical=model.gravity_vertical,
        contact_points="corners",
        stages=stages,
    )


def _outlines(blocks: bsm.Blocks, corners: FloatArray) -> tuple[list[FloatArray], dict[tuple[float, float], int]]:
    """Return the blocks' outlines with every corner on them, and the joint of every piece of an edge by its middle."""
    reach = ON_EDGE * float(np.ptp(corners, axis=0).max())
    outlines, joints = [], {}
    for first, last in zip(blocks.offsets, blocks.offsets[1:], strict=False):
        rows = np.arange(first, last)
        pieces = []
        for k, following in zip(rows, np.roll(rows, -1), strict=True):
            along = corners[following] - corners[k]
            length = np.hypot(*along)
            part = (corners - corners[k]) @ along / length**2
            off = np.abs(_cross(along, corners - corners[k])) / length
            inside = (off < reach) & (part * length > reach) & ((1 - part) * length > reach)
            places, chosen = np.unique(np.append(0.0, np.round(part[inside], 9)), return_index=True)
            pieces.append(corners[np.append(k, np.flatnonzero(inside))[chosen]])
            ends = np.append(places, 1.0)
            for middle in corners[k] + ((ends[:-1] + ends[1:]) / 2)[:, None] * along:
                key = _key(middle)
                joints[key] = max(joints.get(key, -1), int(blocks.edge_joint[k]))
        outline = np.concatenate(pieces)
        sides = np.roll(outline, -1, axis=0) - outline
        if (_cross(sides, np.roll(sides, -1, axis=0)) < -(reach**2)).any():
            raise NoSliceError("has blocks that are not convex")
        outlines.append(outline)
    return outlines, joints


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the products of plane vectors (..., 2)."""
    found: FloatArray = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return found


def _prism(outline: FloatArray) -> tuple[FloatArray, list[tuple[int, ...]]]:
    """Return corners and faces of an outline in x and z, from y = 0 to 1 m."""
    k = len(outline)
    front, back = (np.column_stack([outline[:, 0], np.full(k, y), outline[:, 1]]) for y in (0.0, 1.0))
    sides = [(i, k + i, k + (i + 1) % k, (i + 1) % k) for i in range(k)]
    return np.concatenate([front, back]), [tuple(range(k)), tuple(range(2 * k - 1, k - 1, -1)), *sides]


def _joints_of_faces(arrays: dict[str, np.ndarray], joints: dict[tuple[float, float], int]) -> np.ndarray:
    """Return the joint of every face between two blocks, by its middle."""
    points, offsets = arrays["vertices"][arrays["face_vertices"]], arrays["face_offsets"]
    found = np.full(len(offsets) - 1, -1, dtype=np.int32)
    for face in np.flatnonzero(arrays["face_cells"][:, 1] >= 0):
        middle = points[offsets[face] : offsets[face + 1]].mean(axis=0)
        found[face] = joints.get(_key(middle[[0, 2]]), -1)
    return found


def _key(point: FloatArray) -> tuple[float, float]:
    return float(np.round(point[0], 6)) + 0.0, float(np.round(point[1], 6)) + 0.0


def compared(path: Path) -> Iterator[str]:
    """Yield the columns of a row: blocks, verdicts in both, displacement, blocks unstable in one alone, seconds."""
    model = bsm.load(path)
    assert not in_space(model.blocks)
    slice_of_it = extruded(model)
    seconds = []
    runs = []
    for each in (model, slice_of_it):
        begun = time.process_time()
        runs.append(bsm.run(each, bsm.Options(threads=1)))
        seconds.append(time.process_time() - begun)
    plane, space = ([str(stage.status) for stage in run.stages] for run in runs)
    yield str(model.blocks.count)
    yield ", ".join(plane)
    yield "the same" if plane == space else ", ".join(space)
    last = [run.stages[-1] for run in runs]
    turn = np.radians(-90.0 - model.gravity_direction)
    flat = last[0].displacement[:, :2] @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    there = np.setdiff1d(np.arange(model.blocks.count), np.concatenate([run.unstable_blocks for run in runs]))
    off = np.abs(last[1].displacement[there][:, [0, 2]] - flat[there]).max(initial=0.0)
    size = np.abs(flat[there]).max(initial=0.0)
    ratio = off / size if size > 0 else 0.0
    told = f"{ratio:.0e}" if ratio > SMALL else f"below {SMALL:.0e}"
    yield told if runs[0].status == runs[1].status == "stable" else "-"
    yield str(len(np.setxor1d(*(run.unstable_blocks for run in runs))))
    yield f"{seconds[0]:.1f}, {seconds[1]:.1f}"


def main() -> None:
    """Print a row a model file; all of the examples by default."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.extruded", description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*", type=Path, help="model files of the plane; the examples by default")
    paths = parser.parse_args().models or sorted((ROOT / "examples").glob("*/*.toml"))
    print("| model | blocks | plane | space | displacement off by | unstable in one alone | processor seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for path in paths:
        name = f"{path.parent.name}/{path.stem}"
        try:
            print(f"| {name} | {' | '.join(compared(path))} |", flush=True)
        except (NoSliceError, bsm.ModelError) as reason:
            print(f"{name} is left out: {str(reason).splitlines()[0]}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
