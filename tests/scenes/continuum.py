"""Slabs of 4 m x 3 m of elastic rock, their blocks in every shape that the continuum solution must take."""

import dataclasses

import numpy as np

import bsm_mesh as bsm
from tests.scenes.models import framed, model_of
from tests.scenes.shapes import grid, rectangle, running_bond, turned

EXACT = 1e-9  # linear fields lie in both element spaces, the gravity column in the second-order one; rounding is lost
E, MU = 50e9, 0.25
STRESS = np.array([(-3.0, 1.2), (1.2, -7.0)]) * 1e6
ROCK = bsm.Rock("rock", unit_weight=0, young=E, poisson=MU)
HEAVY = bsm.Rock("rock", unit_weight=26e3, young=E, poisson=MU)
PINNED = [bsm.Fixed(point=(0, 0)), bsm.Roller(point=(4, 3), direction=90)]
L_SHAPE = np.array([(0, 0), (4, 0), (4, 0.5), (0.5, 0.5), (0.5, 3), (0, 3)])  # its centroid does not see all of it
SHAPES = {
    "triangles": [np.array(c)[k] for c in grid(4, 3) for k in ([0, 1, 2], [0, 2, 3])],
    "squares": grid(4, 3),
    "wall in bond": running_bond(6, 4),
    "posts on a beam": [rectangle(0, 0, 4, 1), *grid([0, 0.5, 2, 2.6, 4], [1, 3])],
    "concave": [L_SHAPE, rectangle(0.5, 0.5, 4, 3)],
    "triangle on long edges": [
        rectangle(0, 0, 4, 1),
        *([np.array([(0, 1), (1.5, 1), (0, 3)]), np.array([(1.5, 1), (4, 1), (4, 3)])]),
        np.array([(1.5, 1), (4, 3), (0, 3)]),
    ],
}


def slab(shape):
    return framed(bsm.Blocks.from_polygons(SHAPES[shape], rock="rock"), 4.0, 3.0)


def bolted(model, *, load, rigid):
    """Return a model under a part of its weights and pressures, in its own rock or in rigid rock."""
    fields = {"stiffness": "rigid"} if rigid else {}
    pressures = [one for one in model.loads if isinstance(one, bsm.Pressure)]
    assert len(pressures) == len(model.loads)
    return model.replace(
        rocks=[dataclasses.replace(rock, unit_weight=load * rock.unit_weight, **fields) for rock in model.rocks],
        loads=[dataclasses.replace(one, pressure=tuple(load * np.asarray(one.pressure))) for one in pressures],
    )


def cantilever(columns, poisson, *, mixed):
    """Return a beam of 8 m x 2 m under its weight, in four times as many square blocks along as across.

    Mixed: a square at the free end is cut in two triangles, and with one triangle there all blocks become triangles.
    """
    squares = [
        np.array(corners) for corners in grid(np.linspace(0, 8, columns + 1), np.linspace(0, 2, columns // 4 + 1))
    ]
    at_end = [k for k, corners in enumerate(squares) if corners.mean(axis=0)[0] > 8 - 8 / columns]
    if mixed:
        last = squares.pop(at_end[-1])
        squares += [last[[0, 1, 2]], last[[0, 2, 3]]]
    blocks = bsm.Blocks.from_polygons(squares, rock="rock").with_boundary("left", lambda x, y: x < 1e-9)
    rock = bsm.Rock("rock", unit_weight=26e3, young=E, poisson=poisson)
    return bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(boundary="left")])


def sag(model, displacement):
    """Return the mean vertical displacement of the blocks from 6 to 7 m along a cantilever."""
    x = model.blocks.moments.centroid[:, 0]
    there = (x > 6) & (x < 7)
    return -np.average(displacement[there, 1], weights=model.blocks.moments.area[there])


def on_a_slope(degrees, friction, fields):
    """Return a flat block on a slope at an angle [degrees]."""
    shapes = [turned(np.array(rectangle(*corners)), degrees) for corners in ((-2, -1, 3, 0), (0, 0, 1, 0.4))]
    law = bsm.MohrCoulomb(friction=friction)
    return model_of(shapes, rocks=[bsm.Rock("rock", unit_weight=26e3, **fields)], law=law)
