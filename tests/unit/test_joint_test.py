"""Laboratory tests of a joint and of a bolt: closed forms in Python, files and messages of the command."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.joint_test import closure_test, direct_shear_test, pull_bolt, shear_bolt

LAW = bsm.MohrCoulomb(friction=35, cohesion=1e5, residual_friction=30, residual_cohesion=2e4, softening_slip=5e-3)
JOINT = bsm.Joint("J", 10e9, 2e9, law=LAW)
PEAK, LEFT = 1e5 + 1e6 * np.tan(np.radians(35)), 2e4 + 1e6 * np.tan(np.radians(30))


def test_direct_shear_rises_elastically_softens_and_ends_at_the_residual():
    curve = direct_shear_test(JOINT, 1e6, 0.012)
    u, elastic = curve.shear_displacement, PEAK / 2e9
    rising = u < 0.99 * elastic
    assert_allclose(curve.shear_stress[rising], 2e9 * u[rising], atol=1e-3)
    fall = (PEAK - LEFT) / 5e-3  # with the slip s = u - stress / ks
    falling = (u > 1.2 * elastic) & (u < 4e-3)
    exact = (PEAK - fall * u) / (1 - fall / 2e9)
    assert_allclose(curve.shear_stress[falling], exact[falling], rtol=0.01)
    assert_allclose(curve.shear_stress[-20:], LEFT, rtol=1e-12)
    assert_allclose(curve.normal_stress, 1e6, rtol=1e-9)


@pytest.mark.slow
def test_to_and_fro_energy_is_dissipated():
    curve = direct_shear_test(JOINT, 1e6, 0.012, cycles=2)
    assert_allclose(curve.shear_displacement[[0, 200, 400, 600, 800, 1000]], np.array([0, 12, 0, -12, 0, 12]) * 1e-3)
    assert (np.diff(curve.slip_path) >= -1e-12).all()
    assert curve.work > LEFT * 0.06


def test_a_joint_that_opens_bears_nothing_and_one_without_law_everything():
    plain = direct_shear_test(bsm.Joint("J", 10e9, 2e9), 1e6, 0.01, steps=20)
    assert_allclose(plain.shear_stress, 2e9 * plain.shear_displacement)
    assert np.isinf(plain.strength).all()


def test_linear_closure():
    curve = closure_test(JOINT, 20e6, steps=10)
    assert_allclose(curve.closure, curve.normal_stress / 10e9, atol=1e-15)
    assert len(curve.closure) == 21


BOLT = bsm.Bolt(
    start=(0, 0), end=(0, 2), diameter=0.025, young=200e9, yield_strength=500e6, bond_strength=150e3, spacing=1.5
)


def test_a_bolt_is_pulled_out_of_the_shorter_half():
    """150 kN/m on a metre; before, E A over its length."""
    curve = pull_bolt(BOLT, 0.02)
    assert_allclose(curve.force[-1], 150e3, rtol=1e-6)
    assert_allclose(curve.tension, curve.force, rtol=1e-9, atol=1e-6)
    assert_allclose(curve.force[1] / curve.displacement[1], 200e9 * np.pi * 0.025**2 / 4 / 2.0, rtol=1e-9)


def test_a_strong_bond_lets_the_steel_yield():
    strong = bsm.Bolt(start=(0, 0), end=(0, 2), diameter=0.025, young=200e9, yield_strength=500e6, bond_strength=1e6)
    assert_allclose(pull_bolt(strong, 0.02).force[-1], 500e6 * np.pi * 0.025**2 / 4, rtol=1e-9)


def test_a_bolt_across_a_joint_bears_shear_by_dowel_action_or_as_it_turns():
    assert abs(shear_bolt(BOLT, 1e-3).force[1]) < 1.0  # a bolt at right angles stretches in the second order only
    doweled = shear_bolt(replace(BOLT, bearing_stiffness=1e9), 1e-3)
    assert_allclose(doweled.shear, doweled.force, rtol=0.02, atol=10.0)
    assert doweled.force[-1] > 1e3
    assert shear_bolt(BOLT, 1e-2, inclination=30).force[-1] > 0.4 * 150e3


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: direct_shear_test(JOINT, -1e6, 0.01), "direct shear test: normal_stress = -1e"),
        (lambda: direct_shear_test(JOINT, 1e6, 0.0), "displacement = 0 m"),
        (lambda: direct_shear_test("J", 1e6, 0.01), r"joint = 'J' must be bsm.Joint\(...\)"),
        (lambda: closure_test(JOINT, 1e6, steps=1), "steps = 1"),
        (lambda: pull_bolt(BOLT, 0.01, inclination=90), "bolt pulled out: inclination = 90 degrees"),
    ],
)
def test_bad_values(call, words):
    with pytest.raises(bsm.ModelError, match=words):
        call()


MODEL = """
[mesh]
file = "mesh.vtu"
default_joint = "J1"
[rock.r]
unit_weight = "26 kN/m^3"
[joint.J1]
normal_stiffness = "10 GPa/m"
shear_stiffness = "2 GPa/m"
law = "barton_bandis"
jrc = 8
jcs = "80 MPa"
residual_friction = 28
max_closure = "0.2 mm"
[[support]]
blocks = [0]
fix = "all"
[[bolt]]
name = "b"
start = [0.5, 0.9]
end = [0.5, -0.9]
diameter = "25 mm"
young = "200 GPa"
bond_strength = "150 kN/m"
"""


@pytest.fixture
def folder(tmp_path):
    from bsm_mesh.converters.meshes.block_files import write_polygons
    from tests.scenes.shapes import rectangle

    blocks = bsm.Blocks.from_polygons([rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)], rock="r")
    write_polygons(blocks, tmp_path / "mesh.vtu")
    (tmp_path / "model.toml").write_text(MODEL)
    (tmp_path / "lab.csv").write_text("displacement [m],shear_stress [Pa]\n0.001,9e5\n0.002,9.2e5\n")
    return tmp_path


def test_the_command_at_one_stress(folder):
    words = ["joint-test", str(folder / "model.toml"), "--joint", "J1", "--normal-stress", "1 MPa", "--json"]
    done = CliRunner().invoke(cli, [*words, "-o", str(folder / "out")])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    names = {"joint_shear.csv", "joint_closure.csv", "joint_shear.png", "joint_closure.png"}
    assert {name.rsplit("/", 1)[-1] for name in told["files"]} == names
    assert_allclose(told["closure"], 1e6 * 2e-4 / (10e9 * 2e-4 + 1e6), rtol=1e-9)
    assert all((folder / "out" / name).stat().st_size > 500 for name in names)


@pytest.mark.slow
def test_the_command_writes_tables_and_pictures(folder):
    words = [
        "joint-test",
        str(folder / "model.toml"),
        "--joint",
        "J1",
        "--normal-stress",
        "1 MPa",
        "--normal-stress",
        "2e6",
    ]
    words += [
        "--cycles",
        "1",
        "--bolt",
        "b",
        "--laboratory",
        str(folder / "lab.csv"),
        "-o",
        str(folder / "out"),
        "--json",
    ]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0
    told = json.loads(done.stdout)
    peak = [1e6 * s * np.tan(np.radians(28 + 8 * np.log10(80 / s))) for s in (1, 2)]
    assert_allclose([row["peak_shear_stress"] for row in told["shear"]], peak, rtol=1e-6)
    assert_allclose(told["closure"], 2e6 * 2e-4 / (10e9 * 2e-4 + 2e6), rtol=1e-9)
    for file in told["files"]:
        assert (folder / "out" / file.rsplit("/", 1)[-1]).stat().st_size > 500
    with (folder / "out" / "joint_shear.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 801
    assert_allclose(max(float(row["shear_stress [Pa]"]) for row in rows), peak[1], rtol=1e-6)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--joint", "J2"], "there is no joint 'J2'"),
        (["--joint", "J1", "--bolt", "x"], "there is no bolt 'x'"),
        (["--joint", "J1", "--normal-stress", "1 m"], "--normal-stress '1 m'"),
        (["--joint", "J1", "--displacement", "-1"], "--displacement '-1'"),
        (["--joint", "J1", "--laboratory", "bad.csv"], "needs the columns displacement, shear_stress; it has"),
        (["--joint", "J1", "--laboratory", "none.csv"], "none.csv: cannot be read"),
        (["--joint", "J1", "--laboratory", "words.csv"], "is no finite number"),
    ],
)
def test_what_cannot_be_tested_is_told(folder, monkeypatch, words, said):
    monkeypatch.chdir(folder)
    (folder / "bad.csv").write_text("a,b\n1,2\n")
    (folder / "words.csv").write_text("displacement [m],shear_stress [Pa]\n1,x\n")
    with pytest.raises(bsm.ModelError) as told:
        CliRunner().invoke(cli, ["joint-test", "model.toml", *words], catch_exceptions=False)
    assert said in str(told.value)
    assert not (folder / "out").exists()


DILATING = bsm.Joint("J", 20e9, 4e9, law=bsm.MohrCoulomb(friction=35), dilation_angle=8, dilation_slip=5e-3)


@pytest.mark.slow
def test_under_a_constant_stress_a_joint_opens_by_the_slope_of_dilation():
    curve = direct_shear_test(DILATING, 1e6, 8e-3, cycles=1)
    slip = 8e-3 - 1e6 * np.tan(np.radians(35)) / 4e9
    assert_allclose(curve.normal_stress, 1e6, rtol=1e-9)
    assert_allclose(curve.slip_path[200], slip, rtol=1e-9)
    rises = np.tan(np.radians(8)) * np.minimum(curve.slip_path, 5e-3)
    assert_allclose(curve.closure[0] - curve.closure, rises, atol=1e-12)
    assert curve.work > 0


@pytest.mark.heavy
@pytest.mark.parametrize("steps", [5, 200])
def test_under_a_constant_stiffness_the_stress_grows_with_the_opening(steps):
    """The rock around, of the stiffness K, takes what the joint opens by beyond what it closes by under more stress."""
    K, kn, ks = 5e9, 20e9, 4e9
    mu, t = np.tan(np.radians([35, 8]))
    curve = direct_shear_test(DILATING, 1e6, 4e-3, steps=steps, normal_stiffness=K)
    both = K * kn / (K + kn)
    slip = (4e-3 - mu * 1e6 / ks) / (1 + mu * t * both / ks)
    assert_allclose(curve.slip_path[-1], slip, rtol=1e-9)
    assert_allclose(curve.normal_stress[-1], 1e6 + both * t * slip, rtol=1e-9)
    assert_allclose(curve.shear_stress[-1], mu * curve.normal_stress[-1], rtol=1e-9)


@pytest.mark.slow
def test_a_joint_that_wears_as_it_dilates_keeps_its_stress_to_and_fro():
    """Stresses jump by what rounding leaves of the corners: no opening gives the last digit."""
    law = bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28, roughness_wears=True)
    joint = bsm.Joint("J", 1e9, 5e8, law=law, dilation_angle=8, dilation_slip=5e-3)
    curve = direct_shear_test(joint, 1e6, 8e-3, cycles=1, steps=50)
    assert_allclose(curve.normal_stress, 1e6, rtol=1e-9)
    assert curve.closure[0] - curve.closure[-1] == pytest.approx(np.tan(np.radians(8)) * 5e-3, rel=1e-9)


@pytest.mark.slow
def test_the_command_draws_the_opening_of_a_joint_that_dilates(folder):
    text = MODEL.replace('max_closure = "0.2 mm"', 'dilation_angle = 6\ndilation_slip = "4 mm"')
    (folder / "model.toml").write_text(text)
    words = ["joint-test", str(folder / "model.toml"), "--joint", "J1", "--normal-stiffness", "5 GPa/m"]
    done = CliRunner().invoke(cli, [*words, "-o", str(folder / "out"), "--json"])
    assert done.exit_code == 0, done.output
    assert (folder / "out/joint_opening.png").stat().st_size > 0
    with (folder / "out/joint_shear.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["normal_stress_of_test [Pa]"]) == 0.5e6]
    closure, stress = (np.array([float(row[name]) for row in rows]) for name in ("closure [m]", "normal_stress [Pa]"))
    assert_allclose(stress, 0.5e6 + 5e9 * (closure[0] - closure), rtol=1e-9)
    assert stress[-1] > 1e6
