"""Results folders of polyhedra: written, read back, checked by NumPy alone, looked at in VTK, and continued with."""

import json
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.certificate.certificate import certificate, certificate_arrays
from bsm_mesh.certificate.verify_certificate import check_stage
from tests.scenes.small_case import Case
from tests.unit.test_space_run import SLOPE, WEAKER
from tests.unit.test_vtu_3d import read

OPTIONS = bsm.Options(threads=1)
SLOT = (  # above the joint: the block that slides over it comes to rest at a wall that it did not touch
    SLOPE.replace("box = [[0, 0, 0], [2, 2, 3]]", "box = [[0, 0, 0], [4, 1, 4]]")
    .replace("friction = 35", "friction = 20")
    .replace("point = [1, 1, 1]", "point = [2, 0.5, 1.5]")
    .replace("[[-2, 2.5], [2, 2.5], [2, 3], [-2, 3]]", "[[-0.1, -0.1], [0.1, -0.1], [0.1, 3], [-0.1, 3]]")
    .replace("origin = [1, 1, 0]", "origin = [2, 0.5, 1.5]")
    + '\n[[support]]\nboundary = "east"\nfix = "all"\n'
)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Return a run of three stages; in the last one a block slides off."""
    path = tmp_path_factory.mktemp("slope") / "slope.toml"
    path.write_text(SLOPE + WEAKER, encoding="utf-8")
    return bsm.run(path, output=False)


def equal(one, other):
    """Assert that two records have equal fields, as far as they are arrays or records of them."""
    for field in fields(one):
        left, right = getattr(one, field.name), getattr(other, field.name)
        if isinstance(left, np.ndarray):
            assert_array_equal(left, right, err_msg=field.name)
        elif field.name in ("contacts", "supports", "evidence", "bolts") and left is not None:
            equal(left, right)


@pytest.fixture(scope="module")
def folder(results, tmp_path_factory):
    return results.save(tmp_path_factory.mktemp("saved") / "out")


@pytest.mark.heavy
def test_results_are_read_back_to_the_last_digit(results, folder):
    again = bsm.Results.load(folder)
    assert [stage.status for stage in again.stages] == ["stable", "stable", "unstable"]
    assert again.blocks.rock_names == results.blocks.rock_names
    assert_array_equal(again.blocks.vertices, results.blocks.vertices)
    for one, other in zip(again.stages, results.stages, strict=True):
        equal(one, other)
        assert one.proof.text == other.proof.text if other.proof else one.proof is None
    assert again.check().ok == results.check().ok
    with pytest.warns(bsm.ResultsWarning):
        again.save(folder.parent / "again")
    files = [sorted(path.glob("*.npz")) for path in (folder, folder.parent / "again")]
    assert len(files[0]) == 3
    assert [bsm.Results.load(file[0].parent).stages[0].residual for file in files] == [results.stages[0].residual] * 2


@pytest.mark.heavy
def test_numpy_alone_checks_the_certificate(folder):
    script = Path(verify_certificate.__file__).parent
    run = f"runpy.run_path({str(script)!r}, run_name='__main__')"
    code = f"import sys, runpy; sys.argv = ['verify', {str(folder)!r}]; {run}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("every block is in balance") == 2
    assert "'weaker': unstable, followed: block 0 was followed over" in done.stdout


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("contact_normal_force", lambda a: 1.01 * a, "is out of balance"),
        ("contact_shear", lambda a: 1.01 * a, "has another shear force than its components"),
        ("contact_point", lambda a: a + 0.01, "does not lie on its face"),
        ("contact_normal", lambda a: a[:, ::-1], "has another normal than its face"),
        ("contact_length", lambda a: 1.01 * a, "represents more than its face"),
        ("contact_opening", lambda a: a + 1e-4, "has another opening than its blocks have"),
        ("contact_block_a", lambda a: a[::-1] * 0 + 1, "is between no two blocks that have its faces"),
        ("contact_utilisation", lambda a: 1.01 * a, "has another strength than is said"),
        ("vertices", lambda a: 1.01 * a, "weighs otherwise than its volume"),
        ("weight", lambda a: 1.01 * a, "weighs otherwise than its volume"),
        ("reactions", lambda a: 1.01 * a, "reactions are not the sum of the supports' forces"),
        ("support_reaction", lambda a: 1.01 * a, "reactions are not the sum of the supports' forces"),
        ("bar_direction", lambda a: 0 * a + (1, 0, 0), "in a direction in which none holds it"),
        ("applied", lambda a: a + 1e3, "blocks are loaded otherwise than by the loads"),
        ("water", lambda a: a + 1e3, "the water presses on block"),
    ],
)
def test_a_changed_number_does_not_hold(results, name, change, said):
    told = certificate(results)
    arrays = {key: np.array(values) for key, values in certificate_arrays(results, results.stages[1]).items()}
    assert check_stage(told, told["stages"][1], arrays)[1] == []
    arrays[name] = change(arrays[name])
    assert said in "; ".join(check_stage(told, told["stages"][1], arrays)[1])


def test_moments_of_the_certificate_are_those_of_the_blocks(results):
    arrays = {key: np.array(v) for key, v in certificate_arrays(results, results.stages[0]).items()}
    found, moments = verify_certificate.space.with_moments(arrays), results.blocks.moments
    assert_allclose(found["volume"], moments.volume, rtol=1e-12)
    assert_allclose(found["centroid"], moments.centroid, rtol=1e-12)
    assert_allclose(found["gyration"], moments.gyration, rtol=1e-12)


def test_vtk_reads_polyhedra_and_contact_polygons(results, folder):
    """Whatever stands is written; volumes by VTK itself, forces of polygons add up to the weight above."""
    _, arrays, _ = read(folder / "blocks_0001.vtu")
    assert arrays["block_id"].tolist() == np.flatnonzero(results.stages[1].present).tolist()
    assert_allclose(arrays["displacement"], results.stages[1].displacement[results.stages[1].present, :3])
    _, arrays, _ = read(folder / "blocks_0002.vtu")
    assert arrays["unstable"].tolist() == [1, 0]
    _, arrays, names = read(folder / "contacts_0001.vtu")
    sign = 1 if arrays["block_b"][0] else -1  # force on block b
    assert_allclose(sign * arrays["force"].sum(axis=0), [0, 0, -6 * 26e3], atol=1e-6)
    assert names["joint:J1"] == 0
    assert (folder / "contacts.pvd").read_text().count("contacts_000") == 3


@pytest.mark.heavy
def test_the_model_as_run_builds_the_same_model(case: Case) -> None:
    case.write("shape/cavern.csv", "x;z\n-2;2.5\n2;2.5\n2;3\n-2;3\n")
    polygon = "polygon = [[-2, 2.5], [2, 2.5], [2, 3], [-2, 3]]"
    shaken = "\n[gravity]\nhorizontal = 0.01\ntrend = 30\n"
    case.write(
        "slope.toml", (SLOPE + WEAKER + shaken).replace(polygon, 'profile = "shape/cavern.csv"\nfrom = -5\nto = 5')
    )
    outcome = case.run("run", "slope.toml", "-o", "out")
    assert outcome.code == 0
    assert bsm.load(case.folder / "out/model.toml") == bsm.load(case.folder / "slope.toml")
    told = json.loads((case.folder / "out/summary.json").read_text())
    assert (told["dimensions"], told["status"]) == (3, "unstable")
    assert case.run("verify", "out").code == 0
    assert verify_certificate.main(case.folder / "out") == 0  # beside model.toml, whose last stage weakens the joint


BOLTED = """
[[bolt]]
start = [1, 1, 2.4]
end = [1.2, 1, 0.2]
diameter = "8 mm"
yield_strength = "500 MPa"
bond_strength = "30 kN/m"
bearing_stiffness = "1 GPa"
bearing_strength = "50 MPa"
"""


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("text", "renewed"), [(SLOPE + WEAKER, False), (SLOT + WEAKER, True), (SLOPE + WEAKER + BOLTED, False)]
)
def test_an_interrupted_run_goes_on_to_the_same_digits(case: Case, text: str, renewed: bool) -> None:
    path = case.folder / "slope.toml"
    case.write("slope.toml", text)

    def stop(results):
        if len(results.stages) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bsm.run(path, finished=stop)
    before = bsm.Results.load(case.folder / "out/slope.interrupted")
    assert before.status == "unfinished"
    points = before.stages[1].contacts
    assert (points.face != points.point_face).any() == renewed
    resumed, whole = bsm.run(path, resume=True), bsm.run(path, output=False)
    assert len(resumed.stages) == 3
    for one, other in zip(resumed.stages, whole.stages, strict=True):
        equal(one, other)


@pytest.mark.heavy
def test_steps_are_snapshots(case: Case) -> None:
    case.write("slope.toml", SLOPE + WEAKER + '\n[output]\nsnapshots = "steps"\n')
    assert case.run("run", "slope.toml", "-o", "out").code == 0
    listed = (case.folder / "out/blocks.pvd").read_text()
    assert "blocks_0002_00000.vtu" in listed
    assert not (case.folder / "out/joints.pvd").exists()
