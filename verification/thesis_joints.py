"""Chapter 4 of the thesis: strength of joints, the iteration over failed contacts, the ground's stress."""

from __future__ import annotations

import math

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.contact.strength import peak_strength
from bsm_mesh.model.stress_field import StressField
from bsm_mesh.solve.bolts.kernels import node_movements
from tests.scenes.models import framed, model_of
from tests.scenes.pushed_block import FRICTION, GAMMA, GAP, PUSH, WIDTH, example_2
from tests.scenes.reference import dense_solution
from tests.scenes.shapes import grid, rectangle, running_bond
from verification.case import Answer, Case, limit_between
from verification.thesis_matrices import Array

EXACT = 1e-12
FAR = 1e15  # a trial shear beyond any strength
PRESSED = np.array([0.0, 0.2, 1.0, 1.9, 1.92, 3.0, 8.0]) * 1e6  # N/m


def tan(degrees: float) -> float:
    """Return the tangent of an angle in degrees."""
    return math.tan(math.radians(degrees))


def patton() -> Answer:
    """Compare the lower of both lines; they cross at C / (tan(phi + i) - tan(phi_r))."""
    law = bsm.Patton(friction=30, dilation=10, residual_friction=30, cohesion=0.5e6)
    first, second = PRESSED * tan(40), 0.5e6 + PRESSED * tan(30)
    return np.minimum(first, second), peak_strength(law, PRESSED, np.ones(len(PRESSED)))


def turning_point() -> Answer:
    """Compare where line 1 meets line 2: pressure and strength there."""
    law = bsm.Patton(friction=30, dilation=10, residual_friction=30, cohesion=0.5e6)
    slope, intercept = (values[0] for values in law.strength_lines(np.ones(1)))
    pressure = (intercept[1] - intercept[0]) / (slope[0] - slope[1])
    at = peak_strength(law, np.array([pressure]), np.ones(1))[0]
    return np.array([1.91022e6, 1.60287e6]), np.array([pressure, at])


def sheared_off() -> Answer:
    """Compare once line 2 was exceeded, line 3: residual friction without cohesion."""
    law = bsm.Patton(friction=30, dilation=10, residual_friction=28, cohesion=0.5e6)
    one = np.ones(len(PRESSED))
    return PRESSED * tan(28), law.respond(PRESSED, FAR * one, one, one > 0).strength


LADANYI = bsm.LadanyiArchambault(friction=30, dilation=15, jcs=40e6)
LOW = np.array([1e3, 1e5, 1e6, 1e7, 3.9e7])


def _rock(stress: Array) -> Array:
    """Return Fairhurst's strength of the asperities, tensile strength a tenth of the compressive one [Pa]."""
    strength: Array = 40e6 * (math.sqrt(11) - 1) / 10 * np.sqrt(1 + 10 * stress / 40e6)
    return strength


def ladanyi() -> Answer:
    """Compare with the authors' shear area ratio and rate of dilation, Fairhurst's strength of the asperities."""
    part = 1 - LOW / 40e6
    a, D = 1 - part**1.5, part**4 * tan(15)
    exact = (LOW * (1 - a) * (D + tan(30)) + a * _rock(LOW)) / (1 - (1 - a) * D * tan(30))
    return exact, peak_strength(LADANYI, LOW, np.ones(len(LOW)))


def ladanyi_low() -> Answer:
    """Compare at no pressure tan(phi + i), and the slope of a_s S_r beside it, which the thesis drops."""
    stress = np.array([1e-3])
    steep = 1 - tan(15) * tan(30)
    sheared = 1.5 * (math.sqrt(11) - 1) / 10 / steep  # d(a_s S_r) / d(sigma) at 0
    found = peak_strength(LADANYI, stress, np.ones(1)) / stress - sheared
    return np.array([tan(45)]), found


def ladanyi_high() -> Answer:
    """Compare from the strength of the rock on all asperities are sheared: S_r."""
    stress = np.array([4e7, 4e8])
    return _rock(stress), peak_strength(LADANYI, stress, np.ones(2))


def barton() -> Answer:
    """Compare JRC 10, JCS 100 MPa, residual friction 28 degrees."""
    stress = np.array([0.5, 1.0, 5.0, 10.0]) * 1e6
    law = bsm.BartonBandis(jrc=10, jcs=100e6, residual_friction=28)
    angle = 10 * np.log10(100e6 / stress) + 28
    return stress * np.tan(np.radians(angle)), peak_strength(law, stress, np.ones(4))


def no_tension() -> Answer:
    """Compare a block of weight W on a joint is lifted by P: it stays where P < W."""

    def stays(part: float) -> bool:
        lift = [bsm.PointLoad(block=1, point=(0.5, 0.5), force=(0.0, part * 25e3))]
        model = model_of([rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)], loads=lift)
        return bool(bsm.run(model).status == "stable")

    return 1.0, limit_between(stays, 0.999, 1.001)


def first_cycle() -> Answer:
    """Compare where nothing fails the iteration ends with the solution of Eq. 3.40, here of dense matrices."""
    polygons, row = running_bond(6, 8), 8
    model = model_of(polygons, kn=1e10, friction=80.0, supports=[bsm.Fixed(blocks=list(range(row)))])
    moments, joint = model.blocks.moments, model.joints[0]
    bars = [(b, moments.centroid[b] + arm, angle, 0.0) for b in range(row)
            for arm, angle in ((0.0, 0.0), (0.0, 90.0), (np.array([0.1, 0.0]), 90.0))]  # fmt: skip
    loads = np.column_stack([model.gravity_forces, np.zeros(len(polygons))])
    exact = dense_solution(polygons, (joint.normal_stiffness, joint.shear_stiffness), loads, bars).displacement
    return exact, bsm.run(model, bsm.Options(scheme="wang")).stages[-1].displacement


def cycles() -> Answer:
    """Compare Example 2 with the shear stiffness kept: a cycle moves the block by its unbalanced force over that."""
    results = bsm.run(example_2(3e7), bsm.Options(scheme="wang", sliding_stiffness=1.0, max_steps=2000))
    exact = GAP * 3e7 * WIDTH / (PUSH - GAMMA * WIDTH * tan(FRICTION))
    return exact, float(len(results.stages[-1].steps))


def position() -> Answer:
    """Compare a point of a block that turns by up to a radian: x + R(theta) a, where the thesis takes x + theta x a."""
    rng = np.random.default_rng(411)
    U, arm = rng.normal(size=(20, 3)), rng.normal(size=(20, 2))
    exact = []
    for (u, v, turn), a in zip(U, arm, strict=True):
        c, s = math.cos(turn), math.sin(turn)
        exact.append(np.array([u, v]) + np.array([(c, -s), (s, c)]) @ a - a)
    return np.array(exact), node_movements(U, np.arange(20, dtype=np.int32), arm)[0]


DEPTH = np.array([20.0, 21.0, 22.5, 23.0])


def _stress(k0: object) -> Array:
    """Return horizontal and vertical stress at depths, compression positive, (2, k) [Pa]."""
    blocks = framed(bsm.Blocks.from_polygons(grid(3, 3), rock="rock"), 3, 3)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=GAMMA, young=1e9, poisson=0.25)],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        in_situ=bsm.InSitu(surface=23.0, k0=k0),
    )
    points = np.column_stack([np.full(len(DEPTH), 0.5), 23.0 - DEPTH])
    xx, yy, _ = StressField(model).at(points, np.zeros(len(DEPTH), dtype=int)).T
    return -np.array([xx, yy])


def vertical_stress() -> Answer:
    """Compare the weight of the ground above."""
    return GAMMA * DEPTH, _stress(1.0)[1]


def confined_ground() -> Answer:
    """Compare ground at rest: p = gamma h and q = mu / (1 - mu) gamma h of Example 1."""
    return np.array([GAMMA / 3 * DEPTH, GAMMA * DEPTH]), _stress(0.25 / 0.75)


def _ratio(name: str, exact: Array) -> Answer:
    horizontal, vertical = _stress(name)
    return exact, horizontal / vertical


CASES = (
    Case(name="patton", what="Patton's bilinear strength over seven pressures", source="patton",
         quantity="strength [N/m]", compute=patton, tolerance=EXACT, equations=("4.1", "4.2", "4.8")),
    Case(name="patton-turning-point", what="where the two lines cross: phi + i = 40, phi_r = 30, C = 0.5 MN",
         source="patton", quantity="pressure, strength [N/m]", compute=turning_point, tolerance=5e-6,
         equations=("4.8",)),
    Case(name="patton-residual", what="strength once asperities are sheared off (line 3 of Fig. 4.2)", source="wang",
         quantity="strength [N/m]", compute=sheared_off, tolerance=EXACT, equations=("4.2",)),
    Case(name="ladanyi", what="strength by Ladanyi and Archambault", source="ladanyi", quantity="strength [Pa]",
         compute=ladanyi, tolerance=EXACT, equations=("4.3",)),
    Case(name="ladanyi-low", what="its slope at no pressure, less that of a_s S_r", source="ladanyi",
         quantity="tan(phi + i)", compute=ladanyi_low, tolerance=1e-7, equations=("4.4",)),
    Case(name="ladanyi-high", what="its strength at great pressure", source="ladanyi", quantity="strength [Pa]",
         compute=ladanyi_high, tolerance=EXACT, equations=("4.5",)),
    Case(name="barton", what="strength by Barton and Choubey", source="barton", quantity="strength [Pa]",
         compute=barton, tolerance=EXACT, equations=("4.6", "4.7")),
    Case(name="no-tension", what="a block on a joint without tensile strength is lifted", source="wang",
         quantity="lift over weight at which it leaves", compute=no_tension, tolerance=1.1e-3, equations=("4.9",)),
    Case(name="first-cycle", what="the thesis's iteration where no contact fails", source="lagrange",
         quantity="displacement [m], turn", compute=first_cycle, tolerance=1e-9,
         equations=("4.10", "4.12", "4.13")),
    Case(name="cycles-of-a-slide", what="cycles of the thesis's iteration in which block 2 slides 0.5 m",
         source="springs", quantity="cycles", compute=cycles, tolerance=0.03, equations=("4.10", "4.12", "4.13")),
    Case(name="moved-point", what="where a point of a turning block goes: exact rotation", source="statics",
         quantity="displacement [m]", compute=position, tolerance=EXACT, equations=("4.11",)),
    Case(name="vertical-stress", what="stress of level ground", source="wang", quantity="sigma_v [Pa]",
         compute=vertical_stress, tolerance=EXACT, equations=("4.14",)),
    Case(name="confined-ground", what="primary stress of Example 1", source="wang", quantity="q, p [Pa]",
         compute=confined_ground, tolerance=EXACT, equations=("3.47",)),
    Case(name="herget", what="horizontal over vertical stress in the Canadian shield", source="herget",
         quantity="K at 20 to 23 m", compute=lambda: _ratio("herget", 267 / DEPTH + 1.25), tolerance=EXACT,
         equations=("4.15",)),
    Case(name="brown-hoek-upper", what="upper bound of horizontal over vertical stress", source="brown-hoek",
         quantity="K at 20 to 23 m", compute=lambda: _ratio("brown_hoek_upper", 1500 / DEPTH + 0.5), tolerance=EXACT,
         equations=("4.16",)),
    Case(name="brown-hoek-lower", what="its lower bound", source="brown-hoek", quantity="K at 20 to 23 m",
         compute=lambda: _ratio("brown_hoek_lower", 100 / DEPTH + 0.3), tolerance=EXACT, equations=("4.17",)),
)  # fmt: skip
