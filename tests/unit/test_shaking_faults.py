"""Reasons of shaken stages without an answer: error, limit and cure, for both kinds of rock."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.results.shaking import ENERGIES
from bsm_mesh.solve.motion.shaking_faults import divergence, imbalance

SINE = bsm.Shaking(waveform="sine", frequency=2, amplitude=1.0, duration=1.0, time_step=0.5, max_imbalance=0.01)


def memory(error: float) -> SimpleNamespace:
    """Return records in which the balance of energies of 1 has an error."""
    records = np.zeros((2, 2 + len(ENERGIES)))
    records[1, 2:] = [error if name == "error" else float(name == "input") for name in ENERGIES]
    return SimpleNamespace(time=0.25, records=records)


@pytest.mark.parametrize(
    ("given", "cure"),
    [
        ({}, "give shaking a smaller time_step (now 0.5)"),
        ({"mass_scaling": 4.0}, "give shaking a smaller time_step (now 0.5) or mass_scaling (now 4)"),
        (
            {"integrator": "implicit"},
            "give shaking a smaller time_step (now 0.5), contact_damping, or integrator = 'explicit'",
        ),
    ],
)
def test_an_error_of_the_energies_is_reported_with_its_cure(given, cure):
    found = imbalance(memory(0.02), replace(SINE, **given))
    of_greatest = "the energy balance of the shaking has an error of 2 % of the greatest energy (allowed: 1 %)"
    assert found == f"{of_greatest}: {cure}"
    assert imbalance(memory(0.01), replace(SINE, **given)) == ""


def test_divergence_is_reported_with_its_cure():
    found = divergence(memory(np.nan), SINE)
    assert found == ("after 0.25 s of shaking the explicit motion diverges: give shaking a smaller time_step (now 0.5)")
