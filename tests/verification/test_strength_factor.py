"""The factor of strength by limit analysis against closed forms, and against linear programs at reduced strength.

Plane failure: Hoek and Bray; Wyllie and Mah. Arch: least friction of semicircular arches by limit analysis. Tutorial
slope of UDEC: its manual's geometry, factors by statics of each block on its plane.
"""

from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog

import bsm_mesh as bsm
from bsm_mesh.certificate.verify_certificate import proved
from bsm_mesh.certificate.verify_certificate.geometry import moments
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.strength import with_strength
from bsm_mesh.model.supports import bars_of
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.evidence import bar_rows
from bsm_mesh.solve.algebra.loads import external_loads, given_of
from bsm_mesh.solve.limit.program import LimitProgram
from bsm_mesh.solve.limit_analysis import strength_limit
from tests.scenes.arch import arch
from tests.scenes.large import jointed_slope, leaning_slope
from tests.scenes.models import model_of
from tests.scenes.plane_failure import hoek_and_bray
from tests.scenes.shapes import rectangle, square, turned

SIDES = 2e-5  # relative: the factor lies between two that are 1e-5 apart, and what bounds carry is known to 1e-8


def tan(angle):
    return np.tan(np.radians(angle))


def on_incline(*blocks, friction=40.0, **given):
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 5, 0), *(blocks or [rectangle(-0.5, 0, 0.5, 0.5)]))]
    return model_of(polygons, friction=friction, **given)


def faults_of(model, found):
    """Return what the independent check of certificates has against the proof."""
    witness, blocks, water = found.proof.witness, model.blocks, WaterLoad(model)
    arrays = {f"proof_{field.name}": getattr(witness, field.name) for field in fields(witness)}
    arrays |= moments(blocks.vertices, blocks.offsets) | {"vertices": blocks.vertices, "offsets": blocks.offsets}
    arrays |= {"position": np.zeros((blocks.count, 3)), "present": np.ones(blocks.count, bool)}
    bars = bars_of(model.supports, blocks)
    arrays |= bar_rows(bars, bars.point) | {"at": arrays["centroid"], "bolt_block": np.zeros(0, int)}
    arrays |= {"water": water.on_blocks(blocks.vertices, arrays["centroid"])}
    given = given_of(model, water, point_forces_of(model.acting_loads, blocks))
    arrays |= {name: values for name, values in given.items() if values is not None}
    return proved({"laws": list(witness.laws), "proof": {"laws": witness.laws}}, arrays, linear=False)[1]


def assert_is(model, factor, **given):
    """Assert the factor from both sides, and that a stranger can check the proof of the upper one."""
    found = strength_limit(model, **given)
    assert found.factor <= factor * (1 + 1e-7)
    assert_allclose(found.factor, factor, rtol=SIDES)
    assert factor * (1 - 1e-7) <= found.beyond <= factor * (1 + SIDES)
    assert faults_of(model, found) == []
    return found


@pytest.mark.parametrize("friction", [40.0, 20.0])
def test_a_block_on_an_incline(friction):
    found = assert_is(on_incline(friction=friction), tan(friction) / tan(30))
    u, v, _ = found.mechanism[1]
    assert_allclose(np.degrees(np.arctan2(v, u)) % 360, 210 - 30, atol=1e-2)  # it dilates by the friction that is left
    assert not found.mechanism[0].any()
    assert "(proved)" in str(found)


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
def test_a_chip_beside_boulders(size):
    """What it lacks is little beside the weight of a boulder that lies level, and all of its own."""
    level = [rectangle(20, 0, 30, 1), rectangle(21, 1, 29, 9)]
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 5, 0), rectangle(1, 0, 1 + size, 0.5 * size))]
    found = strength_limit(model_of([*level, *polygons], friction=40.0, fixed=(0, 2)))
    assert_allclose(found.factor, tan(40) / tan(30), rtol=SIDES)
    assert found.mechanism[3].any()


@pytest.mark.parametrize(
    ("zw", "cohesion", "printed"),
    [(3.0, 25e3, 1.247), (4.348, 25e3, 1.072), (0.0, 25e3, 1.544), (0.0, 0.0, 1.076), (3.0, 0.0, 0.801)],
)
def test_plane_failure_with_water_and_cohesion(zw, cohesion, printed):
    case = hoek_and_bray(zw=zw, cohesion=cohesion)
    assert case.factor == pytest.approx(printed, abs=2e-3)
    assert_is(case.model(), case.factor)


@pytest.mark.parametrize(("plunge", "length", "printed"), [(55, 8.0, 1.499), (20, 6.5, 2.099)])
@pytest.mark.parametrize("spacing", [1.0, 2.5])
def test_plane_failure_with_a_bolt(plunge, length, printed, spacing):
    """The bolt pulls with its yield force: whole, or divided too, F = (N(T / F) tan phi) / S(T / F)."""
    case = hoek_and_bray(cohesion=0.0)
    pull, head, diameter = 4e5, np.array(case.crest) / 2, 0.04
    along = np.array([np.cos(np.radians(plunge)), -np.sin(np.radians(plunge))])
    steel = {"diameter": diameter, "yield_strength": pull * spacing / (np.pi * diameter**2 / 4), "spacing": spacing}
    bolt = bsm.Bolt(start=head, end=head + length * along, kind="end_anchored", **steel)
    model = case.model().replace(bolts=(bolt,))
    factor = case.factor_with_bolt(pull, plunge)
    assert factor == pytest.approx(printed, abs=2e-3)
    found = assert_is(model, factor)
    assert_allclose(found.bolt_force, pull * spacing, rtol=1e-3)
    divided = factor
    for _ in range(100):
        divided = 0.5 * (divided + case.factor_with_bolt(pull / divided, plunge))
    assert divided < factor - 0.1
    assert_is(model, divided, bolts=True)


@pytest.mark.parametrize(
    ("strength", "limit"),
    [
        ({"yield_strength": 4e4 / (np.pi * 0.01**2)}, 4e4),
        ({"kind": "end_anchored", "anchor_capacity": 5e4}, 5e4),
        ({"bond_strength": 3e4}, 3e4),  # over the 1 m in the hung block
    ],
)
def test_a_bolt_that_hangs_a_block(strength, limit):
    bolt = bsm.Bolt(start=(1.5, 0), end=(1.5, 2.5), diameter=0.02, spacing=1.2, **strength)
    model = model_of([rectangle(0, 1, 3, 3), square(1, 0)], gamma=26e3, bolts=[bolt])
    found = assert_is(model, limit / 1.2 / 26e3, bolts=True)
    assert_allclose(found.bolt_force, 1.2 * 26e3, rtol=SIDES)
    assert strength_limit(model).factor == (0.0 if limit < 1.2 * 26e3 else np.inf)


@pytest.mark.parametrize(("n", "thickness", "least"), [(20, 0.12, 0.3825), (30, 0.12, 0.3819), (30, 0.20, 0.3090)])
def test_arches_stand_down_to_their_least_friction(n, thickness, least):
    found = strength_limit(arch(n, thickness, 40.0))
    assert tan(40.0) / found.factor == pytest.approx(least, abs=1e-4)
    assert faults_of(arch(n, thickness, 40.0), found) == []


@pytest.mark.parametrize("n", [16, 30, 60])
def test_an_arch_too_thin_falls_whatever_its_friction(n):
    found = strength_limit(arch(n, 0.09, 40.0))
    assert found.factor == 0
    assert found.beyond == pytest.approx(1e-3)
    assert not found.normal_force.any()
    assert found.mechanism[:n].any()
    assert faults_of(arch(n, 0.09, 40.0), found) == []


def tutorial_slope(friction, upper=None):
    """Return UDEC's tutorial slope without its left block: two blocks on cracks, the upper crack with a joint."""
    polygons = [
        [(0.0, 0.0), (20.0, 0.0), (20.0, 8.0), (0.0, 2.0)],
        [(5.0, 3.5), (20.0, 8.0), (20.0, 18.0), (5.0, 12.0)],
        [(5.0, 12.0), (20.0, 18.0), (20.0, 20.0), (5.0, 20.0)],
    ]
    model = model_of(polygons, friction=friction, gamma=2e4)
    law = bsm.MohrCoulomb(friction=friction if upper is None else upper)
    blocks = model.blocks.with_joint("upper", lambda x, y: np.abs(y - 12 - 0.4 * (x - 5)) < 1e-9)
    return model.replace(blocks=blocks, joints=(*model.joints, bsm.Joint("upper", 1e9, 1e9, law=law)))


@pytest.mark.parametrize("friction", [20.0, 11.0])
def test_the_tutorial_slope_of_udec(friction):
    top, lower = tan(friction) / 0.4, tan(friction) / 0.3
    if friction == 20:
        assert (top, lower) == pytest.approx((0.90993, 1.21323), abs=1e-5)
    found = assert_is(tutorial_slope(friction), top)
    assert_allclose(found.mechanism[:2], 0, atol=1e-12)
    found = assert_is(tutorial_slope(friction, upper=60.0), lower, joints=["J"])
    assert found.mechanism[1:].any(axis=1).all()


def test_only_chosen_joints_are_divided():
    """The top block slides at any strength of the lower crack: no factor on that is great or small enough."""
    found = strength_limit(tutorial_slope(20.0), joints=["J"])
    assert (found.factor, found.beyond) == (0.0, pytest.approx(1e-3))
    assert strength_limit(tutorial_slope(25.0), joints=["upper"]).factor == pytest.approx(tan(25) / 0.4, rel=SIDES)


def test_tensile_strength_is_divided_too():
    """A block hangs from another by the tension of 60 kPa on 1 m."""
    joint = bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30, cohesion=1e5), tensile_strength=6e4)
    model = model_of([rectangle(0, 1, 1, 2), square(0, 0)], joint=joint)
    assert_is(model, 6e4 / 25e3)


def test_rock_faces_are_divided_or_left():
    """Two halves of a beam without a joint between them, one built in: c L = F W."""
    rock = bsm.Rock("rock", unit_weight=25e3, cohesion=1e5, friction=0.0, tensile_strength=1e6, young=1e9, poisson=0.2)
    model = model_of([square(0, 0), rectangle(1, 0, 1.5, 1)]).replace(rocks=(rock,), joints=(), default_joint=None)
    assert_is(model, 1e5 / 12.5e3)
    with pytest.raises(bsm.ModelError, match="no chosen contact has a strength"):
        strength_limit(model, rocks=False)


@pytest.mark.parametrize(
    "polygons",
    [
        [rectangle(-5, -1, 5, 0), square(0, 0)],  # lies: needs no friction
        [rectangle(-2, 0, 0, 1), rectangle(1, 0, 3, 1), square(0, 0)],  # wedged: presses as hard as it takes
    ],
)
def test_without_a_limit(polygons):
    model = model_of(polygons, fixed=range(len(polygons) - 1))
    found = strength_limit(model)
    assert found.factor == found.beyond == np.inf
    assert not found.mechanism.any()
    assert found.proof.witness is None
    assert "no limit" in str(found)


def test_a_block_that_nothing_touches_falls_at_any_strength():
    found = strength_limit(model_of([rectangle(-5, -1, 5, 0), square(0, 0), square(20, 5)]))
    assert found.factor == 0
    assert_allclose(found.mechanism[2], (0, -1, 0), atol=1e-9)
    assert found.programs == 1


@pytest.mark.parametrize("angle", [20.0, 30.0])
def test_a_square_on_its_corner_has_the_strength_of_its_contact(angle):
    """It is on a plane with its centre above the corner: it slides as a block on a face does."""
    stood = turned(rectangle(0, 0, 1, 1), 45.0 - angle)
    blocks = [turned(polygon, angle) for polygon in (rectangle(-2, -1, 2, 0), stood)]
    found = strength_limit(model_of(blocks, friction=35.0))
    assert found.factor == pytest.approx(np.tan(np.radians(35.0)) / np.tan(np.radians(angle)), rel=1e-4)


def test_what_cannot_be_asked_is_refused():
    with pytest.raises(bsm.ModelError, match="there is no joint 'K'"):
        strength_limit(on_incline(), joints=["K"])
    with pytest.raises(bsm.ModelError, match="neither weight nor load"):
        strength_limit(on_incline(gamma=0.0))
    with pytest.raises(bsm.ModelError, match="model = 3 must be"):
        strength_limit(3)


def random_slope(seed):
    generator = np.random.default_rng(seed)
    dips = generator.uniform(45, 85), -generator.uniform(20, 40)
    scene = jointed_slope(int(generator.integers(20, 80)), generator.uniform(20, 45), dips)
    return replace(scene, cohesion=generator.uniform(0, 5e3) if seed % 2 else 0.0).model()


def by_highs(model):
    """Return whether forces within strength balance the loads, by another solver of the same linear program."""
    program, loads = LimitProgram(model.replace(contact_points="ends")), external_loads(model)
    rows, bound = program.bounds()
    free, scale = np.repeat(program.movable, 3), np.hypot(*loads[:, :2].T).mean()
    given = {"A_eq": program.equilibrium[free], "b_eq": -loads.reshape(-1)[free] / scale}
    answer = linprog(np.zeros(program.unknowns), A_ub=rows, b_ub=bound / scale, **given, bounds=(None, None))
    assert answer.status in (0, 2)
    return answer.status == 0


@pytest.mark.parametrize("seed", range(20))
def test_of_random_slopes_the_factor_parts_what_stands_from_what_does_not(seed):
    model = random_slope(seed)
    found = strength_limit(model)
    assert 0 < found.factor < found.beyond < found.factor * (1 + 1.01e-5)
    assert faults_of(model, found) == []
    for factor, stands in ((found.factor * (1 - 1e-6), True), (found.beyond * (1 + 1e-6), False)):
        reduced = with_strength(model, {"*": 1 / factor}).replace(contact_points="ends")
        assert LimitProgram(reduced).balance(external_loads(reduced)).stands == stands
    for factor, stands in ((found.factor * (1 - 1e-3), True), (found.factor * (1 + 1e-3), False)):
        assert by_highs(with_strength(model, {"*": 1 / factor})) == stands


def test_forces_at_the_factor_are_in_equilibrium_and_within_the_strength_that_is_left():
    model = random_slope(1)
    found = strength_limit(model)
    c = found.contacts
    force = found.normal_force[:, None] * c.normal + found.shear_force[:, None] * c.normal[:, ::-1] * (-1, 1)
    total = external_loads(model)
    for block, sign in ((c.block_b, 1.0), (c.block_a, -1.0)):
        arm = c.point - model.blocks.moments.centroid[block]
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        np.add.at(total, block, sign * np.column_stack([force, moment]))
    free = np.setdiff1d(np.arange(model.blocks.count), model.supports[0].blocks)
    weight = model.weights[free].mean()
    assert_allclose(total[free], 0, atol=1e-6 * weight)
    law, pressure = model.joints[0].law, -found.normal_force
    strength = (law.cohesion * c.length + pressure * tan(law.friction)) / found.factor
    assert (np.abs(found.shear_force) <= strength + 1e-6 * weight).all()
    assert (pressure >= -1e-6 * weight).all()


@pytest.mark.slow
def test_two_thousand_blocks():
    model = leaning_slope(2000).model()
    assert strength_limit(model).factor == np.inf
    model = jointed_slope(2000).model()
    found = strength_limit(model)
    assert found.beyond <= found.factor * (1 + 1e-3)
    assert faults_of(model, found) == []
