"""Ablation: plans without a method, settings with other values; slips of the pen are reported."""

from __future__ import annotations

import pytest

from benchmarks.campaign.ablation import Ablation
from bsm_mesh.solve.continuation.plan import PLANS
from bsm_mesh.solve.methods import nearby_equilibrium, newton
from bsm_mesh.solve.motion import following


@pytest.fixture(autouse=True)
def restored(monkeypatch):
    for phase, plan in PLANS.items():
        monkeypatch.setitem(PLANS, phase, plan)
    for module in (newton, following):
        monkeypatch.setattr(module, "SETTINGS", module.SETTINGS)
    monkeypatch.setattr(nearby_equilibrium, "NEWTON", nearby_equilibrium.NEWTON)


def test_a_method_is_in_no_plan_any_more():
    Ablation(without=("dynamic relaxation",)).apply()
    names = {method.name for plan in PLANS.values() for method in plan}
    assert "dynamic relaxation" not in names
    assert "explicit motion" in names


def test_settings_are_changed_wherever_they_are_known():
    ablation = Ablation(settings=("newton.shrinking=0.5", "following.going_on.damping=0.3"))
    ablation.apply()
    assert newton.SETTINGS.shrinking == nearby_equilibrium.NEWTON.shrinking == 0.5
    assert (following.SETTINGS.going_on.damping, following.SETTINGS.beginning.damping) == (0.3, 0.5)
    assert str(ablation) == "newton.shrinking=0.5; following.going_on.damping=0.3"


@pytest.mark.parametrize(
    ("ablation", "said"),
    [
        (Ablation(without=("interior point",)), "there is no method 'interior point'; there are Newton, dynamic"),
        (Ablation(settings=("dynamic_relaxation=20",)), "sets nothing; write module.field=value, of "),
        (Ablation(settings=("dynamic_relaxation.lamp=20",)), "RelaxationSettings has no field 'lamp'"),
    ],
)
def test_what_there_is_not_is_told(ablation, said):
    with pytest.raises(ValueError, match=said):
        ablation.apply()
