"""Rockbolts (Wang ch. 5) against statics and published closed forms: Farmer (1975), Wyllie and Mah (2004)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results import BoltStatus
from tests.scenes.models import LINEAR, installed_bolts
from tests.scenes.plane_failure import hoek_and_bray
from tests.scenes.shapes import rectangle
from verification.slopes import statics_of

CONTINUATION = bsm.Options(scheme="continuation")
GAMMA = 26e3
ROOF, HUNG = rectangle(0, 1, 3, 3), rectangle(1, 0, 2, 1)


def joint(stiffness, friction):
    return bsm.Joint("J", normal_stiffness=stiffness, shear_stiffness=stiffness, law=bsm.Patton(friction=friction))


def solve(polygons, bolts, *, stiffness=1e9, weight=GAMMA, supports=None, options=CONTINUATION, friction=30.0, **keys):
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=weight)],
        joints=[joint(stiffness, friction)],
        default_joint="J",
        supports=supports or [bsm.Fixed(blocks=[0])],
        bolts=bolts,
        **keys,
    )
    return bsm.run(model, options)


def stress_of(force, diameter):
    return force / (np.pi * diameter**2 / 4)


def roof_bolt(**keys):
    return bsm.Bolt(**{"start": (1.5, 0), "end": (1.5, 2.5), "diameter": 0.022, **keys})


# --- a bolt that hangs a free block -----------------------------------------------------------------------------


@pytest.mark.heavy
@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9, 1e12])
@pytest.mark.parametrize("kind", ["grouted", "end_anchored"])
@pytest.mark.parametrize("spacing", [1.0, 1.5])
def test_hanging_block(stiffness, kind, spacing):
    results = solve([ROOF, HUNG], [roof_bolt(kind=kind, spacing=spacing)], stiffness=stiffness)
    assert results.status == "stable"
    assert results.check().ok
    assert_allclose(results.stages[-1].bolts.axial_force, GAMMA * spacing, rtol=5e-3)


@pytest.mark.slow
def test_elastic_bond_holds_a_block_where_the_bolt_leaves_it():
    """Hung clear of the roof 0.1 m off its centre it tilts by atan of that over the depth of its centroid below."""
    results = solve(
        [rectangle(0, 1.5, 3, 3.5), HUNG],
        [
            bsm.Bolt(start=(1.6, 0), end=(1.6, 3.0), diameter=0.022, bond_stiffness=1e9),
        ],
    )
    stage = results.stages[-1]
    assert results.status == "stable"
    assert_allclose(stage.bolts.axial_force.max(), GAMMA, rtol=1e-3)
    height = stage.bolts.station[stage.bolts.block == 1].max()  # its node next to the joint
    assert 0.9 < height < 1.0
    assert_allclose(stage.displacement[1, 2], np.arctan2(0.1, height - 0.5), rtol=1e-3)


CAPACITIES = {
    "yield": ({"yield_strength": stress_of(1.0, 0.022)}, BoltStatus.YIELDING),
    "anchorage": ({"kind": "end_anchored", "anchor_capacity": 1.0}, BoltStatus.SLIPPING),
    "bond in the hung block": ({"bond_strength": 1.0}, BoltStatus.SLIPPING),  # it has 1 m there, 1.5 m above
    "interfaces": (
        {"hole_diameter": 0.04, "bond_steel_grout": 1 / (np.pi * 0.022), "bond_grout_rock": 1 / (np.pi * 0.022)},
        BoltStatus.SLIPPING,
    ),
    "elastic bond": ({"bond_strength": 1.0, "bond_stiffness": 1e9}, BoltStatus.SLIPPING),
}


@pytest.mark.heavy
@pytest.mark.parametrize("name", CAPACITIES)
def test_capacity_below_and_above_the_weight(name):
    keys, status = CAPACITIES[name]

    def hung(share):
        strengths = {
            k: v * share * GAMMA if isinstance(v, float) and k != "hole_diameter" else v for k, v in keys.items()
        }
        strengths |= {k: v for k, v in keys.items() if k == "bond_stiffness"}
        return solve([ROOF, HUNG], [roof_bolt(**strengths)])

    weak, strong = hung(0.99), hung(1.01)
    assert weak.status == "unstable"
    assert weak.unstable_blocks.tolist() == [1]
    bolts = weak.stages[-1].bolts
    assert_allclose(bolts.axial_force.max(), 0.99 * GAMMA, rtol=1e-9)
    assert bolts.status[0] == status
    assert_allclose(bolts.utilisation.max(), 1.0, rtol=1e-9)
    assert strong.status == "stable"
    assert_allclose(strong.stages[-1].bolts.axial_force.max(), GAMMA, rtol=5e-3)


# --- C3: plane failure with a bolt ------------------------------------------------------------------------------


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize(("plunge", "length", "published"), [(55, 8.0, 1.499), (20, 6.5, 2.099)])
@pytest.mark.parametrize("spacing", [1.0, 2.5])
def test_plane_failure_with_a_bolt_at_yield(plunge, length, published, spacing, points):
    T, case = 4e5, hoek_and_bray(cohesion=0.0)
    head, direction = np.array(case.crest) / 2, np.array([np.cos(np.radians(plunge)), -np.sin(np.radians(plunge))])
    bolt = bsm.Bolt(
        start=head,
        end=head + length * direction,
        kind="end_anchored",
        diameter=0.04,
        yield_strength=stress_of(T * spacing, 0.04),
        pretension=T * spacing,
        spacing=spacing,
    )
    found = statics_of(case, bolts=[bolt], contact_points=points)
    assert_allclose(found, case.factor_with_bolt(T, plunge), rtol=1e-10)
    assert_allclose(found, published, atol=1e-3)


# --- C15: grouted bolt with elastic bond ------------------------------------------------------------------------

D, E, L, BOND, PULL = 0.022, 200e9, 2.0, 1e9, 100e3


def pulled(load=PULL, **keys):
    """Return two blocks on either side of a joint that is pulled open; the bolt has the length L in each."""
    blocks = [rectangle(-L, -0.5, 0, 0.5), rectangle(0, -0.5, L, 0.5)]
    bolt = bsm.Bolt(start=(-L, 0), end=(L, 0), diameter=D, young=E, **keys)
    force = bsm.PointLoad(block=1, point=(L, 0), force=(load, 0))
    return solve(blocks, [bolt], weight=0.0, loads=[force])


@pytest.mark.heavy
@pytest.mark.parametrize("keys", [{}, {"bond_stiffness": BOND}])
def test_ultimate_pull(keys):
    bond = 150e3
    assert pulled(bond * L * (1 - 1e-4), bond_strength=bond, **keys).status == "stable"
    torn = pulled(bond * L * (1 + 1e-4), bond_strength=bond, **keys)
    assert torn.status == "unstable"
    assert_allclose(torn.stages[-1].bolts.axial_force.max(), bond * L, rtol=1e-9)


# --- pretension -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["grouted", "end_anchored"])
@pytest.mark.parametrize("options", [LINEAR, bsm.Options(scheme="continuation", tolerance=1e-10)])
def test_pretension_compresses_the_joints_between_its_ends(kind, options):
    """By statics of a cut along each joint: its contacts balance the bolt in force and moment; none beyond its ends."""
    T, y, spacing = 50e3, 0.35, 2.0
    blocks = [rectangle(i, 0, i + 1, 1) for i in range(5)]
    bolt = bsm.Bolt(start=(0.5, y), end=(3.5, y), diameter=0.02, kind=kind, pretension=T, spacing=spacing)
    results = solve(blocks, [bolt], weight=0.0, options=options)
    assert results.status.is_at_rest
    contacts, bolts = results.stages[-1].contacts, results.stages[-1].bolts
    block, point, force = bolts.on_blocks()
    for left in range(4):
        mine = np.minimum(contacts.block_a, contacts.block_b) == left
        sense = np.where(contacts.block_b[mine] > left, 1.0, -1.0)[:, None]
        right = block > left
        forces = np.concatenate([contacts.force[mine] * sense, force[right]])
        points = np.concatenate([contacts.point[mine], point[right]])
        moments = points[:, 0] * forces[:, 1] - points[:, 1] * forces[:, 0]
        assert_allclose(forces.sum(axis=0), 0, atol=1e-9 * T)
        assert_allclose(moments.sum(), 0, atol=1e-9 * T)
        compression = -contacts.normal_force[mine].sum()
        if left < 3:
            crossing = bolts.axial_force[min(left, len(bolts.axial_force) - 1)] / spacing
            assert_allclose(compression, crossing, rtol=1e-8)
            assert crossing > 0.9 * T / spacing
        else:
            assert_allclose(compression, 0, atol=1e-9 * T)


# --- balance, and the two kinds where they are one ---------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_forces_of_bolts_are_in_balance_with_themselves(seed):
    rng = np.random.default_rng(seed)
    polygons = [rectangle(i, j, i + 1, j + 1) for i in range(4) for j in range(3)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock")
    bolts = [
        bsm.Bolt(start=(0.2, 0.3), end=(3.9, 2.6), diameter=0.025, bond_strength=4e4, spacing=1.3),
        bsm.Bolt(start=(0.1, 2.9), end=(3.2, 0.2), diameter=0.025, bond_strength=9e4, bond_stiffness=1e8, plate=3e4),
        bsm.Bolt(start=(1.5, 0), end=(1.6, 2.7), diameter=0.03, kind="end_anchored", pretension=9e4),
        bsm.Bolt(start=(2.5, 0), end=(2.6, 2.7), diameter=0.03, bearing_stiffness=1e9, spacing=0.8),
    ]
    position = rng.normal(size=(blocks.count, 3)) * 0.02
    installed = installed_bolts(bolts, blocks, np.zeros_like(position))
    forces = installed.evaluate(position).forces
    placed = blocks.moments.centroid + position[:, :2]
    moment = placed[:, 0] * forces[:, 1] - placed[:, 1] * forces[:, 0] + forces[:, 2]
    assert np.abs(forces).max() > 1e4
    assert_allclose(forces[:, :2].sum(axis=0), 0, atol=1e-12 * np.abs(forces).sum())
    assert_allclose(moment.sum(), 0, atol=1e-12 * np.abs(moment).sum())


@pytest.mark.heavy
@pytest.mark.parametrize("load", [2e4, 6e4])
def test_end_anchored_is_grouted_with_two_nodes(load):
    """A grouted bolt through two blocks has one element; its bond there is the anchorage."""
    keys = {"diameter": 0.02, "start": (-0.8, 0.1), "end": (0.8, 0.1), "pretension": 5e3, "yield_strength": 3e8}
    found = []
    for extra in ({"kind": "end_anchored", "anchor_capacity": 5e4}, {"kind": "grouted", "bond_strength": 5e4 / 0.8}):
        blocks = [rectangle(-1, -0.5, 0, 0.5), rectangle(0, -0.5, 1, 0.5)]
        force = bsm.PointLoad(block=1, point=(1, 0), force=(load, -1e3))
        found.append(solve(blocks, [bsm.Bolt(**keys, **extra)], loads=[force], weight=1e3))
    one, other = found
    assert one.status == other.status == ("stable" if load < 5e4 else "unstable")
    assert_allclose(one.stages[-1].displacement, other.stages[-1].displacement, rtol=1e-9, atol=1e-15)
    assert_allclose(one.stages[-1].bolts.axial_force, other.stages[-1].bolts.axial_force, rtol=1e-9)


@pytest.mark.heavy
@pytest.mark.parametrize("kind", ["grouted", "end_anchored"])
def test_stiffness_times_length_instead_of_modulus_and_diameter(kind):
    """Wang Eqs. 5.1, 5.2: the tension is K_b times the elongation, K_b L the input."""
    given = {"start": (1.5, 0), "end": (1.5, 2.5), "diameter": 0.022, "kind": kind}
    bolts = bsm.Bolt(**given, stiffness=4e6), bsm.Bolt(**given, young=4e6 / (np.pi * 0.022**2 / 4))
    one, other = (solve([ROOF, HUNG], [bolt]).stages[-1] for bolt in bolts)
    assert_allclose(one.displacement, other.displacement, rtol=1e-12)
    head, tip = one.bolts.point
    assert_allclose(one.bolts.axial_force, 4e6 / 2.5 * (np.hypot(*(tip - head)) - 2.5), rtol=1e-6)
    with pytest.raises(bsm.ModelError, match="stiffness is given, and young too"):
        bsm.Bolt(**given, young=100e9, stiffness=4e6)


# --- unloading --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("keys", [{"yield_strength": stress_of(4e4, 0.02)}, {"bond_strength": 4e4}])
def test_unloading_and_reloading(keys):
    """Beyond the limit the force stays; back by the elastic stretch it is zero, then slack; reloaded the same way."""
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)], rock="rock")
    bolt = bsm.Bolt(start=(0, 0.5), end=(2, 0.5), diameter=0.02, **keys)
    start = np.zeros((2, 3))
    bolts = installed_bolts([bolt], blocks, start)
    elastic = 4e4 / (bolt.axial_stiffness / 2)
    forces = []
    for opening in np.array([0.5, 1.0, 3.0, 2.5, 2.0, 1.0, 2.0, 2.5, 3.0, 3.5]) * elastic:
        at = bolts.evaluate(start + np.array([(0, 0, 0), (opening, 0, 0)]))
        forces.append(at.tension[0])
        bolts = bolts.commit(at)
    assert_allclose(forces, np.array([0.5, 1, 1, 0.5, 0, 0, 0, 0.5, 1, 1]) * 4e4, atol=1e-6 * 4e4)


def test_installed_later_feels_only_what_moves_later():
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)], rock="rock")
    bolt = bsm.Bolt(start=(0, 0.5), end=(2, 0.5), diameter=0.02, pretension=1e4)
    start = np.zeros((2, 3))
    moved = start + np.array([(0, 0, 0), (1e-3, 2e-3, 1e-3)])
    bolts = installed_bolts([bolt], blocks, moved)
    assert_allclose(bolts.evaluate(moved).tension, 1e4)
    further = moved + np.array([(0, 0, 0), (1e-4, 0, 0)])
    assert_allclose(bolts.evaluate(further).tension, 1e4 + bolt.axial_stiffness / 2 * 1e-4, rtol=1e-3)
    assert (bolts.without(np.array([False, True])).evaluate(further).tension == 0).all()


@pytest.mark.parametrize("keys", [{}, {"bond_stiffness": 1e9}, {"bearing_stiffness": 1e9}, {"kind": "end_anchored"}])
def test_both_schemes_agree_where_nothing_fails(keys):
    """A wall under a sloping load, its tensioned bolts neither slack nor at a limit."""
    wall = [rectangle(i, j, i + 1, j + 1) for j in range(3) for i in range(3)]
    bolts = [
        bsm.Bolt(start=(0, 2.6), end=(2.9, 2.4), diameter=0.03, pretension=6e4, spacing=1.5, **keys),
        bsm.Bolt(start=(0, 1.4), end=(2.9, 1.6), diameter=0.03, pretension=6e4, spacing=1.5, **keys),
        bsm.Bolt(start=(0.4, 3), end=(0.6, 0.2), diameter=0.03, pretension=4e4, **keys),
    ]
    force = bsm.PointLoad(block=7, point=(1.5, 3), force=(5e3, -80e3))
    supports = [bsm.Fixed(blocks=[0, 1, 2])]
    one, other = (
        solve(wall, bolts, stiffness=1e10, friction=85, loads=[force], supports=supports, options=options).stages[-1]
        for options in (LINEAR, bsm.Options(scheme="continuation", tolerance=1e-8))
    )
    assert (one.bolts.axial_force > 1e3).all()
    assert (other.contacts.status == 0).all()
    size = np.abs(one.displacement).max()
    assert_allclose(other.displacement, one.displacement, atol=1e-4 * size)
    assert_allclose(other.bolts.axial_force, one.bolts.axial_force, rtol=1e-4)
    assert_allclose(other.bolts.shear_force, one.bolts.shear_force, atol=1e-3)
