"""The random tunnels in rock that yields: what their table counts, and what it compares."""

import pytest

from benchmarks.plastic_tunnels import against, judged, table


@pytest.mark.heavy
def test_a_tunnel_is_judged():
    record = judged(2)
    assert record["verdict"] == "stable"
    assert 1e-4 < record["moved"] < 0.1


@pytest.mark.slow
def test_viscous_flow_finds_an_equilibrium_that_no_correction_leads_to():
    assert judged(110)["verdict"] == "stable"


def test_another_verdict_or_displacement_is_named():
    before = [{"seed": seed, "verdict": "stable", "moved": 0.01, "seconds": 1.0} for seed in range(3)]
    now = [before[0], {**before[1], "moved": 0.0101}, {**before[2], "verdict": "unstable", "seconds": 20.0}]
    assert table(now).splitlines()[2:] == ["| stable | 2 | 1.0 | 1 | 0 |", "| unstable | 1 | 20.0 | 20 | 1 |"]
    assert [line.partition(":")[0] for line in against(now, before).splitlines()] == [
        "1",
        "2",
        "3 tunnels, 2 of them otherwise; processor time, s",
    ]
