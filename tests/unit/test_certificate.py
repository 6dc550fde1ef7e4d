"""Certificates: a check without a partner carries every verdict out, and refuses what was changed."""

import ast
import contextlib
import io
import json
import shutil
import subprocess
import sys
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.converters.vtk_files import read_vtu
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

SCRIPT = Path(verify_certificate.__file__).parent
ALONE = {"__future__", "base64", "collections", "json", "math", "pathlib", "re", "sys", "tomllib", "typing", "zipfile"}
ALONE |= {"zlib", "numpy"}


class TwoThirds:
    """A law of the user's own: two thirds of the pressure."""

    def respond(self, pressure, trial_shear, length, failed):
        strength = np.maximum(pressure, 0.0) * 2 / 3
        sticking = np.abs(trial_shear) <= strength
        return bsm.JointResponse(
            shear=np.where(sticking, trial_shear, np.copysign(strength, trial_shear)),
            by_pressure=np.where(sticking | (pressure <= 0), 0.0, np.copysign(2 / 3, trial_shear)),
            strength=strength,
            sticking=sticking,
            failed=failed,
        )


def on_incline(law, degrees=30.0, **given):
    polygons = [turned(p, degrees) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    return model_of(polygons, law=law, **given)


def with_bolt(yield_strength):
    """Return a block below a fixed one, which a bolt alone holds."""
    bolt = bsm.Bolt(start=(0.5, 0.1), end=(0.5, 1.9), diameter=0.02, yield_strength=yield_strength)
    return model_of([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)], friction=30.0, fixed=(1,), bolts=[bolt])


def dilating():
    """Return a block that is pushed along a floor, 2 mm up to a wall, and rises by its dilation on the way."""
    polygons = [rectangle(-9, -1, 9, 0), rectangle(0, 0, 1, 1), rectangle(1.002, 0, 3, 1)]
    joint = bsm.Joint("J", 1e9, 4e8, law=bsm.MohrCoulomb(friction=30), dilation_angle=5, dilation_slip=1e-2)
    push = bsm.PointLoad(block=1, point=(0.0, 0.3), force=(20e3, 0.0))
    return model_of(polygons, joint=joint, fixed=(0, 2), loads=[push])


SCENES = {
    "at rest": (lambda: on_incline(bsm.MohrCoulomb(friction=35)), ["equilibrium"]),
    "slides": (lambda: on_incline(bsm.MohrCoulomb(friction=25)), ["proved"]),
    "dilates": (lambda: dilating(), ["equilibrium"]),
    "patton holds": (
        lambda: on_incline(bsm.Patton(friction=25, dilation=10, cohesion=1e4, residual_friction=20)),
        ["equilibrium"],
    ),
    "patton slides": (
        lambda: on_incline(bsm.Patton(friction=20, dilation=15, cohesion=1e2, residual_friction=15)),
        ["proved"],
    ),
    "own law": (lambda: on_incline(TwoThirds()), ["equilibrium"]),
    "bolt holds": (lambda: with_bolt(500e6), ["equilibrium"]),
    "bolt yields": (lambda: with_bolt(30e6), ["proved"]),
    "wedged": (
        lambda: model_of([rectangle(x, 0, x + 1, 1) for x in range(3)], friction=30.0, fixed=(0, 2)),
        ["followed"],
    ),
    "water": (
        lambda: on_incline(bsm.MohrCoulomb(friction=40), water=bsm.Water(table=[(-20, -0.2), (20, 0.2)])),
        ["equilibrium"],
    ),
    "loaded": (
        lambda: on_incline(
            bsm.MohrCoulomb(friction=40), loads=[bsm.PointLoad(block=1, point=(0.0, 0.2), force=(2e3, -1e3))]
        ),
        ["equilibrium"],
    ),
}


@cache
def results_of(name):
    return bsm.run(SCENES[name][0]())


def save(name, tmp_path):
    return results_of(name).save(tmp_path / "first")


@pytest.fixture(scope="module", params=SCENES)
def saved(request, tmp_path_factory):
    grounds = SCENES[request.param][1]
    folder = tmp_path_factory.mktemp("saved") / "out"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.ResultsWarning)  # a law of the user's own cannot be written
        results_of(request.param).save(folder)
    return folder, grounds


def checked(folder):
    """Return exit code and lines of the script."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = verify_certificate.main(folder)
    return code, said.getvalue().splitlines()


def test_the_script_stands_alone():
    """Of other modules it imports its own only, and those of Python and NumPy."""
    names, own = set(), {path.stem for path in SCRIPT.glob("*.py")}
    for path in SCRIPT.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level:
                assert node.level == 1
                assert node.module in own
            elif isinstance(node, ast.ImportFrom):
                names.add(str(node.module).partition(".")[0])
    assert names == ALONE


def test_the_folder_runs_wherever_it_is_copied(tmp_path):
    folder = save("at rest", tmp_path)
    copy = shutil.copytree(SCRIPT, tmp_path / "check of certificates")
    done = subprocess.run(
        [sys.executable, "-I", str(copy), str(folder)], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert (done.returncode, done.stdout.splitlines(), done.stderr) == (*checked(folder), "")


@pytest.mark.heavy
def test_it_runs_where_the_package_cannot_be_imported(tmp_path):
    folder = save("slides", tmp_path)
    done = subprocess.run(
        [sys.executable, "-I", str(SCRIPT), str(folder)], capture_output=True, text=True, check=False, cwd=folder
    )
    assert (done.returncode, done.stdout.splitlines(), done.stderr) == (*checked(folder), "")
    assert "proved" in done.stdout


def test_every_verdict_bears_out(saved):
    folder, grounds = saved
    told = json.loads((folder / "certificate.json").read_text(encoding="utf-8"))
    assert [stage["ground"] for stage in told["stages"]] == grounds
    code, lines = checked(folder)
    assert code == 0, lines
    assert ("laws of the user's own" in lines[0]) == any(law["kind"] == "own" for law in told["stages"][0]["laws"])


def changed(folder, target, arrays=None, **told):
    """Copy a folder with other arrays (functions of what they were) and other words in the first stage."""
    shutil.copytree(folder, target)
    certificate = json.loads((target / "certificate.json").read_text(encoding="utf-8"))
    stage = certificate["stages"][0]
    stage.update({key: change(stage[key]) for key, change in told.items()})
    (target / "certificate.json").write_text(json.dumps(certificate), encoding="utf-8")
    with np.load(target / stage["arrays"]) as file:
        columns = dict(file)
    for name, change in (arrays or {}).items():
        columns[name] = change(columns[name])
    np.savez(target / stage["arrays"], **columns)
    return target


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("contact_normal_force", "out of balance"),
        ("contact_shear_force", "out of balance"),
        ("weight", "out of balance"),
        ("reactions", "reactions are not the sum"),
        ("contact_utilisation", "has another strength than is said"),
        ("support_reaction", "reactions are not the sum"),
    ],
)
def test_a_changed_force_is_refused(tmp_path, name, words):
    code, lines = checked(changed(save("at rest", tmp_path), tmp_path / "out", {name: lambda v: v * 1.001}))
    assert code == 1
    assert words in lines[-1]


@pytest.mark.parametrize("friction", [29.0, 36.0])
def test_a_changed_friction_is_refused(tmp_path, friction):
    folder = save("at rest", tmp_path)
    code, lines = checked(
        changed(folder, tmp_path / "out", laws=lambda laws: [{**law, "friction": friction} for law in laws])
    )
    assert code == 1
    assert "strength" in lines[-1]


def test_a_turned_block_is_refused(tmp_path):
    folder = save("at rest", tmp_path)
    code, lines = checked(changed(folder, tmp_path / "out", {"position": lambda v: v + np.array([0, 0, 0.02])}))
    assert code == 1
    assert "DOES NOT HOLD" in lines[-1]


def test_a_sunken_block_overlaps(tmp_path):
    folder = save("at rest", tmp_path)

    def sunk(position):
        position[1] += (0.05, -0.05, 0.0)
        return position

    code, lines = checked(changed(folder, tmp_path / "out", {"position": sunk}))
    assert code == 1
    assert "blocks overlap" in lines[-1]


@pytest.mark.parametrize(
    ("scene", "verdict", "ground"),
    [
        ("at rest", "unstable", "followed"),
        ("at rest", "unstable", "proved"),
        ("slides", "stable", "equilibrium"),
        ("slides", "unstable", "equilibrium"),
        ("wedged", "stable", "equilibrium"),
    ],
)
def test_a_changed_verdict_is_refused(tmp_path, scene, verdict, ground):
    folder = changed(save(scene, tmp_path), tmp_path / "out", verdict=lambda _: verdict, ground=lambda _: ground)
    text = (folder / "summary.json").read_text(encoding="utf-8")
    assert checked(folder)[0] == 1  # the summary says otherwise
    told = json.loads(text)
    told["stages"][0]["status"] = verdict
    (folder / "summary.json").write_text(json.dumps(told), encoding="utf-8")
    code, lines = checked(folder)
    assert code == 1
    assert "DOES NOT HOLD" in lines[0]


@pytest.mark.parametrize(
    ("scene", "arrays", "words"),
    [
        ("slides", {"proof_velocity": lambda v: -v}, "the mechanism proves nothing"),
        ("slides", {"proof_velocity": lambda v: v - np.array([0, 0.1, 0])}, "the mechanism proves nothing"),
        ("slides", {"proof_loads": lambda v: 2 * v}, "loaded otherwise"),
        ("slides", {"proof_lines": lambda v: v / 2}, "the lines of law 0 are not its strength"),
        ("bolt yields", {"proof_element_yield": lambda v: 3 * v}, "the mechanism proves nothing"),
        ("wedged", {"displacement": lambda v: v / 2}, "blocks have not moved as far"),
    ],
)
def test_a_changed_mechanism_is_refused(tmp_path, scene, arrays, words):
    code, lines = checked(changed(save(scene, tmp_path), tmp_path / "out", arrays))
    assert code == 1
    assert words in lines[-1]


def test_friction_raised_in_a_proof_is_refused(tmp_path):
    """No mechanism of 25 degrees proves anything for 31: the block would rest."""
    folder = save("slides", tmp_path)

    def rougher(laws):
        return [{**law, "friction": 31.0} if "friction" in law else law for law in laws]

    slope = np.tan(np.radians(31.0))
    code, lines = checked(
        changed(
            folder,
            tmp_path / "out",
            {"proof_lines": lambda v: np.where(v == v[0, 0, 0], slope, v)},
            laws=rougher,
            proof=lambda proof: {**proof, "laws": rougher(proof["laws"])},
        )
    )
    assert code == 1
    assert "the mechanism proves nothing" in lines[-1]


def test_an_equilibrium_from_which_blocks_would_fall_is_refused(tmp_path):
    """On contacts so soft the block would topple: its weight turns it more than they turn it back."""

    def softer(stiffness):
        return 1e-6 * stiffness

    soft = {"normal_stiffness": softer, "shear_stiffness": softer}
    code, lines = checked(changed(save("at rest", tmp_path), tmp_path / "out", soft))
    assert code == 1
    assert "there is a direction in which blocks fall" in lines[-1]


def test_the_mechanism_is_in_the_blocks_file(tmp_path):
    cells = read_vtu(save("slides", tmp_path) / "blocks_0000.vtu").cell_data["mechanism"]
    u, v, _ = cells[1]
    assert np.degrees(np.arctan2(v, u)) % 360 == pytest.approx(210.0 - 25.0)


def test_read_back_results_have_the_same_certificate(tmp_path):
    folder = save("bolt yields", tmp_path)
    again = bsm.Results.load(folder)
    with pytest.warns(bsm.ResultsWarning):
        again.save(tmp_path / "again")
    for name in ("certificate.json", "certificate_0000.npz"):
        assert (tmp_path / "again" / name).read_bytes() == (folder / name).read_bytes()


def test_what_bears_pressure_may_be_open_by_its_dilation_alone(tmp_path):
    """Walls that slip has parted carry pressure; without the angle, or without the slip, they could not."""
    results = bsm.run(dilating())
    contacts = results.stages[0].contacts
    slipped = np.tan(np.radians(5)) * 2e-3
    assert contacts.opening[contacts.normal_force < 0].max() == pytest.approx(slipped, rel=0.2)
    assert results.check().ok
    folder = results.save(tmp_path / "out")
    assert checked(folder)[0] == 0
    for name in ("dilation", "slip_path"):
        code, lines = checked(changed(folder, tmp_path / name, {name: np.zeros_like}))
        assert code != 0
        assert any("carries pressure and is open" in line for line in lines)
