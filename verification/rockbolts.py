"""Bolts in models: hung blocks, grouted bolts that are pulled, pretension, dowels."""

from __future__ import annotations

import math

import numpy as np

import bsm_mesh as bsm
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import rectangle
from verification.case import Answer, Case, limit_between

GAMMA = 26e3
ROOF, HUNG = rectangle(0, 1, 3, 3), rectangle(1, 0, 2, 1)
D, E, L, BOND, PULL = 0.022, 200e9, 2.0, 1e9, 100e3
EA = E * math.pi * D**2 / 4
RATE = math.sqrt(BOND / EA)  # of decay along a grouted bolt [1/m]


def _solve(polygons: list[np.ndarray], bolt: bsm.Bolt, *, weight: float = GAMMA, friction: float = 30.0,
           options: bsm.Options | None = None, **given: object) -> bsm.Results:  # fmt: skip
    model = model_of(polygons, gamma=weight, friction=friction, bolts=[bolt], **given)
    return bsm.run(model, options or bsm.Options())


def hung_block() -> Answer:
    """Compare force of a bolt, and of bolts 1.5 m apart, that hang a block of 1 m2 [kN]."""
    found = []
    for spacing in (1.0, 1.5):
        bolt = bsm.Bolt(start=(1.5, 0), end=(1.5, 2.5), diameter=D, spacing=spacing)
        found.append(_solve([ROOF, HUNG], bolt).stages[-1].bolts.axial_force.max() / 1e3)
    return GAMMA * np.array([1.0, 1.5]) / 1e3, np.array(found)


def hung_off_its_centre() -> Answer:
    """Compare a block hung 0.3 m off its centre leans on the roof: moments about the corner that it leans on [kN]."""
    bolt = bsm.Bolt(start=(1.8, 0), end=(1.8, 2.5), diameter=0.1)
    return GAMMA * 0.5 / 0.2 / 1e3, _solve([ROOF, HUNG], bolt).stages[-1].bolts.axial_force.max() / 1e3


def bolt_that_yields() -> Answer:
    """Compare weight of a hung block at which the steel flows, over the yield force."""

    def holds(part: float) -> bool:
        bolt = bsm.Bolt(start=(1.5, 0), end=(1.5, 2.5), diameter=D, yield_strength=GAMMA / part / (math.pi * D**2 / 4))
        return bool(_solve([ROOF, HUNG], bolt).status == "stable")

    return 1.0, limit_between(holds, 0.99, 1.01)


def _pulled(load: float = PULL, **keys: float) -> bsm.Results:
    blocks = [rectangle(-L, -0.5, 0, 0.5), rectangle(0, -0.5, L, 0.5)]
    bolt = bsm.Bolt(start=(-L, 0), end=(L, 0), diameter=D, young=E, **keys)
    return _solve(blocks, bolt, weight=0.0, loads=[bsm.PointLoad(block=1, point=(L, 0), force=(load, 0))])


def shear_lag() -> Answer:
    """Compare tension at 0.25, 0.5 and 1 m from the joint [kN]."""
    bolts = _pulled(bond_stiffness=BOND).stages[-1].bolts
    middle = (bolts.station[:-1] + bolts.station[1:]) / 2 - L
    x = np.array([0.25, 0.5, 1.0])
    found = np.exp(np.interp(x, middle, np.log(bolts.axial_force))) / 1e3
    return np.array([40.386, 16.310, 2.658]), found


def opening_of_grouted() -> Answer:
    """Compare how far the joint opens by either side of it [um]."""
    return 362.675, 1e6 * float(_pulled(bond_stiffness=BOND).stages[-1].displacement[1, 0]) / 2


def ultimate_pull() -> Answer:
    """Compare pull at which the bond gives way, over its strength times the length."""
    bond = 150e3

    def holds(part: float) -> bool:
        return bool(_pulled(bond * L * part, bond_strength=bond).status == "stable")

    return 1.0, limit_between(holds, 1 - 1e-4, 1 + 1e-4)


def pretension_in_series() -> Answer:
    """Compare what a tensioned bolt keeps that closes a joint: K / (K + k) of it [kN]."""
    T0, K = 50e3, 1e9
    bolt = bsm.Bolt(start=(-L, 0), end=(L, 0), diameter=D, young=E, kind="end_anchored", pretension=T0)
    blocks = [rectangle(-L, -0.5, 0, 0.5), rectangle(0, -0.5, L, 0.5)]
    stage = _solve(blocks, bolt, weight=0.0, options=LINEAR).stages[-1]
    return T0 * K / (K + EA / (2 * L)) / 1e3, stage.bolts.axial_force.max() / 1e3


DOWEL = {"start": (0.5, 1), "end": (0.5, -1), "diameter": 0.025, "young": E, "bearing_stiffness": 2e9}


def dowel_stiffness() -> Answer:
    """Compare half a bolt of 1 m as beam elements on springs, moment-free at the joint, two in series [MN/m]."""
    n = 500
    h, EI = 1.0 / n, E * math.pi * 0.025**4 / 64
    beam = EI / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                                 [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]])  # fmt: skip
    K = np.zeros((2 * n + 2, 2 * n + 2))
    for e in range(n):
        K[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += beam
    K[::2, ::2] += np.diag(np.r_[h / 2, np.full(n - 1, h), h / 2]) * 2e9
    load = np.zeros(2 * n + 2)
    load[0] = 1.0
    return 1e-6 / (2 * np.linalg.solve(K, load)[0]), bsm.Bolt(**DOWEL).dowel_stiffness / 1e6


def dowel_closed_form() -> Answer:
    """Compare e I b^3 of two half-infinite beams, b = (k / (4 E I))^(1/4), in a run: shear over displacement [MN/m]."""
    EI = E * math.pi * 0.025**4 / 64
    load = 10e3
    blocks = [rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)]
    push = [bsm.PointLoad(block=1, point=(0, 0.0), force=(load, 0.0))]
    stage = _solve(blocks, bsm.Bolt(**DOWEL), weight=25e3, friction=0.0, loads=push).stages[-1]
    exact = EI * (2e9 / (4 * EI)) ** 0.75
    return exact / 1e6, load / stage.displacement[1, 0] / 1e6


def dowel_strength() -> Answer:
    """Compare two plastic hinges: the least work of bearing and hinge over all depths of the hinge [kN]."""
    bearing, steel, d = 60e6, 400e6, 0.025
    depth = np.linspace(1e-3, 0.5, 200_000)
    least = (bearing * d * depth / 2 + d**3 * steel / 6 / depth).min()
    bolt = bsm.Bolt(**DOWEL, bearing_strength=bearing, yield_strength=steel)
    return least / 1e3, bolt.dowel_strength / 1e3


CASES = (
    Case(name="hung-block", what="bolts that hang a block from the roof", source="statics", quantity="tension [kN]",
         compute=hung_block, tolerance=3e-3),
    Case(name="hung-off-its-centre", what="a block hung off its centre", source="statics", quantity="tension [kN]",
         compute=hung_off_its_centre, tolerance=3e-3),
    Case(name="bolt-that-yields", what="a hung block too heavy for the steel", source="statics",
         quantity="weight over yield force", compute=bolt_that_yields, tolerance=0.011),
    Case(name="shear-lag", what="grouted bolt with elastic bond, pulled by 100 kN", source="farmer",
         quantity="tension [kN]", compute=shear_lag, tolerance=2e-3),
    Case(name="shear-lag-opening", what="the same: the joint that it crosses", source="farmer", quantity="opening [um]",
         compute=opening_of_grouted, tolerance=5e-3),
    Case(name="ultimate-pull", what="grouted bolt pulled out", source="farmer", quantity="pull over bond strength",
         compute=ultimate_pull, tolerance=1.1e-4),
    Case(name="pretension-in-series", what="a tensioned bolt across a joint", source="springs",
         quantity="tension [kN]", compute=pretension_in_series, tolerance=1e-11),
    Case(name="dowel-by-beams", what="dowel stiffness, by 500 beam elements on springs", source="hetenyi",
         quantity="stiffness [MN/m]", compute=dowel_stiffness, tolerance=1e-3),
    Case(name="dowel-in-a-run", what="a block held by a dowel alone", source="hetenyi", quantity="stiffness [MN/m]",
         compute=dowel_closed_form, tolerance=1e-5),
    Case(name="dowel-strength", what="dowel strength", source="johansen", quantity="shear [kN]",
         compute=dowel_strength, tolerance=1e-9),
)  # fmt: skip
