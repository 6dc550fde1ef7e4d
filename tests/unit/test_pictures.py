"""Pictures: what is on them, which are drawn, and what is reported where they cannot be."""

from __future__ import annotations

import struct
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.pictures.canvas import DPI, FALLS, NARROWEST, WATER, WIDTH, finish
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.pictures.marks import NAME_PLACES, add_name
from bsm_mesh.pictures.pictures import PICTURES, figure_of
from bsm_mesh.pictures.plot import draw_in_subprocess
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.pictures.sheets import new_sheet
from bsm_mesh.results.joint_sets import joint_sets
from bsm_mesh.results.records import ContactStatus
from bsm_mesh.results.stress import extreme_stresses, principal_stresses
from bsm_mesh.text.headings import heading
from bsm_mesh.text.tables import engineering, percent
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import Case

NOT_THERE = {  # in the small case
    *("water_pressure", "flow_head", "flow_discharge", "bolts", "bolts_utilisation", "joints_opening", "joints_slip"),
    *("shaking_acceleration", "shaking_displacement", "zones_displacement"),
    *("zones_sigma_1", "zones_sigma_3", "zones_yielding"),
}


@pytest.fixture
def results(case: Case) -> Case:
    assert case.run("run", "model.toml", "-q").code == 0
    return case


def pixels(path: Path | str) -> np.ndarray:
    """Return a picture's colours, (height, width, 3), 0 to 1."""
    from matplotlib.image import imread

    return np.asarray(imread(path))[..., :3]


def of_colour(shown: np.ndarray, colour: str) -> np.ndarray:
    """Return which pixels have a colour, but for rounding."""
    wanted = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    return np.abs(shown - wanted).max(axis=2) < 0.02


@pytest.mark.slow
def test_every_picture_shows_something(results: Case) -> None:
    outcome = results.run("plot", "out/model")
    assert outcome.code == 0, outcome.err
    paths = [Path(line) for line in outcome.out.splitlines()]
    assert {path.stem for path in paths} == set(PICTURES) - NOT_THERE
    noted = "out/model/.bsm-mesh-results"
    assert sorted(outcome.new) == sorted([noted, "out/model/pictures", *map(str, paths)])
    for path in paths:
        width, height = struct.unpack(">II", path.read_bytes()[16:24])
        assert NARROWEST * DPI <= width <= WIDTH
        assert 0.4 * width < height < 1.5 * width
        middle = pixels(path)[int(0.3 * height) : int(0.7 * height), int(0.3 * width) : int(0.6 * width)]
        colours = np.unique((255 * middle).astype(int) @ (1 << 16, 1 << 8, 1))
        assert len(colours) > 1
        assert (middle < 0.99).any(axis=2).mean() > 0.5  # not white paper


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_the_water_table_is_seen_over_a_model_of_kilometres(case: Case) -> None:
    text = Path("model.toml").read_text(encoding="utf-8").replace("[mesh]", '[mesh]\nunit = "km"')
    case.write("model.toml", f"{text}\n[water]\ntable = [[0, 1500]]\n")
    assert case.run("run", "model.toml", "--pictures", "-q").code == 0
    for name in ("sigma_1", "water_pressure"):
        assert of_colour(pixels(f"out/model/pictures/{name}.png"), WATER).any(axis=0).sum() > 400  # columns


def wedge() -> bsm.Model:
    """Return a block of 1 m on a fixed plate, over which a fixed plate lies; one of 0.1 m falls beside them."""
    shapes = [rectangle(0, 0, 10, 1), rectangle(4, 1, 5, 2), rectangle(0, 2, 10, 3), rectangle(8, 1.5, 8.1, 1.6)]
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30.0))
    return model_of(shapes, joint=joint, fixed=(0, 2), title="Flake")


@pytest.fixture(scope="module")
def flake() -> bsm.results.Results:
    """Return the results of a flake that falls, whose area is a hundredth of the others'."""
    return bsm.run(wedge(), bsm.Options(displacement_limit=0.2, falls=bsm.Falls(ignore_below=0)))


def texts(figure: object) -> str:
    """Return all that is written in a figure."""
    from matplotlib.text import Text

    return " | ".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.parametrize("name", ["model", "displacement", "deformation", "final_position", "joints", "thrust"])
def test_a_flake_that_comes_down_is_ringed_and_named(flake: bsm.results.Results, name: str) -> None:
    from matplotlib.patches import Circle

    assert flake.unstable_blocks.tolist() == [3]
    figure = figure_of(flake, name)
    (axes, *_) = figure.axes
    (ring,) = [patch for patch in axes.patches if isinstance(patch, Circle)]
    assert np.hypot(*(np.array(ring.center) - (8.05, 1.55))) < 0.3
    assert ring.radius > 0.1  # seen, however small the block is
    assert "block 3\n0.01 m2, 250 N/m" in texts(figure)


@pytest.mark.heavy
def test_names_of_blocks_keep_clear_of_each_other_and_tell_weights_of_what_was_taken_away() -> None:
    from matplotlib.text import Annotation, Text

    model = wedge()
    chips = [rectangle(x, y, x + 0.1, y + 0.1) for x, y in ((6.0, 1.65), (6.5, 1.65), (7.0, 1.65))]
    shapes = [*(model.blocks.polygon(k) for k in range(3)), *chips]
    results = bsm.run(
        model.replace(blocks=bsm.Blocks.from_polygons(shapes, rock="rock")),
        bsm.Options(displacement_limit=0.2, falls=bsm.Falls(ignore_below=0, on_fall="remove")),
    )
    assert str(results.status) == "stable_after_falls"
    figure = figure_of(results, "displacement")
    names = [each for each in figure.findobj(Annotation) if each.get_text().startswith("block ")]
    assert [each.get_text() for each in names] == [f"block {k}\n0.01 m2, 250 N/m" for k in (3, 4, 5)]
    boxes = [Text.get_window_extent(each) for each in names]
    assert not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])


@pytest.mark.heavy
def test_fragments_too_small_to_count_are_counted_and_have_no_ring() -> None:
    from matplotlib.patches import Circle

    results = bsm.run(wedge(), bsm.Options(displacement_limit=0.2, falls=bsm.Falls(ignore_below=0.05)))
    assert (str(results.status), [fall.block for fall in results.stages[-1].falls]) == ("stable", [3])
    figure = figure_of(results, "displacement")
    assert not [patch for patch in figure.axes[0].patches if isinstance(patch, Circle)]
    assert "1 fragment too small to count removed; excluded from the colour scale" in texts(figure)
    assert "block 3" not in texts(figure)
    assert "excluded" not in texts(figure_of(results, "final_position"))  # it has no scale


def test_blocks_that_come_down_are_out_of_the_colour_scale(flake: bsm.results.Results) -> None:
    figure = figure_of(flake, "displacement")
    moved = np.hypot(*flake.stages[-1].displacement[:, :2].T)
    assert moved[3] > 0.1
    assert "displacement, mm" in figure.axes[1].get_ylabel()  # the block that rests moves by 25 micrometres
    assert figure.axes[1].get_ylim()[1] == pytest.approx(1e3 * moved[1], rel=1e-6)


def test_the_greatest_displacement_is_that_of_the_table(flake: bsm.results.Results) -> None:
    """A block too small to count is in neither, nor does it stretch the scale."""
    stage = flake.stages[-1]
    moved, few = stage.displacement.copy(), np.array([2], np.int32)
    moved[2, :2] = 3 * np.abs(moved[1, :2])
    for small, most in ((few[:0], moved[2]), (few, moved[1])):
        drawn = figure_of(
            replace(flake, stages=[replace(stage, displacement=moved, small_blocks=small)]), "displacement"
        )
        greatest = float(np.hypot(*most[:2]))
        assert f"greatest {engineering(greatest, 'm')}" in texts(drawn)
        assert drawn.axes[1].get_ylim()[1] == pytest.approx(1e3 * greatest, rel=1e-6)


def test_the_extreme_stress_is_that_of_the_run() -> None:
    """Of a block between a held plate and a load; what the supports hold has no stress that is known."""
    shapes = [rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)]
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30.0))
    load = bsm.PointLoad(block=0, point=(0.9, 0.5), force=(0.0, -1e7))  # on the held block
    results = bsm.run(model_of(shapes, joint=joint, loads=[load]))
    least, _, unknown = extreme_stresses(results.blocks, results.stages[0])
    assert unknown == 1
    assert least > principal_stresses(results.stages[0].stress)[0].min()
    told = texts(figure_of(results, "sigma_1")).replace("\n", " ")
    assert f"{engineering(least, 'Pa')} at most; 1 block excluded: supported" in told


def test_the_shares_of_the_joints_are_those_of_the_table(flake: bsm.results.Results) -> None:
    """Of the length, a face that slips at one end by half: not of the faces that slip as a whole."""
    last = flake.stages[-1]
    contacts = last.contacts
    status = contacts.status.copy()
    status[np.flatnonzero(contacts.block_a != 3)[0]] = ContactStatus.SLIPPING
    mixed = replace(flake, stages=(replace(last, contacts=replace(contacts, status=status)),))
    (joint,) = [one for one in joint_sets(mixed, mixed.stages[-1]) if one.name == "J"]
    assert joint.slipping > 0
    assert f"slipping, {percent(joint.slipping)} of the length" in texts(figure_of(mixed, "joints"))


def test_a_window_shows_its_part(flake: bsm.results.Results) -> None:
    figure = figure_of(flake, "joints", window=(3.0, 0.5, 6.0, 2.5))
    (axes, *_) = figure.axes
    assert (*axes.get_xlim(), *axes.get_ylim()) == (3.0, 6.0, 0.5, 2.5)
    assert "2 m in all" in texts(figure)  # above the block and below it
    assert "250 N/m" not in texts(figure)


def test_a_figure_may_be_drawn_on(flake: bsm.results.Results) -> None:
    given = paper((6, 4))
    assert figure_of(flake, "joints", figure=given) is given
    assert figure_of(flake, "bolts") is None
    with pytest.raises(ModelError, match="there is no picture 'joint_state'; did you mean 'joints_state'"):
        figure_of(flake, "joint_state")


def test_what_stands_is_not_drawn_as_if_it_collapsed() -> None:
    """A ring of blocks round a hole of 1 m moves by micrometres: it is drawn moved by a tenth of the hole at most."""
    xs = (0, 4, 5, 9)
    shapes = [rectangle(xs[i], xs[j], xs[i + 1], xs[j + 1]) for j in range(2) for i in range(3) if (i, j) != (1, 1)]
    shapes.append(rectangle(0, 5, 9, 9))  # the roof is one block
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30.0))
    model = model_of(shapes, joint=joint, fixed=(0, 1, 2))
    results = bsm.run(model)
    scene = Scene(results=results, number=0, title="")
    assert scene.opening == pytest.approx(1.0)
    shown = scene.exaggeration * np.hypot(*scene.corner_movement.T).max()
    assert 0.04 < shown <= 0.1
    assert f"exaggerated {scene.exaggeration:g} times" in texts(figure_of(results, "deformation"))


def test_the_outline_leaves_out_what_blocks_share() -> None:
    """A long edge on two short ones: all but the outer edges are shared, T-junction or not."""
    shapes = [rectangle(0, 0, 2, 1), rectangle(0, 1, 1, 2), rectangle(1, 1, 1.5, 2)]
    model = model_of(shapes, friction=30.0)
    lines = Scene(results=bsm.run(model), number=0, title="").outline()
    assert np.hypot(*(lines[:, 1] - lines[:, 0]).T).sum() == pytest.approx(2 + 1 + 0.5 + 1 + 1.5 + 1 + 1)
    inner = (lines[..., 1] == 1.0).all(axis=1)
    assert np.sort(lines[inner][..., 0].reshape(-1)).tolist() == [1.5, 2.0]


@pytest.mark.parametrize(
    "at", [(2.0, 6.0), (2.2, 6.4), pytest.param((2.5, 6.8), marks=pytest.mark.heavy), (3.0, 7.0), (1.5, 6.5)]
)
def test_a_name_hides_neither_the_ring_of_another_nor_the_line_to_it(at: tuple[float, float]) -> None:
    """The first ring lies high, so that its name is below it; the second lies below and to the left of it."""
    model = model_of([rectangle(0, 0, 20, 10), rectangle(0, 10, 20, 10.1)], friction=30.0)
    sheet = new_sheet(Scene(results=bsm.run(model), number=0, title=""), paper((14.0, 7.0)))
    add_name(sheet, np.array([3.5, 9.0]), "block 64\n0.405 m2, 10.52 kN/m", FALLS, NAME_PLACES, across=1.0)
    add_name(sheet, np.array(at), "block 45\n0.00247 m2, 64.23 N/m", FALLS, NAME_PLACES, across=1.0)
    sheet.figure.canvas.draw()
    first, second = sheet.axes.texts
    hidden = second.get_bbox_patch().get_window_extent()
    ring, _ = sheet.axes.patches
    assert not hidden.overlaps(first.get_bbox_patch().get_window_extent())
    assert not hidden.overlaps(ring.get_window_extent())
    assert not hidden.count_contains(first.arrow_patch.get_path().interpolated(20).vertices)


@pytest.mark.parametrize("y", [-1.0, 1.2, 2.5])
def test_a_name_lies_within_the_frame_of_a_flat_model(y: float) -> None:
    """Above it the name would hide the title, below it the labels of the axis."""
    model = model_of([rectangle(-40, -3, 40, 0), rectangle(-3, 0, -1, 2.5)], friction=30.0)
    sheet = new_sheet(Scene(results=bsm.run(model), number=0, title=""), paper((8.0, 3.0)))
    add_name(sheet, np.array([-2.0, y]), "blocks 1, 2\n8 m2, 200 kN/m", FALLS, NAME_PLACES, across=3.0)
    sheet.figure.canvas.draw()
    frame = sheet.axes.get_window_extent()
    (name,) = sheet.axes.texts
    box = name.get_bbox_patch().get_window_extent()
    assert frame.y0 - 5 <= box.y0  # pixels: of the frame round the text
    assert box.y1 <= frame.y1 + 5


def test_a_title_that_is_too_wide_is_broken_within_the_picture() -> None:
    figure = paper((4.0, 3.0))
    entitle(figure, "factor of safety 1.208: " * 6)
    figure.canvas.draw()
    title = figure.findobj(lambda part: getattr(part, "get_text", str)().startswith("factor"))[0].get_window_extent()
    assert title.x1 <= figure.bbox.width
    assert title.y1 <= figure.bbox.height


def test_a_title_is_broken_only_where_the_next_word_has_no_room() -> None:
    results = bsm.run(model_of([rectangle(0, 0, 1, 1)], fixed=(0,)))
    lines = finish(new_sheet(Scene(results=results, number=0, title="word " * 60)), "").get_suptitle().splitlines()
    assert len(lines) > 2
    assert {len(line) for line in lines[:-1]} == {max(map(len, lines))}


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_every_stage_is_drawn_and_one_by_name(case: Case) -> None:
    text = Path("model.toml").read_text(encoding="utf-8")
    case.write("model.toml", text + '[[stage]]\nname = "dug"\nexcavate = [3]\n')
    assert case.run("run", "model.toml", "-q").code == 0
    outcome = case.run("plot", "out/model", "--only", "joints_")
    assert [Path(line).name for line in outcome.out.split()] == [
        f"joints_{name}{suffix}.png" for suffix in ("_stage_0", "") for name in ("state", "utilisation", "pressure")
    ]
    for stage in ("dug", "1"):
        one = case.run("plot", "out/model", "--only", "joints_state", "--stage", stage)
        assert [Path(line).name for line in one.out.split()] == ["joints_state.png"]
    part = case.run("plot", "out/model", "--only", "model", "--stage", "0", "--window", "0", "0", "1", "1")
    assert [Path(line).name for line in part.out.split()] == ["model_stage_0_window.png"]
    case.refuses(
        "plot", "out/model", "--stage", "dog", says=["no stage 'dog'", "did you mean 'dug'? (known: dug, initial)"]
    )
    two = case.run("plot", "out/model", "--only", "thrust", "--only", "model", "--stage", "dug")
    assert [Path(line).name for line in two.out.split()] == ["model.png", "thrust.png"]
    case.refuses("plot", "out/model", "--only", "blots", says=["no picture 'blots'", "bolts"])
    case.refuses("plot", "out/model", "--only", "bolt_forces", says=["there is nothing to show in 'bolt_forces'"])
    case.refuses(
        "plot", "out/model", "--only", "hist", "--window", *"0011", says=["histories show no part of the model"]
    )
    for window in (("1", "0", "1", "1"), ("0", "0", "nan", "1")):
        case.refuses("plot", "out/model", "--window", *window, says=["--window", "x0 below x1"])


@pytest.mark.heavy
@pytest.mark.usefixtures("drawn_here")
def test_pictures_of_a_former_run_are_gone_with_it(results: Case) -> None:
    assert results.run("plot", "out/model", "--only", "model").code == 0
    assert Path("out/model/pictures/model.png").exists()
    assert results.run("run", "model.toml", "-q").code == 0
    assert not Path("out/model/pictures").exists()


def test_headings() -> None:
    """A stage is named where there are several."""
    only, second = {"name": "initial", "status": "stable"}, {"name": "crown", "status": "not_converged"}
    one, two = {"status": "stable", "stages": [only]}, {"status": "not_converged", "stages": [only, second]}
    assert heading({"title": "Tunnel", **one}) == "Tunnel: stable"
    fallen = {**one, "stages": [{**one["stages"][-1], "verdict": "stable, after 2 blocks fell"}]}
    assert heading({"title": "Tunnel", **fallen}) == "Tunnel: stable, after 2 blocks fell"
    assert heading({"title": "", **two}) == "bsm-mesh: stage crown, not converged"
    assert heading({"title": "Tunnel", **one}, "on its way") == "Tunnel: on its way"
    unfinished = {"title": "Tunnel", **one, "status": "unfinished"}
    assert heading(unfinished) == "Tunnel: stage initial, stable, of an unfinished run"  # no verdict on the whole


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_run_with_pictures(results: Case) -> None:
    outcome = results.run("run", "model.toml", "--pictures", "-q", "-o", "again")
    assert outcome.code == 0, outcome.err
    assert f"pictures: {len(set(PICTURES) - NOT_THERE)} files in {Path('again/pictures')}" in outcome.out


def fake(code: int, error: str = "") -> object:
    def run(*_: object, **__: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], code, "", error)

    return run


@pytest.mark.parametrize("code", [-11, -6, 3221225477])  # the last: Windows's access violation
def test_a_drawing_that_dies(results: Case, monkeypatch: pytest.MonkeyPatch, code: int) -> None:
    monkeypatch.setattr("bsm_mesh.pictures.plot.run_with_lines", fake(code))
    results.refuses("plot", "out/model", says=["out/model: the drawing process was killed (signal", "without pictures"])


def test_a_drawing_that_fails(results: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bsm_mesh.pictures.plot.run_with_lines", fake(1, "Traceback ...\nImportError: libfreetype.so"))
    with pytest.raises(ModelError, match=r"could not be drawn: ImportError: libfreetype\.so"):
        draw_in_subprocess(Path("out/model"))


@pytest.mark.usefixtures("drawn_here")
def test_a_folder_that_takes_no_pictures(results: Case) -> None:
    results.write("out/model/pictures", "a file of this name")
    message = results.refuses(
        "plot", "out/model", says=["cannot write out/model/pictures/model.png", "choose another folder"]
    )
    assert "apt-get" not in message
