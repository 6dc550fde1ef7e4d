"""Content of the page of ``bsm-mesh view``: outlines, and every array of the results in every state, in few bytes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.frames import Frame, evenly, frames_in
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.pages.cell_values import CellValues, cell_values
from bsm_mesh.results.joint_sets import ROCK_FACE

if TYPE_CHECKING:
    from bsm_mesh.converters.vtk_files import Grid

MOST_BYTES = 100e6  # of numbers: 29 states of 10 000 blocks; a browser opens 17 of them in 3 s
MOTION = {  # by dimension: displacements and rotations, by which blocks are moved
    2: ("displacement x", "displacement y", "rotation"),
    3: ("displacement x", "displacement y", "displacement z", "rotation x", "rotation y", "rotation z"),
}
KEPT = (*MOTION[2], *MOTION[3], "rock", "joint")  # even where they are zero throughout
Arrays = dict[str, npt.NDArray[np.float32]]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Layer:
    """The things of a kind in a state: blocks (all there ever are), joints, bolts or the water table.

    Attributes
    ----------
    arrays : dict of str to (k,) float32
        What there is to colour by; NaN where a block is not there.
    ends, moved : (k, 4) float32 [m]
        Of lines: x, y, x, y of their ends from the model's middle, and how they move; none for blocks. In space
        (k, 3): the points of lines and polygons.
    offsets : (n + 1,) int32
        In space: line or polygon n has the points ``offsets[n]`` to ``offsets[n + 1]``; empty in the plane.
    blocks : (k, 2) int32
        Of joints the two blocks; of bolts the bolt, and the number of the element.
    """

    arrays: Arrays
    ends: npt.NDArray[np.float32]
    moved: npt.NDArray[np.float32]
    offsets: IntArray
    blocks: IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class State:
    """A state of the results.

    Attributes
    ----------
    frame : Frame
        Which one.
    layers : dict of str to Layer
        By kind.
    unstable : (k,) int32
        Blocks that fall.
    """

    frame: Frame
    layers: dict[str, Layer]
    unstable: IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ViewData:
    """All that the page shows.

    Attributes
    ----------
    blocks : Blocks
        As they were given.
    middle : (d,) float64 [m]
        From where coordinates count in the page: single precision is enough then.
    states : list of State
        In order.
    left_out : int
        Steps that were written and are not in the page.
    units : dict of str to dict of str to str
        By kind and array.
    names : dict of str to dict of str to tuple of str
        What numbers represent, by kind and array.
    bolt_names : tuple of str
        Names of the bolts.
    falls : list of dict
        Fallen blocks, a row each: ``block``, ``stage``, ``area`` [m2], ``weight`` [N/m], ``x``, ``y`` [m] as given; in
        space the volume as ``area`` [m3], the weight in N, and ``z`` [m].
    """

    blocks: Blocks
    middle: FloatArray
    states: list[State]
    left_out: int
    units: dict[str, dict[str, str]]
    names: dict[str, dict[str, tuple[str, ...]]]
    bolt_names: tuple[str, ...]
    falls: list[dict[str, Any]]


def read_view(saved: SavedResults) -> ViewData:
    """Return the content of the page on a results folder.

    Raises
    ------
    ModelError
        If it is damaged, or too large for a page.
    """
    blocks = saved.blocks()
    low, high = blocks.vertices.min(axis=0), blocks.vertices.max(axis=0)
    reader = _Reader(saved, blocks, (low + high) / 2)
    frames = frames_in(saved)
    ends = {frame: reader.state(frame) for frame in frames if frame.is_end}
    chosen = evenly(frames, _steps_that_fit(saved, list(ends.values()), len(frames) - len(ends)))
    states = _without_zeros([ends[frame] if frame in ends else reader.state(frame) for frame in chosen])
    return ViewData(
        blocks=blocks,
        middle=reader.middle,
        states=states,
        left_out=len(frames) - len(chosen),
        units=reader.units,
        names=reader.names,
        bolt_names=reader.bolt_names,
        falls=_falls(saved, blocks, states),
    )


class _Reader:
    """Reads states, and keeps what all of them share: units and names."""

    def __init__(self, saved: SavedResults, blocks: Blocks, middle: FloatArray) -> None:
        self.saved, self.blocks, self.middle = saved, blocks, middle
        self.units: dict[str, dict[str, str]] = {}
        self.names: dict[str, dict[str, tuple[str, ...]]] = {}
        self.given = {"rock": blocks.rock_names, "joint": (*saved.told["joint_names"], ROCK_FACE)}
        self.bolt_names: tuple[str, ...] = ()

    def state(self, frame: Frame) -> State:
        blocks = self.saved.grid(frame.file("blocks"))
        joints = self._lines("joints", frame, ("block_a", "block_b"), file="contacts" if self.saved.in_space else "")
        layers = {"blocks": self._blocks(blocks), "joints": joints}
        if frame.file("bolts") in self.saved:
            layers["bolts"] = self._lines("bolts", frame, ("bolt", "bolt"))
        table = self.saved.water_table(frame.stage)
        if len(table):
            lines = (table - self.middle).reshape(-1, 2)
            layers["water"] = _layer([], lines, np.zeros_like(lines), np.zeros((len(table), 2)))
        here = blocks.cell_data["block_id"]
        return State(frame=frame, layers=layers, unstable=here[blocks.cell_data["unstable"] > 0].astype(np.int32))

    def _blocks(self, grid: Grid) -> Layer:
        here = grid.cell_data["block_id"]

        def whole(values: FloatArray) -> FloatArray:
            all_of_them = np.full(self.blocks.count, np.nan)
            all_of_them[here] = values
            return all_of_them

        found = [(one, whole(one.values)) for one in self._known("blocks", grid)]
        none = np.zeros((0, len(self.middle)))
        return _layer(found, none, none, np.zeros((0, 2)))

    def _lines(self, kind: str, frame: Frame, numbers: tuple[str, str], *, file: str = "") -> Layer:
        from bsm_mesh.converters.bolt_files import bolts_of_grid

        grid = self.saved.grid(frame.file(file or kind))
        if kind == "bolts":
            self.bolt_names = bolts_of_grid(grid).names
        ends = grid.points[grid.connectivity] - self.middle
        moved = grid.point_data["displacement"][grid.connectivity, : len(self.middle)]
        which = np.stack([grid.cell_data[name] for name in numbers], axis=1)
        offsets = grid.offsets if self.saved.in_space else ()
        return _layer([(one, one.values) for one in self._known(kind, grid)], ends, moved, which, offsets)

    def _known(self, kind: str, grid: Grid) -> list[CellValues]:
        found = cell_values(kind, grid, self.given, in_space=self.saved.in_space)
        self.units.setdefault(kind, {}).update({one.name: one.unit for one in found})
        self.names.setdefault(kind, {}).update({one.name: one.names for one in found if one.names})
        return found


def _layer(
    found: list[tuple[CellValues, FloatArray]], ends: FloatArray, moved: FloatArray, blocks: Any, offsets: Any = ()
) -> Layer:
    width = 4 if ends.shape[1] == 2 else 3
    return Layer(
        arrays={one.name: values.astype(np.float32) for one, values in found},
        ends=ends.reshape(-1, width).astype(np.float32),
        moved=moved.reshape(-1, width).astype(np.float32),
        offsets=np.array(offsets, dtype=np.int32),
        blocks=blocks.astype(np.int32),
    )


def _bytes(state: State) -> int:
    return sum(
        sum(values.nbytes for values in layer.arrays.values()) + layer.ends.nbytes + layer.moved.nbytes
        for layer in state.layers.values()
    )


def _steps_that_fit(saved: SavedResults, ends: list[State], steps: int) -> int:
    """Return how many steps fit in a page in addition to the ends of the stages."""
    taken, largest = sum(map(_bytes, ends)), max(map(_bytes, ends), default=0)
    if taken > MOST_BYTES:
        raise ModelError(
            f"{saved.folder}: {taken / 1e6:.0f} MB of numbers are more than the {MOST_BYTES / 1e6:.0f} MB of a page; "
            "look at them with ParaView: bsm-mesh paraview"
        )
    return min(steps, int((MOST_BYTES - taken) / largest)) if largest else steps


def _without_zeros(states: list[State]) -> list[State]:
    """Return the states without arrays that are zero in all of them; by which outlines move stays."""
    shown = {
        (kind, name)
        for state in states
        for kind, layer in state.layers.items()
        for name, values in layer.arrays.items()
        if name in KEPT or np.nan_to_num(values).any()
    }

    def thinned(kind: str, layer: Layer) -> Layer:
        return replace(layer, arrays={name: values for name, values in layer.arrays.items() if (kind, name) in shown})

    return [
        replace(state, layers={kind: thinned(kind, layer) for kind, layer in state.layers.items()}) for state in states
    ]


def _falls(saved: SavedResults, blocks: Blocks, states: list[State]) -> list[dict[str, Any]]:
    """Return the fallen blocks: those taken away in a stage, and every unstable block at its end."""
    rows = []
    for number, told in enumerate(saved.told["stages"]):
        for fall in told.get("falls", ()):
            taken = {name: fall[name] for name in ("block", "area", "weight")}
            rows.append({**taken, **_place(blocks, fall["block"]), "stage": told["name"]})
        state = next(state for state in states if state.frame.is_end and state.frame.stage == number)
        rows += [{**_fallen(blocks, state, block), "stage": told["name"]} for block in told["unstable_blocks"]]
    return rows


def _fallen(blocks: Blocks, state: State, block: int) -> dict[str, Any]:
    """Return the record of an unstable block at the end of a stage; loads that act on it are in its weight."""
    arrays, nothing = state.layers["blocks"].arrays, np.zeros(blocks.count)
    up = "xyz"[blocks.vertices.shape[1] - 1]
    weight = float(arrays.get(f"water {up}", nothing)[block] - arrays.get(f"load {up}", nothing)[block])
    return {"block": block, "area": float(blocks.moments.bulk[block]), "weight": weight, **_place(blocks, block)}


def _place(blocks: Blocks, block: int) -> dict[str, float]:
    return dict(zip("xyz", blocks.moments.centroid[block].tolist(), strict=False))
