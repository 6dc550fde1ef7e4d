"""Models of blocks on one kind of joint or with named sides, and where blocks are at the end."""

from __future__ import annotations

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.solve.bolts.installed import InstalledBolts
from tests.scenes.shapes import turned

GAMMA = 25e3  # N/m3
LINEAR = bsm.Options(scheme="linear")


def model_of(
    blocks, *, friction=35.0, kn=1e9, ks=None, law=None, joint=None, gamma=GAMMA, fixed=(0,), supports=None, **given
):
    """Return a model of blocks, or of polygons, on one kind of joint; `ks` is `kn` where not given."""
    if not isinstance(blocks, bsm.Blocks | bsm.Polyhedra):
        blocks = bsm.Blocks.from_polygons(blocks, rock="rock")
    joint = joint or bsm.Joint("J", kn, kn if ks is None else ks, law=law or bsm.MohrCoulomb(friction=friction))
    rocks = given.pop("rocks", [bsm.Rock(name, unit_weight=gamma) for name in blocks.rock_names])
    return bsm.Model(
        blocks=blocks,
        rocks=rocks,
        joints=[joint],
        default_joint=joint.name,
        supports=[bsm.Fixed(blocks=list(fixed))] if supports is None else supports,
        **given,
    )


def stiff_model(blocks, *, friction, held, default_joint="joint"):
    """Return a model of blocks of elastic rock, in the plane or in space, on one kind of stiff joint."""
    law = bsm.MohrCoulomb(friction=friction)
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3, young=30e9, poisson=0.25)],
        joints=[bsm.Joint("joint", normal_stiffness=1e10, shear_stiffness=5e9, law=law)],
        default_joint=default_joint,
        supports=[bsm.Fixed(blocks=held)],
    )


def moved_polygons(results):
    """Return the polygons of the blocks as they are at the end."""
    blocks, displacement = results.blocks, results.stages[-1].displacement
    centroid = blocks.moments.centroid
    return [
        turned(blocks.polygon(b) - centroid[b], np.degrees(displacement[b, 2]), centroid[b] + displacement[b, :2])
        for b in range(blocks.count)
    ]


def admissible_at(results, friction):
    """Return whether forces at the final contact points can carry the final loads, each within its friction cone."""
    from scipy.optimize import linprog

    stage = results.stages[-1]
    c, slope = stage.contacts, np.tan(np.radians(friction))
    edges = [slope * sign * np.column_stack([-c.normal[:, 1], c.normal[:, 0]]) - c.normal for sign in (1, -1)]
    columns = np.zeros((3 * results.blocks.count, 2 * len(c.point)))
    centroid = results.blocks.moments.centroid + stage.displacement[:, :2]
    for k, edge in enumerate(edges):
        place = np.arange(len(c.point)) + k * len(c.point)
        for block, sign in ((c.block_b, 1.0), (c.block_a, -1.0)):
            arm = c.point - centroid[block]
            moment = arm[:, 0] * edge[:, 1] - arm[:, 1] * edge[:, 0]
            for row, part in enumerate((*edge.T, moment)):
                columns[3 * block + row, place] += sign * part
    free = np.repeat(~np.isin(np.arange(results.blocks.count), stage.supports.block), 3)
    right = -stage.loads.reshape(-1)[free] / stage.reference_weight
    return linprog(np.ones(columns.shape[1]), A_eq=columns[free], b_eq=right).status == 0


def installed_bolts(bolts, blocks: bsm.Blocks, position: np.ndarray) -> InstalledBolts:
    """Return bolts in blocks without weight, installed at a position."""
    return InstalledBolts.of(bsm.Model(blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=0)], bolts=bolts), position)


def framed(blocks: bsm.Blocks, width: float, height: float) -> bsm.Blocks:
    """Return the blocks of a rectangle with its four sides as boundaries."""
    off = 1e-6 * max(width, height)
    return (
        blocks.with_boundary("left", lambda x, y: x < off)
        .with_boundary("right", lambda x, y: x > width - off)
        .with_boundary("bottom", lambda x, y: y < off)
        .with_boundary("top", lambda x, y: y > height - off)
    )


def stress_on_sides(stress: np.ndarray) -> list[bsm.Traction]:
    """Return the tractions of a uniform stress on the four sides of a `framed` rectangle."""
    normals = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}
    return [bsm.Traction(boundary=side, traction=tuple(stress @ n)) for side, n in normals.items()]
