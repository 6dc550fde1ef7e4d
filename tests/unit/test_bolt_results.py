"""What is reported of bolts: support pressure, tables, VTU, pictures; and bolts in the scheme of the thesis."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.bolt_patterns import radial_bolts
from bsm_mesh.pictures.bolt_pictures import draw_bolt_forces
from bsm_mesh.results import BoltForces, BoltStatus
from bsm_mesh.text.bolt_tables import BOLT_HEADER, bolt_table
from bsm_mesh.text.tables import bolt_rows
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import MODEL, Case


def record(bolts, force, status=None):
    """Return a record of bolts of one element each with given tensions."""
    n = len(bolts)
    ends = np.array([(bolt.start, bolt.end) for bolt in bolts]).reshape(-1, 2)
    zero = np.zeros(n)
    return BoltForces(
        names=tuple(f"B{k}" for k in range(n)),
        node_start=2 * np.arange(n + 1),
        block=np.zeros(2 * n, np.int32),
        station=np.tile([0.0, 1.0], n),
        original=ends,
        point=ends,
        displacement=np.zeros((2 * n, 2)),
        spacing=np.array([bolt.spacing for bolt in bolts]),
        status=np.full(n, BoltStatus.ELASTIC) if status is None else status,
        alive=np.ones(n, dtype=bool),
        axial_force=np.asarray(force, dtype=float),
        bond_force=np.zeros(2 * n),
        slip=np.zeros(2 * n),
        plastic_stretch=zero,
        utilisation=zero,
        limit=np.zeros(n, np.int8),
        shear_force=zero,
        shear_point=np.zeros((n, 2)),
        shear_direction=np.zeros((n, 2)),
    )


def test_the_table_has_a_row_a_bolt():
    """Of one that is not there it has no numbers, and where none is there no rows."""
    bolts = [bsm.Bolt(start=(x, 0), end=(x, 3), diameter=0.02, spacing=2.0) for x in (0.0, 1.0, 2.0)]
    status = np.array([BoltStatus.ELASTIC, BoltStatus.YIELDING, BoltStatus.ABSENT])
    rows = bolt_table(record(bolts, [50e3, 120e3, 0.0], status))
    assert all(len(row) == len(BOLT_HEADER) for row in rows)
    assert rows[0] == ("B0", "elastic", "50 kN", "0", "50 kN", "25 kPa")
    assert rows[1][:3] == ("B1", "yielding", "120 kN")
    assert rows[2] == ("B2", "absent", "-", "-", "-", "-")
    assert bolt_table(record(bolts, [0.0] * 3, np.full(3, BoltStatus.ABSENT))) == []


def test_support_pressure_of_a_row():
    """Bolts at 0, 1, 3 and 4 m along a floor: their shares are 1, 1.5, 1.5 and 1 m."""
    bolts = [bsm.Bolt(start=(x, 0), end=(x, -2), diameter=0.02, spacing=2.0) for x in (0, 1, 3, 4)]
    found = record(bolts, [12e3, 12e3, 6e3, 6e3]).support_pressure
    assert_allclose(found, [6e3, 4e3, 2e3, 3e3])


def test_support_pressure_counts_only_bolts_of_the_same_wall():
    """Bolts of the opposite wall, absent bolts and single bolts."""
    row = [bsm.Bolt(start=(x, 0), end=(x, 2), diameter=0.02) for x in (0, 1, 2)]
    floor = [bsm.Bolt(start=(0.5, -3), end=(0.5, -5), diameter=0.02)]
    status = np.array([BoltStatus.ELASTIC, BoltStatus.ABSENT, BoltStatus.ELASTIC, BoltStatus.ELASTIC])
    found = record([*row, *floor], [1e3, 0, 2e3, 5e3], status).support_pressure
    assert_allclose(found, [500, np.nan, 1000, np.nan])


def test_support_pressure_round_an_arch():
    bolts = radial_bolts(centre=(0, 0), radius=3, length=2, count=19, diameter=0.02)
    found = record(bolts, np.full(19, 1e4)).support_pressure
    assert_allclose(found[1:-1], 1e4 / (3 * np.sin(np.radians(10))))


def test_a_support_pressure_that_is_not_known_is_no_bar():
    """Of bolts of which none has a neighbour the forces are drawn; of some, a question mark."""
    row = [bsm.Bolt(start=(x, 0), end=(x, 2), diameter=0.02, name=f"R{x}") for x in (0.5, 1.5)]
    alone = bsm.Bolt(start=(0.5, -3), end=(0.5, -5), diameter=0.02, name="alone")
    found = record([*row, alone], np.array([1e3, 2e3, 5e3]))
    *_, axes = draw_bolt_forces(found, "").axes
    assert [text.get_text() for text in axes.texts] == ["?"]
    assert [round(bar.get_x() + bar.get_width() / 2) for bar in axes.patches] == [0, 1, 0, 1]
    assert min(bar.get_height() for bar in axes.patches) > 0


@pytest.mark.heavy
def test_charts_of_some_bolts_say_of_how_many():
    """The pressures are of all bolts, the charts of the twelve most used."""
    row = [bsm.Bolt(start=(x, 0), end=(x, 2), diameter=0.02, name=f"R{x}") for x in range(14)]
    for count, told in ((14, "above: the 12 most used of 14 bolts"), (12, "")):
        *charts, pressures = draw_bolt_forces(record(row[:count], np.linspace(1e3, 2e3, count)), "").axes
        assert len(charts) == 12
        assert pressures.get_title(loc="left") == told


@pytest.mark.heavy
def test_rows_and_summary_name_bolts_at_their_limit(case: Case) -> None:
    bolts = '[[bolt]]\nname = "weak"\nstart = [0.4, 0.4]\nend = [0.4, 1.9]\ndiameter = 0.02\n' + (
        "bond_strength = 3e4\n[[bolt]]\nstart = [1.4, 1.6]\nend = [1.6, 1.9]\ndiameter = 0.02\n"
    )
    lifted = MODEL.replace('"1 MPa"', '"-50 kPa"')  # against a weight of 26 kPa
    lifted = lifted.replace('"mesh.msh"', '"mesh.msh"\nallow_unused = true')  # the second bolt lies in one block
    case.write("model.toml", lifted + bolts + '[solver]\nscheme = "continuation"\n')
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 0, outcome.err
    assert "slipping (weak)" in outcome.out
    assert "1 in a single block, without effect" in " ".join(outcome.out.split())
    assert "1 bolt lies in a single block and carries nothing (bolt 2" in outcome.out
    assert "bolts.pvd, bolts.csv" in outcome.out
    told = json.loads((case.folder / "out/model/summary.json").read_text())["stages"][0]["bolts"]
    assert [bolt["status"] for bolt in told] == ["slipping", "slack"]
    assert told[0]["utilisation"] == pytest.approx(1.0)
    assert told[0]["support_pressure"] is None
    assert case.run("report", "out/model", "--no-pictures", "-q").code == 0
    page = (case.folder / "out/model/report.html").read_text(encoding="utf-8")
    assert "<summary>Bolts: 2</summary>" in page
    assert "<td>weak</td><td>slipping</td>" in page
    assert '<td>in a single block</td><td class="number">-</td>' in page


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_pictures_show_bolts(case: Case) -> None:
    from matplotlib.image import imread

    bolts = '[[bolt]]\nstart = [0.4, 0.4]\nend = [0.4, 1.9]\ndiameter = 0.02\npretension = "30 kN"\n'
    bolts += 'yield_strength = "500 MPa"\n'
    case.write("model.toml", MODEL + bolts)
    outcome = case.run("run", "model.toml", "-q", "--pictures")
    assert outcome.code == 0, outcome.err
    for name in ("bolts", "bolts_utilisation", "bolt_forces"):
        picture = imread(case.folder / f"out/model/pictures/{name}.png")[..., :3]
        assert len(np.unique((255 * picture).astype(int) @ (1 << 16, 1 << 8, 1))) > 20


@pytest.mark.parametrize("strength", [None, 2e4])
def test_scheme_of_the_thesis(strength):
    """A bolt that hangs a block, by Wang's iteration: held, or at its capacity."""
    blocks = bsm.Blocks.from_polygons([rectangle(0, 1, 3, 3), rectangle(1, 0, 2, 1)], rock="rock")
    yields = None if strength is None else strength / (np.pi * 0.011**2)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=26e3)],
        joints=[bsm.Joint("J", normal_stiffness=1e8, shear_stiffness=1e8, law=bsm.Patton(friction=30))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        bolts=[bsm.Bolt(start=(1.5, 0), end=(1.5, 2.5), diameter=0.022, yield_strength=yields)],
    )
    results = bsm.run(model, bsm.Options(scheme="wang"))
    assert results.status == ("stable" if strength is None else "unstable")
    assert_allclose(results.stages[-1].bolts.axial_force, strength or 26e3, rtol=5e-3)
    assert len(results.stages[-1].steps) < 100


def test_mean_pressure_is_that_of_the_mean_tension():
    """Elements of 1 and 3 m with 8 and 4 kN: 5 kN in the mean, over 2 m along the tunnel and 1 m of wall."""
    bolts = [bsm.Bolt(start=(x, 0), end=(x, 4), diameter=0.02, spacing=2.0) for x in (0, 1)]
    one = record(bolts, [8e3, 8e3])
    found = dataclasses.replace(
        one,
        node_start=np.array([0, 3, 6]),
        station=np.tile([0.0, 1.0, 4.0], 2),
        original=np.array([(x, y) for x in (0.0, 1.0) for y in (0.0, 1.0, 4.0)]),
        block=np.zeros(6, np.int32),
        axial_force=np.array([8e3, 4e3, 0.0, 0.0]),
    )
    assert_allclose(found.mean_force, [5e3, 0.0])
    assert_allclose(found.mean_pressure, [2.5e3, 0.0])
    assert_allclose(found.support_pressure, [4e3, 0.0])


@pytest.mark.parametrize(
    ("bond", "limit", "words"), [(100e3, 2, "0.25 of bond, plate or anchorage"), (1e6, 1, "0.102 of the steel")]
)
def test_the_utilisation_of_a_bolt_names_its_strength(tmp_path, bond, limit, words):
    """A block of 25 kN hangs on a bolt with 1 m of bond in it, whose steel yields at 245 kN."""
    bolt = bsm.Bolt(start=(0.5, 0), end=(0.5, 2), diameter=0.025, yield_strength=5e8, bond_strength=bond, name="B")
    model = model_of([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)], friction=30, fixed=(1,), bolts=[bolt])
    results = bsm.run(model)
    rows = dict(bolt_rows(results.stages[-1].bolts))
    assert rows["greatest utilisation of a bolt"].startswith(f"{words} (B, 0 m from its head, where its force is 25 kN")
    assert bolt_table(results.stages[-1].bolts)[0][3] == words
    again = bsm.Results.load(results.save(tmp_path / "out"))
    assert again.stages[-1].bolts.limit.tolist() == [limit]
