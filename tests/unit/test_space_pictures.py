"""Pictures of polyhedra: which faces are seen, from where, what is cut away, and what they show of a run."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

import bsm_mesh as bsm
from bsm_mesh.folder.frames import frames_in
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.pages.report import write_report
from bsm_mesh.pictures.animation import animate, draw_step
from bsm_mesh.pictures.figures import paper
from bsm_mesh.pictures.joint_net import orientations
from bsm_mesh.pictures.look import Look
from bsm_mesh.pictures.painter import Layer, Painter
from bsm_mesh.pictures.pictures import draw_pictures, figure_of
from bsm_mesh.pictures.plot import PictureChoice
from bsm_mesh.pictures.plotting import as_given
from bsm_mesh.pictures.raster import seen_faces
from bsm_mesh.pictures.sheets import scene_of
from bsm_mesh.pictures.space_positions import SpacePositions
from bsm_mesh.pictures.surfaces import Sides
from tests.scenes.small_case import Case
from tests.unit.test_key_blocks_command import JOINT
from tests.unit.test_paraview import constants
from tests.unit.test_space_bolts import STEEL, model_of
from tests.unit.test_space_run import SLOPE, WEAKER

ROOF = (
    """
dimensions = 3
title = "Wedge in a roof"

[mesh]
box = [[-3, -3, -2], [3, 3, 3]]
default_joint = "J1"

[rock.granite]
unit_weight = "26 kN/m^3"
"""
    + JOINT.format(name="J1", friction=5, cohesion=0)
    + "".join(
        f"""
[[joint_plane]]
name = "J1"
dip = 60
dip_direction = {direction}
point = [{x}, {y}, 1]
"""
        for direction, x, y in ((0, 0, 1), (90, 1, 0), (180, 0, -1), (270, -1, 0))
    )
    + """
[[excavation]]
name = "room"
polygon = [[-2, -1], [2, -1], [2, 1], [-2, 1]]
from = -2
to = 2
"""
    + "".join(
        f'\n[[support]]\nboundary = "{side}"\nfix = "all"\n'
        for side in ("west", "east", "south", "north", "bottom", "top")
    )
    + """
[solver]
threads = 1

[output]
snapshots = "steps"

[[stage]]
name = "room"
excavate = ["room"]
"""
)


def square(column: float, row: float, size: float, distance: float) -> list[list[float]]:
    return [[column + size * a, row + size * b, distance] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]


def test_the_nearest_face_is_seen_whatever_the_order() -> None:
    """A small square before a large one that is nearer by its mean: sorting faces by distance draws it wrong."""
    tilted = [[0, 0, 0.0], [9, 0, 9.0], [9, 9, 9.0], [0, 9, 0.0]]
    small = square(6, 3, 3, 5.0)  # behind the mean of the large one, before it where it is
    for order in ((tilted, small), (small, tilted)):
        owner, depth = seen_faces(np.concatenate(order), np.array([0, 4, 8]), (10, 12))
        name = np.array([face is small for face in order])
        assert name[owner[4, 7]]
        assert depth[4, 7] == 5.0
        assert not name[owner[1, 1]]
        assert_allclose(depth[1, 1], 1.0)
        assert owner[4, 11] == -1


@pytest.mark.parametrize("second", [3, 7])
def test_blocks_are_named_where_they_are_seen_with_an_edge_between_two(second: int) -> None:
    """Two squares of one plane, seen from the south: an edge divides two blocks, and none one block."""
    ink, squares = np.array([0.0, 1.0, 0.0]), [[(x, 5, 0), (x + 1, 5, 0), (x + 1, 5, 1), (x, 5, 1)] for x in (0, 1)]
    layer = Layer(
        corners=np.array(squares, dtype=float).reshape(-1, 3),
        offsets=np.array([0, 4, 8]),
        part=np.array([3, second]),
        colours=np.tile([1.0, 0.0, 0.0], (2, 1)),
        edge=ink,
    )
    figure = paper((4.0, 2.0))
    axes = figure.add_subplot()
    seen = Painter(look=Look(0.0, 0.0), view=(-0.5, -0.5, 2.5, 1.5), width=90, layers=[layer]).paint(axes)
    assert seen is not None
    block, middle, size = seen.middles()
    assert block.tolist() == sorted({3, second})
    assert_allclose(middle, [[0.5, 0.5], [1.5, 0.5]] if second == 7 else [[1.0, 0.5]], atol=0.05)
    assert_allclose(size, 1.0 if second == 7 else np.sqrt(2), rtol=0.05)
    image = np.asarray(axes.images[0].get_array())
    between = image[20:40, 40:50]  # columns from x = 0.8 to 1.2
    assert (between[..., 1].max() > 0.25) == (second == 7)


def test_a_view_to_the_north_has_east_at_the_right_and_up_above() -> None:
    look = Look(0.0, 0.0)
    assert_allclose(look.flat(np.array([[1.0, 5.0, 2.0]])), [[1.0, 2.0]], atol=1e-15)
    assert_allclose(look.distance(np.array([[1.0, 5.0, 2.0]])), [5.0])
    assert_allclose(Look.along(np.array([0.0, 0.0, 1.0])).plunge, -45.0)  # up into a roof, not too steep
    assert_allclose(np.linalg.det(Look(123.0, -31.0).axes), -1.0)  # right, up, ahead: a left-handed triple


def test_every_bare_side_turns_about_its_outward_normal() -> None:
    """Two cubes: their common face is a side of each, and they turn opposite ways."""
    cube = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    blocks = bsm.Polyhedra.from_solids([(cube, faces), (cube + np.array([1, 0, 0]), faces)], rock="r", joint="j")
    sides = Sides(blocks)
    assert len(sides.face) == 12
    corners, offsets = sides.polygons(np.arange(12))
    middle = blocks.moments.centroid[sides.block]
    for k in range(12):
        a, b, c = corners[offsets[k] : offsets[k] + 3]
        assert np.cross(b - a, c - b) @ (a - middle[k]) > 0
        assert_allclose(np.cross(b - a, c - b), sides.outward[k])
    assert sides.bare(np.array([True, True])).sum() == 10
    assert sides.bare(np.array([True, False])).sum() == 6
    assert len(sides.bent_edges(np.flatnonzero(sides.bare(np.array([True, True]))))) == 16  # 12, four of them in halves


@pytest.fixture(scope="module")
def roof(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run in whose last stage a pyramid falls from the roof of a room."""
    folder = tmp_path_factory.mktemp("roof")
    (folder / "roof.toml").write_text(ROOF, encoding="utf-8")
    bsm.run(folder / "roof.toml")
    return folder / "out/roof"


def test_a_wedge_that_falls_is_seen_from_below_ringed_and_named(roof: Path) -> None:
    results = bsm.Results.load(roof)
    scene = scene_of(results, 1, "")
    assert scene.cut
    assert scene.eye.plunge < -30
    (down,) = results.stages[1].unstable_blocks
    figure = figure_of(results, "final_position")
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert any(text.startswith(f"block {down}\n") and "m3" in text and "kN" in text for text in texts)
    assert {"E", "N", "up"} <= set(texts)
    image = np.asarray(figure.axes[0].images[0].get_array())
    red, green, blue = image[..., :3].reshape(-1, 3).T
    assert ((red > 2 * green) & (green > blue)).mean() > 0.005  # the colour of what falls, shaded


@pytest.mark.heavy
def test_an_open_excavation_is_seen_with_the_outer_faces(tmp_path: Path) -> None:
    (tmp_path / "slope.toml").write_text(SLOPE, encoding="utf-8")
    results = bsm.run(tmp_path / "slope.toml")
    assert not scene_of(results, 1, "", look=(200.0, 40.0)).cut
    image = np.asarray(results.plot("displacement", look=(90.0, 0.0)).axes[0].images[0].get_array())
    assert 0.5 < (image[..., 3] > 0.5).mean() < 0.95


def test_a_model_before_it_is_run_is_drawn_from_any_side() -> None:
    """Weights, a pressure, water below a plane of head and in a joint, bolts: as the run's first stage records them."""
    bolt = bsm.Bolt(start=(0.5, 0.2, 0.5), end=(2.5, 0.7, 0.5), **STEEL, pretension=1e3)
    aside = bsm.PointLoad(block=1, point=(0.9, 0.1, 0.9), force=(1e3, -2e3, 3e3))
    plane = bsm.HeadPlane(point=(0, 0, 0.4), dip=10, dip_direction=90)
    water = bsm.Water(plane=plane, joint_pressure={"J": 3e3})
    held = [bsm.Fixed(blocks=[0, 1, 2])]  # so that loads are still those of the start
    given = {
        "supports": held,
        "loads": [bsm.Pressure(boundary="top", pressure=2e3), aside],
        "water": water,
        "title": "Bar",
        "default_joint": "J",
    }
    model = model_of([bolt], **given, gravity_horizontal=0.1)
    given, first = as_given(model).stages[0], bsm.run(model).stages[0]
    for name in ("loads", "water", "joint_water", "present"):
        assert_allclose(getattr(given, name), getattr(first, name), atol=1e-6, err_msg=name)
    assert given.displacement.shape == given.reactions.shape == (3, 6)
    assert given.stress.shape == first.stress.shape
    assert_allclose(given.bolts.original, first.bolts.original)
    figure = model.plot(look=(90.0, 0.0))
    assert figure.get_suptitle() == "Bar: as given"
    assert "looking to 090, 0 degrees down" in figure.axes[0].get_title(loc="left")
    key = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"rock", "bolt with head"} <= key
    assert any(text.startswith("loads, greatest") for text in key)
    with pytest.raises(bsm.ModelError, match=r"window .* is for blocks in the plane"):
        model.plot(window=(0, 0, 1, 1))


def test_the_stereonet_has_the_planes_of_the_joints(roof: Path) -> None:
    """Four planes of 60 degrees to the four sides; their mean has no one dip, their friction is 5 degrees."""
    results = bsm.Results.load(roof)
    polygons = results.blocks.contact_polygons
    dip, direction = orientations(polygons.normal[polygons.joint == 0])
    assert_allclose(dip, 60.0, atol=1e-3)
    assert_allclose(np.sort(direction), [0, 90, 180, 270], atol=1e-3)
    labels = [text.get_text() for text in results.plot("stereonet").axes[0].get_legend().get_texts()]
    assert any(label.startswith("J1: 4 poles") for label in labels)
    assert "friction 5 degrees: planes with poles outside are steeper" in labels
    assert "friction 5 degrees: intersections inside are steeper" in labels


def test_the_report_of_a_run_in_space(roof: Path) -> None:
    text = write_report(roof, pictures=False).read_text(encoding="utf-8")
    assert "z up; forces are those of whole blocks" in text
    assert "Plane problem" not in text
    for part in ("2.31 m3", "unstable blocks", "joint plane J1", "excavation room"):
        assert part in text, part


@pytest.mark.slow
def test_the_command_draws_every_picture_of_space(case: Case) -> None:
    case.write("slope.toml", SLOPE + WEAKER)
    outcome = case.run("run", "slope.toml", "--pictures")
    assert "pictures: " in outcome.out
    pictures = {path.stem for path in Path("out/slope/pictures").glob("*.png")}
    assert {"model", "displacement_stage_1", "deformation_stage_1", "sigma_1_stage_1", "final_position"} <= pictures
    assert {"joints_state_stage_1", "joints_pressure_stage_1"} <= pictures


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"look": (0.0, 100.0)}, "plot: look 0 100: give the azimuth"),
        ({"window": (0.0, 0.0, 1.0, 1.0)}, "plot: window .* is for blocks in the plane"),
        ({"only": ("thrust",)}, "plot: there is nothing to show in 'thrust'"),
    ],
)
def test_pictures_that_space_does_not_have_are_refused(roof: Path, wish: dict, message: str) -> None:
    with pytest.raises(bsm.ModelError, match=message):
        list(draw_pictures(roof, PictureChoice(stage="-1", **wish)))


def test_a_block_moves_from_frame_to_frame_to_where_it_is_at_the_end(roof: Path) -> None:
    saved, results = SavedResults(roof), bsm.Results.load(roof)
    positions, frames = SpacePositions(saved), frames_in(saved)
    assert len(frames) == 4  # two stages of two steps
    first, last = frames[0], frames[-1]
    given, start = positions.extent(first)
    assert_allclose(given, positions.extent(last)[0])
    drop = start[0, 1] - positions.extent(last)[1][0, 1]  # in the picture, which looks up by 45 degrees
    (down,) = results.unstable_blocks
    fallen = results.stages[-1].displacement[down] - results.stages[0].displacement[down]
    assert drop == pytest.approx(-fallen[2] * np.sin(np.pi / 4), rel=1e-3)
    assert positions.greatest(last) == pytest.approx(np.linalg.norm(fallen[:3]), rel=0.01)
    assert positions.greatest(first) < 0.01 * positions.greatest(last)
    assert draw_step(roof, 3).name == "position_00003.png"


def test_the_movement_is_drawn_with_the_excavation_before_it_is_made(roof: Path) -> None:
    with Image.open(animate(roof)) as film:
        assert film.n_frames == 5
        at_first = np.asarray(film.convert("RGB")).astype(int)
        film.seek(4)
        at_last = np.asarray(film.convert("RGB")).astype(int)
    falls = [(image[..., 0] > image[..., 2] + 100).mean() for image in (at_first, at_last)]
    blue = [(image[..., 2] > image[..., 0] + 10).mean() for image in (at_first, at_last)]
    assert falls[0] < 0.001 < 0.02 < falls[1]  # within the rock at first
    assert blue[0] < 0.01 < 0.1 < blue[1]  # the walls; at first they are behind the rock that is excavated


def test_the_script_for_paraview_looks_as_the_pictures_do(roof: Path) -> None:
    told, script = constants(roof), (roof / "in_paraview.py").read_text(encoding="utf-8")
    assert told["KINDS"] == ["blocks", "contacts", "supports"]
    assert told["STATES"][-1] == "stage room: unstable, 1 block falls: 1.6 % of the volume"
    assert told["IN_SPACE"]
    assert told["OPACITY"] < 0.5  # the roof is seen through the blocks before it
    assert told["EXAGGERATION"] == 1  # a block falls
    (axes,) = re.findall("RIGHT, UP, AHEAD = (.*)", script)
    results = bsm.Results.load(roof)
    assert_allclose(ast.literal_eval(axes), scene_of(results, 1, "").eye.axes, atol=1e-6)


def test_a_direction_is_for_space(case: Case) -> None:
    results = bsm.run("model.toml")
    with pytest.raises(bsm.ModelError, match=r"look \(--look\) is for three dimensions, .*; leave it out"):
        results.plot(look=(0.0, 0.0))
