"""Laws of joints on the bench: direct shear and closure by the contacts of a run, beside published formulas."""

from __future__ import annotations

import dataclasses
from functools import partial

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.joint_test import closure_test, direct_shear_test
from examples.numbers import joint_laws as bench
from verification.case import Answer, Case

PAGE = "joint_laws.md#comparison-with-the-formulas"
SOURCES = {"Barton-Bandis": "barton", "Ladanyi-Archambault": "ladanyi", "Mohr-Coulomb, softening": "coulomb"}


def peaks(name: str) -> Answer:
    """Compare peaks of direct shear at five pressures."""
    law, formula = bench.LAWS[name]
    exact = [formula(stress) for stress in bench.STRESSES]
    return np.array(exact), np.array([bench.sheared(law, stress).peak for stress in bench.STRESSES])


def closures() -> Answer:
    """Compare closure at 0.5, 1, 2, 5 and 10 MPa, kni 10 GPa/m, at most 0.2 mm [um]."""
    joint = bsm.Joint("J", 10e9, 1e9, law=bsm.MohrCoulomb(friction=30), max_closure=2e-4)
    found = [1e6 * closure_test(joint, 1e6 * stress, steps=4).closure.max() for stress in (0.5, 1, 2, 5, 10)]
    return np.array([40.0, 66.667, 100.0, 142.857, 166.667]), np.array(found)


def scale() -> Answer:
    """Compare JRC and JCS [MPa] of 8 and 50 MPa over 1 m instead of 0.1 m."""
    law = bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=28, joint_length=1.0)
    return np.array([8 * 10 ** (-0.02 * 8), 50 * 10 ** (-0.03 * 8)]), np.array([law.roughness, law.wall_strength / 1e6])


def wear() -> Answer:
    """Compare roughness left after 1, 2, 4, 10 and 100 times the displacement of the peak, from the strength there."""
    law = bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=28, joint_length=1.0, roughness_wears=True)
    times, one = np.array([1.0, 2.0, 4.0, 10.0, 100.0]), np.ones(5)
    stress = 1e6 * one
    path = (times - 1) * law.peak_displacement  # slip behind the peak
    strength = law.respond(stress, 1e15 * one, one, one < 0, path).strength
    left = (np.degrees(np.arctan(strength / stress)) - 28) / (law.roughness * np.log10(law.wall_strength / stress))
    return np.array([1.0, 0.85, 0.70, 0.50, 0.0]), left


def softening() -> Answer:
    """Compare shear stress at half the softening slip: half-way between peak and residual strength [kPa]."""
    law = dataclasses.replace(bench.SOFTENING)
    curve = bench.sheared(law, 1e6)
    slip = curve.shear_displacement - curve.shear_stress / 10e9  # the elastic part goes back
    half = np.interp(2.5e-3, slip[np.argmax(curve.shear_stress) :], curve.shear_stress[np.argmax(curve.shear_stress) :])
    peak, residual = bench.peak(1e6), 1e6 * np.tan(np.radians(28))
    return (peak + residual) / 2 / 1e3, half / 1e3


def dilation() -> Answer:
    """Compare how far a joint of 8 degrees opens as it slides 4 and 10 mm, its dilation worn off after 5 mm [um]."""
    joint = bsm.Joint("J", 20e9, 10e9, law=bsm.MohrCoulomb(friction=30), dilation_angle=8.0, dilation_slip=5e-3)
    exact, found = [], []
    for far in (4e-3, 10e-3):
        curve = direct_shear_test(joint, 1e6, far, steps=100)
        slip = far - curve.shear_stress[-1] / 10e9  # the rest is elastic
        exact.append(1e6 * np.tan(np.radians(8.0)) * min(slip, 5e-3))
        found.append(1e6 * (curve.closure[0] - curve.closure[-1]))
    return np.array(exact), np.array(found)


CASES = (
    *(Case(name=f"bench-{name.lower().replace(' ', '-').replace(',', '')}", what=f"direct shear, {name}: five peaks",
           source=SOURCES[name], quantity="strength [Pa]", compute=partial(peaks, name), tolerance=1e-11, page=PAGE)
      for name in bench.LAWS),
    Case(name="closure", what="closure of a joint by a hyperbola", source="bandis", quantity="closure [um]",
         compute=closures, tolerance=1e-5),
    Case(name="scale-of-roughness", what="JRC and JCS of a longer joint", source="barton", quantity="JRC, JCS [MPa]",
         compute=scale, tolerance=1e-12),
    Case(name="wear-of-roughness", what="roughness that wears off behind the peak", source="barton-bakhtar",
         quantity="part of JRC", compute=wear, tolerance=1e-12),
    Case(name="dilation", what="walls part by tan(dilation angle) of the slip until it has worn off", source="statics",
         quantity="opening [um]", compute=dilation, tolerance=1e-11),
    Case(name="softening", what="strength that softens with slip, half-way", source="coulomb",
         quantity="shear stress [kPa]", compute=softening, tolerance=0.01),
)  # fmt: skip
