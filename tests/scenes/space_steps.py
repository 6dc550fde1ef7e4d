"""Steps of models in space that several tests make: contacts at a random position, the tangent and its derivative."""

import numpy as np
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.movements import turned as turned_by
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.three_d.contacts.history import PointHistory
from tests.scenes.polyhedra import box

TANGENT = 1e-8  # of the greatest entry: differences of forces with steps of 1e-7
TILT = np.array([0.2, -0.3, 0.15])  # rad: of the whole model, so that frames differ from the axes
SOLIDS = [
    box((0, 0, -1), (1, 1, 0)),
    box((0, 0, 0), (1, 1, 1)),
    box((1, 0, 0), (2, 1, 1)),
    box((0, 0, 1), (1, 1, 2)),
]


def step_of(model):
    """Return the equations of the first step."""
    engine = Continuation(model, bsm.Options(threads=1), lambda *_: None)
    contacts = engine.system.gather(PointHistory.none(), engine.system.start, first=True)
    return StepEquations(engine.system, engine.factors, contacts, engine.system.start, 0.0)


def turned_and_moved(system, seed, size):
    """Return the whole model turned by `TILT`, its blocks moved by random small movements."""
    turn = np.tile(TILT, (len(system.start), 1))
    position = np.hstack([turned_by(system.centroid, turn) - system.centroid, turn])
    return system.moved_by(position, size * np.random.default_rng(seed).normal(size=position.shape))


def assert_tangent(step, position):
    """Assert that the tangent at a position (n, 6) is the derivative of minus the forces."""
    pattern, data = step.pattern, step.tangent(step.evaluate(position))
    count, row = pattern.rows, np.repeat(np.arange(pattern.rows), np.diff(pattern.row_start))
    found = np.zeros((count, 6, count, 6))
    for place, (i, j) in enumerate(zip(row, pattern.column, strict=True)):
        found[i, :, j] += data[place]
    size, exact = 1e-7, np.zeros((6 * count, 6 * count))
    for k in range(len(exact)):
        change = np.zeros_like(position)
        change.flat[k] = size
        ahead, behind = (step.evaluate(step.moved_by(position, sign * change)).forces for sign in (1, -1))
        exact[:, k] = -(ahead - behind).ravel() / (2 * size)
    assert_allclose(found.reshape(exact.shape), exact, atol=TANGENT * np.abs(exact).max())
