"""The ground of a verdict, by the command, from the files of a results folder alone."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.certificate.verify_certificate import check_stage
from bsm_mesh.commands.cli import cli
from bsm_mesh.folder.own_files import SUMMARY
from bsm_mesh.folder.summary import _checksum, fingerprint
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned


def on_incline(friction, degrees=30.0, **given):
    polygons = [turned(p, degrees) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    return model_of(polygons, friction=friction, **given)


def verified(folder):
    outcome = CliRunner().invoke(cli, ["verify", str(folder), "--json"])
    return json.loads(outcome.stdout), outcome.exit_code


def told(results, folder):
    results.save(folder)
    return verified(folder)


def test_forces_at_rest_are_checked(tmp_path):
    (ground,), code = told(bsm.run(on_incline(35.0)), tmp_path / "out")
    assert (ground["verdict"], ground["kind"], ground["holds"], code) == ("stable", "equilibrium", True, 0)
    assert "every block is in balance" in ground["text"]
    assert "no direction in which blocks fall" in ground["text"]


def test_the_linear_scheme_gives_no_verdict(tmp_path):
    """A block on a slope steeper than its friction: forces balance, and nothing can fail."""
    results = bsm.run(on_incline(25.0), bsm.Options(scheme="linear"))
    assert results.status == "no_verdict"
    assert not results.status.is_stable
    assert results.status.is_at_rest
    (ground,), code = told(results, tmp_path / "out")
    assert (ground["verdict"], ground["kind"], ground["holds"], code) == ("no_verdict", "equilibrium", True, 0)
    assert bsm.Results.load(tmp_path / "out").status == "no_verdict"
    summary = json.loads((tmp_path / "out" / SUMMARY).read_text())
    assert summary["stages"][0]["verdict"] == "no verdict: nothing can fail in this scheme"


@pytest.mark.parametrize(("scheme", "claimed"), [("linear", "stable"), ("continuation", "no_verdict")])
def test_a_verdict_that_its_scheme_cannot_give_does_not_hold(tmp_path, scheme, claimed):
    out = tmp_path / "out"
    results = bsm.run(on_incline(35.0), bsm.Options(scheme=scheme))
    results.save(out)
    certificate = json.loads((out / "certificate.json").read_text())
    certificate["stages"][0]["verdict"] = claimed
    with np.load(out / certificate["stages"][0]["arrays"]) as arrays:
        text, faults = check_stage(certificate, certificate["stages"][0], dict(arrays))
    assert (text, len(faults)) == ("", 1)
    assert f"an equilibrium of scheme '{scheme}' is none for '{claimed}'" in faults[0]


@pytest.mark.heavy
def test_a_slide_is_proved_by_its_mechanism(tmp_path):
    (ground,), code = told(bsm.run(on_incline(25.0)), tmp_path / "out")
    assert (ground["verdict"], ground["kind"], code) == ("unstable", "proved", 0)
    assert "block 1 was followed over" in ground["text"]


def test_what_was_followed_is_named_where_nothing_is_proved(tmp_path):
    """Friction between walls might hold a block, and statics cannot determine that nothing presses it there."""
    walled = model_of([rectangle(x, 0, x + 1, 1) for x in range(3)], friction=30.0, fixed=(0, 2))
    (ground,), code = told(bsm.run(walled), tmp_path / "out")
    assert (ground["verdict"], ground["kind"], code) == ("unstable", "followed", 0)
    assert "block 1 was followed over" in ground["text"]
    assert "forces within strength exist that balance the loads, which proves nothing" in ground["text"]


@pytest.mark.heavy
def test_no_proof_is_sought_where_blocks_have_moved_before(tmp_path):
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    stop = turned(rectangle(-1.8, 0, -0.8, 0.5), 30.0)
    model = model_of([*polygons, stop], friction=25.0, fixed=(0, 2), stages=[bsm.Stage(name="later", excavate=[2])])
    grounds, code = told(bsm.run(model), tmp_path / "out")
    assert ([ground["kind"] for ground in grounds], code) == (["equilibrium", "followed"], 0)
    assert "no proof was sought: blocks moved by 0.3 m before" in grounds[1]["text"]


@pytest.mark.heavy
def test_an_excavation_is_proved_where_nothing_has_moved(tmp_path):
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    stop = turned(rectangle(-1.5, 0, -0.5, 0.5), 30.0)
    model = model_of([*polygons, stop], friction=25.0, fixed=(0, 2), stages=[bsm.Stage(name="later", excavate=[2])])
    grounds, code = told(bsm.run(model), tmp_path / "out")
    assert ([ground["kind"] for ground in grounds], code) == (["equilibrium", "proved"], 0)


def test_a_verdict_that_there_is_not_has_no_ground(tmp_path):
    (ground,), _ = told(bsm.run(on_incline(25.0), bsm.Options(max_steps=2)), tmp_path / "out")
    assert (ground["verdict"], ground["kind"]) == ("not_converged", "best state")
    assert "the limit of 2 steps was reached" in ground["text"]
    assert "of the reference weight (1e-06 is allowed)" in ground["text"]


def test_results_without_a_certificate_are_refused(tmp_path):
    folder = bsm.run(on_incline(35.0)).save(tmp_path / "out")
    listed = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    for name in ("certificate.json", "certificate_0000.npz"):
        del listed["files"][name]
        (folder / name).unlink()
    sealed(folder, listed)
    outcome = CliRunner().invoke(cli, ["verify", str(folder)], catch_exceptions=True)
    assert outcome.exit_code != 0
    assert "certificate.json; run the model again" in str(outcome.exception)


def sealed(folder, listed):
    """Write a summary whose checksums are right."""
    for name in listed["files"]:
        listed["files"][name] = fingerprint(folder / name)
    listed.pop("checksum", None)
    (folder / SUMMARY).write_text(json.dumps({**listed, "checksum": _checksum(listed)}), encoding="utf-8")


@pytest.mark.parametrize("name", ["position", "contact_normal_force", "weight"])
def test_a_certificate_of_other_results_does_not_hold(tmp_path, name):
    folder = bsm.run(on_incline(35.0)).save(tmp_path / "out")
    with np.load(folder / "certificate_0000.npz") as file:
        arrays = dict(file)
    arrays[name] = arrays[name] * (1 + 1e-12)
    np.savez(folder / "certificate_0000.npz", **arrays)
    sealed(folder, json.loads((folder / SUMMARY).read_text(encoding="utf-8")))
    (ground,), code = verified(folder)
    assert (ground["holds"], code) == (False, 3)
    assert "not of these results" in ground["text"]
