"""Flow as it is given: in Python and in a model file, changed by stages, and every fault with its cure."""

from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.model.flow_faults import flow_in_stage
from bsm_mesh.model.notes import notes_of
from bsm_mesh.modelfile.model_text import files_of_model
from tests.scenes.flow_models import bricks

HEADS = {"left": 2.5, "right": 1.0}
ALL = bsm.Flow(
    head=HEADS,
    seepage=("top",),
    drains=(bsm.Drain(start=(3, 0.2), end=(3, 2.7)), bsm.Drain(start=(5, 0.2), end=(5, 2.7), level=1.5)),
    wells=(bsm.Well(point=(4, 1), discharge=1e-6),),
    grout=(bsm.Grout(polygon=((0.5, 0.5), (1.5, 0.5), (1.5, 2.5)), aperture=1e-5),),
    viscosity=1.3e-3,
    tolerance=1e-5,
)
CHANGE = bsm.FlowChange(head={"left": 2.0}, closed=("top",), drains=(bsm.Drain(start=(7, 0.2), end=(7, 2.7)),))


def test_a_model_file_makes_the_same_model(tmp_path: Path) -> None:
    model = bricks(flow=ALL, stages=[bsm.Stage(name="low", flow=CHANGE)])
    for name, write in files_of_model(model, bsm.Options()).items():
        write(tmp_path / name)
    read = bsm.load(tmp_path / "model.toml")
    assert read.flow == model.flow
    assert read.stages[0].flow == model.stages[0].flow
    assert read.joints == model.joints


def test_stages_add_to_the_flow_and_change_levels() -> None:
    model = bricks(flow=ALL, stages=[bsm.Stage(name="low", flow=CHANGE), bsm.Stage(name="same", gravity=(0.1, 0))])
    assert flow_in_stage(model, 0) is model.flow
    low = flow_in_stage(model, 1)
    assert low is not None
    assert dict(low.head) == {"left": 2.0, "right": 1.0}
    assert low.seepage == ()
    assert len(low.drains) == 3
    assert flow_in_stage(model, 2) == low


def test_a_boundary_that_a_stage_opens_to_the_air_has_no_level_any_more() -> None:
    opened = ALL.changed(bsm.FlowChange(seepage=("left",)))
    assert dict(opened.head) == {"right": 1.0}
    assert opened.seepage == ("top", "left")


FAULTS = {
    "no way in": (lambda: bsm.Flow(seepage=("top",)), "nothing lets water in: give head"),
    "named twice": (lambda: bsm.Flow(head=HEADS, seepage=("left",)), "boundary 'left' is named more than once"),
    "no hole": (lambda: bsm.Drain(start=(1, 1), end=(1, 1)), "start and end are one point; give a hole with a length"),
    "no discharge": (lambda: bsm.Well(point=(0, 0), discharge=0.0), "changes nothing; remove the well"),
    "no polygon": (lambda: bsm.Grout(polygon=((0, 0), (1, 1))), "must be three points"),
    "coupling": (lambda: bsm.Flow(head=HEADS, coupling="both"), "coupling = 'both' is unknown"),
    "aperture": (
        lambda: bsm.Joint("J", 1e9, 1e9, aperture=1e-4, residual_aperture=2e-4),
        "residual_aperture = 0.0002 m is above aperture = 0.0001 m",
    ),
    "residual alone": (
        lambda: bsm.Joint("J", 1e9, 1e9, residual_aperture=2e-4),
        "residual_aperture is the part of aperture that no stress closes; give aperture too",
    ),
    "no boundary": (
        lambda: bricks(flow=bsm.Flow(head={"lef": 2.0})),
        "there is no boundary 'lef'; did you mean 'left'",
    ),
    "too high": (lambda: bricks(flow=bsm.Flow(head={"left": 1e5})), "head of 'left' is 99997 m above the model"),
    "no aperture": (lambda: bricks(aperture=None, residual=0.0, flow=ALL), "joint 'J1': flow needs its aperture [m]"),
    "no residual": (lambda: bricks(residual=0.0, flow=ALL), "two-way coupling needs residual_aperture [m]"),
    "two waters": (
        lambda: bricks(flow=ALL, water=bsm.Water(table=((0, 1),))),
        "water and flow are both given: give one",
    ),
    "water later": (
        lambda: bricks(flow=ALL, stages=[bsm.Stage(name="wet", water=bsm.Water(table=((0, 1),)))]),
        "stage 'wet': water: with flow a stage changes flow instead",
    ),
    "flow later": (
        lambda: bricks(stages=[bsm.Stage(name="wet", flow=CHANGE)]),
        "stage 'wet': flow: the model has no flow at the start; give [flow], with a level below the joints",
    ),
    "all shut": (
        lambda: bricks(flow=ALL, stages=[bsm.Stage(name="shut", flow=bsm.FlowChange(closed=("left", "right")))]),
        "stage 'shut': flow: the last boundary with a head (left, right) is closed",
    ),
    "filled": (
        lambda: bricks(flow=ALL, stages=[bsm.Stage(name="dig", excavate=[11]), bsm.Stage(name="back", fill=[11])]),
        "stage 'back': fill: apertures of joints that come later are not followed",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_told_with_their_cure(name: str) -> None:
    make, text = FAULTS[name]
    with pytest.raises(bsm.ModelError) as told:
        make()
    assert text in str(told.value)


def test_levels_that_let_no_water_in_are_noted() -> None:
    lowered = bsm.Stage(name="low", flow=bsm.FlowChange(head={"top": 2.0}))
    notes = notes_of(bricks(flow=bsm.Flow(head={"left": 0.0, "top": 3.0}), stages=[lowered]))
    text = "stage 'low': flow: head of 'top' is 1 m below all of it: no water enters there, and it is open to the air"
    assert [note for note in notes if "head of" in note] == [text]


NO_FLOW = {
    "a drain in rock": ({"drains": (bsm.Drain(start=(0.5, 0.5), end=(1, 0.5)),)}, "meets no joint: it drains nothing"),
    "a well far off": ({"wells": (bsm.Well(point=(50, 0), discharge=1e-6),)}, "wells are in joints: move it"),
    "grout off the model": ({"grout": (bsm.Grout(polygon=((50, 0), (51, 0), (50, 1))),)}, "has no joint in it"),
    "grout on a line": ({"grout": (bsm.Grout(polygon=((2.7, 0.5), (2.7, 1.5), (2.7, 2.5))),)}, "has no joint in it"),
    "grout that ends at a joint": (
        {"grout": (bsm.Grout(polygon=((0.5, 1), (1.5, 1), (1.5, 1.5), (0.5, 1.5))),)},
        "has no joint in it",
    ),
    "no outlet": (
        {"head": {}, "wells": (bsm.Well(point=(4, 1), discharge=-1e-6),)},
        "water of well 1 (the first at (4, 1)) cannot leave",
    ),
}


@pytest.mark.parametrize("name", NO_FLOW)
def test_what_cannot_flow_is_told_before_the_run(name: str) -> None:
    given, text = NO_FLOW[name]
    with pytest.raises(bsm.ModelError) as told:
        bsm.run(bricks(flow=bsm.Flow(**{"head": HEADS} | given)), bsm.Options(scheme="linear"))
    assert text in str(told.value)


def test_a_stage_in_which_water_cannot_flow_is_named_before_the_run() -> None:
    shut = bsm.FlowChange(closed=("left",), wells=(bsm.Well(point=(4, 1), discharge=-1e-6),))
    model = bricks(flow=bsm.Flow(head={"left": 2.5}), stages=[bsm.Stage(name="injection", flow=shut)])
    with pytest.raises(bsm.ModelError, match="stage 'injection': flow: water of well 1"):
        bsm.run(model, bsm.Options(scheme="linear"))


def test_statics_and_the_continuum_say_that_they_know_no_flow() -> None:
    from bsm_mesh.converters.continuum.compared_stages import compare_stages

    model = bricks(flow=ALL)
    results = bsm.run(model, bsm.Options(scheme="linear"))
    with pytest.raises(bsm.ModelError, match="knows no flow in joints"):
        compare_stages(model, results)
