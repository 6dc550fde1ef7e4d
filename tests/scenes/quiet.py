"""Blocks with quiet boundaries: a column through which a wave goes, and blocks on a base that is quiet."""

from __future__ import annotations

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY
from tests.scenes.models import GAMMA, model_of
from tests.scenes.shaken import STAGE
from tests.scenes.shapes import rectangle

DENSITY = 2600.0
MODULI = {0: 10e9, 90: 30e9}  # Pa, of waves that move blocks along x and along y


def column(
    direction, count=100, *, quiet=("bottom", "top"), amplitude=0.01, wavelength=40.0, length=3.9, joint=None, **given
):
    """Return a column of rigid cubes of 1 m on springs, and the speed of its waves; one enters below.

    A wavelength has so many blocks. It is followed as long as a wave takes for `length` columns. `joint`: stiffness
    [Pa/m] of a joint in every so many faces, in series with the rock.
    """
    modulus = MODULI[direction]
    stiffness, every = joint or (np.inf, 1)
    jointed = 1 / (1 / modulus + 1 / stiffness)
    speed = np.sqrt(1 / (1 / modulus + 1 / (stiffness * every)) / DENSITY)
    blocks = bsm.Blocks.from_polygons([rectangle(0, k, 1, k + 1) for k in range(count)], rock="rock")
    blocks = blocks.with_boundary("sides", lambda x, y: np.minimum(x, 1 - x) < 1e-6)
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-6)
    blocks = blocks.with_boundary("top", lambda x, y: y > count - 1e-6)
    blocks = blocks.with_joint("K", lambda x, y: np.abs(y / every - np.round(y / every)) < 1e-6)
    duration = length * count / speed
    usual = {"quantity": "velocity", "every": duration / max(20, 8 * count)}
    shaking = bsm.Shaking(
        waveform="ricker", frequency=speed / wavelength, amplitude=amplitude, direction=direction, quiet=quiet,
        boundary="bottom", duration=duration, **{**usual, **given},
    )  # fmt: skip
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=DENSITY * GRAVITY)],
        joints=[bsm.Joint("J", modulus, modulus), bsm.Joint("K", jointed, jointed)],
        default_joint="J",
        supports=[
            *(bsm.Fixed(boundary=name) for name in quiet),
            bsm.Roller(boundary="sides", direction=90 - direction),
        ],
        in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": -1e6}),
        gravity_vertical=1.0,  # no weights
        stages=[bsm.Stage(name="wave", shaking=shaking)],
        histories=[bsm.History(name="middle", block=count // 2)],
    )
    return model, speed


def velocities(results, name):
    """Return times and velocities of a history while blocks are shaken: means between two times."""
    steps = [step for stage in results.stages for step in stage.steps]
    shaken = np.array([step.time is not None for step in steps])
    time = np.append(0.0, [step.time for step in steps if step.time is not None])
    moved = np.append(0.0, np.asarray(results.histories["middle"][name])[shaken])
    return (time[1:] + time[:-1]) / 2, np.diff(moved) / np.diff(time)


def reflected(angle, kind, *, poisson=0.25, dashpots=1.0):
    """Return amplitudes and energies of what a plane boundary sends back of a plane wave in elastic rock.

    Its dashpots are ``dashpots`` times ``rho c_p`` across and ``rho c_s`` along it (Lysmer and Kuhlemeyer 1969). A wave
    with displacement d and slowness s has the stress ``-(lambda (d s) I + mu (d s^T + s d^T))`` times its velocity.
    With both reflected waves that is ``-rho (c_p v_n, c_s v_t)`` at the boundary.

    Parameters
    ----------
    angle : float [degrees]
        Between the wave and the boundary's normal.
    kind : {"p", "s"}
        Of the wave.

    Returns
    -------
    amplitudes : (2,) complex
        Of the reflected pressure and shear wave, over that of the wave.
    energies : (2,) float
        Their energies over the wave's, per length of the boundary.
    """
    p, s = 1.0, np.sqrt((1 - 2 * poisson) / (2 - 2 * poisson))  # speeds; density 1, so mu is s^2
    along = np.sin(np.radians(angle)) / (p if kind == "p" else s)
    across = [np.sqrt(complex(1 / speed**2 - along**2)) for speed in (p, s)]  # beyond the critical angle it fades
    ways = {"p": (along * p, across[0] * p), "s": (across[1] * s, -along * s)}

    def pulls(moved, slowness):
        """Return stress and dashpots' force over velocity, along and across the boundary."""
        moved, slowness = np.array(moved), np.array(slowness)
        spread = (p**2 - 2 * s**2) * (moved @ slowness)
        stress = -np.array([s**2 * (moved[0] * slowness[1] + moved[1] * slowness[0]),
                            spread + 2 * s**2 * moved[1] * slowness[1]])  # fmt: skip
        return stress + dashpots * np.array([s, p]) * moved

    comes = pulls(ways[kind], (along, across[0 if kind == "p" else 1]))
    back = [pulls((ways["p"][0], -ways["p"][1]), (along, -across[0])),
            pulls((ways["s"][0], -ways["s"][1]), (along, -across[1]))]  # fmt: skip
    amplitudes = np.linalg.solve(np.column_stack(back), -comes)
    flows = [speed**2 * one.real for speed, one in zip((p, s), across, strict=True)]
    return amplitudes, np.abs(amplitudes) ** 2 * flows / flows[0 if kind == "p" else 1]


def on_quiet_base(friction=40.0, amplitude=0.2, **given):
    """Return two blocks on a base of two, which a wave enters from below along x."""
    polygons = [rectangle(-3, -1, 1, 0), rectangle(1, -1, 4, 0), rectangle(0, 0, 2, 0.5), rectangle(0, 0.5, 2, 1)]
    shaking = bsm.Shaking(
        waveform="sine", frequency=20.0, cycles=4, amplitude=amplitude, quantity="velocity", quiet=["bottom"],
        boundary="bottom", **{"every": 0.02, "duration": 0.4, **given},
    )  # fmt: skip
    model = model_of(polygons, friction=friction, gamma=GAMMA)
    return model.replace(
        blocks=model.blocks.with_boundary("bottom", lambda x, y: y < -1 + 1e-6),
        supports=[bsm.Fixed(boundary="bottom")],
        stages=[bsm.Stage(name=STAGE, shaking=shaking)],
        histories=[bsm.History(name="base", block=0), bsm.History(name="b", block=3)],
    )
