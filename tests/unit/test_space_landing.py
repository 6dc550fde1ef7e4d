"""Blocks that land in space: on a face, an edge or a corner, from gaps of any size, and where a slope meets a floor."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.movements import turned as turned_by
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.motion.masses import MotionSettings
from bsm_mesh.solve.step.equations import StepEquations
from bsm_mesh.three_d.contacts.history import PointHistory
from bsm_mesh.three_d.motion.explicit import ExplicitMotion
from tests.scenes.polyhedra import box, model_in_space, prism, rotation

PASSED = 0.01  # of a block: a face that is first seen deeper counts as passed
SLAB = box((-3, -3, -1), (3, 3, 0))
CUBE, FACES = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))


def landed(solids, corners, **more):
    """Return status, end and lowest corner of the last block, by its `corners` (8, 3), in every step of its way."""
    model = model_in_space([*solids, (corners, FACES)], fixed=range(len(solids)), **more)
    centre, lowest = corners.mean(axis=0), []

    def there(position):
        return centre + position[-1, :3] + turned_by(corners - centre, np.tile(position[-1, 3:], (8, 1)))

    run = Continuation(
        model, bsm.Options(threads=1), lambda _, state: lowest.append(there(state().position)[:, 2].min())
    )
    end = run.run()
    return end.status, there(end.position), np.array(lowest)


@pytest.mark.parametrize(
    ("about_y", "about_x", "gap"),
    [
        (0, 0, 1e-4),
        (0, 0, 0.03),
        (10, 0, 0.01),
        (30, 0, 0.02),
        pytest.param(40, 0, 0.005, marks=pytest.mark.heavy),
        pytest.param(45, 0, 0.05, marks=pytest.mark.heavy),
        pytest.param(40, 40, 0.05, marks=pytest.mark.heavy),
        pytest.param(30, 45, 0.01, marks=pytest.mark.heavy),
    ],
)
def test_a_cube_that_drops_rests_on_a_face_by_its_weight(about_y, about_x, gap):
    """However it is turned and near as it is; a face that was first looked for after 5 % of a block was passed."""
    x = rotation(90, about_x) @ rotation(-90, 0)
    corners = CUBE @ (x @ rotation(0, about_y)).T
    status, end, lowest = landed([SLAB], corners + np.array([0, 0, gap - corners[:, 2].min()]))
    assert status == "stable"
    assert lowest.min() > -PASSED
    heights = np.sort(end[:, 2])
    assert heights[:4] == pytest.approx(-26e3 / 1e9, abs=2e-6)
    assert heights[4:] == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("law", [bsm.MohrCoulomb(friction=30), bsm.Patton(friction=30, dilation=30, cohesion=1.0)])
def test_friction_acts_on_a_block_as_it_lands(law):
    """A flat block hits the slab as it moves along: the impact's impulse takes its part of the velocity.

    Velocities are over the root of gravity: it slides by half their square over the friction. Above a pascal the second
    law has that friction too.
    """
    along, down, friction = 0.2, 0.1, np.tan(np.radians(30))
    model = model_in_space([SLAB, box((-0.5, -0.5, 1e-6), (0.5, 0.5, 0.1))], law=law)
    engine = Continuation(model, bsm.Options(threads=1), lambda *_: None)
    start = engine.system.start
    contacts = engine.system.gather(PointHistory.none(), start, first=True)
    step = StepEquations(engine.system, engine.factors, contacts, start, engine.min_lam)
    velocity = np.zeros((2, 6))
    velocity[1, [0, 2]] = along, -down
    settings = MotionSettings(damping=0.0, damps_impacts=True, real_masses=True)
    motion = ExplicitMotion(step, settings, velocity=velocity)
    for _ in range(60):
        motion.advance()
    assert np.abs(motion.velocity).max() < 0.02 * along
    slides = (along - friction * down) ** 2 / (2 * friction)
    assert motion.residual.position[1, 0] == pytest.approx(slides, rel=0.1)


@pytest.mark.heavy
@pytest.mark.parametrize(("dip", "friction"), [(25, 20), (40, 20), (50, 10), (70, 20)])
def test_a_block_that_slides_down_to_a_floor_stays_above_it(dip, friction):
    """Its bottom faces the floor best but lies over the slope; the face that lies over the floor faces it worse."""
    along, across = np.array([(np.cos(t), -np.sin(t)) for t in np.radians([dip, dip - 90])])
    top = -3 * along
    solids = [prism([top, (top[0], -1), (0, -1), (0, 0)]), prism([(0, 0), (0, -1), (12, -1), (12, 0)])]
    corners = (CUBE + 0.5) @ rotation(0, dip).T + np.array([1, 0, 1]) * np.insert(0.01 * across - 1.3 * along, 1, 0)
    status, _, lowest = landed(solids, corners, friction=friction)
    assert lowest[-1] < 0.2  # it has arrived
    assert lowest.min() > -PASSED
    assert status == "stable"


@pytest.mark.parametrize(
    ("turn", "clear"), [(10, 0.01), (40, 0.005), pytest.param(70, 0.01, marks=pytest.mark.heavy), (40, 0.06)]
)
def test_a_corner_that_passes_an_edge_in_the_air_is_not_held(turn, clear):
    """Faces of both look at each other there. Within 3 % of a block its points may push it aside, no more."""
    corners = CUBE @ rotation(0, turn).T
    leftmost = corners[corners[:, 0].argmin()] * (1, 0, 1)
    status, end, _ = landed([SLAB], corners + np.array([3 + clear, 0, 0.02]) - leftmost)
    assert status == "unstable"
    if clear > 0.03:
        assert end[:, 0].min() == pytest.approx(3 + clear, abs=1e-6)
