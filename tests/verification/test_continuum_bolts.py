"""Bolts in the continuum: closed forms, and the Block-Spring Model with rigid blocks, whose bars they are."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum import compare_stages, solve_continuum_stages
from bsm_mesh.converters.continuum.files import write_bolts
from bsm_mesh.converters.vtk_files import read_vtu
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.results import BoltStatus
from bsm_mesh.solve.zones.mesh import Discretization
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.stages import Continuum
from tests.scenes import models
from tests.scenes.continuum import bolted
from tests.scenes.models import framed
from tests.scenes.shapes import grid, rectangle

EXAMPLES = Path(__file__).parents[2] / "examples"
GAMMA, D, E = 26e3, 0.022, 200e9
EA = E * np.pi * D**2 / 4
GROUTED = 5e-3  # of the bolts' forces (L2); found 4e-3, of which the corner that only blocks have is most
SAME = 1e-3  # rigid rock: rock of 1e13 Pa, and rotations of 1e-3 that blocks follow exactly
TANGENT = 1e-5  # of the greatest entry: central differences


def model_of(polygons, bolts, weight=GAMMA, friction=30.0, fields=None, **keys):
    rock = bsm.Rock("rock", unit_weight=weight, **(fields or {}))
    return models.model_of(polygons, rocks=[rock], friction=friction, bolts=bolts, **keys)


def both(model):
    results = bsm.run(model, bsm.Options(tolerance=1e-9))
    assert results.status == "stable"
    return results.stages, solve_continuum_stages(model, order=1, joints=True)


@pytest.mark.heavy
def test_wang_example_4():
    """Three grouted bolts around an opening, in rock of 40 GPa."""
    loaded = load_model_file(EXAMPLES / "04_bolted_opening/model.toml", lambda _: None)
    (stage,) = compare_stages(loaded.model, bsm.run(loaded.model, loaded.options))
    assert stage.comparison.bolt_error.l2 < GROUTED
    assert "in bolt forces" in stage.sentence
    assert stage.comparison.where(stage.comparison.bolt_error) == "wall"


@pytest.mark.parametrize("name", [pytest.param("model", marks=pytest.mark.heavy), "two_bolts"])
def test_bolts_in_rigid_rock_under_small_displacements(name):
    """A tenth of the loads: the rest of the difference is quadratic in the blocks' rotation, and in no element."""
    loaded = load_model_file(EXAMPLES / f"04_bolted_opening/{name}.toml", lambda _: None)
    tenth = bolted(loaded.model, load=0.1, rigid=True)
    (stage,) = compare_stages(tenth, bsm.run(tenth, bsm.Options(tolerance=1e-9)), refine=False)
    assert stage.comparison.bolt_error.l2 < SAME
    assert stage.comparison.force_error.l2 < SAME


def test_bolts_are_written_with_their_difference(tmp_path):
    loaded = load_model_file(EXAMPLES / "04_bolted_opening/two_bolts.toml", lambda _: None)
    (stage,) = compare_stages(loaded.model, bsm.run(loaded.model, loaded.options), refine=False)
    write_bolts(stage.comparison, tmp_path / "bolts.vtu")
    grid = read_vtu(tmp_path / "bolts.vtu")
    forces = [grid.cell_data[f"axial_force{end}"] for end in ("", "_fem", "_difference")]
    assert_allclose(forces[0], stage.comparison.bolts.axial_force)
    assert_allclose(forces[1], stage.comparison.nominal.bolts.axial_force)
    assert_allclose(forces[2], forces[0] - forces[1])
    assert_allclose(forces[1], forces[0], rtol=2e-2)


def test_histories_at_the_end_of_a_stage():
    """What the model records, by the same measure in both: the hung block, its joint, its bolt."""
    bolt = bsm.Bolt(name="B", start=(1.5, 0), end=(1.5, 2.5), diameter=D, young=E)
    histories = [
        bsm.History(name="point", point=(1.2, 0.5)),
        bsm.History(name="line", line=((1.5, 0.5), (1.5, 2.0))),
        bsm.History(name="block", block=1),
        bsm.History(name="joint", joint="J"),
        bsm.History(name="bolt", bolt="B"),
    ]
    model = model_of([rectangle(0, 1, 3, 3), rectangle(1, 0, 2, 1)], [bolt], histories=histories)
    results = bsm.run(model)
    (stage,) = compare_stages(model, results, refine=False)
    values = {(value.history, value.quantity): value for value in stage.comparison.histories}
    assert_allclose(values["bolt", "axial_force"].fem, GAMMA, rtol=1e-6)
    for key in (("point", "v"), ("line", "extension_1"), ("block", "v"), ("joint", "opening"), ("bolt", "axial_force")):
        assert_allclose(values[key].fem, values[key].bsm, rtol=5e-3)
        last = results.histories[key[0]][key[1]][-1]
        assert_allclose(values[key].bsm, last, rtol=1e-9)


@pytest.mark.parametrize("kind", ["grouted", "end_anchored"])
def test_hanging_block(kind):
    bolt = bsm.Bolt(start=(1.5, 0), end=(1.5, 2.5), diameter=D, young=E, kind=kind, spacing=1.5)
    stage = solve_continuum(model_of([rectangle(0, 1, 3, 3), rectangle(1, 0, 2, 1)], [bolt]), order=1, joints=True)
    assert stage.converged
    assert_allclose(stage.bolts.axial_force, 1.5 * GAMMA, rtol=1e-6)
    length = np.diff(stage.bolts.station).sum()
    assert_allclose(stage.displacement[1, 1], -1.5 * GAMMA * length / EA, rtol=1e-3)


def pulled(load, **keys):
    """Return the continuum of two blocks, pulled apart; the bolt has 2 m in each."""
    polygons = [rectangle(-2, -0.5, 0, 0.5), rectangle(0, -0.5, 2, 0.5)]
    force = bsm.PointLoad(block=1, point=(2.0, 0.0), force=(load, 0.0))
    bolt = bsm.Bolt(start=(-2, 0), end=(2, 0), diameter=D, young=E, **keys)
    return solve_continuum(model_of(polygons, [bolt], weight=0.0, loads=[force]), order=1, joints=True)


def test_elastic_shear_lag():
    """Farmer (1975): the opening of the joint under a grouted bolt, and its tension there."""
    bond, load = 1e9, 100e3
    stage = pulled(load, bond_stiffness=bond)
    b = np.sqrt(bond / EA)
    assert_allclose(stage.displacement[1, 0], 2 * load / np.tanh(2 * b) / (EA * b), rtol=1e-2)
    assert_allclose(stage.bolts.axial_force.max(), load, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("keys", [{"bond_strength": 50e3}, {"yield_strength": 100e3 / (np.pi * D**2 / 4)}])
def test_strength(keys):
    """Bond of 50 kN/m over 2 m, or steel that yields at 100 kN: it holds just less, and not just more."""
    assert pulled(99.9e3, **keys).converged
    assert not pulled(100.1e3, **keys).converged


def test_dowel_alone_holds_a_block():
    polygons = [rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)]
    bolt = bsm.Bolt(start=(0.5, 1), end=(0.5, -1), diameter=0.025, young=E, bearing_stiffness=2e9)
    push = bsm.PointLoad(block=1, point=(0.0, 0.0), force=(5e3, 0.0))
    ours, theirs = both(model_of(polygons, [bolt], friction=0.0, loads=[push]))
    assert_allclose(theirs[-1].bolts.shear_force, ours[-1].bolts.shear_force, rtol=SAME)
    assert_allclose(theirs[-1].displacement[1, 0], ours[-1].displacement[1, 0], rtol=SAME)


def test_bolts_by_stages():
    """Installed after the first settlement, then stressed by an excavation, then cut by another."""
    column = [rectangle(0, -j, 1, 1 - j) for j in range(4)]
    bolt = bsm.Bolt(start=(0.5, -0.3), end=(0.5, 0.6), diameter=0.02, stage="support", pretension=5e3)
    stages = [
        bsm.Stage(name="support"),
        bsm.Stage(name="open", excavate=[2]),
        bsm.Stage(name="cut", excavate=[1]),
    ]
    model = model_of(column, [bolt], stages=stages).replace(supports=[bsm.Fixed(blocks=[0]), bsm.Fixed(blocks=[3])])
    ours, theirs = both(model)
    for one, other in zip(ours, theirs, strict=True):
        assert_allclose(other.bolts.axial_force, one.bolts.axial_force, rtol=SAME, atol=1.0)
        assert_allclose(other.displacement, one.displacement, rtol=1e-2, atol=5e-6)  # a pendulum: hardly held sideways
    assert [s.bolts.status[0] for s in theirs] == [
        BoltStatus.ABSENT,
        BoltStatus.ELASTIC,
        BoltStatus.ELASTIC,
        BoltStatus.ABSENT,
    ]


def test_elastic_about_their_pretension():
    """In the linear scheme: springs in series, T = T0 K / (K + k), and what a load and an excavation add."""
    polygons = [rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1), rectangle(2, 0, 3, 1)]
    bolt = bsm.Bolt(start=(0.25, 0.5), end=(1.75, 0.5), diameter=0.05, kind="end_anchored", pretension=80e3)
    later = bsm.Bolt(start=(0.25, 0.4), end=(1.75, 0.4), diameter=0.02, stage="push", bearing_stiffness=1e9)
    load = bsm.PointLoad(block=1, point=(1.5, 0.5), force=(-30e3, -5e3))
    stages = [bsm.Stage(name="push", loads=[load]), bsm.Stage(name="off", excavate=[2])]
    model = model_of(polygons, [bolt, later], weight=0.0, stages=stages)
    results = bsm.run(model, bsm.Options(scheme="linear"))
    found = compare_stages(model, results)
    k = E * np.pi * 0.05**2 / 4 / 1.5
    initial = found[0].comparison.nominal.bolts.axial_force
    assert_allclose(initial, [80e3 * 1e9 / (1e9 + k), 0.0], rtol=1e-3)
    for stage, compared in zip(results.stages, found, strict=True):
        theirs = compared.comparison.nominal.bolts
        assert_allclose(theirs.axial_force, stage.bolts.axial_force, rtol=SAME, atol=1.0)
        assert_allclose(theirs.shear_force, stage.bolts.shear_force, rtol=SAME, atol=1.0)
        assert compared.comparison.force_error.l2 < SAME


@pytest.mark.parametrize("order", [1, 2])
def test_tangent_is_the_derivative(order):
    """Bars that slip, yield and shear, under their tension: central differences of the internal forces."""
    bolts = [
        bsm.Bolt(start=(0.2, 0.3), end=(2.8, 2.6), diameter=0.025, bond_strength=4e4, spacing=1.3),
        bsm.Bolt(start=(0.1, 2.9), end=(2.2, 0.2), diameter=0.025, bond_strength=9e4, bond_stiffness=1e8, plate=3e4),
        bsm.Bolt(start=(1.5, 0.1), end=(1.6, 2.7), diameter=0.03, kind="end_anchored", pretension=9e4),
        bsm.Bolt(start=(2.5, 0.1), end=(2.6, 2.7), diameter=0.03, bearing_stiffness=1e9, spacing=0.8),
    ]
    model = model_of(grid(3, 3), bolts, fields={"young": 20e9, "poisson": 0.2})
    continuum = Continuum(
        model.replace(blocks=framed(model.blocks, 3.0, 3.0)), Discretization(order=order, joints=True)
    )
    embedded = StageRun(continuum, np.tile(np.eye(3), (continuum.mesh.mesh.t.shape[1], 1, 1))).state.bolts
    rng = np.random.default_rng(3)
    u = 1e-3 * rng.standard_normal(continuum.basis.N)
    at = embedded.evaluate(u)
    assert (at.tension > 0).any()
    assert (at.tension == 0).any()
    K = embedded.tangent(at)
    for direction in rng.standard_normal((4, len(u))):
        step = 1e-9 * direction
        ahead, behind = (-embedded.forces(embedded.evaluate(u + s)) for s in (step, -step))
        assert_allclose((ahead - behind) / 2e-9, K @ direction, atol=TANGENT * np.abs(K @ direction).max())
