"""Blocks with zones that are shaken, some with answers in closed form."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.model.options import Options
from bsm_mesh.results.evidence import Proof
from bsm_mesh.solve.stages.scheme import Watchers
from bsm_mesh.solve.zones.scheme import ZoneStages
from bsm_mesh.solve.zones.shaken_stage import in_motion
from bsm_mesh.solve.zones.supports import nodal_unknowns
from tests.scenes.shaken import quake
from tests.scenes.shapes import rectangle, turned

STAGE = "earthquake"
STILL = bsm.Shaking(waveform="pulse", frequency=1.0, amplitude=0.0, duration=0.1)
WEIGHT = 25e3  # N/m3
PILE = [rectangle(-2, -1, 3, 0), rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1), rectangle(0.2, 1, 1.2, 2)]


def shaken_zones(polygons, shaking, *, joint=None, young=1e10, poisson=0.2, degrees=0.0, rock=None, **given):
    """Return a model of blocks with zones, the first of them fixed, that are shaken; everything turned."""
    zones = given.pop("zones", None) or bsm.Zones(size=0.5, displacement="large")
    if degrees:
        given["gravity_direction"] = degrees - 90.0
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([turned(polygon, degrees) for polygon in polygons], rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=WEIGHT, young=young, poisson=poisson, zones=zones, **(rock or {}))],
        joints=[joint or bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=35.0))],
        default_joint="J",
        supports=given.pop("supports", [bsm.Fixed(blocks=[0])]),
        stages=[*given.pop("before", ()), bsm.Stage(name=STAGE, shaking=shaking)],
        **given,
    )


def bar(shaking, length, pieces, *, zones, young, weight=WEIGHT, **given):
    """Return a bar without Poisson's ratio, 1 m wide and held at its foot, cut into pieces without joints."""
    cuts = np.linspace(0.0, length, pieces + 1)
    blocks = bsm.Blocks.from_polygons([rectangle(0, a, 1, b) for a, b in pairwise(cuts)], rock="rock").with_boundary(
        "foot", lambda x, y: np.abs(y) < 1e-9
    )
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=weight, young=young, poisson=0.0, zones=zones)],
        supports=[bsm.Fixed(boundary="foot")],
        stages=[bsm.Stage(name=STAGE, shaking=shaking)],
        **given,
    )


def started(order, high=10.0, young=1e8, a=0.1):
    """Return the upper half of a bar on a base that starts: its displacement over time, the exact one, and the stage.

    It is -sum 4 a / (pi (2 n + 1)) sin(k z) (1 - cos(w t)) / w^2, k = (2 n + 1) pi / (2 H), w = k c.
    """
    start = bsm.Shaking(
        waveform="pulse", frequency=1.0, cycles=0.3, amplitude=a, direction=90.0, duration=0.5, every=0.01
    )
    zones, history = bsm.Zones(size=0.4 * order, order=order), bsm.History(name="upper", block=1)
    results = bsm.run(bar(start, high, 2, zones=zones, young=young, histories=[history]))
    stage = results.stages[-1]
    during = stage.shaking.time <= 0.3
    k = (2 * np.arange(400) + 1) * np.pi / (2 * high)
    upper = (np.cos(k * high / 2) - np.cos(k * high)) / (k * high / 2)
    w = k * np.sqrt(young * GRAVITY / WEIGHT)
    exact = ((1 - np.cos(np.outer(stage.shaking.time[during], w))) * (-2 * a / (k * high) * upper / w**2)).sum(axis=1)
    v = results.histories["upper"]["v"]
    return (v - v[0])[:-1][during], exact, stage


def column(direction, *, joint=None, count=15, high=4.0, wavelength=40.0, length=2.6, zones=None, **given):
    """Return a column of rock between quiet ends, through which a wave goes from below, its speed and its density.

    Parameters
    ----------
    direction : float [degrees]
        In which the wave moves the rock: 0, 90.
    joint : tuple of float, optional
        Stiffness [Pa/m] of a joint across the column, and its height [m].
    length : float
        How long it is followed, over the time in which the wave goes through the column.
    """
    young, poisson, density = 26e9, 0.25, 2600.0
    shear = young / 2 / (1 + poisson)
    speed = np.sqrt((shear if direction == 0 else shear * 2 * (1 - poisson) / (1 - 2 * poisson)) / density)
    top = count * high
    blocks = bsm.Blocks.from_polygons([rectangle(0, k * high, 1, (k + 1) * high) for k in range(count)], rock="rock")
    for name, where in {
        "sides": lambda x, y: np.minimum(x, 1 - x) < 1e-6,
        "bottom": lambda x, y: y < 1e-6,
        "top": lambda x, y: y > top - 1e-6,
    }.items():
        blocks = blocks.with_boundary(name, where)
    joints = []
    if joint is not None:
        blocks = blocks.with_joint("J", lambda x, y: np.abs(y - joint[1]) < 1e-6)
        joints = [bsm.Joint("J", joint[0], joint[0])]
    duration = length * top / speed
    shaking = bsm.Shaking(
        waveform="ricker", frequency=speed / wavelength, amplitude=0.01, direction=direction, quantity="velocity",
        quiet=("bottom", "top"), boundary="bottom", duration=duration, every=duration / 200,
    )  # fmt: skip
    zones = zones or bsm.Zones(size=1.1)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=density * GRAVITY, young=young, poisson=poisson, zones=zones)],
        joints=joints,
        supports=[
            *(bsm.Fixed(boundary=name) for name in ("bottom", "top")),
            bsm.Roller(boundary="sides", direction=90 - direction),
        ],
        in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": -1e6}),
        gravity_vertical=1.0,  # no weights
        stages=[bsm.Stage(name=STAGE, shaking=shaking)],
        histories=[bsm.History(name="middle", block=count // 2)],
        **given,
    )
    return model, speed, density


def passed(speed):
    """Return when a wave of a column has gone through its middle [s]."""
    return (30 + 3 * 40 + 4) / speed


def through_a_joint(model, time, stiffness, speed, density):
    """Return the velocity at times in the middle of a column that a wave has reached through a joint.

    Z / (2 k) dv/dt + v = v of the wave that comes: both sides have the same stress (Pyrak-Nolte et al. 1990). The
    history is the mean of a block of 4 m.
    """
    base = BaseMotion(model.stages[-1].shaking)

    def rate(t, v):
        return 2 * stiffness / (density * speed) * (base.velocity_at(np.array([t - 30 / speed]))[0] - v)

    over = solve_ivp(rate, (0, time[-1]), [0.0], rtol=1e-8, atol=1e-12, max_step=1e-4)
    within = np.linspace(-2, 2, 41) / speed
    return np.interp(time[:, None] + within, over.t, over.y[0]).mean(axis=1)


def stack(zones=None):
    """Return a stack of two blocks on a base that slide; rigid ones without `zones`."""
    polygons = [rectangle(-2, -1, 3, 0), rectangle(0, 0, 1, 0.5), rectangle(0.1, 0.5, 0.9, 1.0)]
    joint = bsm.Joint("J", 1e8, 1e8, law=bsm.MohrCoulomb(friction=10.0))
    shaking = bsm.Shaking(record=quake(5.0, 2.0), every=0.5, contact_damping=0.2)
    model = shaken_zones(polygons, shaking, joint=joint, young=5e9, poisson=0.0, zones=zones)
    return model if zones else model.replace(rocks=[bsm.Rock("rock", unit_weight=WEIGHT)])


def newmarks_block(**given):
    """Return Newmark's block: half of gravity acts for .3 s, friction is .2; and how far it slides [m]."""
    a, slows, t0 = 0.5 * GRAVITY, 0.2 * GRAVITY, 0.3
    pulse = bsm.Shaking(waveform="pulse", frequency=1, cycles=t0, amplitude=a, duration=1.0, **given.pop("how", {}))
    joint = bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=float(np.degrees(np.arctan(0.2)))))
    model = shaken_zones([rectangle(-2, -1, 1, 0), rectangle(-0.5, 0, 0.5, 0.5)], pulse, joint=joint, **given)
    return model, (a - slows) * t0**2 / 2 * a / slows


def unwatched(model):
    """Return the stages of a model with zones, without anything that looks at them."""
    watchers = Watchers(lambda *_: None, lambda _: (), lambda *_: Proof(text="not sought"), lambda _: ())
    return ZoneStages(model, Options(), watchers)


def at_displacements(model, u):
    """Return the blocks of a model of one shaken stage in motion, from displacements that `u` returns of places."""
    stages = unwatched(model)
    run, of = stages._run, stages._continuum
    run.end_of(0)
    present, shaking = of.presence[0], model.stages[-1].shaking
    nodes = nodal_unknowns(of.basis)
    block = np.zeros(len(nodes), dtype=np.int64)
    block[of.mesh.mesh.t] = of.mesh.block
    moved = run.state.u.copy()
    moved[nodes] += u(of.basis.doflocs[:, nodes[:, 0]].T, block)
    loads = run.loads_on(present)
    run.state.u = run.equations(present, loads).free.fulfilled(moved)
    return in_motion(run, shaking, present, loads)
