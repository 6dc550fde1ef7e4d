"""The check of a certificate where faces of polyhedra meet at an angle: in corners and in edges."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import bsm_mesh as bsm
from bsm_mesh.certificate.certificate import certificate, certificate_arrays
from bsm_mesh.certificate.verify_certificate import check_stage
from tests.scenes.dropped_blocks import dropped_blocks
from tests.scenes.polyhedra import model_in_space, prism
from tests.scenes.rock_3d import rotations_held

FRUSTUM = [(-0.005, 0), (0.005, 0), (0.5, 0.5), (-0.5, 0.5)]  # m: an edge of 10 mm along a bar of 2 m


def on_an_edge():
    """Return a hull that rests on an edge of another, whose faces there are nearly across each other."""
    return dropped_blocks(0)[1]


def crossed_bars():
    """Return a bar that lies across another: each touches with a face that is smaller than the area of an edge."""
    corners, faces = prism(FRUSTUM, 2.0)
    corners -= (0, 1, 0)
    above = Rotation.from_euler("y", 20, degrees=True).apply(corners)
    below = Rotation.from_euler("yz", (200, 90), degrees=True).apply(corners)
    above[:, 2] += 1e-3 - above[:, 2].min()
    below[:, 2] -= below[:, 2].max()
    model = model_in_space([(below, faces), (above, faces)], kn=1e8, ks=1e8)
    return model.replace(supports=[*model.supports, rotations_held(model.blocks, [1])])


def faults(results, **changes):
    """Return the faults of the last stage's certificate after changes of its arrays."""
    told, stage = certificate(results), results.stages[-1]
    arrays = {key: np.array(values) for key, values in certificate_arrays(results, stage).items()}
    for name, change in changes.items():
        arrays[name] = change(arrays)
    return check_stage(told, told["stages"][-1], arrays)[1]


@pytest.fixture(scope="module", params=[pytest.param(on_an_edge, marks=pytest.mark.heavy), crossed_bars])
def rest(request):
    """Return the run of a block that rests on edges."""
    found = bsm.run(request.param(), bsm.Options(threads=1))
    assert found.status == "stable"
    return found


def test_rest_on_edges_holds(rest) -> None:
    assert faults(rest) == []


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("contact_normal", lambda a: a["contact_normal"][:, [2, 0, 1]], "has another normal than its face"),
        ("contact_length", lambda a: 100 * a["contact_length"], "represents more than its face"),
    ],
)
def test_other_normals_and_areas_do_not_hold(rest, name, change, said) -> None:
    assert said in "; ".join(faults(rest, **{name: change}))


def test_shear_force_of_rounding_holds() -> None:
    """A shear force that is nothing beside the normal force has any direction."""
    results = bsm.run(crossed_bars(), bsm.Options(threads=1))
    tiny = {"contact_shear": lambda a: 1e-16 * a["contact_normal_force"][:, None] * a["contact_normal"]}
    force = {"contact_shear_force": lambda a: np.linalg.norm(a["contact_shear"], axis=1)}
    assert faults(results, **tiny, **force) == []
    large = {"contact_shear": lambda a: 1e-9 * a["contact_normal_force"][:, None] * a["contact_normal"]}
    assert "has a shear force across its face" in "; ".join(faults(results, **large, **force))
