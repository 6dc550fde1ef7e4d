"""Which stages may be compared with a continuum, why not, and the description of them."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import compare, solve_continuum
from bsm_mesh.converters.continuum import Comparability, compare_stages
from bsm_mesh.converters.continuum.comparison import percent
from bsm_mesh.modelfile.build import load_model_file
from tests.scenes.continuum import HEAVY, slab
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

EXAMPLES = Path(__file__).parents[2] / "examples"


def stages_of(model, options=None, **keys):
    return compare_stages(model, bsm.run(model, options), **keys)


def example(name):
    loaded = load_model_file(EXAMPLES / name, lambda _: None)
    return stages_of(loaded.model, loaded.options)


def test_rock_without_joints_is_comparable():
    (stage,) = stages_of(bsm.Model(blocks=slab("squares"), rocks=[HEAVY], supports=[bsm.Fixed(boundary="bottom")]))
    assert stage.kind is Comparability.COMPARABLE
    assert stage.comparison.force_error is None
    assert stage.sentence.startswith("Blocks and finite elements differ by ")
    assert "in stress" in stage.sentence
    assert "joint" not in stage.sentence


def test_joints_ask_for_interfaces():
    model = model_of([rectangle(0, -1, 2, 0), rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)])
    (stage,) = stages_of(model)
    assert stage.kind is Comparability.WITH_INTERFACES
    assert stage.comparison.force_error.l2 < 1e-3
    assert stage.comparison.displacement_errors[0].l2 < 1e-2
    assert stage.comparison.refined is not None
    assert "differ by less than 0.1 % in displacement and less than 0.1 % in joint forces" in stage.sentence
    (named,) = stage.comparison.displacement_errors  # rigid rock has no other elasticity to match
    assert named.name == "displacement"


def test_every_stage_has_its_class():
    initial, rapid = example("falling_table/rapid.toml")
    assert initial.kind is Comparability.WITH_INTERFACES
    assert rapid.kind is Comparability.NOT_COMPARABLE
    assert rapid.comparison is None
    assert rapid.sentence == "Not comparable: blocks fall: there is no state of rest to compare."


@pytest.mark.slow
def test_what_is_not_comparable_has_no_percentage_of_difference():
    for name, reason in (
        ("arch/thin.toml", "blocks fall"),
        ("03_stratified_slope/dip_25_5.toml", "small displacements hold up to 1 %"),
    ):
        (stage,) = example(name)
        assert stage.kind is Comparability.NOT_COMPARABLE
        assert reason in stage.reason
        assert "differ by" not in stage.sentence


def test_gaps_that_close():
    """A block pushed over a narrow gap: blocks have a contact there, the elements none."""
    shapes = [rectangle(0, -1, 4, 0), rectangle(0, 0, 1, 1), rectangle(1.002, 0, 2, 1)]
    push = bsm.PointLoad(block=1, point=(0.0, 0.1), force=(20e3, 0.0))
    (stage,) = stages_of(model_of(shapes, loads=[push], friction=30.0))
    assert stage.kind is Comparability.NOT_COMPARABLE
    assert stage.reason == "gaps close: blocks 1 and 2 press on each other and did not touch at first"


@pytest.mark.parametrize(("name", "met"), [("04_bolted_opening/model.toml", True), ("rough_joint/model.toml", False)])
def test_corners_that_met_at_a_node_are_told(name, met):
    """Blocks without a common side press on each other once they moved: elements have no interface there."""
    loaded = load_model_file(EXAMPLES / name, lambda _: None)
    results = bsm.run(loaded.model, loaded.options)
    contacts = results.stages[-1].contacts
    near = 1e-6  # of a side's two blocks, so swollen, as much lies in both for every metre
    given = [shapely.Polygon(results.blocks.polygon(b)).buffer(near / 2) for b in range(results.blocks.count)]
    pairs = zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    side = np.array([given[a].intersection(given[b]).area / near for a, b in pairs])
    met_force = np.hypot(contacts.normal_force, contacts.shear_force) * (side < 1e-3)
    assert (met_force.max() > 0) == met
    (stage,) = compare_stages(loaded.model, results, refine=False)
    most = float(f"{met_force.max() / 1e3:.3g}")
    told = f"{np.count_nonzero(met_force)} corners that met others carry up to {most:g} kN/m"
    assert (told in stage.sentence) == met


@pytest.mark.heavy
def test_rock_that_breaks():
    """A push above slips one end of the face between two blocks of rock without a joint: in the elements too."""
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([rectangle(0, -1, 1, 0), rectangle(0, 0, 1, 1)], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=26e3, young=10e9, poisson=0.2, friction=10.0)],
        supports=[bsm.Fixed(blocks=[0])],
        loads=[bsm.PointLoad(block=1, point=(0.0, 1.0), force=(4e3, 0.0))],
    )
    (stage,) = stages_of(model)
    assert stage.kind is Comparability.WITH_INTERFACES
    assert stage.comparison.force_error is None
    assert stage.comparison.stress_errors[-1].l2 < 0.05

    def holds(push):
        load = bsm.PointLoad(block=1, point=(0.0, 0.1), force=(push, 0.0))
        found = solve_continuum(model.replace(loads=[load]), order=1, joints=True, rock_breaks=True)
        return found.converged and np.abs(found.displacement).max() < 1e-3

    limit = 26e3 * np.tan(np.radians(10.0))
    assert holds(0.999 * limit)
    assert not holds(1.001 * limit)


def test_what_all_blocks_do_together_is_no_matter():
    """A column sinks by a fiftieth of a block's size in all, each block by less than a hundredth on the one below."""
    shapes = [rectangle(0, j, 1, j + 1) for j in range(-1, 6)]
    model = model_of(shapes)
    soft = bsm.Joint("J", normal_stiffness=26e3 * 6 / 0.009, shear_stiffness=1e7, law=bsm.MohrCoulomb(friction=30.0))
    (stage,) = stages_of(model.replace(joints=[soft]))
    assert np.abs(stage.comparison.displacement).max() > 0.02
    assert stage.kind is Comparability.WITH_INTERFACES
    (stage,) = stages_of(model.replace(joints=[dataclasses.replace(soft, normal_stiffness=26e3 * 6 / 0.011)]))
    assert stage.kind is Comparability.NOT_COMPARABLE
    assert "block 1 moved 1.06 % of its size against block 0" in stage.reason


def test_the_linear_scheme_has_elastic_joints():
    """Friction that cannot carry a push, in a scheme that lets nothing slip: both methods hold it all the same."""
    shapes = [rectangle(0, -1, 2, 0), rectangle(0, 0, 1, 1)]
    push = bsm.PointLoad(block=1, point=(0.0, 0.1), force=(60e3, 0.0))
    (stage,) = stages_of(model_of(shapes, loads=[push]), bsm.Options(scheme="linear"))
    assert stage.kind is Comparability.WITH_INTERFACES
    assert stage.comparison.force_error.l2 < 1e-3


@pytest.mark.heavy
def test_compare_gives_the_last_stage_or_its_reason():
    loaded = load_model_file(EXAMPLES / "falling_table/slow.toml", lambda _: None)
    results = bsm.run(loaded.model, loaded.options)
    last = compare(loaded.model, results)
    assert last.nominal.name == "empty"
    assert_allclose(last.displacement, results.stages[-1].displacement)
    assert [error.name for error in last.errors[-3:]] == ["joint forces", "opening of joints", "slip of joints"]
    assert last.errors[-3] is last.force_error
    labels = [row.label for row in last.table()]
    assert any("joint forces, worst blocks" in label for label in labels)
    loaded = load_model_file(EXAMPLES / "arch/thin.toml", lambda _: None)
    with pytest.raises(bsm.ModelError, match="stage 'initial' is not comparable with a continuum: blocks fall"):
        compare(loaded.model, bsm.run(loaded.model, loaded.options))


@pytest.mark.heavy
def test_excavated_blocks_count_nowhere():
    loaded = load_model_file(EXAMPLES / "staged_tunnel/full_face.toml", lambda _: None)
    first, last = stages_of(loaded.model, loaded.options, refine=False)
    assert first.sentence.startswith("Nothing moves here. ")
    gone = ~last.comparison.present
    assert gone.any()
    assert not np.any(last.comparison.nominal.stress[gone])
    assert not np.any(last.comparison.displacement_difference[gone])


@pytest.mark.parametrize(
    ("share", "text"), [(0.0, "less than 0.1 %"), (0.0112, "1.1 %"), (0.0996, "10.0 %"), (0.67, "67 %")]
)
def test_percentages(share, text):
    assert percent(share) == text
