"""Joints that open as they slide: closed forms, consistent tangent, energy, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.dilation import slip_of_step
from bsm_mesh.contact.forces import evaluate
from bsm_mesh.contact.history import commit, restore_history, worn
from bsm_mesh.joint_test.specimen import Specimen, position_of
from bsm_mesh.model.strength import with_strength
from tests.scenes.models import model_of
from tests.scenes.reference import full_matrix
from tests.scenes.shapes import rectangle, turned
from tests.scenes.steps import begun
from tests.unit.test_force_kernels import differences

KN, KS, FRICTION, ANGLE, LAST = 10e9, 2e9, 30.0, 10.0, 5e-3
MU, T = np.tan(np.radians([FRICTION, ANGLE]))
GIVEN = {"dilation_angle": ANGLE, "dilation_slip": LAST}
JOINT = bsm.Joint("J", KN, KS, law=bsm.MohrCoulomb(friction=FRICTION), **GIVEN)


def led(joint, path):
    """Return normal and shear stress [Pa] along a path of shear displacements and openings, (k, 2) [m]."""
    specimen, stresses = Specimen(joint), []
    for shear, opening in path:
        at = position_of(shear, opening)
        contacts = specimen.contacts(at)
        found = specimen.system.evaluate(contacts, at)
        specimen.keep(contacts, found)
        stresses.append((found.forces[1, 1], -found.forces[1, 0]))
    return np.array(stresses), specimen.history


@pytest.mark.parametrize("steps", [1, 7])
@pytest.mark.parametrize("moved", [1e-3, 3e-3, 9e-3])
@pytest.mark.parametrize("way", [-1, 1])
def test_slip_between_walls_that_are_held_presses_them(steps, moved, way):
    """Of the displacement s the slip is x = (s - mu p0 / ks) / (1 + mu t kn / ks), until it has worn off."""
    closure = 1e-4
    path = [(0.0, 0.0), (0.0, -closure), *((way * moved * k / steps, -closure) for k in range(1, steps + 1))]
    stress, history = led(JOINT, path)
    slip = (moved - MU * KN * closure / KS) / (1 + MU * T * KN / KS)
    if slip > LAST:
        slip = moved - MU * KN * (closure + T * LAST) / KS
    pressure = KN * (closure + T * min(slip, LAST))
    assert_allclose(stress[-1], (pressure, way * MU * pressure), rtol=1e-12)
    assert_allclose(history.slip_path, slip, rtol=1e-12)
    assert_allclose(history.offset, T * min(slip, LAST), rtol=1e-12)


def test_sliding_back_opens_on():
    """Opening counts the way, back and forth, and wears off on it."""
    path = [(0.0, 0.0), (0.0, -1e-4), (2e-3, -1e-4), (0.0, -1e-4), (2e-3, -1e-4)]
    _, history = led(JOINT, path)
    there = (2e-3 - MU * KN * 1e-4 / KS) / (1 + MU * T * KN / KS)
    assert 1.2 * there < history.slip_path.mean() < LAST
    assert_allclose(history.offset, T * np.minimum(history.slip_path, LAST), rtol=1e-12)


def test_a_contact_parts_where_it_leaves_the_slope_of_dilation():
    """Led along at more than the dilation angle it is open, at less it is closed; the pressure has no jump there."""
    pressures = []
    for angle in (11.0, 10.0 + 1e-6, 10.0 - 1e-6, 9.0):
        stress, _ = led(JOINT, [(0.0, 0.0), (0.0, -1e-9), (1e-3, 1e-3 * np.tan(np.radians(angle)))])
        pressures.append(stress[-1, 0])
    assert pressures[0] == 0.0
    assert pressures[1] <= 1e-6 * pressures[3]
    assert pressures[2] < 1e-3 * pressures[3]
    assert pressures[3] > 1e4


@pytest.mark.heavy
@pytest.mark.parametrize("angle", [0.0, 10.0, FRICTION])
def test_work_of_a_loop_up_the_slope_of_dilation_and_back_through_the_air(angle):
    """The slip x under the pressure p takes p x (mu - t), as much as nothing at the greatest angle, never less.

    The shear spring lets go by slip too while the pressure falls; the normal spring's energy comes back.
    """
    closure, slip, t = 1e-4, 2e-3, np.tan(np.radians(angle))
    keys = {"dilation_angle": angle, "dilation_slip": LAST} if angle else {"dilation_angle": 0.0, "dilation_slip": None}
    pressure = KN * closure
    elastic = MU * pressure / KS
    corners = [(0, 0), (0, -closure), (elastic, -closure), (elastic + slip, t * slip - closure)]
    corners += [(elastic + slip, 2 * t * slip + closure), (0, 2 * t * slip + closure), (0, 0)]
    number = np.arange(200 * (len(corners) - 1) + 1) / 200
    path = np.stack([np.interp(number, range(len(corners)), column) for column in zip(*corners, strict=True)], axis=1)
    stress, _ = led(replace(JOINT, **keys), path)
    forces = stress[:, ::-1] * (1.0, -1.0)  # shear along, pressure against the opening
    work = (0.5 * (forces[1:] + forces[:-1]) * np.diff(path, axis=0)).sum()
    expected = pressure * (slip + elastic / 2) * (MU - t)
    assert_allclose(work, expected, atol=2e-3 * pressure * slip * MU)


LAWS = {
    "mohr_coulomb": {"law": bsm.MohrCoulomb(friction=30, cohesion=1e4)},
    "patton": {"law": bsm.Patton(friction=30, dilation=12, cohesion=1e5)},
    "barton_bandis": {"law": bsm.BartonBandis(jrc=12, jcs=60e6, residual_friction=26)},
    "ladanyi_archambault": {"law": bsm.LadanyiArchambault(friction=25, dilation=12, jcs=60e6)},
    "hyperbolic": {"law": bsm.BartonBandis(jrc=12, jcs=60e6, residual_friction=26), "max_closure": 2e-3},
}


@pytest.mark.parametrize("name", list(LAWS))
@pytest.mark.parametrize("turn", [0.0, 40.0])
def test_the_tangent_is_the_derivative_of_minus_the_forces(name, turn):
    polygons = [rectangle(-2, -1, 2, 0), rectangle(-1, 0, 0, 1), rectangle(0, 0, 1, 1)]
    model = model_of([turned(p, turn) for p in polygons], kn=1e9)
    model = model.replace(joints=[replace(model.joints[0], **LAWS[name], **GIVEN)])
    step = begun(model)
    position = step.start + np.random.default_rng(1).normal(scale=2e-4, size=step.start.shape)
    position[1:, :2] += turned(np.array([[3e-3, -4e-4], [2e-3, -6e-4]]), turn)
    at = step.evaluate(position)
    slides = at.closed & ~at.sticking
    assert slides.sum() >= 3
    assert (at.slip > 0).sum() >= 3
    found = full_matrix(step.pattern, step.tangent(at))
    expected = -differences(lambda where: step.evaluate(where).forces, position, step=1e-8)
    assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_contacts_without_shear_stiffness_do_not_slip():
    one, nothing = np.ones(2), np.zeros(2)
    slip = slip_of_step(
        1e-4 * one,
        5.0 * one,
        np.array([0.0, KS]),
        T * one,
        LAST * one,
        lambda overlap: (KN * overlap, KN * one),
        lambda pressure: (nothing, nothing),
    )
    assert_allclose(slip, [0.0, 5.0 / KS])


def test_a_model_without_dilation_asks_for_nothing():
    step = begun(model_of([rectangle(-2, -1, 2, 0), rectangle(-1, 0, 1, 1)]))
    at = evaluate(step.contacts, step.system.catalogue.laws, step.start)
    assert not len(at.slip)
    assert not len(step.contacts.features.dilating.rows)


def test_strength_reduction_divides_its_tangent_too():
    model = model_of([rectangle(-2, -1, 2, 0), rectangle(-1, 0, 1, 1)])
    joint = replace(JOINT, name="J", dilation_angle=FRICTION)
    reduced = with_strength(model.replace(joints=[joint]), {"*": 0.5}).joints[0]
    assert np.tan(np.radians(reduced.dilation_angle)) == pytest.approx(0.5 * MU)


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"dilation_slip": None}, "over which slip does it wear off"),
        ({"dilation_angle": 0.0}, "dilation_slip = 0.005 m never acts"),
        ({"dilation_angle": 31.0}, "above the residual friction of its law: a sliding joint would give energy"),
        ({"law": None}, "a joint without a law does not slide"),
        ({"law": bsm.MohrCoulomb(friction=40, residual_friction=5)}, "above the residual friction of its law"),
    ],
)
def test_what_cannot_be_is_refused(keys, text):
    with pytest.raises(bsm.ModelError, match=text):
        replace(JOINT, **keys)


def slid():
    """Return a step of three blocks, a position at which contacts slide and dilate, and what they carry there."""
    model = model_of([rectangle(-2, -1, 2, 0), rectangle(-1, 0, 0, 1), rectangle(0.2, 0, 1.2, 1)], kn=KN)
    step = begun(model.replace(joints=[replace(JOINT, name=model.joints[0].name)]))
    position = step.start + np.array([(0, 0, 0), (3e-3, -2e-4, 0), (2e-3, -3e-4, 0)])
    at = step.evaluate(position)
    assert (at.slip > 0).all()
    assert len(at.slip) == 4
    return step, position, at


def assert_the_same(found, at, *, slips):
    """Assert that contacts carry what they carried, as they slip in this step or have slipped before."""
    assert_allclose(found.pressure, at.pressure, rtol=1e-9)
    assert_allclose(found.shear, at.shear, rtol=1e-9)
    assert (found.slip > 1e-9 * at.slip.max()).any() == slips


def test_what_has_slipped_stays_open():
    step, position, at = slid()
    assert_the_same(step.system.evaluate(worn(step.contacts, at), position), at, slips=False)


def test_what_slipped_provisionally_slips_again():
    """Contacts that are searched anew within a step open once, not twice."""
    step, position, at = slid()
    size = step.system.outlines.size
    history, _ = commit(step.contacts, at, position, size)
    anew = step.system.gather(history, position, first=False)
    assert_the_same(step.system.evaluate(anew, position), at, slips=False)
    again = restore_history(anew, step.contacts, at, size)
    assert_the_same(step.system.evaluate(again, position), at, slips=True)


@pytest.mark.heavy
def test_some_of_the_contacts_dilate_as_among_all():
    step, position, at = slid()
    rows = np.flatnonzero(step.contacts.candidates.block_a + step.contacts.candidates.block_b == 1)
    some = step.system.some(step.contacts, rows, np.arange(len(position)))
    found = step.system.evaluate(some, position)
    assert len(found.slip) == len(rows) < len(at.slip)
    assert_allclose(found.pressure, at.pressure[rows])
    assert found.slip.max() > 0
