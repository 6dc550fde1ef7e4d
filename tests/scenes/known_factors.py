"""Models whose factors of safety are known: closed forms, limit analysis, published ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray
from tests.scenes.models import model_of
from tests.scenes.plane_failure import PlaneFailure, hoek_and_bray, sau_mau_ping
from tests.scenes.shapes import rectangle, turned


@dataclass(frozen=True)
class Known:
    """A model whose factor of safety is known.

    Attributes
    ----------
    name : str
        What it is.
    source : str
        Who says so: a key of `verification.sources.SOURCES`.
    factor : float
        Known factor.
    build : callable
        Returns the model.
    joints : tuple of str or None
        Joints whose strength is divided; None: all.
    at_bound : bool
        Whether the bound of limit analysis is that factor; else it lies above.
    """

    name: str
    source: str
    factor: float
    build: Callable[[], bsm.Model]
    joints: tuple[str, ...] | None = None
    at_bound: bool = True


LEAST_FRICTION = {(0.12, 20): 0.3825, (0.12, 30): 0.3819, (0.20, 30): 0.3090}
"""Least coefficients of friction of semicircular arches, by thickness over radius and voussoirs: limit analysis."""

TOPPLING = 0.7855
"""Coefficient of friction at the limit of Goodman & Bray's slope (1976), as in Wyllie & Mah (2004), chapter 9."""


def tan(degrees: float) -> float:
    """Return the tangent of an angle in degrees."""
    return float(np.tan(np.radians(degrees)))


def incline(friction: float, dip: float) -> bsm.Model:
    """Return a flat block on a plane: it slides at tan(friction) = tan(dip)."""
    polygons = [turned(p, dip) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5))]
    return model_of(polygons, friction=friction, kn=1e10)


def arch(ratio: float, n: int, friction: float) -> bsm.Model:
    """Return a semicircular arch of n voussoirs, its thickness over its radius given, between fixed springings."""
    angles = np.linspace(0, np.pi, n + 1)
    inner, outer = (r * np.column_stack([np.cos(angles), np.sin(angles)]) for r in (1 - ratio / 2, 1 + ratio / 2))
    stones = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(n)]
    feet = [rectangle(x - 0.5, -0.5, x + 0.5, 0.0) for x in (1.0, -1.0)]
    return model_of([*feet, *stones], friction=friction, kn=1e12, fixed=(0, 1), gamma=25e3)


@dataclass(frozen=True, kw_only=True)
class RoofPrism:
    """A symmetric triangular prism in a roof, apex upwards, that a horizontal stress holds between its joints.

    Bray (1977), in Brady & Brown, Rock Mechanics for Underground Mining, section 9.5, with the joints' deformation. The
    field presses each face by ``H cos(a)`` and holds it up by ``H sin(a)``, H its horizontal force on a side, a the
    half angle at the apex. The weight W then moves the prism down by u: a face of length l opens by ``u sin(a)`` and
    slides by ``u cos(a)``, so that the joint's pressure falls while its shear grows:

        N = H cos(a) - kn l u sin(a),  S = H sin(a) + ks l u cos(a),  2 (S cos(a) - N sin(a)) = W

    It slides where S = N tan(phi): u and N follow, and the greatest weight. Statics alone lets the rock press the prism
    as it likes, and finds no limit but phi = a.

    Attributes
    ----------
    apex : float
        Half the angle at the apex [degrees].
    stress : float
        Of the field, horizontal [Pa].
    kn, ks : float
        Stiffness of the joints [Pa/m].
    friction : float
        Of the joints [degrees].
    height : float
        Of the prism [m].
    gamma : float
        Unit weight of the rock [N/m3].
    """

    apex: float
    stress: float
    kn: float
    ks: float
    friction: float = 45.0
    height: float = 4.0
    gamma: float = 25e3

    @property
    def factor(self) -> float:
        """By what tan(friction) is divided where the greatest weight, linear in tan(phi) over the same, is W.

        With x = tan(phi): W (ks cos(a) + kn sin(a) x) = 2 H (ks cos(a)^2 + kn sin(a)^2) (cos(a) x - sin(a)).
        """
        a = np.radians(self.apex)
        weight = self.gamma * self.height**2 * np.tan(a)
        holds = 2 * self.stress * self.height * (self.ks * np.cos(a) ** 2 + self.kn * np.sin(a) ** 2)
        least = (weight * self.ks * np.cos(a) + holds * np.sin(a)) / (holds * np.cos(a) - weight * self.kn * np.sin(a))
        return float(tan(self.friction) / least)

    def model(self, *, dug: bool = False) -> bsm.Model:
        """Return the prism between fixed rock, or, `dug`, on the rock of an opening that a stage takes away."""
        half, side = self.height * tan(self.apex), 2 * self.height
        left = np.array([(-side, 0), (-half, 0), (0, self.height), (-side, self.height)])
        polygons = [left, left[::-1] * (-1, 1), np.array([(-half, 0), (half, 0), (0, self.height)])]
        below = [rectangle(-half, -1, half, 0)] if dug else []
        return bsm.Model(
            blocks=bsm.Blocks.from_polygons([*polygons, *below], rock="rock"),
            rocks=[bsm.Rock("rock", unit_weight=self.gamma)],
            joints=[bsm.Joint("J", self.kn, self.ks, law=bsm.MohrCoulomb(friction=self.friction))],
            default_joint="J",
            supports=[bsm.Fixed(blocks=[0, 1, *([3] if dug else [])])],
            in_situ=bsm.InSitu(stress={"xx": -self.stress, "yy": 0.0, "xy": 0.0}),
            stages=[bsm.Stage(name="dig", excavate=(3,))] if dug else [],
        )


def tutorial_slope(friction: float, *, excavate: tuple[int, ...] = (1,)) -> bsm.Model:
    """Return the slope of UDEC's tutorial: block 1, on the left, is excavated; 2 and 3, on it, may slide.

    The crack under the top block falls by .4, that under the lower one by .3.
    """
    lower, upper = (2 + 0.3 * np.array([0.0, 5.0, 20.0])), (12 + 0.4 * np.array([0.0, 15.0]))
    polygons = [
        [(0, 0), (20, 0), (20, lower[2]), (5, lower[1]), (0, lower[0])],
        [(0, lower[0]), (5, lower[1]), (5, upper[0]), (5, 20), (0, 20)],
        [(5, lower[1]), (20, lower[2]), (20, upper[1]), (5, upper[0])],
        [(5, upper[0]), (20, upper[1]), (20, 20), (5, 20)],
    ]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([np.array(p, dtype=float) for p in polygons], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=20e3)],
        joints=[bsm.Joint("J", 1.33e7, 1.33e7, law=bsm.MohrCoulomb(friction=friction))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0, 1])],
        stages=[bsm.Stage(name="dig", excavate=excavate)],
    )


def goodman_and_bray(friction: float) -> bsm.Model:
    """Return sixteen columns that topple off a stepped base: 10 m wide, 4 to 40 m high, leaning at 60 degrees."""
    n = np.arange(1, 17)
    return columns(np.where(n <= 10, 4.0 * n, 40.0 - 6.2 * (n - 10)), 1.0, 30.0, friction)


def columns(height: FloatArray, step: float, lean: float, friction: float) -> bsm.Model:
    """Return columns 10 m wide on a base with steps [m], from the toe on, all turned by `lean` [degrees]."""
    m = len(height)
    beside = [rectangle(10.0 * k, step * k, 10.0 * (k + 1), step * k + h) for k, h in enumerate(height)]
    profile = [(0.0, -30.0), (10.0 * m, -30.0), (10.0 * m, step * (m - 1))]
    for k in range(m - 1, 0, -1):
        profile += [(10.0 * k, step * k), (10.0 * k, step * (k - 1))]
    base = np.array([*profile, (0.0, 0.0)])
    return model_of([turned(p, lean) for p in (base, *beside)], friction=friction, kn=1e11, gamma=25e3)


def known() -> Iterator[Known]:
    """Return what is known, none of it built yet."""
    name = "block on a plane of 30 degrees, friction 40"
    yield Known(name, "statics", tan(40) / tan(30), partial(incline, 40.0, 30.0))
    for zw, cohesion in ((0.0, 25e3), (3.0, 25e3), (0.0, 0.0), (3.0, 0.0)):
        yield _plane_failure("plane failure, Hoek & Bray", "hoek-bray", hoek_and_bray(zw=zw, cohesion=cohesion))
    for zw, cohesion, shaken in ((0.0, 100e3, 0.0), (7.0, 100e3, 0.0), (7.0, 0.0, 0.0), (0.0, 100e3, 0.1)):
        case = sau_mau_ping(zw=zw, cohesion=cohesion, horizontal=shaken)
        yield _plane_failure("Sau Mau Ping Road", "hoek", case)
    for (ratio, n), least in LEAST_FRICTION.items():
        name = f"arch of {n} stones, thickness {ratio:g} of the radius, friction 35"
        yield Known(name, "arches", tan(35) / least, partial(arch, ratio, n, 35.0))
    for apex, stress, kn, ks in ((30.0, 0.3e6, 1e10, 1e9), (30.0, 0.3e6, 1e10, 1e10), (20.0, 1e6, 1e10, 5e9)):
        prism = RoofPrism(apex=apex, stress=stress, kn=kn, ks=ks)
        name = f"roof prism, Bray, apex {2 * apex:g}, {stress / 1e6:g} MPa, kn / ks {kn / ks:g}, friction 45"
        yield Known(name, "bray", prism.factor, prism.model, at_bound=False)
    name = "UDEC's tutorial slope, friction 20: top block"
    yield Known(name, "statics", tan(20) / 0.4, partial(tutorial_slope, 20.0))
    lower = partial(tutorial_slope, 20.0, excavate=(1, 3))
    yield Known("the same without the top block: lower block", "statics", tan(20) / 0.3, lower)
    name = "toppling, Goodman & Bray, friction 42"
    yield Known(name, "goodman-bray", tan(42) / TOPPLING, partial(goodman_and_bray, 42.0), at_bound=False)


def _plane_failure(where: str, source: str, case: PlaneFailure) -> Known:
    water = f"{case.zw:g} m of water in the crack" if case.zw else "dry"
    shaken = f", {case.horizontal:g} g out of the slope" if case.horizontal else ""
    name = f"{where}, {water}, {'cohesion' if case.cohesion else 'no cohesion'}{shaken}"
    return Known(name, source, case.factor, case.model, ("J",))
