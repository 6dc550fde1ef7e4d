"""Numbers and picture of docs/joint_laws.md: what the bench finds of every law, beside the published formula."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.files import whole_file
from bsm_mesh.joint_test import JointCurve, closure_test, direct_shear_test
from examples.numbers.pages import Table, markdown

PAGE, PICTURE = "docs/joint_laws.md", "docs/joint_laws.png"
ROOT = Path(__file__).parents[2]
STRESSES = (0.1e6, 0.5e6, 1e6, 5e6, 20e6)
BARTON = bsm.BartonBandis(jrc=10, jcs=80e6, residual_friction=28, joint_length=1.0, roughness_wears=True)
LADANYI = bsm.LadanyiArchambault(friction=30, dilation=15, jcs=60e6)
SOFTENING = bsm.MohrCoulomb(
    friction=40, cohesion=0.2e6, residual_friction=28, residual_cohesion=0.0, softening_slip=5e-3
)
KN, LIMIT = 20e9, 0.3e-3
KS, EXPONENT, REFERENCE = 4e9, 0.6, 1e6


def _tan(degrees: float) -> float:
    return math.tan(math.radians(degrees))


def barton(s: float) -> float:
    """Return the peak of Barton and Choubey 1977, scaled to 1 m after Barton and Bandis 1982 [Pa]."""
    return s * _tan(28 + 10 * 10 ** (-0.2) * math.log10(80e6 * 10 ** (-0.3) / s))


def ladanyi(s: float) -> float:
    """Return the peak of Ladanyi and Archambault 1970 (Wang Eq. 4.3) [Pa]."""
    c, smooth = 60e6, _tan(30)
    a, rate = 1 - (1 - s / c) ** 1.5, (1 - s / c) ** 4 * _tan(15)
    rock = c * (math.sqrt(11) - 1) / 10 * math.sqrt(1 + 10 * s / c)
    return (s * (1 - a) * (rate + smooth) + a * rock) / (1 - (1 - a) * rate * smooth)


def barton_stiffness(s: float) -> float:
    """Return the peak strength over the displacement at the peak, L / 500 (JRCn / L)^0.33 [Pa/m]."""
    return barton(s) / ((10 * 10 ** (-0.2)) ** 0.33 / 500)


def power_stiffness(s: float) -> float:
    """Return the shear stiffness by a power of the normal stress [Pa/m]."""
    return KS * (s / REFERENCE) ** EXPONENT


def peak(s: float) -> float:
    """Return the peak of the softening law [Pa]."""
    return 0.2e6 + s * _tan(40)


LAWS: dict[str, tuple[Any, Callable[[float], float]]] = {
    "Barton-Bandis": (BARTON, barton),
    "Ladanyi-Archambault": (LADANYI, ladanyi),
    "Mohr-Coulomb, softening": (SOFTENING, peak),
}


STIFFENING: dict[str, tuple[bsm.Joint, Callable[[float], float]]] = {
    "stiffness by peak": (bsm.Joint("J", KN, law=BARTON, reference_stress=REFERENCE), barton_stiffness),
    "by power of stress": (
        bsm.Joint("J", KN, KS, shear_stiffness_exponent=EXPONENT, reference_stress=REFERENCE),
        power_stiffness,
    ),
}


def stiffness_of(joint: bsm.Joint, stress: float) -> float:
    """Return the shear stiffness that the bench finds [Pa/m]."""
    curve = direct_shear_test(joint, stress, 1e-4, steps=2)
    return float(curve.shear_stress[-1] / curve.shear_displacement[-1])


def off_by(found: float, exact: float) -> str:
    """Return the relative difference."""
    return "below 1e-9" if abs(found / exact - 1) < 1e-9 else f"{found / exact - 1:.1e}"


def sheared(law: Any, stress: float) -> JointCurve:
    """Return direct shear over 20 mm."""
    return direct_shear_test(bsm.Joint("J", KN, 10e9, law=law), stress, 20e-3, steps=400)


def beside() -> str:
    """Return the table: formula, and by how much the bench's peak differs from it."""
    rows = []
    for stress in STRESSES:
        row = [f"{stress / 1e6:g}"]
        for law, formula in LAWS.values():
            row += [f"{formula(stress) / 1e6:.4f}", off_by(sheared(law, stress).peak, formula(stress))]
        curve = closure_test(bsm.Joint("J", KN, 10e9, law=BARTON, max_closure=LIMIT), stress)
        exact = stress * LIMIT / (KN * LIMIT + stress)
        row += [f"{1e3 * exact:.4f}", off_by(curve.closure.max(), exact)]
        for joint, formula in STIFFENING.values():
            row += [f"{formula(stress) / 1e9:.3f}", off_by(stiffness_of(joint, stress), formula(stress))]
        rows.append(row)
    names = [word for name in LAWS for word in (f"{name}, MPa", "bench off by")]
    names += ["closure, mm", "bench off by"]
    names += [word for name in STIFFENING for word in (f"{name}, GPa/m", "bench off by")]
    return markdown(("normal stress, MPa", *names), rows)


def draw() -> None:
    """Draw strength and stiffness over stress, shear over displacement, closure: formulas as lines, bench as points."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14, 9.2), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    (strength, shear), (closure, stiffness) = figure.subplots(2, 2)
    fine = np.geomspace(1e4, 20e6, 300)
    for name, (law, formula) in LAWS.items():
        (line,) = strength.plot(fine / 1e6, [formula(s) / 1e6 for s in fine.tolist()], label=name)
        found = [sheared(law, s).peak / 1e6 for s in STRESSES]
        strength.plot(np.array(STRESSES) / 1e6, found, "o", color=line.get_color(), fillstyle="none")
        curve = sheared(law, 1e6)
        shear.plot(1e3 * curve.shear_displacement, curve.shear_stress / 1e6, color=line.get_color())
    stress = np.linspace(0, 20e6, 200)
    closure.plot(1e3 * stress * LIMIT / (KN * LIMIT + stress), stress / 1e6, color="black")
    tested = closure_test(bsm.Joint("J", KN, 10e9, law=BARTON, max_closure=LIMIT), 20e6, steps=20)
    closure.plot(1e3 * tested.closure, tested.normal_stress / 1e6, "o", color="black", fillstyle="none")
    for name, (joint, formula) in STIFFENING.items():
        (line,) = stiffness.loglog(fine / 1e6, [formula(s) / 1e9 for s in fine.tolist()], label=name)
        found = [stiffness_of(joint, s) / 1e9 for s in STRESSES]
        stiffness.plot(np.array(STRESSES) / 1e6, found, "o", color=line.get_color(), fillstyle="none")
    labels = (
        (strength, "normal stress, MPa", "peak shear strength, MPa"),
        (shear, "shear displacement, mm, under 1 MPa", "shear stress, MPa"),
        (closure, "closure, mm", "normal stress, MPa"),
        (stiffness, "normal stress, MPa", "shear stiffness, GPa/m"),
    )
    for axes, x, y in labels:
        axes.set_xlabel(x)
        axes.set_ylabel(y)
        axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    strength.legend(frameon=False)
    stiffness.legend(frameon=False)
    with whole_file(ROOT / PICTURE) as draft:
        figure.savefig(draft, format="png")


TABLES: tuple[Table, ...] = (Table(name="joint-laws", page=PAGE, make=beside, tolerance=0.5, draw=draw),)
