"""Models with flow in their joints."""

import numpy as np

import bsm_mesh as bsm

CLOSE = 1e-9


def on_two_joints(**flow):
    """Return two loaded blocks on a fixed base, which touch at one point: the joints below them are in series.

    Water is at 20 m to the left of the base and at 2 m to its right. The joints resist no shear, so that blocks
    that turn press on them with nothing but their loads.
    """
    base = [(0, -1), (2, -1), (4, -1), (4, 0), (2, 0), (0, 0)]
    one, other = [(0, 0), (2, 0), (1.9, 1), (0, 1)], [(2, 0), (4, 0), (4, 1), (2.1, 1)]
    blocks = bsm.Blocks.from_polygons([base, one, other], rock="rock")
    blocks = blocks.with_joint("J1", lambda x, y: abs(y) < CLOSE)
    blocks = blocks.with_boundary("left", lambda x, y: (abs(x) < CLOSE) & (y < CLOSE))
    blocks = blocks.with_boundary("right", lambda x, y: (abs(x - 4) < CLOSE) & (y < CLOSE))
    joint = bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1.0, aperture=0.4e-3, residual_aperture=0.02e-3)
    loads = [
        bsm.PointLoad(block=1, point=(1.0, 0.5), force=(0, -600e3)),
        bsm.PointLoad(block=2, point=(3.0, 0.5), force=(0, -240e3)),
    ]
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0)],
        joints=[joint],
        default_joint="J1",
        supports=[bsm.Fixed(blocks=[0]), bsm.Roller(blocks=[1, 2], direction=0)],
        loads=loads,
        flow=bsm.Flow(head={"left": 20.0, "right": 2.0}, **{"tolerance": 1e-9} | flow),
    )


def bricks(columns=4, rows=3, width=2.0, height=1.0, *, aperture=0.5e-3, residual=0.05e-3, **model):
    """Return a wall of rectangular blocks with joints between all, on rollers to the sides and below.

    Its boundaries are left, right, bottom and top.
    """
    corners = np.array([(0, 0), (width, 0), (width, height), (0, height)])
    polygons = [corners + np.array([i * width, j * height]) for j in range(rows) for i in range(columns)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock")
    x1, y1 = columns * width, rows * height
    sides = {
        "left": lambda x, y: abs(x) < CLOSE,
        "right": lambda x, y: abs(x - x1) < CLOSE,
        "bottom": lambda x, y: abs(y) < CLOSE,
        "top": lambda x, y: abs(y - y1) < CLOSE,
    }
    for name, where in sides.items():
        blocks = blocks.with_boundary(name, where)
    joint = bsm.Joint("J1", normal_stiffness=5e9, shear_stiffness=5e9, aperture=aperture, residual_aperture=residual)
    given = {
        "supports": [bsm.NormalRoller(boundary=name) for name in ("left", "right", "bottom")],
        "rocks": [bsm.Rock("rock", unit_weight=26e3)],
        "joints": [joint],
        "default_joint": "J1",
    }
    return bsm.Model(blocks=blocks, **given | model)


def dam(*, drain=None, **flow):
    """Return a dam, one block 10 m wide and 12 m high, on a fixed base: the joint between them is all there is.

    Water stands 11 m high upstream (left) and 2 m high downstream.
    """
    ground = [(-4, -3), (14, -3), (14, 0), (10, 0), (0, 0), (-4, 0)]
    blocks = bsm.Blocks.from_polygons([ground, [(0, 0), (10, 0), (3, 12), (0, 12)]], rock="rock")
    blocks = blocks.with_boundary("upstream", lambda x, y: (x < CLOSE) & (y > -CLOSE))
    blocks = blocks.with_boundary("downstream", lambda x, y: (x > 10 - CLOSE) & (abs(y) < CLOSE))
    joint = bsm.Joint(
        "base",
        normal_stiffness=5e9,
        shear_stiffness=5e9,
        aperture=0.4e-3,
        residual_aperture=0.04e-3,
        law=bsm.MohrCoulomb(friction=50, cohesion=1e6),
        tensile_strength=1e6,
    )
    drains = () if drain is None else (drain,)
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=24e3)],
        joints=[joint],
        default_joint="base",
        supports=[bsm.Fixed(blocks=[0])],
        flow=bsm.Flow(head={"upstream": 11.0, "downstream": 2.0}, drains=drains, **flow),
    )
