"""Tables of large models: beside a former campaign, with the sum of what ended in both."""

from benchmarks.campaign.outcome import TIMEOUT
from benchmarks.campaign.tables import of_models


def record(seconds, status="stable"):
    return {"status": status} | ({} if status == TIMEOUT else {"seconds": seconds})


def test_the_sum_is_of_models_with_an_end_in_both():
    now = {("a", 0): record(1.0), ("b", 0): record(3.0), ("c", 0): record(0.0, TIMEOUT), ("new", 0): record(9.0)}
    before = {("a", 0): record(2.0), ("b", 0): record(6.0), ("c", 0): record(5.0)}
    limits = dict.fromkeys(now, 10.0)
    rows = of_models(now, limits, before, dict.fromkeys(before, 10.0))
    assert {len(row) for row in rows} == {len(rows[0])}
    last = dict(zip(rows[0], rows[-1], strict=True))
    assert (last["model"], last["processor s"], last["s before"], last["now over before"]) == (
        "sum of 2",
        "4.0",
        "8.0",
        "0.50",
    )
    assert len(of_models(now, limits)) == 1 + len(now)
