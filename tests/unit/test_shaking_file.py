"""Shaking in a model file: records of tables and of PEER, waveforms, faults, and the model that was run."""

import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.modelfile.model_tables import StageTable
from bsm_mesh.modelfile.record_files import read_record
from tests.scenes.shaken import block_on_plane
from tests.scenes.small_case import MODEL

PEER = "PEER\nA\nB\nNPTS= 3, DT= .1000 SEC\n 0.0 .5E+00\n -.25\n"
CSV = "time [s],acceleration [g]\n0.0,0.0\n0.1,0.5\n0.2,-0.25\n"


@pytest.mark.parametrize(
    ("name", "text", "quantity", "values"),
    [
        ("a.csv", CSV, "acceleration", [0, 0.5 * GRAVITY, -0.25 * GRAVITY]),
        ("b.csv", "Time (ms);Velocity (cm/s)\n0;0,0\n100;1,5\n200;2,0\n", "velocity", [0, 0.015, 0.02]),
        ("c.csv", "time,value\n0,0\n0.1,1\n0.2,2\n", "acceleration", [0, 1, 2]),
        ("f.csv", "time,acceleration [ft/s^2]\n0,0\n0.1,1\n0.2,2\n", "acceleration", [0, 0.3048, 0.6096]),
        ("g.csv", "time,acceleration [%g]\n0,0\n0.1,50\n0.2,-25\n", "acceleration", [0, GRAVITY / 2, -GRAVITY / 4]),
        ("i.csv", "time,velocity [in/s]\n0,0\n0.1,1\n0.2,2\n", "velocity", [0, 0.0254, 0.0508]),
        (
            "d.AT2",
            "PEER\nA\nB\nNPTS= 3, DT= .1000 SEC\n 0.0 .5E+00\n -.25\n",
            "acceleration",
            [0, 0.5 * GRAVITY, -0.25 * GRAVITY],
        ),
    ],
)
def test_records_are_read_in_their_units(tmp_path, name, text, quantity, values):
    path = tmp_path / name
    path.write_text(text)
    time, found = read_record(path, quantity)
    assert_allclose(time, [0, 0.1, 0.2], atol=1e-12)
    assert_allclose(found, values, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "text", "quantity", "fault"),
    [
        ("a.csv", "t,x\n0,1\n", "acceleration", "needs the columns 'time' and 'acceleration'"),
        (
            "v.csv",
            "time,velocity [m/s]\n0,1\n",
            "acceleration",
            r"has time, velocity \[m/s\]; give quantity = 'velocity'",
        ),
        ("b.csv", "time,acceleration [ft]\n0,1\n1,2\n", "acceleration", "ft"),
        ("c.csv", "time,velocity\n0,x\n1,2\n", "velocity", "no finite number"),
        ("d.at2", "PEER\nA\nB\nNPTS= 3\n0.1\n", "acceleration", "no time step"),
        ("e.at2", "PEER\nA\nB\nDT= 0.1\n0.1 x\n", "acceleration", "'x'"),
        ("f.at2", "PEER\nA\nB\nDT= 0.1\n0.1\n", "velocity", "holds accelerations"),
    ],
)
def test_faulty_records_end_in_a_message(tmp_path, name, text, quantity, fault):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(bsm.ModelError, match=fault):
        read_record(path, quantity)


def amplitude(text, quantity):
    given = {"waveform": "sine", "frequency": 2.0, "amplitude": text, "quantity": quantity}
    return StageTable.model_validate({"name": "quake", "shaking": given}).shaking.amplitude


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [
        ("0.15 g", "acceleration", 0.15 * GRAVITY),
        ("-150 gal", "acceleration", -1.5),
        ("1.5e2 cm/s^2", "acceleration", 1.5),
        ("20 cm/s", "velocity", 0.2),
        ("3 ft/s2", "acceleration", 0.9144),
        ("2 MPa", "stress", 2e6),
        (3.0, "acceleration", 3.0),
    ],
)
def test_amplitudes_have_the_units_of_records(text, quantity, value):
    """The unit g is standard gravity, not a gram."""
    assert amplitude(text, quantity) == pytest.approx(value, rel=1e-12)


def test_an_amplitude_in_another_unit_names_those_that_it_may_have():
    for text in ("0.15 kPa", "0.15", "much"):
        with pytest.raises(ValueError, match=r"one of the units m/s2, m/s\^2, g, cm/s2, .* quantity = 'acceleration'"):
            amplitude(text, "acceleration")
    with pytest.raises(ValueError, match=r"plain number \[m/s\], or a text with one of the units m/s, cm/s"):
        amplitude("0.15 g", "velocity")


def test_a_record_in_a_file_is_no_fault_beside_others(tmp_path):
    stage = '[[stage]]\nname = "quake"\n[stage.shaking]\nrecord = "quake.csv"\n'
    (tmp_path / "quake.csv").write_text(CSV)
    (tmp_path / "model.toml").write_text(f'[mesh]\nfile = "a.msh"\n[rock.a]\nunit_weight = "x"\n{stage}')
    with pytest.raises(bsm.ModelError) as caught:
        bsm.load(tmp_path / "model.toml")
    assert len(caught.value.faults) == 1
    assert "unit_weight" in caught.value.faults[0]


SHAKINGS = {
    "record": bsm.Shaking(record=([0.0, 0.1, 0.3], [0.0, 2.5, -1.0]), quantity="velocity", mass_damping=(0.02, 2.0)),
    "waveform": bsm.Shaking(waveform="sine", frequency=5.0, amplitude=3.0, cycles=2, direction=30.0, every=0.1),
    "housner": bsm.Shaking(waveform="ricker", frequency=5.0, amplitude=3.0, contact_damping="housner", every=0.1),
}


@pytest.mark.heavy
@pytest.mark.parametrize("name", SHAKINGS)
def test_the_model_that_was_run_is_written_and_read_back(tmp_path, name):
    model = block_on_plane(SHAKINGS[name], friction=0.4)
    results = bsm.run(model)
    results.save(tmp_path / "out")
    again = bsm.load(tmp_path / "out" / "model.toml")
    assert again.stages == model.stages
    text = (tmp_path / "out" / "model.toml").read_text()
    if name == "record":
        (tmp_path / "out" / "quake.csv").write_text("time [s],velocity [m/s]\n0,0\n0.1,2.5\n0.3,-1\n")
        start, end = text.index("record = ["), text.index("]\n", text.index("record = [")) + 2
        while text[start:end].count("[") != text[start:end].count("]"):
            end = text.index("]\n", end) + 2
        (tmp_path / "out" / "other.toml").write_text(f'{text[:start]}record = "quake.csv"\n{text[end:]}')
        assert bsm.load(tmp_path / "out" / "other.toml").stages == model.stages
    (tmp_path / "out" / "bad.toml").write_text(text.replace("[stage.shaking]", "[stage.shaking]\nevery_s = 1"))
    with pytest.raises(bsm.ModelError, match="every_s"):
        bsm.load(tmp_path / "out" / "bad.toml")


def test_a_quantity_written_as_a_key_is_answered_with_the_keys_of_record_and_waveform(case):
    case.write("model.toml", MODEL + "[[stage]]\nname = 'quake'\n[stage.shaking]\nacceleration = '0.3 g'\n")
    case.refuses(
        "check", "model.toml", says=["unknown key 'acceleration'; write record, or waveform with", "amplitude"]
    )
