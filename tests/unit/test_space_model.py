"""What a model of polyhedra refuses, in which words, and what knows polygons alone."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.notes import notes_of
from bsm_mesh.three_d.model.parts import some_polyhedra
from tests.scenes.faults import fault
from tests.scenes.polyhedra import box, model_in_space, on_incline

OUTLINE = [(0, 0), (1, 0), (1, 1)]


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"gravity_direction": -80.0}, "gravity_direction: with polyhedra z is up"),
        ({"contact_points": "gauss"}, 'contact_points: polyhedra take "both"'),
        ({"supports": [bsm.Roller(boundary="b", direction=0)]}, "polyhedra are held by Fixed(blocks=...)"),
        ({"supports": [bsm.Fixed(blocks=[7])]}, "there is no block 7; blocks are numbered 0 to 1"),
        ({"supports": [bsm.Fixed(boundary="top")]}, "there is no boundary 'top'"),
        (
            {"loads": [bsm.PointLoad(block=1, point=(0, 0), force=(1, 0))]},
            "load 1 (PointLoad): point load on block 1: in space point and force are three",
        ),
        ({"water": bsm.Water(table=[(0, 1)])}, "water: table is for the plane"),
        ({"joints": ()}, "joint 'J1' is not defined"),
        ({"in_situ": bsm.InSitu(stress={"xx": -1e6})}, "stress needs the components xx, yy and zz"),
        ({"in_situ": bsm.InSitu(surface=[(0, 1), (2, 3)])}, "in_situ: of polyhedra surface is one level [m]"),
        ({"stages": [bsm.Stage(name="dug", excavate=[OUTLINE])]}, "stage 'dug': excavate: a polygon is for blocks in"),
        ({"in_situ": bsm.InSitu(surface=-2)}, "the whole model lies above the surface, -2 m"),
    ],
)
def test_a_model_of_polyhedra_refuses_what_is_for_the_plane(changes, match):
    with fault(match):
        on_incline(0).replace(**changes)


def test_polygons_have_no_contact_points_of_polyhedra():
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="r")
    with fault('contact_points = "both" is for polyhedra'):
        bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=26e3)], contact_points="both")


def test_an_in_situ_stress_of_polyhedra_is_none_of_the_plane():
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="r")
    for given in ({"stress": {"zz": -1e6}}, {"surface": 5, "k0_across": 2.0}, {"surface": 5, "trend": 10}):
        with fault("k0_across, trend and the components zz, yz, xz are for polyhedra"):
            bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=26e3)], in_situ=bsm.InSitu(**given))
    with fault("in_situ: k0_across = 'hergt' is unknown; did you mean 'herget'?"):
        bsm.InSitu(surface=5, k0_across="hergt")
    with fault("in_situ: stress zz: give one number, or four [c, a_x, a_y, a_z]; has 3"):
        bsm.InSitu(stress={"zz": (1, 2, 3)})
    with fault("trend belongs to a surface"):
        bsm.InSitu(stress={"zz": -1e6}, trend=20)


def test_the_trend_of_an_earthquake_is_for_polyhedra_and_goes_with_gravity():
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="r")
    stage = bsm.Stage(name="quake", gravity=(0.1, 0), gravity_trend=10)
    for given, place in (({"gravity_trend": 30.0}, "model"), ({"stages": [stage]}, "stage 'quake'")):
        with fault(f"{place}: gravity_trend is for polyhedra; leave it out"):
            bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=26e3)], **given)
    with fault("stage 'quake': gravity_trend is that of gravity; give gravity too"):
        bsm.Stage(name="quake", gravity_trend=10)
    model = on_incline(0, gravity_horizontal=0.2)
    assert_allclose(model.gravity_vector, [0.2, 0, -1], atol=1e-15)
    assert model.replace(gravity_trend=None).digest == model.digest != model.replace(gravity_trend=90.0).digest
    assert_allclose(model.replace(gravity_trend=30.0).gravity_vector, [0.1, 0.2 * np.cos(np.pi / 6), -1], atol=1e-15)


@pytest.mark.parametrize(
    ("options", "changes", "match"),
    [
        (bsm.Options(scheme="linear"), {}, "scheme = 'linear' is for the plane"),
        (bsm.Options(), {"supports": ()}, "no support holds it"),
        (bsm.Options(), {"rocks": [bsm.Rock("granite", unit_weight=0.0)]}, "nothing loads the model"),
    ],
)
def test_a_run_of_polyhedra_is_refused_before_it_begins(options, changes, match):
    with fault(match):
        bsm.run(on_incline(0).replace(**changes), options)


@pytest.mark.parametrize(
    ("changes", "note"),
    [
        ({"water": bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 50)))}, "water: the plane lies 49 m above the top"),
        ({"water": bsm.Water(plane=bsm.HeadPlane(point=(0, 0, -9)))}, "water: the plane lies below all blocks"),
        (
            {"rocks": [bsm.Rock(name, unit_weight=26e3) for name in ("granite", "gneis")]},
            "rock 'gneis' is used by no block",
        ),
        ({"rocks": [bsm.Rock("granite", unit_weight=90e3)]}, "rock 'granite': unit_weight = 90000 N/m^3 is unusual"),
        ({"supports": [bsm.Fixed(blocks=[0, 1])]}, "every block is held by supports"),
    ],
)
def test_what_is_not_usual_of_polyhedra_is_noted(changes, note):
    model = on_incline(0)
    assert notes_of(model) == []
    assert [text.startswith(note) for text in notes_of(model.replace(**changes))] == [True]
    assert bsm.run(model.replace(**changes), bsm.Options(threads=1)).stages[0].notes[0].startswith(note)


def test_what_knows_polygons_alone_says_so(tmp_path):
    results = bsm.run(on_incline(10), bsm.Options(threads=1))
    for ask in (results.to_pandas, results.to_meshio):
        with fault("not available in three dimensions (these blocks are polyhedra)"):
            ask()
    with fault("Results.save: tables: not available in three dimensions"):
        results.save(tmp_path / "out", tables=True)
    assert not list(tmp_path.iterdir())


def test_some_of_the_blocks_keep_their_faces():
    """The faces against what is gone become outer ones, turned outward; contacts of the others stay."""
    solids = [box((0, 0, i), (1, 1, i + 1)) for i in range(4)]
    whole = model_in_space(solids).blocks
    part, face = some_polyhedra(whole, np.array([True, False, True, True]))
    assert part.count == 3
    assert_allclose(part.moments.centroid[:, 2], [0.5, 2.5, 3.5])
    (kept,) = part.contact_polygons.face
    (between,) = whole.contact_polygons.face[(whole.contact_polygons.block_a + whole.contact_polygons.block_b) == 5]
    assert face[kept] == between
