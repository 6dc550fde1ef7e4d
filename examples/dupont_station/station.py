"""Data of this example: its two cases with their options, the continuum, measured displacements."""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.converters.continuum import solve_continuum
from bsm_mesh.geometries import dupont_station
from bsm_mesh.model.submodel import some_blocks

HERE = Path(__file__).parent
LEFT, RIGHT, FLOOR, CROWN, TOP = -3.0, 3.0, -8.0, 0.0, 9.0  # m
NEAR = 1e-6  # m: a corner this near to a line lies on it
# The measured sections are in Fig. 8.10 only; these are assumed: start on the wall, end in the rock.
EXTENSOMETERS = {
    "crown, upwards": ((0.0, CROWN), (0.0, TOP)),
    "upper right corner, 45 degrees": ((RIGHT, CROWN), (10.0, 7.0)),
    "right wall, level": ((RIGHT, -4.0), (12.0, -4.0)),
    "left wall, level": ((LEFT, -4.0), (-12.0, -4.0)),
}


@dataclass(frozen=True)
class Movement:
    """Displacements (n, 3) [m, m, rad] of blocks."""

    blocks: bsm.Blocks
    displacement: np.ndarray

    def at(self, points, block):
        """Return the displacement (k, 2) [m] of points that move with their blocks."""
        u = self.displacement[block]
        arm = points - self.blocks.moments.centroid[block]
        return u[:, :2] + np.stack([-arm[:, 1], arm[:, 0]], axis=1) * u[:, 2:]

    def on_line(self, x=None, y=None, side=0):
        """Return corners (k, 2) on a line x or y, and their displacement, of blocks above or right of it (side 1)."""
        blocks = self.blocks
        axis, level = (0, x) if x is not None else (1, y)
        beside = (blocks.moments.centroid[blocks.owner, axis] - level) * side >= 0
        chosen = np.flatnonzero((np.abs(blocks.vertices[:, axis] - level) < NEAR) & beside)
        chosen = chosen[np.argsort(blocks.vertices[chosen, 1 - axis], kind="stable")]
        points = blocks.vertices[chosen]
        return points, self.at(points, blocks.owner[chosen])

    def along(self, start, end, count=120):
        """Return distances from `start` [m] and the displacement [m] against that direction, into the opening."""
        start, end = np.array(start), np.array(end)
        length = np.hypot(*(end - start))
        stations = np.linspace(0.01, length - 0.01, count)
        points = start + stations[:, None] * (end - start) / length
        polygons = shapely.polygons(shapely.linearrings(self.blocks.vertices, indices=self.blocks.owner))
        which, block = shapely.STRtree(polygons).query(shapely.points(points), predicate="intersects")
        _, once = np.unique(which, return_index=True)
        return stations[which[once]], -self.at(points[which[once]], block[once]) @ ((end - start) / length)

    def summary(self):
        """Return the numbers of the README: settlement, crown and walls [mm], and where it settles most [m]."""
        top, settled = self.on_line(y=TOP, side=-1)
        greatest = settled[:, 1].argmin()
        crown = [
            u for (x, _), u in zip(*self.on_line(y=CROWN, side=1), strict=True) if LEFT - NEAR <= x <= RIGHT + NEAR
        ]
        told = {
            "settlement": -1e3 * settled[greatest, 1],
            "at": float(top[greatest, 0]),
            "crown": -1e3 * np.array(crown)[:, 1],
        }
        for name, x, side in (("left wall", LEFT, -1), ("right wall", RIGHT, 1)):
            points, u = self.on_line(x=x, side=side)
            wall = (points[:, 1] <= CROWN + NEAR) & (points[:, 1] >= FLOOR - NEAR)
            told[name] = -side * 1e3 * u[wall, 0]
        return told


def load(name="model"):
    """Return the model of Case 1 (`model`) or Case 2 (`bolts`)."""
    return bsm.load(HERE / f"{name}.toml")


def released_in(model, parts):
    """Return the model with the excavation released in so many equal parts."""
    relaxation = tuple((k + 1) / parts for k in range(parts))
    return model.replace(stages=[replace(model.stages[0], relaxation=relaxation)])


def on_layout(model, **parameters):
    """Return the model with blocks of another geometry."""
    with tempfile.TemporaryDirectory() as folder:
        path = dupont_station.build(Path(folder) / "station.msh", **parameters)
        return model.replace(blocks=converters.read_blocks(path), histories=[])  # their points may lie beyond


def with_joints(model, **change):
    """Return the model with joints changed."""
    return model.replace(joints=[replace(joint, **change) for joint in model.joints])


def with_k(model, k):
    """Return the model with another ratio K of horizontal to vertical stress."""
    return model.replace(in_situ=replace(model.in_situ, k0=k))


def with_soil(model, unit_weight):
    """Return the model under 11 m of another soil [N/m3]."""
    pressure = 11.0 * unit_weight
    loads = [replace(load, pressure=pressure) for load in model.loads]
    return model.replace(loads=loads, in_situ=replace(model.in_situ, surcharge=pressure))


def with_pressure(model, pressure):
    """Return Case 1 with another support pressure [Pa]."""
    return model.replace(stages=[replace(model.stages[0], pressure=pressure)])


def with_rock_tension(model, strength):
    """Return the model with a tensile strength of the rock between joints [Pa]."""
    rocks = [replace(rock, tensile_strength=strength) if rock.name == "rock" else rock for rock in model.rocks]
    return model.replace(rocks=rocks)


def with_bolts(model, **change):
    """Return Case 2 with bolts changed."""
    return model.replace(bolts=[replace(bolt, **change) for bolt in model.bolts])


def movement_of(results):
    """Return how the blocks that are left moved at the end of a run."""
    stage = results.stages[-1]
    return Movement(some_blocks(results.blocks, stage.present), stage.displacement[stage.present])


def elastic(model):
    """Return the model without bolts, and with joints that neither slip nor open."""
    joints = [joint.without_law() for joint in model.joints]
    return model.replace(joints=joints, bolts=())


def continuum(model, joints, slips=False, order=2):
    """Return the movement by finite elements, or None where they found no equilibrium.

    Elastic rock; its joints ignored, or interfaces, elastic or (`slips`) with the joints' own laws. `order` of the
    displacements: with 1 interfaces act at the blocks' own contact points.
    """
    model = model.replace(bolts=()) if slips else elastic(model)
    stage = solve_continuum(model, joints=joints, order=order)
    moved = Movement(some_blocks(model.blocks, stage.present), stage.displacement[stage.present])
    return moved if stage.converged else None


def slipping_elements():
    """Return Case 1 as finite elements move its blocks, their joints slipping, to be compared with a run."""
    model = load().replace(title="Finite elements with joints that slip, Case 1")
    return as_elements_move(model, solve_continuum(model, joints=True, order=1))


def elastic_elements():
    """Return Case 1 as finite elements move its blocks, their joints elastic."""
    model = elastic(load()).replace(title="Finite elements with elastic joints, Case 1")
    return as_elements_move(model, solve_continuum(model, joints=True))


def elastic_blocks():
    """Return Case 1 by the linear Block-Spring Model, joints and rock elastic."""
    return bsm.run(elastic(load()), bsm.Options(scheme="linear"))


def as_elements_move(model, solution):
    """Return results of a model whose blocks move as those of a continuum's solution."""
    linear = bsm.run(elastic(model), bsm.Options(scheme="linear"))
    slips = any(joint.law is not None for joint in model.joints)
    status = bsm.results.Status.STABLE if slips and solution.converged else linear.status  # they are at rest
    moved = {"displacement": solution.displacement, "present": solution.present, "status": status}
    last = replace(linear.stages[-1], **moved)
    return replace(linear, title=model.title, stages=(*linear.stages[:-1], last))


def linear_blocks(model):
    """Return the movement by the linear Block-Spring Model: joints and rock elastic, as in the continuum."""
    return movement_of(bsm.run(elastic(model), bsm.Options(scheme="linear")))
