"""Numbers of the examples whose answer statics knows, or bounds."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.studies.statistics import fails
from examples.numbers.pages import Table, markdown
from examples.numbers.runs import EXAMPLES, admits, load, moved, proves, run, statics, verdict

LIMIT = "`bsm-mesh limit`, start geometry"


def arch() -> str:
    """Return the table of the arch."""
    lines = []
    for file, ratio in (("model", "0.10815, 1 % above"), ("thin", "0.10601, 1 % below")):
        name = f"arch/{file}"
        results = run(name)
        told = "" if results.unstable_blocks.size else f", moved {1e3 * moved(results).max():.3f} mm"
        lines.append((f"{file}.toml", ratio, verdict(results) + told, admits(name), proves(name, "the arch must move")))
    return markdown(("file", "t/R", "verdict", LIMIT, "which proves"), lines)


def falling_table() -> str:
    """Return the table of the slope whose water falls, its factors from the formula of plane failure."""
    lines = []
    for file in ("slow", "rapid"):
        results = run(f"falling_table/{file}")
        for stage in results.stages:
            down = ", the wedge" if stage.unstable_blocks.size else ""
            lines.append((f"{file}.toml", stage.name, f"{_factor(file, stage.name):.3f}", stage.status.value + down))
    return markdown(("file", "stage", "factor of safety by formula", "verdict"), lines)


def _factor(file: str, stage: str) -> float:
    """Return the factor of safety of the wedge by statics (Wyllie and Mah)."""
    dip, base = math.atan2(7.652, 10.928), math.hypot(10.928, 7.652)
    weight, cohesion, tan_phi = (
        26e3 * load("falling_table/slow").blocks.moments.area[0],
        15e3,
        math.tan(math.radians(37)),
    )
    if stage == "drawdown":
        depth = 12.0 - 7.652
        thrust, uplift = 9810 * depth**2 / 2, 9810 * depth * base / 2
        pressed = weight * math.cos(dip) - uplift - thrust * math.sin(dip)
        return (cohesion * base + pressed * tan_phi) / (weight * math.sin(dip) + thrust * math.cos(dip))
    contacts = next(each for each in run(f"falling_table/{file}").stages if each.name == stage).contacts
    on_plane = contacts.joint == 0
    pressed, sheared = -contacts.normal_force[on_plane].sum(), abs(contacts.shear_force[on_plane].sum())
    return (cohesion * base + pressed * tan_phi) / sheared


def incline() -> str:
    """Return the table of the block on an incline, and the forces of the one that stands."""
    lines = []
    for file, height, friction, dip in INCLINES:
        name = f"incline/{file}"
        slides, topples = (
            math.tan(math.radians(dip)) > math.tan(math.radians(friction)),
            math.tan(math.radians(dip)) > 10 / height,
        )
        limit = f"{'yes' if topples else 'no'} ({math.degrees(math.atan(10 / height)):.1f}°)"
        lines.append((f"{file}.toml", f"{height:g} m", f"{friction:g}°", f"{dip:g}°", "yes" if slides else "no", limit,
                      verdict(run(name)), admits(name), proves(name)))  # fmt: skip
    header = (
        "file",
        "h",
        "φ",
        "ψ",
        "slides by the formula",
        "topples (beyond atan b/h)",
        "verdict",
        LIMIT,
        "which proves",
    )
    contacts = run("incline/model").stages[-1].contacts
    normal, shear = -contacts.normal_force, np.abs(contacts.shear_force)
    heel, toe = normal.argmin(), normal.argmax()
    free = bsm.run(load("incline/topples"), bsm.Options()).stages[-1]
    return f"""{markdown(header, lines)}

Of the block that stands, N = {normal.sum() / 1e3:.2f} kN = W cos ψ and S = {shear.sum() / 1e3:.2f} kN = W sin ψ.
The heel, lightly loaded ({normal[heel] / 1e3:.1f} kN), has slipped; the toe carries {shear[toe] / 1e3:.1f} kN
of the shear.

"Unstable" is here: moved more than `displacement_limit` = 10 m. Without that key the run of
topples.toml ends `{free.status.value}` after {free.max_displacement:.0f} m: the
block falls on its side and slides on. Friction of 40° would hold it on a longer plane of 30°.

{_upright()}"""


def _upright() -> str:
    """Return what the tall block does for which both formulas hold."""
    name = "incline/tall_slides"
    stage, model = run(name).stages[-1], load(name)
    friction, width = next(row[2] for row in INCLINES if row[0] == "tall_slides"), 10.0
    height = float(model.blocks.moments.area[1]) / width
    arm, turned = height / 2 * math.tan(math.radians(friction)), math.degrees(abs(stage.displacement[1, 2]))
    far = moved(run(name))[1]
    return f"""For tall_slides.toml both formulas hold, and it slides without toppling: while it slides, base friction
is N tan φ and no more. The force on the base acts h/2 tan φ = {arm:.2f} m from its middle, within the half
width of {width / 2:g} m. It has turned by {turned:.2f}° after {far:.1f} m, as its joint closes more at the toe.
The formula tan ψ > b/h is for a block that friction holds; one that slides topples if tan φ > b/h."""


INCLINES = (("model", 10.0, 40.1, 40.0), ("slides", 5.0, 20.0, 40.0), ("topples", 25.0, 40.0, 30.0),
            ("tall_slides", 25.0, 20.0, 40.0))  # fmt: skip


def retaining_wall() -> str:
    """Return the table of the wall: forces on its base by statics and by the run, and the verdict."""
    lines = []
    for file, q in (("model", 10e3), ("heavy", 50e3)):
        results = run(f"retaining_wall/{file}")
        for stage, surcharge in zip(results.stages, (0.0, q), strict=True):
            down, along, arm = _on_base(surcharge)
            told = [f"{down / 1e3:.1f} kN", f"{along / 1e3:.1f} kN", f"{arm:.2f} m", stage.status.value]
            if stage.status.is_stable:
                contacts = stage.contacts
                base = np.minimum(contacts.block_a, contacts.block_b) == 0
                told[0] += f", {-contacts.normal_force[base].sum() / 1e3:.1f} kN"
                told[1] += f", {abs(contacts.shear_force[base].sum()) / 1e3:.1f} kN"
            lines.append((f"{file}.toml", stage.name, *told))
    head = ("file", "stage", "N by statics, run", "T by statics, run", "N acts from the toe at", "verdict")
    return markdown(head, lines)


def _on_base(surcharge: float) -> tuple[float, float, float]:
    """Return normal force, shear force and distance of the normal force from the toe, per metre, by Coulomb."""
    phi, delta, batter, slope = np.radians([34.0, 20.0, math.degrees(math.atan(0.2)), math.degrees(math.atan(0.15))])
    height, gamma = 5.0, 19e3
    root = math.sqrt(
        math.sin(phi + delta) * math.sin(phi - slope) / math.cos(batter + delta) / math.cos(batter - slope)
    )
    K = math.cos(phi - batter) ** 2 / math.cos(batter) ** 2 / math.cos(batter + delta) / (1 + root) ** 2
    soil = K * gamma * height**2 / 2
    above = K * surcharge * height * math.cos(batter) / math.cos(batter - slope)
    across, down = math.cos(batter + delta), math.sin(batter + delta)
    weights = np.array([24e3 * height, 24e3 * height / 2])  # the rectangle, and the triangle of the back
    N = weights.sum() + (soil + above) * down
    turning = weights @ (0.5, 4 / 3)
    for thrust, y in ((soil, height / 3), (above, height / 2)):
        turning += thrust * (down * (2 - y / height) - across * y)
    return N, (soil + above) * across, turning / N


def staged_tunnel() -> str:
    """Return the table of the tunnel in stages."""
    lines = []
    for file, strength in (("model", "0.4, 0.2 MPa"), ("full_face", "0.4, 0.2 MPa"), ("weak", "0.1, 0.02 MPa")):
        results = run(f"staged_tunnel/{file}")
        stages = results.stages[1:]
        stand = ", ".join(stage.name for stage in stages if stage.status.is_stable)
        far = ", ".join(
            f"{stage.name} {1e3 * np.hypot(*stage.displacement[stage.present, :2].T).max():.2f} mm"
            if stage.status.is_stable
            else f"{stage.name}: {stage.status.value}, a block of the wall"
            for stage in stages
        )  # fmt: skip
        lines.append((f"{file}.toml", strength, stand, far))
    return markdown(("file", "cohesion, tension of the joints", "stages that stand", "greatest displacement"), lines)


NEAR_LIMIT = 27  # degrees, of the wall that the next function tilts


def tilted_wall() -> str:
    """Return the table of the wall and what limit analysis says of it."""
    lines = []
    for file, tilt in (("model", 5), ("tilt_27", 27), ("tilt_28", 28), ("tilt_30", 30)):
        name = f"tilted_wall/{file}"
        results = _by_superlu(name)
        far = 1e3 * moved(results).max()
        shown = f"about {far:.1g}" if tilt == NEAR_LIMIT else f"{far:.3f}"
        told = "" if results.unstable_blocks.size else f", moved {shown} mm"
        lines.append(
            (f"{file}.toml", f"{tilt}°", verdict(results) + told, admits(name), proves(name, "the wall must move"))
        )
    beyond = bsm.solve.limit_analysis.limit_tilt(load("tilted_wall/model"))
    stiff = []
    for stiffness in (100e9, 1e9):
        for tilt in (27.5, 28.0):
            base = load("tilted_wall/tilt_28")
            joints = [_stiff(joint, stiffness) for joint in base.joints]
            model = base.replace(joints=joints, gravity_direction=-90.0 + tilt)
            stiff.append(f"{verdict(bsm.run(model))} at {tilt:g}° with {stiffness / 1e9:g} GPa/m")
    return f"""{markdown(("file", "tilt", "verdict", LIMIT, "which proves"), lines)}

Solved by SuperLU, as without MKL. At 27°, near the limit, the rounding of solver and processor decides the second digit
of the displacement.

By limit analysis the greatest tilt is {5 + beyond:.2f}° ({beyond:.2f}° beyond the 5° of model.toml). Beyond it the
wall must fail. Below it forces within strength exist, but whether the bricks find them is another matter. With
friction, limit analysis gives an upper bound, and here the bricks fall earlier. This is why "admissible" proves
nothing. Stiffness of the joints (10 GPa/m) does not change it much:
{", ".join(stiff)}. Which bricks are named as unstable depends on how far the wall is followed."""


@cache
def _by_superlu(name: str) -> bsm.Results:
    from dataclasses import replace

    model = load(name)
    return bsm.run(model, replace(model.options or bsm.Options(), linear_solver="superlu"))


def _stiff(joint: bsm.Joint, stiffness: float) -> bsm.Joint:
    from dataclasses import replace

    return replace(joint, normal_stiffness=stiffness, shear_stiffness=stiffness)


def toppling_column() -> str:
    """Return the table of the column."""
    lines = []
    for file, dip in (("model", 7.025), ("steeper", 7.225)):
        name = f"toppling_column/{file}"
        results = run(name)
        down = results.unstable_blocks.tolist()
        told = f": blocks {', '.join(map(str, down))}" if down else f", moved {1e3 * moved(results).max():.3f} mm"
        more = (
            f", {bsm.solve.limit_analysis.limit_tilt(load(name)):.4f}° more to the right"
            if statics(name).admissible
            else ""
        )
        lines.append(
            (
                f"{file}.toml",
                f"{dip}°",
                verdict(results) + told,
                admits(name) + more,
                proves(name, "the column must move"),
            )
        )
    falls = run("toppling_column/steeper").stages[-1]
    free = bsm.run(load("toppling_column/steeper"), bsm.Options()).stages[-1]
    return f"""{markdown(("file", "dip", "verdict", LIMIT, "which proves"), lines)}

"Unstable" is here: moved more than `displacement_limit` = 6 m, in {len(falls.steps)} steps. Without it the run ends
`{free.status.value}` after {len(free.steps)} steps, a block having moved {free.max_displacement:.1f} m: {free.reason}.
The lowest block turns with the others but is named stable, as it moves less than a quarter of the greatest movement."""


def uncertain_slope() -> str:
    """Return what the study finds, compared with the formula."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        done = bsm.study(EXAMPLES / "uncertain_slope/study.toml", output=folder)
    table, failed = done.table, fails(done.table)
    low, high = done.summary["failure"]["interval"]
    found = f"{failed.mean():.4f}; 95 % interval {low:.3f} to {high:.3f}"
    rows = [
        ("model.toml", "the slope with the means, water 1.35 m up the crack", "factor 1.153", verdict(run(UNCERTAIN))),
        ("study.toml", "probability of failure, 400 runs by Latin hypercube", "0.3572", found),
    ]
    quarters = {key: _quarters(table.numbers(key), failed) for key in UNCERTAIN_KEYS}
    told = "; ".join(f"{name}: {', '.join(quarters[key])}" for key, name in UNCERTAIN_KEYS.items())
    return f"""{markdown(("file", "what", "by formula", "found"), rows)}

The water decides. Runs that fail in the lowest to the highest quarter of each: {told}."""


UNCERTAIN = "uncertain_slope/model"
UNCERTAIN_KEYS = {
    "water.table.2.2": "water",
    "joint.bedding.friction": "friction",
    "joint.bedding.cohesion": "cohesion",
}


def _quarters(values: np.ndarray, failed: np.ndarray) -> list[str]:
    edges = np.quantile(values, (0.25, 0.5, 0.75))
    which = np.searchsorted(edges, values)
    return [f"{100 * failed[which == k].mean():.0f} %" for k in range(4)]


TABLES: tuple[Table, ...] = (
    Table(name="arch", page="examples/arch/README.md", make=arch),
    Table(name="falling-table", page="examples/falling_table/README.md", make=falling_table),
    Table(name="incline", page="examples/incline/README.md", make=incline, tolerance=0.1),
    Table(name="retaining-wall", page="examples/retaining_wall/README.md", make=retaining_wall),
    Table(name="staged-tunnel", page="examples/staged_tunnel/README.md", make=staged_tunnel),
    Table(name="tilted-wall", page="examples/tilted_wall/README.md", make=tilted_wall),
    Table(name="toppling-column", page="examples/toppling_column/README.md", make=toppling_column, tolerance=0.1),
    Table(name="uncertain-slope", page="examples/uncertain_slope/README.md", make=uncertain_slope, is_slow=True),
)
