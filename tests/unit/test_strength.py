"""Peak strength of joint laws and faces of rock, and the utilisation that results report."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.strength import MAX_UTILISATION, peak_strength, utilisation
from bsm_mesh.contact.table import initial_contacts
from tests.scenes.shapes import grid, square, turned

RTOL = 1e-13
PRESSURE = np.array([0.0, 1e5, 1e6, 5e6])
LENGTH = np.array([1.0, 0.5, 2.0, 1.0])


def tan(degrees):
    return np.tan(np.radians(degrees))


def test_mohr_coulomb():
    law = bsm.MohrCoulomb(friction=30, cohesion=2e5)
    assert_allclose(peak_strength(law, PRESSURE, LENGTH), 2e5 * LENGTH + PRESSURE * tan(30), rtol=RTOL)


def test_patton_is_the_lesser_of_two_lines():
    law = bsm.Patton(friction=30, dilation=10, cohesion=5e5, residual_friction=28)
    lines = PRESSURE * tan(40), 5e5 * LENGTH + PRESSURE * tan(28)  # Wang Eqs. 4.1, 4.2
    assert_allclose(peak_strength(law, PRESSURE, LENGTH), np.minimum(*lines), rtol=RTOL)


def test_patton_lines_cross_where_the_thesis_says():
    """C14 (c): phi + i = 40, phi_r = 30, C = 0.5 MN."""
    crossing = 0.5e6 / (tan(40) - tan(30))
    law = bsm.Patton(friction=30, dilation=10, cohesion=0.5e6)
    found = peak_strength(law, np.array([0.999, 1.0, 1.001]) * crossing, np.ones(3))
    expected = [0.999 * crossing * tan(40), crossing * tan(40), 0.5e6 + 1.001 * crossing * tan(30)]
    assert_allclose(found, expected, rtol=RTOL)


def test_patton_with_one_line_is_friction():
    assert_allclose(peak_strength(bsm.Patton(friction=30), PRESSURE, LENGTH), PRESSURE * tan(30), rtol=RTOL)


def used(rocks, joints, normal_force, shear_force, names=None, default="J"):
    polygons = grid(1, 2)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=names or [rocks[0].name] * 2),
        rocks=rocks,
        joints=joints,
        default_joint=default,
    )
    return utilisation(model, initial_contacts(model), np.asarray(normal_force, float), np.asarray(shear_force, float))


RIGID = bsm.Rock("r", unit_weight=0)


def joint(law):
    return [bsm.Joint("J", 1e9, 1e9, law=law)]


def test_of_a_joint():
    found = used([RIGID], joint(bsm.MohrCoulomb(friction=35, cohesion=1e4)), [-1e5, -2e5], [3e4, -6e4])
    assert_allclose(found, [3e4 / (1e4 * 0.5 + 1e5 * tan(35)), 6e4 / (1e4 * 0.5 + 2e5 * tan(35))], rtol=RTOL)


def test_tension_gives_no_friction():
    found = used([RIGID], joint(bsm.MohrCoulomb(friction=35, cohesion=1e4)), [1e5, -1e5], [3e3, 0])
    assert_allclose(found, [3e3 / (1e4 * 0.5), 0], rtol=RTOL)


def test_no_strength_is_capped_and_no_shear_is_no_use():
    found = used([RIGID], joint(bsm.MohrCoulomb(friction=35)), [1e5, 0], [3e3, 1e-12])
    assert_allclose(found, [MAX_UTILISATION, 0])


def test_without_a_law_the_strength_is_unlimited():
    assert_allclose(used([RIGID], joint(None), [-1.0, -1.0], [1e9, 1e9]), 0)


@pytest.mark.parametrize("order", [1, -1])
def test_between_two_rocks_the_weaker_at_the_pressure_governs(order):
    strong = bsm.Rock("strong", unit_weight=0, young=1e9, poisson=0.2, cohesion=1e6, friction=20)
    weak = bsm.Rock("weak", unit_weight=0, young=1e9, poisson=0.2, cohesion=1e4, friction=40)
    names = ["strong", "weak"][::order]
    pressure = np.array([1e4, 1e8])
    found = used([strong, weak], [], -pressure, [1e4, 1e4], names=names, default=None)
    lines = 0.5e6 + pressure * tan(20), 0.5e4 + pressure * tan(40)
    assert_allclose(found, 1e4 / np.minimum(*lines), rtol=RTOL)


def test_a_rock_without_strength_is_elastic_and_the_other_governs():
    plain, weak = (
        bsm.Rock("p", unit_weight=0, young=1e9, poisson=0.2),
        bsm.Rock("w", unit_weight=0, young=1e9, poisson=0.2, friction=40),
    )
    assert_allclose(used([plain], [], [-1e5, -1e5], [1e9, 1e9], default=None), 0)
    found = used([plain, weak], [], [-1e5, -1e5], [1e4, 1e4], names=["p", "w"], default=None)
    assert_allclose(found, 1e4 / (1e5 * tan(40)), rtol=RTOL)


def test_results_report_it():
    blocks = bsm.Blocks.from_polygons([square(0, 0), square(0, 1)], rock="r")
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=joint(bsm.MohrCoulomb(friction=30)),
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-80.0,
    )
    contacts = bsm.run(model, bsm.Options(scheme="linear")).stages[-1].contacts
    pressure, shear = -contacts.normal_force, np.abs(contacts.shear_force)
    assert_allclose(contacts.utilisation, shear / (pressure * tan(30)), rtol=RTOL)
    assert contacts.joint.tolist() == [0, 0]


def hanging(upper: float | None, lower: float | None, turn: float = 0.0) -> bsm.Model:
    """Return a block of 25 kN under a fixed one, unjointed: two rocks with tensile strengths, or elastic (None)."""
    strengths = [{} if given is None else {"tensile_strength": given, "cohesion": 1e6} for given in (upper, lower)]
    names = ["upper", "lower"]
    polygons = [turned(p, turn) for p in (square(0, 0), square(0, -1))]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=names),
        rocks=[
            bsm.Rock(name, unit_weight=25e3, young=1e9, poisson=0.2, **given)
            for name, given in zip(names, strengths, strict=True)
        ],
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=turn - 90.0,
    )


@pytest.mark.parametrize("turn", [0.0, 33.0])
@pytest.mark.parametrize(
    ("upper", "lower", "status"),
    [
        (60e3, 60e3, "stable"),
        (60e3, 15e3, "unstable"),
        (15e3, 60e3, "unstable"),
        (None, 60e3, "stable"),
        (15e3, None, "unstable"),
        (None, None, "stable"),
    ],
)
def test_a_block_hangs_by_the_weaker_of_two_rocks(upper, lower, status, turn):
    assert bsm.run(hanging(upper, lower, turn), bsm.Options(scheme="continuation")).status == status


def test_three_rocks_each_pair_has_its_own_tension():
    strengths = [1e4, 3e4, 2e4]
    rocks = [
        bsm.Rock(f"r{k}", unit_weight=0, young=1e9, poisson=0.2, cohesion=1e6 * (k + 1), tensile_strength=tension)
        for k, tension in enumerate(strengths)
    ]
    blocks = bsm.Blocks.from_polygons(grid(3, 1), rock=["r0", "r1", "r2"])
    model = bsm.Model(blocks=blocks, rocks=rocks, joints=joint(None))
    a, b = (k.ravel().astype(np.int32) for k in np.indices((3, 3)))
    law, tension = (catalogue := JointCatalogue(model)).laws_of(np.full(9, -1, np.int32), a, b)
    assert_allclose(tension, np.minimum(np.array(strengths)[a], np.array(strengths)[b]))
    shear = [peak_strength(catalogue.laws[k], np.zeros(1), np.ones(1))[0] for k in law]
    assert_allclose(shear, 1e6 * (np.minimum(a, b) + 1))
    assert not np.isfinite(catalogue.laws_of(np.zeros(1, np.int32), a[:1], b[:1])[1]).any()
