"""Contacts whose law jumps where they open: those that Newton's method is caught in break, and no others."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.continuation import first_step, strategies
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.methods import brittle
from bsm_mesh.solve.methods import subdomain_newton as subdomain
from bsm_mesh.solve.methods.brittle import NEAR, contacts_at_strength_drop
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

STIFFNESS, COHESION = 1e9, 1e6  # Pa/m, Pa
PRESSED, SHEARED = 1e-7, 2e-4  # of the left corner [m]


def block_on_a_base(cohesion: float = COHESION, tension: float = 0.0) -> Step:
    """Return the step of a square metre on a base."""
    law = bsm.MohrCoulomb(friction=30.0, cohesion=cohesion)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([[(0, 0), (4, 0), (4, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="r"),
        rocks=[bsm.Rock("r", unit_weight=26e3)],
        joints=[bsm.Joint("J", STIFFNESS, STIFFNESS, law=law, tensile_strength=tension)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
    )
    run = Continuation(model, bsm.Options(), lambda *_: None)
    contacts = run.system.gather(run.begin.history, run.system.start, first=True)
    return Step(run.system, run.factors, contacts, run.system.start, run.min_lam)


def caught(step: Step, turn: float, pressed: float = PRESSED) -> np.ndarray:
    """Return the contacts that break where the left corner is hardly pressed, and a correction turns the block."""
    position = step.start.copy()
    position[1] += [SHEARED, -pressed - 1e-5, -2e-5]  # the left corner at -pressed, the right one 20 micrometres deeper
    correction = np.zeros_like(position)
    correction[1, 2] = -turn  # clockwise: the left corner lifts by turn / 2
    return contacts_at_strength_drop(step, step.residual_at(position), correction)


def test_a_corner_that_carries_shear_and_would_open_is_released():
    step = block_on_a_base()
    rows = caught(step, 10 * PRESSED)
    assert len(rows) == 1
    at = step.evaluate(step.start + np.array([[0, 0, 0], [SHEARED, -PRESSED - 1e-5, -2e-5]]))
    assert at.closed[rows].all()
    assert at.pressure[rows] == pytest.approx(0.5 * STIFFNESS * PRESSED, rel=0.01)
    step.fail_contacts(rows)
    again = step.evaluate(step.start + np.array([[0, 0, 0], [SHEARED, -PRESSED - 1e-5, -2e-5]]))
    assert abs(again.shear[rows]) == pytest.approx(np.tan(np.radians(30)) * again.pressure[rows])
    assert len(caught(step, 10 * PRESSED)) == 0


def test_one_that_opens_late_on_the_way_does_not():
    assert len(caught(block_on_a_base(), 2 * PRESSED / NEAR * 0.9)) == 0


def test_without_cohesion_nothing_jumps():
    assert len(caught(block_on_a_base(cohesion=0.0), 10 * PRESSED)) == 0


def test_tensile_strength_holds_and_breaks():
    """The corner bears tension to 1e5 Pa: 100 micrometres of opening, and is broken close behind."""
    step = block_on_a_base(tension=1e5)
    assert len(caught(step, 10 * PRESSED)) == 0
    rows = caught(step, 1e-4, pressed=-0.99e-4)
    assert len(rows) == 1
    step.fail_contacts(rows)
    assert step.contacts.tension[rows] == 0


def test_releasing_no_contact_changes_nothing():
    step = block_on_a_base()
    contacts = step.contacts
    step.fail_contacts(np.zeros(0, int))
    assert step.contacts is contacts


def tunnel(cohesion: float, size: float) -> bsm.Model:
    """Return a square of Voronoi cells under in-situ stress, of which a stage excavates a circle."""
    from bsm_mesh.geometries import Region, RockMass, Voronoi, cut_blocks, rectangle

    region, cells = Region(outline=rectangle(-50, -50, 50, 50), rock="r"), Voronoi(name="J", size=size, rounds=5)
    cut = cut_blocks(RockMass(regions=[region], joints=[cells], seed=1))
    polygons = np.split(cut.points[cut.corners], cut.rings[1:-1])
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    circle = tuple(zip(10 * np.cos(turn), 10 * np.sin(turn), strict=True))
    law = bsm.MohrCoulomb(friction=35.0, cohesion=cohesion)
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=[bsm.Joint("J", 1e10, 1e10, law=law)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[k for k, corners in enumerate(polygons) if np.abs(corners).max() > 50 - 1e-6])],
        in_situ=bsm.InSitu(surface=200.0, k0=1.0),
        stages=[bsm.Stage(name="tunnel", excavate=(circle,))],
    )


def test_a_tunnel_in_whose_wall_joints_fail_needs_it(monkeypatch):
    """Without the rule Newton's method stands still in the first step of the excavation."""
    pytest.importorskip("shapely")

    def first_step() -> int:
        stage = bsm.run(tunnel(cohesion=0.5e6, size=1.6), bsm.Options(max_steps=2)).stages[-1]
        return stage.steps[0].factorizations

    with_it = first_step()
    with monkeypatch.context() as whole_alone:
        whole_alone.setattr(subdomain, "release_brittle_contacts", lambda *_: False)
        assert with_it < first_step(), "in the blocks solved apart too"
    monkeypatch.setattr(brittle, "contacts_at_strength_drop", lambda *_: np.zeros(0, int))
    assert 2 * with_it < first_step()


@pytest.mark.parametrize("moving", [False, True])
def test_failures_of_a_rejected_attempt_are_undone(monkeypatch, moving):
    def leads_nowhere(step: Step, position: np.ndarray, *_: float, **__: bool) -> Attempt:
        step.fail_contacts(np.array([0]))
        return Attempt(position, step.evaluate(position), converged=False)

    step = block_on_a_base()
    assert not step.contacts.failed.any()
    monkeypatch.setattr(strategies if moving else first_step, "regularized_newton", leads_nowhere)
    if moving:
        step.lam = 1 / step.system.d
        found = strategies.MovingSteps(excavated=False).solve(step, 1e-3, from_rest=False, failures=0)
    else:
        found = first_step.solve_at_once(step, 1e-6)
    assert found.converged
    assert not step.contacts.failed.any()
