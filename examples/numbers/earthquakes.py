"""What each kind of damping does to a rocking block, and to the energies of a wall that is shaken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import quad

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Integrator
from bsm_mesh.results.shaking import ENERGIES
from examples.numbers.pages import Table, markdown
from examples.numbers.runs import load
from examples.numbers.safety import starter
from tests.scenes.models import GAMMA
from tests.scenes.quiet import DENSITY, MODULI, column, reflected, velocities
from tests.scenes.shaken import QUIET, block_on_plane, housners_swings, quake, quarter, rocking, swings, wall

DAMPINGS = (0.0, 0.2, "housner")
SLENDERNESS, SWINGS, MEMBERS = (2, 4, 8), 2, 12
FAMILY = {"slenderness": (1.5, 8.0), "height": (0.5, 4.0), "stiffness": (1e9, 3e10), "tilt": (0.25, 0.75)}
OF_A_WALL: dict[str, dict[str, object]] = {
    "none": {},
    "`contact_damping = 0.2`": {"contact_damping": 0.2},
    '`contact_damping = "housner"`': {"contact_damping": "housner"},
    "`mass_damping = { ratio = 0.02, frequency = 2 }`": {"mass_damping": (0.02, 2.0)},
}


@dataclass(frozen=True, kw_only=True)
class Block:
    """A block that is let go: height over width, height [m], joint stiffness [Pa/m], part of its angle on edge."""

    slenderness: float
    height: float = 2.0
    stiffness: float = 4e9
    tilt: float = 0.5

    @property
    def angle(self) -> float:
        """The angle at which it is on edge [rad]."""
        return float(np.arctan2(1.0, self.slenderness))

    @property
    def lifts(self) -> float:
        """The turn at which an edge lifts off its joint, over the angle on edge: how soft the joint is."""
        half_width = self.height / self.slenderness / 2
        sinks = GAMMA * self.height / self.stiffness  # at rest, by its weight
        return sinks / half_width / self.angle


def swings_of(block: Block, damping: float | str) -> FloatArray:
    """Return the first swings after impacts of a block, over the angle at which it is on edge."""
    half_height = block.height / 2
    length = 9 * np.sqrt(4 * half_height / np.cos(block.angle) / (3 * GRAVITY))  # two swings from three quarters on
    shaking = bsm.Shaking(**QUIET, cycles=length, every=2e-3, contact_damping=damping)
    time, turn, _ = rocking(
        half_height / block.slenderness, half_height, block.tilt * block.angle, shaking, kn=block.stiffness
    )
    found: FloatArray = swings(time, turn, SWINGS) / block.angle
    return found


def swings_of_housner(block: Block) -> FloatArray:
    """Return the same by Housner (1963), without small angles."""
    found: FloatArray = housners_swings(block.angle, block.tilt * block.angle, SWINGS) / block.angle
    return found


def rocking_by_damping() -> str:
    """Return a row for every slenderness: swings by damping, and those of Housner."""
    rows = []
    for slenderness in SLENDERNESS:
        block = Block(slenderness=slenderness)
        found = [swings_of(block, damping) for damping in DAMPINGS] + [swings_of_housner(block)]
        rows += [
            (str(slenderness), str(k + 1), *("-" if len(one) <= k else f"{one[k]:.4f}" for one in found))
            for k in range(SWINGS)
        ]
    names = [f"`{damping}`" if isinstance(damping, float) else f'`"{damping}"`' for damping in DAMPINGS]
    return markdown(("height over width", "swing", *names, "Housner (1963)"), rows)


def random_rocking() -> str:
    """Return a row for every block of a random family: errors of its swings on critical dashpots, and Housner's."""
    random = np.random.default_rng(5963)
    blocks = [
        Block(
            slenderness=float(np.exp(random.uniform(*np.log(FAMILY["slenderness"])))),
            height=float(np.exp(random.uniform(*np.log(FAMILY["height"])))),
            stiffness=float(np.exp(random.uniform(*np.log(FAMILY["stiffness"])))),
            tilt=float(random.uniform(*FAMILY["tilt"])),
        )
        for _ in range(MEMBERS)
    ]
    rows = []
    for block in sorted(blocks, key=lambda block: block.lifts):
        exact = swings_of_housner(block)
        errors = [100 * (swings_of(block, damping) / exact - 1) for damping in (1.0, "housner")]
        given = f"{block.slenderness:.2f}", f"{block.height:.2f}", f"{block.stiffness / 1e9:.1f}", f"{block.tilt:.2f}"
        rows.append((*given, f"{1000 * block.lifts:.2f}", *(f"{one[k]:.2f}" for one in errors for k in range(SWINGS))))
    header = ("height over width", "height, m", "joint, GPa/m", "let go at", "lifts at, 1/1000")
    header += ("`1`: swing 1, %", "swing 2, %", '`"housner"`: swing 1, %', "swing 2, %")
    return markdown(header, rows)


def energies_by_damping() -> str:
    """Return a row for every damping: energies of a wall after a record of 0.3 g, greatest and left movement."""
    shaking = bsm.Shaking(record=quake(3.0, 5.0), every=0.05)
    rows = []
    for name, given in OF_A_WALL.items():
        stage = bsm.run(wall(replace(shaking, **given), courses=8, bricks=2)).stages[-1]
        found = stage.shaking
        assert found is not None
        energy = dict(zip(ENERGIES, found.energy[-1].tolist(), strict=True))
        taken = [f"{energy[part]:.0f}" for part in ("input", "slip", "dashpots", "mass_damping")]
        moved = f"{1000 * stage.max_stage_displacement:.2f}"
        rows.append((name, *taken, f"{100 * found.imbalance:.1g}", f"{found.peak_velocity.max():.3f}", moved))
    header = (
        "damping",
        "input, J/m",
        "slip",
        "dashpots",
        "mass damping",
        "error, %",
        "greatest velocity, m/s",
        "left, mm",
    )
    return markdown(header, rows)


def by_integrator() -> str:
    """Return a row for every case and integrator: the answer, its error, time steps."""
    rows = [_row("Newmark's block, sliding, m", newmark_block, 4)]
    rows += [_row("Housner's block, first quarter, s", quarter_of_a_swing, 5)]
    rows += [_row("free vibration, energy over its mean, greatest less least", vibration, 1)]
    rows += [_row("wall of 16 bricks at 0.4 g, rms movement, mm", small_wall, 3)]
    return markdown(("case", "closed form", "explicit", "implicit", "steps", "implicit steps"), rows)


def _row(name: str, case: Callable[[Integrator], tuple[float | None, float, int]], digits: int) -> tuple[str, ...]:
    exact, explicit, steps = case("explicit")
    _, implicit, implicit_steps = case("implicit")
    form = ".0e" if digits == 1 else f".{digits}f"
    values = ["-" if value is None else f"{value:{form}}" for value in (exact, explicit, implicit)]
    return name, *values, str(steps), str(implicit_steps)


def newmark_block(integrator: Integrator) -> tuple[float | None, float, int]:
    """Return the sliding of Newmark's block by formula and by an integrator [m], and its steps."""
    a, slows, t0 = 0.5 * GRAVITY, 0.2 * GRAVITY, 0.3
    pulse = bsm.Shaking(waveform="pulse", frequency=1, cycles=t0, amplitude=a, duration=0.9, every=0.01)
    stage = bsm.run(block_on_plane(_by(pulse, integrator, 0.1), friction=0.2, kn=1e10)).stages[-1]
    assert stage.shaking is not None
    return (a - slows) * t0**2 / 2 * a / slows, -float(stage.stage_displacement[1, 0]), stage.shaking.cycles


def quarter_of_a_swing(integrator: Integrator) -> tuple[float | None, float, int]:
    """Return the first quarter period of Housner's block by formula and by an integrator [s], and its steps."""
    b, h = 0.25, 1.0
    alpha, p2 = np.arctan2(b, h), 3 * GRAVITY / (4 * np.hypot(b, h))
    begin = 0.5 * alpha

    def slowness(s: float) -> float:
        return float(2 * s / np.sqrt(2 * p2 * (np.cos(alpha - begin) - np.cos(alpha - begin + s**2))))

    exact = quad(slowness, 0, np.sqrt(begin))[0]
    shaking = bsm.Shaking(waveform="pulse", frequency=1.0, amplitude=0.0, cycles=1.05 * exact, every=4e-3)
    time, turn, loop = rocking(b, h, begin, _by(shaking, integrator, 0.5), kn=4e9)
    return exact, float(quarter(time, turn)), loop.shaken.cycles


def vibration(integrator: Integrator) -> tuple[float | None, float, int]:
    """Return by how much the energy of a column that swings up and down varies, over its mean, and the steps."""
    kick = bsm.Shaking(waveform="pulse", frequency=1, amplitude=0.2, cycles=4e-3, duration=2.0, direction=90.0)
    found = bsm.run(wall(_by(replace(kick, every=0.002), integrator, 1.0), courses=4, bricks=1)).stages[-1].shaking
    assert found is not None
    total = found.energy[5:, 2] + found.energy[5:, 3] - found.energy[5:, 1]
    return 0.0, float(np.ptp(total) / total.mean()), found.cycles


def small_wall(integrator: Integrator) -> tuple[float | None, float, int]:
    """Return the rms movement of a wall under a record [mm], and the steps."""
    record = _by(bsm.Shaking(record=quake(0.4 * GRAVITY, 2.5), every=0.05), integrator, 0.05)
    stage = bsm.run(wall(record, courses=4, bricks=4, kn=1e8)).stages[-1]
    assert stage.shaking is not None
    rms = np.sqrt((stage.stage_displacement[1:, :2] ** 2).sum(axis=1).mean())
    return None, 1e3 * float(rms), stage.shaking.cycles


def _by(shaking: bsm.Shaking, integrator: Integrator, part: float) -> bsm.Shaking:
    """Return a shaking by an integrator; the implicit one with a part of `every` as its time step."""
    return replace(shaking, integrator=integrator, time_step=part) if integrator == "implicit" else shaking


def slope_by_damping() -> str:
    """Return a row for every damping of the starter slope under a sine of 0.3 g, and one of Newmark's method."""
    model = starter("slope")
    sine = bsm.Shaking(waveform="sine", frequency=2.0, amplitude=0.3 * GRAVITY, cycles=8)
    rows = []
    for damping in (0.0, 0.05, 0.2):
        shaken = bsm.Stage(name="quake", shaking=replace(sine, contact_damping=damping))
        stage = bsm.run(model.replace(stages=[*model.stages, shaken]), model.options).stages[-1]
        found = stage.shaking
        assert found is not None
        moved = f"{stage.max_stage_displacement:.2f}"
        steps = f"{found.cycles / found.time[-1] / 1000:.0f}"
        rows.append((f"`contact_damping = {damping:g}`", stage.status.value, moved, steps))
    side = bsm.newmark(model, sine, sides=["left"], options=model.options).sides[0]
    assert side.sliding is not None
    assert side.turned is not None
    moved = f"{side.sliding.permanent:.2f} or {side.turned.permanent:.2f}"
    rows.append((f"Newmark, yield acceleration {side.yields:.3f} g", "-", moved, "-"))
    return markdown(("", "verdict", "greatest displacement, m", "steps, thousands a second of the record"), rows)


def reflections() -> str:
    """Return a row for every joint in a column: what quiet ends reflect, and those of intact rock would."""
    rows = []
    for stiffness, every in ((np.inf, 1), (100e9, 1), (25e9, 1), (40e9, 4), (10e9, 4)):
        model, speed = column(90, 80, joint=(stiffness, every))
        time, velocity = velocities(bsm.run(model), "v")
        back = np.abs(velocity[time > 165 / speed]).max() / np.abs(velocity).max()
        slower = speed / np.sqrt(MODULI[90] / DENSITY)
        joint = ("none", "-") if stiffness == np.inf else (f"every {every}", f"{stiffness / 1e9:.0f}")
        rows.append((*joint, f"{slower:.2f}", f"{100 * back:.2f}", f"{100 * (1 - slower) / (1 + slower):.1f}"))
    header = ("joint in faces", "GPa/m", "speed over that of rock", "reflected, %", "with intact rock's impedance, %")
    return markdown(header, rows)


def reflections_at_angles() -> str:
    """Return a row for every angle: what viscous dashpots send back of a plane wave, by the closed form."""
    rows = []
    for angle in (0, 15, 30, 45, 60, 75, 85):
        parts = [reflected(angle, kind) for kind in ("p", "s")]
        energies = [f"{100 * energy.sum():.1f}" for _, energy in parts]
        heights = [f"{100 * np.abs(amplitudes[k]):.0f}" for k, (amplitudes, _) in enumerate(parts)]
        rows.append((str(angle), energies[0], heights[0], energies[1], heights[1]))
    header = "angle to the normal, degrees", "pressure wave: energy, %", "its height, %", "shear wave: energy, %"
    return markdown((*header, "its height, %"), rows)


def groundfall() -> str:
    """Return a row for every wave into a room, and damping: verdict, fallen blocks, movement of others."""
    model = load("groundfall/model")
    room, wave = model.stages
    assert wave.shaking is not None
    rows = []
    for file, scale, damping in (("weak", 0.1, 0.05), ("model", 1.0, 0.05), ("weak", 0.1, 0.0), ("model", 1.0, 0.0)):
        shaking = replace(wave.shaking, scale=scale, contact_damping=damping)
        stages = bsm.run(model.replace(stages=[room, replace(wave, shaking=shaking)]), model.options).stages
        end = stages[-1]
        moved = np.delete(np.hypot(*end.stage_displacement[:, :2].T), end.unstable_blocks)
        name = f"{file}.toml" if damping else "without damping"
        fallen = ", ".join(map(str, end.unstable_blocks)) or "-"
        ends = stages[1].status.value, end.status.value, fallen, f"{1e3 * moved.max():.2f}"
        rows.append((name, f"{12.5 * scale:g}", f"{damping:g}", *ends))
    header = (
        "file",
        "wave, MPa",
        "`contact_damping`",
        "room",
        "after the wave",
        "fallen blocks",
        "others moved by, mm",
    )
    return markdown(header, rows)


TABLES = (
    Table(name="groundfall", page="examples/groundfall/README.md", make=groundfall, is_slow=True, tolerance=0.3),
    Table(name="quiet", page="docs/quiet_boundaries.md", make=reflections, is_slow=True, tolerance=0.3),
    Table(name="quiet-angles", page="docs/quiet_boundaries.md", make=reflections_at_angles),
    Table(name="shaken-slope", page="docs/earthquakes.md", make=slope_by_damping, is_slow=True, tolerance=0.3),
    Table(name="rocking", page="docs/verification_earthquakes.md", make=rocking_by_damping, is_slow=True),
    Table(name="random-rocking", page="docs/verification_earthquakes.md", make=random_rocking, is_slow=True),
    Table(name="integrators", page="docs/verification_earthquakes.md", make=by_integrator, is_slow=True, tolerance=0.3),
    Table(name="damped", page="docs/verification_earthquakes.md", make=energies_by_damping, tolerance=0.15),
)
