"""Zones in large displacement: forces, tangents, blocks that turn, unstable equilibria, and parts that are refused."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.certificate.certificate import certificate, certificate_arrays
from bsm_mesh.solve.zones.large_rock import LargeRock
from bsm_mesh.solve.zones.moving_points import MovingPoints, Places
from tests.scenes import large_zones as scenes
from tests.scenes.arch import arch
from tests.scenes.shapes import rectangle, turned
from tests.scenes.zones import SHEAR, rock, under_stress
from tests.unit.test_zones import BOLT, CASES, GNEISS, RIGID, WATER, wall

STEP = 1e-6  # m, of differences
LARGE = bsm.Zones(size=0.5, displacement="large")
BENDS = dataclasses.replace(GNEISS, zones=LARGE)


def two_triangles(order):
    """Return the rock of a square under a stress of its own, and its unknowns."""
    mesh = skfem.MeshTri(np.array([(0.0, 1.0, 1.2, 0.0), (0.0, 0.0, 1.0, 1.1)]), np.array([(0, 0), (1, 2), (2, 3)]))
    element = skfem.ElementTriP1() if order == 1 else skfem.ElementTriP2()
    basis = skfem.CellBasis(mesh, skfem.ElementVector(element))
    stiffness = np.tile(np.array([(3.0, 1.0, 0.0), (1.0, 3.0, 0.0), (0.0, 0.0, 1.0)]), (2, 1, 1))
    initial = np.ones((3, *basis.dx.shape)) * np.array([-0.1, -0.2, 0.05])[:, None, None]
    return LargeRock.of(basis, stiffness, np.ones(2, dtype=bool), initial), basis


@pytest.mark.parametrize("order", [1, 2])
def test_tangent_of_rock_is_the_derivative_of_its_forces(order):
    rock_, basis = two_triangles(order)
    dofs, u = basis.element_dofs, 0.3 * np.random.default_rng(1).normal(size=basis.N)

    def forces(v):
        return rock_.forces(rock_.at(v, dofs), dofs, basis.N)

    differences = np.stack([(forces(u + d) - forces(u - d)) / (2 * STEP) for d in STEP * np.eye(basis.N)], axis=1)
    K = np.zeros((basis.N, basis.N))
    for cell, entries in enumerate(rock_.entries(rock_.at(u, dofs))):
        K[np.ix_(dofs[:, cell], dofs[:, cell])] += entries
    assert_allclose(K, differences, atol=1e-8 * np.abs(K).max())
    assert_allclose(K, K.T, atol=1e-14 * np.abs(K).max())


@pytest.mark.parametrize("degrees", [30, 90, 180])
def test_rock_that_turns_as_a_whole_keeps_its_stress(degrees):
    """Forces and Cauchy stress turn with it: S0 alone where nothing strains it."""
    rock_, basis = two_triangles(2)
    dofs, x = basis.element_dofs, basis.doflocs.copy()
    turn = np.array(turned(np.eye(2), degrees)).T
    moved = turn @ x - x
    u = np.where(np.isin(np.arange(basis.N), dofs[::2]), moved[0], moved[1])
    there, given = (rock_.at(v, dofs) for v in (u, np.zeros(basis.N)))
    forces, first = (rock_.forces(at, dofs, basis.N) for at in (there, given))
    pairs = np.unique(np.stack([dofs[::2].ravel(), dofs[1::2].ravel()], axis=1), axis=0)
    assert_allclose(forces[pairs], first[pairs] @ turn.T, atol=1e-14)
    assert_allclose(rock_.stress(there), turn @ rock_.stress(given) @ turn.T, atol=1e-14)


def test_derivatives_of_opening_and_slip_are_exact():
    """Between nodes too: r and e are any sums of the nodes' places."""
    rng, count = np.random.default_rng(2), 4
    points = MovingPoints.__new__(MovingPoints)
    none = np.zeros(count)
    known = {
        "unknown": np.arange(8 * count).reshape(count, 8),
        "parts": rng.normal(size=(count, 2, 4)),
        "given": rng.normal(size=(count, 2, 2)),
        "places": Places(piece=none, share=none, slid=rng.normal(size=count), over=none),
    }
    for name, value in known.items():
        object.__setattr__(points, name, value)
    u = rng.normal(size=8 * count)
    for which in (0, 1):
        by_r_and_e = points._gradients(u)[which].reshape(count, 2, 2)
        first = np.swapaxes(points.parts, 1, 2) @ by_r_and_e
        first, second = first.reshape(count, 8), points.on_nodes(points._second_derivatives(u)[which])
        for k in range(8):
            d = np.zeros((count, 8))
            d[:, k] = STEP
            up, down = u + d.ravel(), u - d.ravel()
            change = (points.relative(up)[which] - points.relative(down)[which]) / (2 * STEP)
            assert_allclose(change, first[:, k], atol=1e-8 * np.abs(first).max())
            turned_ = (points._gradients(up)[which] - points._gradients(down)[which]).reshape(count, 2, 2) / (2 * STEP)
            turned_ = (np.swapaxes(points.parts, 1, 2) @ turned_).reshape(count, 8)
            assert_allclose(turned_, second[:, :, k], atol=1e-8 * np.abs(second).max())


OTHERS = ("joints", "bolt", "in situ", "support of a block", "water", "water in whole rock")
HEAVY = [(case, order) for case in OTHERS for order in (1, 2)]


@pytest.mark.parametrize(
    ("case", "order"), [("whole rock", 2), *(pytest.param(*each, marks=pytest.mark.heavy) for each in HEAVY)]
)
def test_every_block_is_in_balance_and_the_certificate_holds(case, order, tmp_path, capsys):
    """By forces where the blocks are then, and outlines as they deformed."""
    zoned = dataclasses.replace(GNEISS, zones=dataclasses.replace(LARGE, order=order))
    results = bsm.run(wall(rocks=[zoned, RIGID], **CASES[case]))
    assert results.status == "stable", results.stages[-1].reason
    check = results.check()
    assert check.ok
    assert check.block_residual < 1e-8
    small = bsm.run(wall(**CASES[case])).stages[-1].displacement
    if order == 2:
        assert_allclose(results.stages[-1].displacement, small, atol=0.02 * np.abs(small).max())
    code, said = verify_certificate.main(results.save(tmp_path / "out")), capsys.readouterr().out
    assert code == 0, said
    assert "overlap" in said


@pytest.mark.parametrize(("beyond", "holds"), [(0.0, True), pytest.param(0.3, False, marks=pytest.mark.heavy)])
def test_certificate_of_a_block_that_slid_over_the_end_of_a_face(beyond, holds):
    """Its last point is 4 mm beyond the end and represents 0.25 m; it may not be further than that."""
    results = bsm.run(scenes.pushed(2.004), bsm.Options(threads=1))
    told, stage = certificate(results), results.stages[-1]
    arrays = {key: np.array(values) for key, values in certificate_arrays(results, stage).items()}
    point = arrays["contact_point"]
    last = np.abs(point[:, 0] - 4.004) < 1e-4
    assert (np.abs(arrays["contact_normal_force"][last]) > 1e3).any()
    point[last, 0] += beyond
    faults = verify_certificate.check_stage(told, told["stages"][-1], arrays)[1]
    assert ("contact 2 does not lie where its blocks touch" not in faults) == holds
    assert (not faults) == holds


@pytest.mark.parametrize("degrees", [pytest.param(37, marks=pytest.mark.heavy), 90])
def test_a_model_that_is_turned_has_the_same_answer(degrees):
    """Soft rock, so that strains are large enough for second-order terms to count: to 1e-9."""
    cut = [rectangle(i, j, i + 1, j + 1) for j in range(2) for i in range(2)]

    def answer(angle):
        soft = dataclasses.replace(rock(young=1e8), zones=bsm.Zones(order=1, displacement="large"))
        joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=5e8)
        model = under_stress(cut, 3 * SHEAR, [soft], degrees=angle, joints=[joint], default_joint="J")
        results = bsm.run(model)
        assert results.status == "stable", results.stages[-1].reason
        moved = results.stages[-1].displacement
        return np.column_stack([turned(moved[:, :2], -angle), moved[:, 2]])

    given = answer(0)
    assert np.abs(given[:, 2]).max() > 0.01  # beyond small displacements
    assert_allclose(answer(degrees), given, atol=1e-9 * np.abs(given).max())


@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_a_column_on_a_soft_joint_topples_below_its_critical_stiffness(factor):
    """Two points half a breadth from the middle, each with half its length: k b^3 / 4 against the moment W h / 2."""
    height, breadth, unit_weight = 6.0, 1.0, 25e3
    critical = 4 * unit_weight * height * breadth * (height / 2) / breadth**3
    polygons = [rectangle(-1, -1, 2, 0), rectangle(0, 0, breadth, height)]
    blocks = bsm.Blocks.from_polygons(polygons, rock="r").with_boundary("bottom", lambda x, y: y < -1 + 1e-9)
    stiff = bsm.Rock("r", unit_weight, young=1e13, poisson=0.0, zones=bsm.Zones(order=1, displacement="large"))
    joint = bsm.Joint("J", factor * critical, factor * critical, law=bsm.MohrCoulomb(friction=35))
    held = [bsm.Fixed(boundary="bottom")]
    model = bsm.Model(blocks=blocks, rocks=[stiff], joints=[joint], default_joint="J", supports=held)
    results = bsm.run(model)
    assert results.status == ("stable" if factor > 1 else "not_converged")
    assert ("is unstable" in results.stages[0].reason) == (factor < 1)


def test_stiff_rock_moves_as_rigid_blocks_do():
    """An arch of E = 1e13 Pa, within .2 % of the rigid engine."""
    model = arch(11, 0.12, 40.0)
    stiff = dataclasses.replace(model.rocks[0], young=1e13, poisson=0.2, zones=bsm.Zones(order=1, displacement="large"))
    rigid, zoned = (bsm.run(each).stages[-1].displacement for each in (model, model.replace(rocks=[stiff])))
    assert_allclose(zoned, rigid, atol=2e-3 * np.abs(rigid).max())


DUG = [bsm.Stage(name="out", excavate=[3]), bsm.Stage(name="back", fill=[3])]
SHAKEN = [bsm.Stage(name="quake", shaking=bsm.Shaking(waveform="sine", frequency=1.0, cycles=1, amplitude=0.1))]
REFUSED = [
    (lambda: bsm.Zones(displacement="huge"), "displacement"),
    (lambda: wall(rocks=[BENDS, RIGID], **CASES["water in a joint"]), "joint_pressure"),
    (lambda: wall(rocks=[BENDS, RIGID], water=WATER, stages=SHAKEN), "water in a stage that is shaken"),
    (lambda: wall(rocks=[BENDS, RIGID], bolts=[dataclasses.replace(BOLT, bearing_stiffness=2e9)]), "resist shear"),
    (lambda: wall(rocks=[BENDS, RIGID], stages=DUG), "fill"),
    (lambda: wall(rocks=[BENDS, RIGID], contact_points="gauss"), "gauss"),
    (lambda: wall(rocks=[BENDS, dataclasses.replace(GNEISS, name="rigid")]), 'others "small"'),
]


@pytest.mark.parametrize(("make", "words"), REFUSED)
def test_parts_that_are_not_known_are_refused(make, words):
    with pytest.raises(bsm.ModelError, match=words):
        make()
