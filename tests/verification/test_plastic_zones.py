"""Zones that yield: the return to the yield surface, its tangent, Salencon's hole, Prandtl's strip footing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.strength import with_strength
from bsm_mesh.pictures.safety_pictures import draw_mechanism
from bsm_mesh.results.evidence import Proof
from bsm_mesh.safety.trials import Reduction
from bsm_mesh.solve.limit import proof as limit_proof
from bsm_mesh.solve.zones import collapse, newton
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.mohr_coulomb import SETS, Yielding
from bsm_mesh.solve.zones.newton import find_equilibrium
from bsm_mesh.solve.zones.plastic_collapse import distance_left, plastic_collapse
from bsm_mesh.solve.zones.scheme import zoned
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.stage_solution import movement
from tests.scenes.plastic_zones import Hole, footing, slope
from tests.scenes.yield_surfaces import LAME, SHEAR, TANGENT, tangent_error, trials

ROCKS = {
    "associated": Yielding(LAME, SHEAR, 3.45e6, 30, 30, 1e6),
    "dilation 10": Yielding(LAME, SHEAR, 3.45e6, 30, 10, 1e6),
    "dilation 0, whole cone": Yielding(LAME, SHEAR, 3.45e6, 30, 0, 1e9),
    "clay": Yielding(LAME, SHEAR, 3.45e6, 0, 0, 0.0),
    "sand": Yielding(LAME, SHEAR, 0.0, 35, 5, 0.0),
}


@pytest.mark.parametrize("name", ROCKS)
def test_stresses_return_to_the_yield_surface(name):
    """And on every plane, edge and corner of it some of them do."""
    rock, trial = ROCKS[name], trials()
    found = rock.returned(trial)
    planes, bounds, _ = rock.planes
    in_order = -np.sort(-found.principal, axis=1)
    assert (in_order @ planes.T - bounds).max() < 1e-7 * 2e7
    elastic = found.set == 0
    assert_allclose(found.stress[elastic], trial[elastic])
    again = rock.returned(found.stress)
    assert_allclose(again.stress, found.stress, atol=1e-6 * 2e7)
    if name == "associated":
        assert set(found.set) == set(range(len(SETS) + 1))


def test_the_associated_return_is_the_nearest_stress():
    """By the energy of the difference: no admissible stress lies on the trial's side of the plane through it."""
    rock, trial = ROCKS["associated"], trials(300)
    found = rock.returned(trial).stress
    others = rock.returned(trials(40) * 1.3).stress
    tensors = [
        np.stack([s[:, 0], s[:, 2], 0 * s[:, 0], s[:, 2], s[:, 1], 0 * s[:, 0], 0 * s[:, 0], 0 * s[:, 0], s[:, 3]], 1)
        for s in (trial - found, found, others)
    ]
    taken, ours, theirs = tensors
    bulk = LAME + 2 * SHEAR / 3
    mean = (taken[:, 0] + taken[:, 4] + taken[:, 8]) / 3
    strain = (taken - mean[:, None] * np.eye(3).ravel()) / (2 * SHEAR) + mean[:, None] / (3 * bulk) * np.eye(3).ravel()
    work = np.einsum("ni,nmi->nm", strain, theirs[None] - ours[:, None])
    assert work.max() < 1e-6 * np.abs(work).max()


@pytest.mark.parametrize("name", ROCKS)
def test_the_tangent_is_the_derivative(name):
    error, compared = tangent_error(ROCKS[name], trials())
    assert compared > 0.9
    assert error < TANGENT


@pytest.mark.heavy
def test_salencons_hole():
    """Stresses within .5 % up to three radii, and the plastic radius within .5 %."""
    hole = Hole()
    results = bsm.run(hole.model(24, 12))
    assert results.status == "stable"
    assert results.check().ok
    stress, radius, by_area = hole.errors(results.stages[-1].zones)
    assert stress < 5e-3
    assert abs(radius) < 5e-3
    assert abs(by_area) < 0.02  # a zone there is .1 of it long


@pytest.mark.slow
def test_strip_footing():
    """Clay carries (2 + pi) c within 1 %, at full strength and at a part of it."""
    results = bsm.run(footing([0.7, 0.95, 0.99, 1.01]))
    assert [stage.status.value for stage in results.stages] == ["stable", "stable", "stable", "not_converged"]
    assert bsm.run(footing([0.7, 0.79], strength=0.808)).status == "stable"
    assert bsm.run(footing([0.7, 0.79], strength=0.782)).status == "unstable"


@pytest.mark.slow
@pytest.mark.parametrize("dilation", [0.0, 20.0])
def test_factor_of_a_homogeneous_slope(dilation, tmp_path):
    """From 2 % below Bishop & Morgenstern's 1.380 to 2 % above Griffiths & Lane's 1.4, with and without dilation."""
    found = bsm.factor_of_safety(slope(dilation=dilation), tolerance=0.02)
    assert found.is_closed
    assert found.unstable > 0.98 * 1.380
    assert found.stable < 1.02 * 1.4
    assert "yields without end" in next(one.reason for one in found.trials if one.value == found.unstable)
    assert len(found.mechanism.blocks) > 3
    assert found.changed == "rock in zones"
    zones = found.states[found.unstable].stages[-1].zones
    assert zones.yielded.any()
    assert zones.plastic_strain.max() > found.states[found.stable].stages[-1].zones.plastic_strain.max()
    draw_mechanism(found, "slope", tmp_path / "mechanism.png")
    assert (tmp_path / "mechanism.png").stat().st_size > 10_000


def test_the_reduced_strength_is_named():
    """Of zones that yield it is the rock's, beside joints and faces where there are any."""
    model = slope()
    assert Reduction().words(model) == "rock in zones"
    other = bsm.Rock("other", unit_weight=0.0, cohesion=1e5)
    joint = bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))
    more = model.replace(rocks=[*model.rocks, other], joints=[joint])
    assert Reduction(bolts=True).words(more) == "all joints, rock faces, rock in zones, bolts"
    assert Reduction(joints=("J1",), rocks=False).words(more) == "joint J1"


def test_no_equilibrium_is_nearer_than_the_bound(monkeypatch):
    """By the places that Newton's method reaches in a few corrections, just below the limit."""
    model = with_strength(slope(dilation=20.0, size=3.0), {"rock:soil": 1 / 1.35})
    continuum = zoned(model, bsm.Options())
    run = StageRun(continuum, nominal_constants(model).stiffness[continuum.mesh.block])
    there = np.ones(model.blocks.count, dtype=bool)
    equations = run.equations(there, run.loads_on(there))
    start = np.zeros(len(equations.load))
    rest, found = find_equilibrium(equations, start)
    assert found
    bounds = []
    for corrections in range(6):
        monkeypatch.setattr(newton, "MAX_ITERATIONS", corrections)
        at, found = find_equilibrium(equations, start)
        if found:
            break
        bounds.append(distance_left(equations, at, start))
        assert plastic_collapse(equations, at, start) is None
    assert len(bounds) > 4
    assert 0.05 * np.abs(rest.u).max() < max(bounds) <= np.abs(rest.u).max()


def test_limit_analysis_is_asked_about_a_block_that_is_there(monkeypatch):
    """Cells of an excavated block follow its neighbours. Where no equilibrium was found they may have moved most."""
    model = Hole().model(6, 3)
    gone = list(model.stages[0].excavate)

    def moved(of, u):
        found = movement(of, u)
        found[gone] += 1.0
        return found

    monkeypatch.setattr(newton, "MAX_ITERATIONS", 1)
    monkeypatch.setattr(collapse, "movement", moved)
    asked = []
    monkeypatch.setattr(limit_proof, "prove", lambda model, down: asked.append(down.tolist()) or Proof(text="no proof"))
    stage = bsm.run(model).stages[-1]
    assert stage.status == "not_converged"
    assert "bsm-mesh safety finds" in stage.reason
    assert asked
    assert max(map(max, asked)) < int(stage.present.sum())


def test_rock_that_is_put_back_is_without_plastic_strain():
    """Also rock that yielded before it was taken away: the ring about the first hole."""
    model, ring = Hole().model(6, 3), [0, 1, 2]
    back = [*model.stages[0].excavate, *ring]
    more = bsm.Stage(name="wider", excavate=ring), bsm.Stage(name="fill", fill=back)
    results = bsm.run(model.replace(stages=[*model.stages, *more]))
    assert results.status == "stable"
    hole, dug, filled = (stage.zones for stage in results.stages[-3:])
    assert hole.yielded[np.isin(hole.block, ring)].max() == 1.0
    assert not filled.yielded[np.isin(filled.block, back)].any()
    assert_allclose(filled.plastic_strain[~np.isin(filled.block, back)], dug.plastic_strain, rtol=1e-6)


REFUSED = [
    (lambda rock: replace(rock, cohesion=None, friction=None, tensile_strength=None), "yield by the rock's strength"),
    (lambda rock: replace(rock, residual_friction=20.0), "keep their strength"),
    (lambda rock: replace(rock, zones=replace(rock.zones, dilation=40.0)), "create energy"),
    (lambda rock: replace(rock, zones=bsm.Zones(dilation=10.0)), "is of rock that yields"),
    (lambda rock: replace(rock, zones=bsm.Zones(law="hooke")), "law"),
]


@pytest.mark.parametrize(("make", "words"), REFUSED)
def test_what_yielding_does_not_know_is_refused(make, words):
    with pytest.raises(bsm.ModelError, match=words):
        make(Hole().model(2, 2).rocks[0])
