"""Flow in the joints to a VTU grid, and back: a line a joint piece, then one a part of a boundary under water."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.converters.vtk_files import Grid, spatial
from bsm_mesh.converters.vtk_library import LINE, numbered
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results

BOUNDARY = "boundary under water"  # the joint -1


def flow_grid(results: Results, stage: StageResult) -> Grid:
    """Return the joints in which water flows, as the blocks were given, with points of their own.

    Points have head, pressure and what leaves there; cells aperture, discharge, mean velocity.
    """
    flow = stage.flow
    assert flow is not None
    m, s = len(flow.first), len(flow.shore)
    node = np.stack([flow.first, flow.last], axis=1).reshape(-1)
    pressure = _at_ends(flow)
    level = flow.shore[:, :, 1].reshape(-1)
    nowhere, nothing = np.full(2 * s, -1), np.zeros(2 * s)
    discharge = np.concatenate([flow.discharge, np.zeros(s)])
    aperture = np.concatenate([flow.aperture, np.zeros((s, 2))])
    lines = np.concatenate([flow.lines, flow.shore])
    along = lines[:, 1] - lines[:, 0]
    unit = along / np.maximum(np.hypot(*along.T), np.finfo(float).tiny)[:, None]
    mean = aperture.mean(axis=1)
    velocity = np.where(mean > 0, discharge / np.where(mean > 0, mean, 1.0), 0.0)
    cells: dict[str, Any] = {
        "joint": np.concatenate([flow.joint, np.full(s, -1)]).astype(np.int32),
        "aperture": mean,
        "discharge": discharge,
        "velocity": spatial(velocity[:, None] * unit),
        "water_pressure": np.concatenate([flow.mean_pressure, flow.shore_pressure.mean(axis=1)]),
        "aperture_at_ends": aperture,
        "wet": np.concatenate([flow.wet, np.tile([0.0, 1.0], (s, 1))]),
        "wet_pressure": np.concatenate([flow.wet_pressure, flow.shore_pressure]),
    }
    points: dict[str, Any] = {
        "head": np.concatenate([flow.head[node], level]),
        "water_pressure": np.concatenate([pressure.reshape(-1), flow.shore_pressure.reshape(-1)]),
        "filled": np.concatenate([flow.filled[node], nothing + 1]),
        "outflow": np.concatenate([flow.outflow[node], nothing]),
        "place": np.concatenate([flow.place[node], nowhere]).astype(np.int32),
        "node": np.concatenate([node, nowhere]).astype(np.int32),
        "displacement": np.zeros((2 * (m + s), 3)),
    }
    return Grid(
        points=lines.reshape(-1, 2),
        offsets=2 * np.arange(m + s + 1),
        connectivity=np.arange(2 * (m + s)),
        cell_type=LINE,
        point_data=points,
        cell_data=cells,
        names={**numbered("joint", results.joint_names), f"joint:{BOUNDARY}": -1, **numbered("place", flow.places)},
    )


def _at_ends(flow: FlowResult) -> Any:
    """Return the pressure at both ends of every piece, (m, 2) [Pa]: 0 where its end is dry."""
    reached = np.stack([flow.wet[:, 0] <= 0, flow.wet[:, 1] >= 1], axis=1)
    return np.where(reached, flow.wet_pressure, 0.0)


def flow_of_grid(grid: Grid, told: dict[str, Any]) -> FlowResult:
    """Return the written flow; `told` are the numbers that the summary keeps."""
    cells, points = grid.cell_data, grid.point_data
    piece = np.flatnonzero(cells["joint"] >= 0)
    lines = grid.points.reshape(-1, 2, 2)
    shore = np.flatnonzero(cells["joint"] < 0)
    node = points["node"].reshape(-1, 2)[piece]
    at = points["node"] >= 0
    of, count = points["node"][at], int(told["nodes"])

    def whole(values: Any) -> Any:
        found = np.zeros((count, *values.shape[1:]), dtype=values.dtype)
        found[of] = values[at]
        return found

    return FlowResult(
        point=whole(grid.points),
        head=whole(points["head"]),
        filled=whole(points["filled"]),
        outflow=whole(points["outflow"]),
        place=whole(points["place"]),
        places=tuple(told["places"]),
        first=node[:, 0],
        last=node[:, 1],
        joint=cells["joint"][piece],
        aperture=cells["aperture_at_ends"][piece],
        discharge=cells["discharge"][piece],
        wet=cells["wet"][piece],
        wet_pressure=cells["wet_pressure"][piece],
        shore=lines[shore],
        shore_pressure=cells["wet_pressure"][shore],
        imbalance=told["imbalance"],
        rounds=told["rounds"],
        change=told["change"],
    )
