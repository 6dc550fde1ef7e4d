"""Laws of the user's own: one class with `respond` serves every scheme, and with straight lines limit analysis too."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.arrays import content_hash
from bsm_mesh.contact.state import STATE
from bsm_mesh.model.joint_laws import memory_of
from bsm_mesh.model.law_faults import PAST
from bsm_mesh.model.strength import Reduced
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, running_bond, turned

THEORY = Path(__file__).parents[2] / "docs/theory_joint_laws.md"
SCHEMES = ("linear", "continuation", "wang")


def cut(trial, strength, slope, failed):
    """Return the trial shear cut to a strength, as a law answers."""
    sticking = np.abs(trial) <= strength
    return bsm.JointResponse(
        shear=np.where(sticking, trial, np.sign(trial) * strength),
        by_pressure=np.where(sticking, 0.0, np.sign(trial) * slope),
        strength=strength,
        sticking=sticking,
        failed=failed.copy(),
    )


@dataclass(frozen=True)
class Power:
    """A curved strength tau = a p^b per area: all that a law takes."""

    a: float
    b: float

    def respond(self, pressure, trial_shear, length, failed):
        p = np.maximum(pressure, 1e-9)
        strength = self.a * (p / length) ** self.b * length
        return cut(trial_shear, strength, self.b * strength / p, failed)


class Coulomb:
    """Friction by a class that is no dataclass and cannot be hashed."""

    __hash__ = None

    def __init__(self, degrees):
        self.tan = np.tan(np.radians(degrees))

    def __eq__(self, other):
        raise AssertionError("laws need not be comparable")

    def respond(self, pressure, trial_shear, length, failed):
        pressing = np.maximum(pressure, 0.0)
        return cut(trial_shear, self.tan * pressing, np.where(pressure > 0, self.tan, 0.0), failed)


class Straight(Coulomb):
    """The same with the line that limit analysis asks for."""

    def strength_lines(self, length):
        return np.full((len(length), 1), self.tan), np.zeros((len(length), 1))


def slab(law, angle=30.0, height=0.2, width=10.0):
    """Return a wide slab on a plane."""
    polygons = [turned(p, angle) for p in (rectangle(-1, -1, 12, 0), rectangle(0, 0, width, height))]
    return model_of(polygons, law=law)


def wall(beds, heads):
    """Return a tilted wall with a law in its beds and one in its heads."""
    blocks = bsm.Blocks.from_polygons([rectangle(-1, -1, 4, 0), *running_bond(3, 3)], rock="r")
    upright = np.abs(blocks.edge_vectors[:, 0]) < 1e-9
    blocks = replace(blocks, edge_joint=upright.astype(np.int32), joint_names=("beds", "heads"))
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=[bsm.Joint("beds", 1e9, 1e9, law=beds), bsm.Joint("heads", 1e9, 5e8, law=heads)],
        default_joint="beds",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-100.0,
    )


@pytest.mark.heavy
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
@pytest.mark.parametrize(("side", "status"), [(0.99, "stable"), (1.01, "unstable")])
def test_a_slab_slides_at_the_strength_of_a_curved_law(side, status, scheme):
    """Shear stress g h sin cos against a (g h cos^2)^b at equal corners."""
    angle, height, b = np.radians(30), 0.2, 0.8
    a = 25e3 * height * np.sin(angle) / (25e3 * height * np.cos(angle)) ** b / side
    model = slab(Power(a, b))
    results = bsm.run(model, bsm.Options(scheme=scheme))
    assert results.status == status or (scheme, side) == ("wang", 1.01)  # cycles that end on their way
    assert (results.status == "stable") == (side < 1)
    assert side > 1 or results.check().ok


def test_the_linear_scheme_reports_the_utilisation_of_a_curved_law():
    law = Power(2.0, 0.8)
    contacts = bsm.run(slab(law), bsm.Options(scheme="linear")).stages[0].contacts
    strength = 2.0 * (-contacts.normal_force / contacts.length) ** 0.8 * contacts.length
    assert_allclose(contacts.utilisation, np.abs(contacts.shear_force) / strength, rtol=1e-12)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_an_own_law_does_as_the_same_law_of_the_project(scheme):
    """Two laws that can be neither hashed nor compared, in one model."""
    options = bsm.Options(scheme=scheme)
    own = bsm.run(wall(Coulomb(35.0), Coulomb(20.0)), options)
    built_in = bsm.run(wall(bsm.MohrCoulomb(friction=35.0), bsm.MohrCoulomb(friction=20.0)), options)
    assert own.status == built_in.status == ("no_verdict" if scheme == "linear" else "stable")
    assert_allclose(own.stages[0].displacement, built_in.stages[0].displacement, rtol=1e-9, atol=1e-15)
    assert_allclose(own.stages[0].contacts.utilisation, built_in.stages[0].contacts.utilisation, rtol=1e-9)
    assert own.stages[0].contacts.utilisation.max() > 0.1


@pytest.mark.parametrize("scheme", SCHEMES)
def test_an_in_situ_field_is_compared_with_an_own_law(scheme):
    model = wall(Coulomb(35.0), Coulomb(1.0)).replace(
        gravity_direction=-90.0, in_situ=bsm.InSitu(stress={"xx": -1e5, "yy": -1e5, "xy": 5e3})
    )
    assert any("beyond the strength" in note for note in bsm.run(model, bsm.Options(scheme=scheme)).stages[0].notes)


def test_limit_analysis_takes_the_lines_of_an_own_law():
    pulled = bsm.PointLoad(block=1, point=(5.0, 0.1), force=(1e3, 0.0))
    for law in (Straight(30.0), bsm.MohrCoulomb(friction=30.0)):
        model = slab(law, angle=0.0).replace(loads=[])
        found = bsm.limit_analysis(model, [pulled])
        assert_allclose(found.factor, 25e3 * 0.2 * 10.0 * np.tan(np.radians(30.0)) / 1e3, rtol=1e-9)


def test_limit_analysis_of_a_law_without_lines_says_what_it_needs():
    with pytest.raises(bsm.ModelError, match=r"the law Coulomb has no method strength_lines\(length\): add it"):
        bsm.limit_analysis(slab(Coulomb(30.0)))


def test_lines_of_a_wrong_shape():
    class Wrong(Coulomb):
        def strength_lines(self, length):
            return np.tan(0.5), np.zeros(len(length))

    with pytest.raises(bsm.ModelError, match="the law Wrong: strength_lines returns arrays of shape"):
        bsm.limit_analysis(slab(Wrong(30.0)))


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda length: 3, "strength_lines failed: TypeError: 'int' object is not iterable; it must return slope and"),
        (lambda length: 1 / 0, "strength_lines failed: ZeroDivisionError"),
        (lambda length: (np.full((len(length), 1), np.nan), np.zeros((len(length), 1))), "negative or no number"),
        (lambda length: (np.full((len(length), 1), -0.5), np.zeros((len(length), 1))), "negative or no number"),
        (lambda length: (np.full((len(length), 1), 0.5), np.full((len(length), 1), -1.0)), "negative or no number"),
    ],
)
def test_lines_that_are_no_strength(answer, words):
    class Wrong(Coulomb):
        def strength_lines(self, length):
            return answer(length)

    with pytest.raises(bsm.ModelError, match=re.escape("the law Wrong: strength_lines ")) as caught:
        bsm.limit_analysis(slab(Wrong(30.0)))
    assert words in str(caught.value)


def test_a_law_counts_by_its_content_in_the_digest_of_a_model():
    assert slab(Coulomb(30.0)) == slab(Coulomb(30.0))
    assert slab(Coulomb(30.0)) != slab(Coulomb(31.0))
    assert slab(Coulomb(30.0)) != slab(Straight(30.0))


def test_digest_of_functions_and_of_objects_in_circles():
    def law(factor):
        return lambda pressure: factor * pressure

    class Slotted:
        __slots__ = ("other", "value")

    def circle(value):
        one = Slotted()
        one.other, one.value = one, value
        return one

    assert content_hash(law(0.5)) == content_hash(law(0.5))
    assert content_hash(law(0.5)) != content_hash(law(0.6))
    assert content_hash(circle(1.0)) == content_hash(circle(1.0)) != content_hash(circle(2.0))


def answering(**changes):
    """Return a law whose answer is changed in some arrays."""

    class Changed(Coulomb):
        def respond(self, pressure, trial_shear, length, failed):
            answer = super().respond(pressure, trial_shear, length, failed)
            for name, change in changes.items():
                object.__setattr__(answer, name, change(getattr(answer, name)))
            return answer

    return Changed(30.0)


class NoJointResponse(Coulomb):
    def respond(self, pressure, trial_shear, length, failed):
        return trial_shear


class WrongArguments(Coulomb):
    def respond(self, pressure, trial_shear):
        return trial_shear


class Spoils(Coulomb):
    def respond(self, pressure, trial_shear, length, failed):
        pressure += 1.0
        return super().respond(pressure - 1.0, trial_shear, length, failed)


class OnlyNearTheSurface(Coulomb):
    """A parabola that falls below 0 in deep rock."""

    def respond(self, pressure, trial_shear, length, failed):
        p = np.maximum(pressure, 0.0)
        return cut(trial_shear, p - 1e-6 * p**2, 1.0 - 2e-6 * p, failed)


class OnlyUnderPressure(Coulomb):
    def respond(self, pressure, trial_shear, length, failed):
        if np.any((pressure > 0) & (pressure < 10)):
            raise ValueError("out of range")
        return super().respond(pressure, trial_shear, length, failed)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (OnlyNearTheSurface(30.0), r"respond returns a strength that is not 0 or more at the pressure 1e\+07 N/m"),
        (OnlyUnderPressure(30.0), "respond failed on arrays of 8 contacts: ValueError: out of range"),
        (30.0, "the law float: has no method respond"),
        ("mohr_coulomb", "names are for model files; give a law, for example bsm.MohrCoulomb"),
        (Coulomb, "has no method respond"),  # the class instead of a law
        (NoJointResponse(30.0), "the law NoJointResponse: respond returns ndarray; it must return a bsm.JointResponse"),
        (WrongArguments(30.0), "the law WrongArguments: respond failed on arrays of 8 contacts: TypeError"),
        (Spoils(30.0), "changes the arrays that it is given"),
        (answering(shear=lambda a: 0.0), "returns shear as float; it must be an array of float64"),
        (answering(by_pressure=lambda a: a[1:]), r"returns by_pressure as float64 of shape \(7,\)"),
        (answering(failed=lambda a: a.astype(int)), "returns failed as int64"),
        (answering(shear=lambda a: a * np.nan), "not finite"),
        (answering(strength=lambda a: a - 1.0), "strength that is not 0 or more"),
        (answering(shear=lambda a: 2 * a), "more shear than strength"),
        (answering(failed=lambda a: ~a), "must leave failed as it is"),
        (answering(failed=lambda a: a & (np.arange(len(a)) < 2)), "failed stays true"),
    ],
)
def test_what_is_no_law_is_refused_where_it_is_given(law, words):
    with pytest.raises(bsm.ModelError, match=f"joint 'J': the law.*{words}" if "law" not in words else words):
        bsm.Joint("J", 1e9, 1e9, law=law)


def test_a_law_is_asked_for_tension_only_where_the_joint_bears_it():
    class Root(Power):
        def respond(self, pressure, trial_shear, length, failed):
            strength = self.a * np.sqrt(pressure)
            slope = np.where(pressure > 0, 0.5 * self.a / np.sqrt(np.maximum(pressure, 1e-9)), 0.0)
            return cut(trial_shear, strength, slope, failed)

    assert bsm.Joint("J", 1e9, 1e9, law=Root(1.0, 0.5)).law is not None
    with pytest.raises(bsm.ModelError, match="strength that is not 0 or more"):
        bsm.Joint("J", 1e9, 1e9, law=Root(1.0, 0.5), tensile_strength=1e5)


class FailsDeepDown(Coulomb):
    """Beyond every pressure at which laws are asked beforehand."""

    def respond(self, pressure, trial_shear, length, failed):
        if (pressure > 2e7).any():
            return self.nothing
        return super().respond(pressure, trial_shear, length, failed)


class Clean(Coulomb):
    """Strength falls to nothing over 0.1 m of slip where walls fit together."""

    remembers = ("mated", "slip_path")

    def respond(self, pressure, trial_shear, length, failed, mated=None, slip_path=None):
        left = 1.0 if mated is None else np.where(mated, np.maximum(1 - slip_path / 0.1, 0.0), 1.0)
        answer = super().respond(pressure, np.full_like(pressure, 1e9), length, failed)
        return replace(answer, shear=left * answer.shear, strength=left * answer.strength)


def test_a_law_is_given_the_state_variables_that_it_names():
    """Also by the law that divides its strength; one that is asked without them knows nothing of the past."""
    contacts = SimpleNamespace(
        failed=np.zeros(3, bool), mated=np.array([True, True, False]), slip_path=np.full(3, 0.05)
    )
    law, one = Clean(45.0), np.ones(3)
    halved = Reduced(law, 2.0)
    first, weaker = (each.respond(one, one, one, *memory_of(each, contacts)).strength for each in (law, halved))
    assert_allclose(first, [0.5, 0.5, 1.0])
    assert_allclose(weaker, first / 2)
    assert_allclose(halved.respond(one, one, one, contacts.failed).strength, 0.5)


class Mated(Clean):
    """Knows whether walls fit together, and answers for flags alone."""

    remembers = ("mated",)

    def respond(self, pressure, trial_shear, length, failed, mated=None):
        if mated is not None:
            np.logical_or(failed, ~mated)
        return Coulomb.respond(self, pressure, trial_shear, length, failed)


@pytest.mark.parametrize("names", [("slip_path", "velocity"), "slip_path"])
def test_a_law_that_names_no_state_variable_is_refused(names):
    law = type("Vague", (Clean,), {"remembers": names})(45.0)
    with pytest.raises(bsm.ModelError, match=r"the law Vague: remembers '(velocity|s)'; give a tuple of state variab"):
        bsm.Joint("J", 1e9, 1e9, law=law)


def test_zones_refuse_a_law_whose_state_variables_they_have_not():
    model = slab(Mated(45.0)).replace(rocks=[bsm.Rock("rock", 25e3, young=1e9, poisson=0.2, zones=bsm.Zones(order=1))])
    with pytest.raises(bsm.ModelError, match="joint 'J': its law remembers 'mated', and zones remember offset and sli"):
        bsm.run(model)


def test_a_law_is_asked_for_slip_with_flags_as_flags():
    """`law_faults` knows all state variables, and of which type they are."""
    assert {"failed", *PAST} == set(STATE)
    with pytest.raises(bsm.ModelError, match="residual_tensile_strength = 1000 Pa never acts"):
        bsm.Joint("J", 1e9, 1e9, law=Mated(45.0), tensile_strength=1e5, residual_tensile_strength=1e3)


@pytest.mark.parametrize("scheme", ["continuation", "wang"])
def test_a_law_that_fails_while_it_is_solved_is_told(scheme):
    model = slab(FailsDeepDown(40.0), height=3000.0)
    with pytest.raises(bsm.ModelError, match=r"the law FailsDeepDown: respond failed at pressures of .* Attribute"):
        bsm.run(model, bsm.Options(scheme=scheme))


@pytest.mark.skipif(not THEORY.is_file(), reason="a checkout without pages")
def test_the_law_in_the_theory_is_one():
    """Its strength is Barton's, its derivative the difference quotient."""
    found = re.search(r"^```python\n(.*?)^```", THEORY.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert found is not None
    names: dict[str, object] = {}
    exec(compile(found[1], str(THEORY), "exec"), names)
    law = names["joint"].law
    pressure, length = np.array([1e3, 1e5, 1e6]), np.array([1.0, 0.5, 2.0])
    expected = pressure * np.tan(np.radians(np.minimum(8 * np.log10(50e6 * length / pressure) + 28, 70)))

    def shear(p):
        return law.respond(p, np.full(3, 1e12), length, np.zeros(3, dtype=bool)).shear

    assert_allclose(shear(pressure), expected, rtol=1e-12)
    step = 1e-6 * pressure
    slope = law.respond(pressure, np.full(3, 1e12), length, np.zeros(3, dtype=bool)).by_pressure
    assert_allclose(slope, (shear(pressure + step) - shear(pressure - step)) / (2 * step), rtol=1e-6)
