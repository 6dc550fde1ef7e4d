"""Models that are shaken: a block on a plane, a rocking block that is released, a wall of bricks."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

import bsm_mesh as bsm
from bsm_mesh.contact.history import commit
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.movements import turned
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.continuation.shaken import ShakenContinuation
from bsm_mesh.solve.motion.motion import Start
from tests.scenes.models import GAMMA, model_of
from tests.scenes.shapes import rectangle, running_bond

LAWS = {
    "mohr_coulomb": {"law": bsm.MohrCoulomb(friction=35, cohesion=2e4)},
    "softening": {"law": bsm.MohrCoulomb(friction=40, residual_friction=25, softening_slip=5e-3)},
    "patton": {"law": bsm.Patton(friction=30, dilation=10, cohesion=1e5)},
    "barton_bandis": {"law": bsm.BartonBandis(residual_friction=28, jrc=8, jcs=80e6)},
    "closure": {"law": bsm.MohrCoulomb(friction=35), "max_closure": 1e-3},
    "growing": {"law": bsm.MohrCoulomb(friction=35), "shear_stiffness_exponent": 0.5, "reference_stress": 5e4},
    "dilation": {"law": bsm.MohrCoulomb(friction=30), "dilation_angle": 8.0, "dilation_slip": 5e-3},
    "tension": {"law": bsm.MohrCoulomb(friction=35, cohesion=1e4), "tensile_strength": 5e3},
    "ladanyi_archambault": {"law": bsm.LadanyiArchambault(friction=28, dilation=10, jcs=80e6)},
}
QUIET = {"waveform": "pulse", "frequency": 1.0, "amplitude": 0.0}
STAGE = "earthquake"


def shaken(polygons, shaking, **given):
    """Return a model of blocks that are shaken, the first of them fixed."""
    return model_of(polygons, stages=[bsm.Stage(name=STAGE, shaking=shaking)], **given)


def block_on_plane(shaking, *, friction, kn=1e9, gamma=GAMMA, **given):
    """Return a block of 1 m by 0.5 m on a wide one."""
    polygons = [rectangle(-5, -1, 5, 0), rectangle(-0.5, 0, 0.5, 0.5)]
    return shaken(polygons, shaking, friction=np.degrees(np.arctan(friction)), kn=kn, gamma=gamma, **given)


def wall(shaking, courses=5, bricks=5, **given):
    """Return a wall of bricks in running bond on a base."""
    return shaken([rectangle(-2, -1, bricks + 2, 0), *running_bond(courses, bricks)], shaking, **given)


def slide_under_a_sine(a, slows):
    """Return swing [m] and greatest velocity [m/s] of a block on a base that moves with a sin t [m/s2].

    It sticks until a sin t exceeds mu g, then slides with v = a (cos t1 - cos t) - mu g (t - t1) to where v = 0.
    """
    begins = np.arcsin(slows / a)

    def speed(t):
        return a * (np.cos(begins) - np.cos(t)) - slows * (t - begins)

    ends = brentq(speed, begins + 0.05, begins + 2)
    return quad(speed, begins, ends)[0], speed(np.linspace(begins, ends, 10_001)).max()


def housners_quarter(b, h, begin):
    """Return the time [s] in which a block of half width b, half height h falls back from a tilt [rad].

    w'^2 / 2 = p^2 (cos(a - w0) - cos(a - w)), p^2 = 3 g / (4 R).
    """
    alpha, p2 = np.arctan2(b, h), 3 * GRAVITY / (4 * np.hypot(b, h))

    def slowness(s):  # with w = w0 - s^2 the root at the start is no more
        return 2 * s / np.sqrt(2 * p2 * (np.cos(alpha - begin) - np.cos(alpha - begin + s**2)))

    return quad(slowness, 0, np.sqrt(begin))[0]


def quake(peak, length, frequency=2.0):
    """Return a record of a sine that grows for a second and fades for another: times, accelerations [m/s2]."""
    time = np.linspace(0.0, length, int(200 * length) + 1)
    envelope = np.minimum(1.0, np.minimum(time, length - time))
    return time, peak * envelope * np.sin(2 * np.pi * frequency * time)


def rocking(half_width, half_height, tilt, shaking, kn=1e9, **given):
    """Return times and turns of a block that is let go at a tilt [rad], and the loop at its end."""
    b, h = half_width, half_height
    polygons = [rectangle(-3, -1, 3, 0), rectangle(-b, 0, b, 2 * h)]
    model = model_of(polygons, friction=np.degrees(np.arctan(5.0)), kn=kn, **given)
    rest = Continuation(model, bsm.Options(), lambda *_: None)
    motion = rest.run()
    history, _ = commit(motion.contacts, motion.at, motion.position, rest.system.outlines.size)
    arm, corner = np.array([-b, h]), np.array([b, 0.0])
    position = motion.position.copy()
    position[1, :2] = corner + turned(arm[None], np.array([-tilt]))[0] - [0.0, h]
    position[1, 1] -= model.weights[1] / (kn * b)  # on one corner
    position[1, 2] = -tilt
    found = []

    def watch(record, motion):
        if record.time is not None:
            found.append((record.time, motion().position[1, 2]))

    start = Start(position=position, history=history, intact=False, bolts=InstalledBolts.of(model, position))
    nobody = np.zeros(0, np.int64)
    loop = ShakenContinuation(model, bsm.Options(), watch, start, shaking=shaking, quiet=nobody)
    loop.run()
    return *np.array(found).T, loop


def quarter(time, turn):
    """Return when a turn is first zero [s]."""
    k = int(np.flatnonzero(np.sign(turn[1:]) != np.sign(turn[:-1]))[0])
    return time[k] - turn[k] * (time[k + 1] - time[k]) / (turn[k + 1] - turn[k])


def swings(time, turn, count):
    """Return the greatest turns [rad] after each of the first impacts of a rocking block, so many at most."""
    through = time[np.flatnonzero(np.sign(turn[1:]) != np.sign(turn[:-1]))]
    impacts = through[np.insert(np.diff(through) > 0.1, 0, True)][: count + 1]
    return np.array([np.abs(turn[(time > begin) & (time < end)]).max() for begin, end in pairwise(impacts)])


def housners_swings(angle, begin, count):
    """Return the same of Housner's block (1963) that is let go at `begin` and is on edge at `angle` [rad].

    The rate of turn after an impact is r = 1 - 3/2 sin^2 a of that before, so the depth of the centre below its highest
    place falls by r^2. No angle is taken as small: at 27 degrees Housner's own linear form is .8 % lower.
    """
    kept = (1 - 1.5 * np.sin(angle) ** 2) ** (2 * np.arange(1, count + 1))
    return angle - np.arccos(np.cos(angle) + kept * (np.cos(angle - begin) - np.cos(angle)))
