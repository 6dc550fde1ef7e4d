"""Values compared with histories: tables read with their units, kept with the results, drawn where they belong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.beside_files import read_beside
from bsm_mesh.pictures.beside import with_sources
from bsm_mesh.pictures.beside_marks import Looks
from bsm_mesh.results import Results
from bsm_mesh.results.beside import line_movement
from bsm_mesh.text.beside_tables import beside_rows, table_of
from tests.scenes.models import model_of
from tests.scenes.shapes import grid
from tests.scenes.small_case import MODEL, Case
from tests.unit.test_snapshots import MOVING, pushed

pytestmark = pytest.mark.filterwarnings("ignore::bsm_mesh.errors.MeshWarning")

LINE = [(0.2, -0.2), (1.2, 0.6), (2.5, 0.5)]
FAR = float(np.hypot(2.3, 0.7))  # m: the wall, which does not move
RECORDED = (
    bsm.History(name="corner", point=(1.5, 1), measured=[bsm.Beside(quantity="u", value=0.45, until=0.55)]),
    bsm.History(name="middle", point=(1.2, 0.5)),
    bsm.History(name="rod", line=LINE),
)
TABLE = """history;source;stage;distance (m);u [mm];u_until [mm];v [cm];extension [mm];displacement;note
corner;prism;;;490;510;-0,1;;;by night
corner;UDEC;initial;;;;;;0,47;
rod;anchor, 1 m;0;1,0;;;;-2;;
"""


@pytest.fixture(scope="module")
def results() -> Results:
    """Return the block that was pushed over half a metre to the right."""
    return bsm.run(pushed().replace(histories=RECORDED), MOVING)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "survey.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


def test_a_table_is_read_in_its_units(table: Path) -> None:
    """Decimal commas between semicolons, in numbers alone; ranges, stages by name or number; a note is not read."""
    found = read_beside(table)
    assert found["corner"] == (
        bsm.Beside(quantity="u", value=0.49, until=0.51, source="prism"),
        bsm.Beside(quantity="v", value=-0.001, source="prism"),
        bsm.Beside(quantity="displacement", value=0.47, stage="initial", source="UDEC"),
    )
    assert found["rod"] == (
        bsm.Beside(quantity="extension", value=-0.002, stage="0", distance=1.0, source="anchor, 1 m"),
    )
    assert set(read_beside(table, "rod")) == {"rod"}
    assert {one.source for one in read_beside(table, source="mine")["corner"]} == {"mine"}


def test_a_table_that_is_written_is_read_alike(table: Path, tmp_path: Path) -> None:
    found = read_beside(table)
    again = tmp_path / "again.csv"
    again.write_text(table_of(found), encoding="utf-8")
    assert {name: set(values) for name, values in read_beside(again).items()} == {
        name: set(values) for name, values in found.items()
    }


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("history,uu [mm]\na,1\n", "column 'uu [mm]' is none of history, stage, source, note, distance, u, v"),
        ("history,u [kPa]\na,1\n", "column 'u [kPa]': unit 'kPa' is none of m, cm, mm"),
        ("history,stage\na,b\n", "no column is a quantity"),
        ("u\n1\n", "no column says of which history"),
        ("history,u\na,x\n", "line 2: u = 'x' is no number; leave the cell empty"),
        (
            'history,u\na,"1,500"\n',
            "line 2: u = '1,500' is no number; where commas are decimal points part columns by semi",
        ),
        ("history;u\na;1,5,0\n", "line 2: u = '1,5,0' is no number; leave the cell empty"),
        ("history,u,u_until\na,,1\n", "line 2: u_until without u; a range has two ends"),
        ("history,u\n", "has no rows; it needs a header and rows below it (a quantity of a history at least"),
    ],
)
def test_a_table_at_fault_is_one_clear_message(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(bsm.ModelError) as caught:
        read_beside(path)
    assert told in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"quantity": "axial_force", "value": 1.0}, "a line has no axial_force; measured values of it are extension"),
        ({"quantity": "extension", "value": 1.0}, "extension needs its distance from the first point"),
        ({"quantity": "across", "value": 1.0, "distance": 3.0}, "the distance 3 m is beyond the end of the line"),
    ],
)
def test_a_value_that_the_history_cannot_have(given: dict[str, object], told: str) -> None:
    with pytest.raises(bsm.ModelError) as caught:
        bsm.History(name="rod", line=LINE, measured=[bsm.Beside(**given)])  # type: ignore[arg-type]
    assert told in str(caught.value)


def test_a_line_moves_as_its_blocks(results: Results) -> None:
    """Half a metre to the right of the block between base and wall, which stay; extensions are those recorded."""
    distance = np.array([0.0, np.hypot(1.0, 0.8), FAR])
    stage = results.stages[-1]
    found = line_movement(results, stage, LINE, distance)
    moved = stage.displacement[1, :2]
    direction = np.array([2.3, 0.7]) / FAR
    np.testing.assert_allclose(found["towards"][1], -moved @ direction, atol=2e-3)  # it hardly turned
    np.testing.assert_allclose(found["across"][1], moved @ [-direction[1], direction[0]], atol=2e-3)
    np.testing.assert_allclose(found["towards"][[0, 2]], 0, atol=1e-6)
    np.testing.assert_allclose(found["extension"][1:], results.histories["rod"].values[-1], atol=1e-12)
    gone = replace(stage, present=np.array([True, False, True]))
    assert np.isnan(line_movement(results, gone, LINE, distance)["towards"][1])


def test_they_are_told_with_what_the_run_finds(results: Results, table: Path) -> None:
    """Of a range the difference is from its nearer end, none within it."""
    rows = {(*row[:3], row[5]): row[3:] for row in beside_rows(with_sources(results, table))}
    computed, value, _, difference = rows["corner", "initial", "u", "prism"]
    assert value == "490 mm to 510 mm"
    assert 0.499 < float(computed.removesuffix(" mm")) / 1e3 < 0.501
    assert difference == "0 m"
    length, _, _, more = (float(told.removesuffix(" mm")) if told.endswith("mm") else 0.0
                          for told in rows["corner", "initial", "displacement", "UDEC"])  # fmt: skip
    assert more == pytest.approx(length - 470, abs=0.1)


def test_they_stand_at_their_places_in_the_pictures(results: Results, table: Path) -> None:
    marks = results.plot("histories", beside=table).axes[0].lines
    last = len(results.stages[-1].steps)
    at = {round(float(line.get_ydata()[0]), 3) for line in marks if list(line.get_xdata()) == [last]}
    assert {470.0, 500.0} <= at  # mm: what is measured, and the middle of the range
    (axes,) = results.plot("extensometers", beside={"anchors": table}).axes
    (anchor,) = [line for line in axes.lines if line.get_label() == "anchors"]
    assert list(anchor.get_xdata()) == [1.0]
    legend = [text.get_text() for text in results.plot("displacement_arrows", beside=table).legends[0].get_texts()]
    assert {"prism", "computed at the same points"} <= set(legend)
    names = [text.get_text() for text in results.plot("points", beside=table).axes[0].get_xticklabels()]
    assert names == ["corner", "middle"]


def test_another_run_beside_a_run(results: Results) -> None:
    """Values of the same run are its own: points where its curves end, profiles on its profiles."""
    both = with_sources(results, {"twin": results})
    for recorded in both.recorded:
        for one in recorded.measured:
            if one.source == "twin" and recorded.kind == "point":
                series = results.histories[recorded.name]
                if one.quantity != "displacement":
                    assert one.value == series[one.quantity][-1]
    axes = both.plot("profiles").axes[0]
    (twin, other) = [line for line in axes.lines if line.get_label() == "twin"]
    for mine, theirs in zip(
        [line for line in axes.lines if "computed" in line.get_label()], (twin, other), strict=True
    ):
        found = np.interp(theirs.get_xdata(), *mine.get_data())
        assert (
            np.abs(found - theirs.get_ydata()) < 1e-6 * np.abs(theirs.get_ydata()).max()
        ).mean() > 0.9  # but at jumps


def test_curves_of_many_sources_are_told_apart() -> None:
    """Curves have no marks: no two of two dozen sources have colour and dash in common."""
    sources = tuple(f"source {number}" for number in range(24))
    looks = Looks(stages=(0,), sources=sources, names=("initial",))
    assert len({(looks.colour(0, source), looks.dash(source)) for source in sources}) == len(sources)


def test_stages_of_another_run() -> None:
    """By name; the last beside the last, unless the other run continues."""
    histories = [bsm.History(name="top", block=1)]
    stages = [bsm.Stage(name="dig", excavate=[2]), bsm.Stage(name="more", excavate=[])]
    longer = bsm.run(model_of(grid(1, 3), stages=stages, histories=histories))
    shorter = bsm.run(model_of(grid(1, 3), stages=stages[:1], histories=histories))
    found = {one.stage for one in with_sources(shorter, {"longer": longer}).recorded[0].measured}
    assert found == {"initial", "dig"}
    found = {one.stage for one in with_sources(longer, {"shorter": shorter}).recorded[0].measured}
    assert found == {"initial", None}


def test_they_survive_files(results: Results, tmp_path: Path) -> None:
    """With the results, and as the table of the model file that a model built in Python gets."""
    results.save(tmp_path / "out")
    assert Results.load(tmp_path / "out").recorded == results.recorded
    assert bsm.load(tmp_path / "out/model.toml").histories == RECORDED


def test_they_change_nothing_of_the_model(results: Results) -> None:
    bare = [replace(history, measured=()) for history in RECORDED]
    assert pushed().replace(histories=bare).digest == pushed().replace(histories=RECORDED).digest


HISTORY = '\n[[history]]\nname = "middle"\npoint = [1.2, 1.5]\nmeasured = "measured.csv"\n'


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_the_commands(case: Case) -> None:
    """A model file names its table: told by run, in the report; what is at fault ends with code 2."""
    case.write("model.toml", MODEL + HISTORY)
    case.write("measured.csv", "v [mm],source\n-3,prism 7\n")
    outcome = case.run("run", "model.toml", "--pictures")
    assert outcome.code == 0, outcome.err
    assert "middle, v: -" in outcome.out
    assert "; prism 7: -3 mm" in outcome.out
    assert case.run("report", "out/model").code == 0
    page = (case.folder / "out/model/report.html").read_text(encoding="utf-8")
    assert "<td>prism 7</td>" in page
    assert case.run("plot", "out/model", "--only", "histories", "--with", "again=out/model").code == 0
    for text, told in (
        ("v [mm],stage\n-3,dig\n", "model.toml: history 'middle': measured: there is no stage 'dig'"),
        ("extension,distance\n1,1\n", "model.toml: history 'middle': a point has no extension"),
        ("history,v\nother,1\n", "no row is of history 'middle'"),
    ):
        case.write("measured.csv", text)
        outcome = case.run("run", "model.toml")
        assert outcome.code == 2
        assert told in outcome.err
    outcome = case.run("plot", "out/model", "--with", "nothing.csv")
    assert outcome.code == 2
    assert "nothing.csv" in outcome.err
    case.write("theirs.csv", "history,v\nmidle,1\n")
    outcome = case.run("plot", "out/model", "--with", "theirs.csv")
    assert "the run recorded no history 'midle'; did you mean 'middle'?" in outcome.err


def test_elements_write_what_they_find(case: Case) -> None:
    pytest.importorskip("skfem")
    case.write("model.toml", MODEL + HISTORY + '\n[[history]]\nname = "rod"\nline = [[1, 0.2], [1, 1.8]]\n')
    case.write("measured.csv", "v [mm]\n-3\n")
    assert case.run("compare", "model.toml", "-q").code == 0
    found = read_beside(case.folder / "out/model/compare_histories.csv")
    assert {one.quantity for one in found["middle"]} == {"u", "v"}
    assert {one.quantity for one in found["rod"]} == {"extension", "towards", "across"}
    assert case.run("run", "model.toml", "-q").code == 0
