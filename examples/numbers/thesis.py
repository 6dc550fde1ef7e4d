"""Numbers of Examples 2 to 5 of the thesis."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters import read_blocks
from bsm_mesh.geometries.stratified_slope import build as build_slope
from examples.numbers import runs
from examples.numbers.pages import Table, markdown
from examples.numbers.runs import admits, load, moved, proves, run, statics, verdict

PUSHED, SLOPE, OPENING, DAM = (
    "02_pushed_block",
    "03_stratified_slope",
    "04_bolted_opening",
    "05_dam_foundation",
)


def pushed_block() -> str:
    """Return the table and the forces of Example 2."""
    lines = []
    for file, what in (
        ("model", "the block must move: P is twice the friction"),
        ("apart", "it must move; not how far"),
    ):
        results = run(f"{PUSHED}/{file}")
        down = results.unstable_blocks.tolist()
        far = f"{moved(results, [1])[0]:.3f} m" + (" when contact is lost" if down else "")
        named = f"block {down[0]} (Wang's {down[0] + 1})" if down else "none"
        name = f"{PUSHED}/{file}"
        lines.append((f"{file}.toml", verdict(results), far, named, admits(name), proves(name, what)))
    table = markdown(
        ("file", "verdict", "moved", "unstable", "`bsm-mesh limit`, start geometry", "which proves"), lines
    )
    model = load(f"{PUSHED}/model")
    factor = bsm.limit_analysis(model.replace(loads=()), model.loads).factor
    base, push = (_against(run(f"{PUSHED}/model").stages[-1].contacts, other) / 1e3 for other in (0, 2))
    return f"""{table}

Coulomb's law holds W tan 30 = {26 * math.tan(math.radians(30)):.2f} kN: of P = 30 kN the factor
{factor:.5f}, which `bsm-mesh limit examples/02_pushed_block/model.toml --load 1` gives. At rest the base
holds {base:.1f} kN of P and block 3 {push:.1f} kN. How the two share P depends on the way there; their sum does not."""


def _against(contacts: bsm.results.ContactForces, other: int) -> float:
    """Return the force of another block on the pushed one, against P [N/m]."""
    force = contacts.normal_force * contacts.normal[:, 0] - contacts.shear_force * contacts.normal[:, 1]
    on_b = (contacts.block_b == 1) & (contacts.block_a == other)
    on_a = (contacts.block_a == 1) & (contacts.block_b == other)
    return float(force[on_a].sum() - force[on_b].sum())


def stratified_slope() -> str:
    """Return the table of Example 3."""
    lines = []
    for file, law in (
        ("dip_24_5", "Patton"),
        ("dip_25_5", "Patton"),
        ("model", "Patton"),
        ("mohr_coulomb", "Mohr-Coulomb"),
        ("floor", "Patton"),
        ("layered", "Patton"),
    ):
        name = f"{SLOPE}/{file}"
        model, results = load(name), run(name)
        lower, upper = (moved(results, rows).mean() for rows in layers(model, float(DIPS[file])))
        far = f"{lower:.3f}, {upper:.3f} m" if upper > 0.1 else f"{1e3 * upper:.3f} mm"
        place = (", on the floor" if file in ("floor", "layered") else ", at the toe") if upper > 0.1 else ""
        found = statics(name)
        answer = admits(name) + (f", weights x {found.factor:.0f}" if 1 < found.factor < 1e6 else "")
        lines.append(
            (
                f"{file}.toml",
                f"{DIPS[file]}°",
                law,
                verdict(results) + place,
                far,
                answer,
                proves(name, "the layers must move"),
            )
        )
    header = (
        "file",
        "dip",
        "law",
        "verdict",
        "lower, upper layer moved",
        "`bsm-mesh limit`, start geometry",
        "which proves",
    )
    return markdown(header, lines)


DIPS = {"dip_24_5": "24.5", "dip_25_5": "25.5", "model": "40", "mohr_coulomb": "40", "floor": "40", "layered": "40"}


def layers(model: bsm.Model, dip: float) -> tuple[list[int], list[int]]:
    """Return the blocks of the lower and of the upper layer, 1 m thick each, over the face of Example 3 at its dip."""
    c, s = math.cos(math.radians(dip)), math.sin(math.radians(dip))
    x, y = model.blocks.moments.centroid.T
    along, above = c * x - s * y, s * x + c * y
    lower, upper = ((above > k) & (above < k + 1) & (along < 0) for k in (0, 1))
    return np.flatnonzero(lower).tolist(), np.flatnonzero(upper).tolist()


def layered_sizes() -> str:
    """Return what Example 3 of layers throughout does with other sizes, by both schemes."""
    usual = load(f"{SLOPE}/layered")
    lines = []
    for length, count, gap in ((2.0, 6, 2.0), (2.5, 5, 2.5), (3.0, 4, 2.0), (3.0, 4, 3.0), (4.0, 3, 2.0)):
        sizes = {"length": length, "blocks": count, "gap": gap, "floor": 10.0, "layered": True}
        with tempfile.TemporaryDirectory() as folder:
            path = build_slope(Path(folder) / "slope.msh", **sizes)
            model = usual.replace(blocks=read_blocks(path, blocks="regions"))
        told = []
        for scheme in ("continuation", "wang"):
            results = bsm.run(model, bsm.Options(scheme=scheme))
            told += [f"{verdict(results)}, {len(results.stages[-1].steps)}", _spans(results, model)]
        lines.append((f"{length:g} m x {count}, {gap:g} m", *told))
    moved = "lower, upper layer moved"
    steps = '`"continuation"`: steps', '`"wang"`: cycles'
    return markdown(("block x number, to the floor", steps[0], moved, steps[1], moved), lines)


def _spans(results: bsm.Results, model: bsm.Model) -> str:
    """Return the means of what the lower and the upper layer moved."""
    return ", ".join(f"{moved(results, rows).mean():.2f}" for rows in layers(model, 40.0)) + " m"


def on_its_way() -> str:
    """Return the step of Example 3 at which the lower layer has reached the toe and the upper slides over it."""
    model = load(f"{SLOPE}/model")
    lower, upper = layers(model, 40.0)
    states: list[np.ndarray] = []
    results = bsm.run(model, snapshot=lambda record, now: states.append(moved(now())))
    last = len(states)
    arrived = next(
        k for k, now in enumerate(states) if abs(now[lower] - 2).max() < 0.05 and 2.0 < now[upper].min() < 2.8
    )
    now = states[arrived]
    spans = [f"{now[rows].min():.2f} to {now[rows].max():.2f} m" for rows in (lower, upper)]
    ends = [f"{moved(results, rows).mean():.3f} m" for rows in (lower, upper)]
    rebound = max(2.0 - state[lower].min() for state in states[arrived:])
    return f"""After step {arrived + 1} of {last} the lower layer moved {spans[0]} and the upper {spans[1]} (as
Fig. 4.21); at the end {ends[0]} and {ends[1]} (Fig. 4.22). Moving blocks have inertia: those of the lower
layer rebound from the toe by up to {rebound:.2f} m before they rest there. The contact of two blocks
is damped critically, the spring that a whole layer is much less."""


def bolted_opening() -> str:
    """Return the table and the forces of Example 4."""
    lines = []
    for file, bolts in (
        ("unbolted", "none"),
        ("roof_bolt", "roof"),
        ("two_bolts", "roof, wall"),
        ("model", "roof, wall, corner"),
        ("thick_two_bolts", "roof, wall"),
        ("thick", "roof, wall, corner"),
    ):
        name = f"{OPENING}/{file}"
        results = run(name)
        stage, down = results.stages[-1], results.unstable_blocks.tolist()
        named = {15: "block 15, the roof wedge", 10: "block 10, the wall wedge"}
        forces = ", ".join(f"{force / 1e3:.1f}" for force in stage.bolts.greatest_force)
        inwards = f"{1e3 * stage.displacement[6, 0]:.1f} mm" if not down else "-"
        lines.append((f"{file}.toml", bolts, verdict(results), ", ".join(named[b] for b in down) or "none",
                      f"{forces} kN" if forces else "-", inwards, admits(name)))  # fmt: skip
    forced, inward = "force in roof, wall, corner bolt", "corner block moves into the opening"
    header = ("file", "bolts", "verdict", "unstable", forced, inward, "`bsm-mesh limit`")
    model = load(f"{OPENING}/model")
    area = model.blocks.moments.area[15]
    force = run(f"{OPENING}/model").stages[-1].bolts.greatest_force[0] / 1e3
    filling = model.joints[0].filling
    modulus = filling.young * (1 - filling.poisson) / ((1 + filling.poisson) * (1 - 2 * filling.poisson))
    closes = 1e6 / modulus * filling.thickness
    return f"""{markdown(header, lines)}

At rest the roof bolt carries {force:.2f} kN, the weight of the wedge: 26 kN/m³ times {area:.3f} m². It hangs on the
bolt alone; its joints are open. The wall bolt holds the thrust of the rock above as well, which squeezes the wedge out.
A filling that soft closes under 1 MPa by {1e3 * closes:.1f} mm, {closes / filling.thickness:.1f} times its thickness,
whatever that is. Up to 3 mm (below) the thickness sets how far blocks move, not which bolts they need."""


SOFT = 5e-3  # m, of filling: from here on the rounding of solver and processor decides which blocks follow the wedge


def filling_thickness() -> str:
    """Return what Example 4 does with thicker fillings."""
    lines = []
    for thickness in (0.2e-3, 0.5e-3, 1e-3, 2e-3, 3e-3, 5e-3, 10e-3):
        stages = {}
        for file in ("unbolted", "roof_bolt", "two_bolts", "model"):
            model = load(f"{OPENING}/{file}")
            joints = [replace(joint, filling=replace(joint.filling, thickness=thickness)) for joint in model.joints]
            thicker = model.replace(joints=joints)
            stages[file] = bsm.run(thicker).stages[-1]
            if file == "unbolted":
                stages["wang"] = bsm.run(thicker, bsm.Options(scheme="wang", max_steps=100)).stages[-1]
        down = [", ".join(map(str, stages[file].unstable_blocks)) for file in ("wang", "unbolted", "roof_bolt")]
        if thickness >= SOFT and 10 in stages["roof_bolt"].unstable_blocks:
            down[-1] = "10, at least"
        held = [_stands(stages[file]) for file in ("two_bolts", "model")]
        lines.append((f"{1e3 * thickness:g} mm", *down, *held))
    header = (
        "filling",
        "fall unbolted, thesis's iteration",
        "default scheme",
        "with the roof bolt",
        "two bolts; corner block moves into the opening, down",
        "three bolts",
    )
    return markdown(header, lines)


def _stands(stage: bsm.results.StageResult) -> str:
    """Return the verdict, and how far the corner block moves if there is one."""
    inwards, down = 1e3 * stage.displacement[6, 0], -1e3 * stage.displacement[6, 1]
    return f"{stage.status.value}, {inwards:.1f}, {down:.1f} mm" if stage.status.is_stable else stage.status.value


HEEL_ROCK, TOE_ROCK = 33, 34  # blocks upstream and downstream of the dam's key


def dam_foundation() -> str:
    """Return the table and the water's force of Example 5."""
    lines = []
    for file, scheme in (("slip", "continuation: joints slip and open"), ("model", "linear: all joints hold")):
        name = f"{DAM}/{file}"
        lines.append((f"{file}.toml", scheme, *dam_moves(load(name), run(name))))
    uplift = run(f"{DAM}/slip").stages[-1].water[:, 1].sum() / 1e6
    table = markdown(("file", "scheme", *DAM_COLUMNS), lines)
    return f"""{table}

The water takes {uplift:.1f} MN/m off the weight of dam and rock; the forces in the contacts are the effective ones."""


DAM_COLUMNS = ("dam downstream", "dam up", "gap at the heel", "block at the toe up", "its downstream neighbour up")


def dam_moves(model: bsm.Model, results: bsm.Results) -> list[str]:
    """Return how dam and toe move, and how far the dam parts from the upstream rock at the surface."""
    u, centroid = results.stages[-1].displacement, model.blocks.moments.centroid
    at_heel = u[:, 0] + u[:, 2] * centroid[:, 1]  # of the point at y = 0; rotations are small
    gap = max(0.0, float(at_heel[0] - at_heel[HEEL_ROCK]))
    values = (u[0, 0], u[0, 1], gap, u[TOE_ROCK, 1], u[TOE_ROCK + 1, 1])
    return [f"{1e3 * value:.2f} mm" for value in values]


MESH = '[mesh]\ngeometry = "dam_foundation"\n'
WATER = "[water]                          # weight and water together, as in the thesis\n"
FIRST = '[in_situ]\nmethod = "gravity"\n[water]\ntable = [[0, 0]]\n[[stage]]\nname = "reservoir"\n[stage.water]\n'


def _dam(old: str, new: str) -> bsm.Model:
    """Return the dam with a part of its model file replaced."""
    text = (runs.EXAMPLES / f"{DAM}/slip.toml").read_text(encoding="utf-8")
    assert old in text
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.toml").write_text(text.replace(old, new), encoding="utf-8")
        return bsm.load(Path(folder) / "model.toml")


def _told_dam(model: bsm.Model) -> list[str]:
    """Return verdict and movements."""
    results = bsm.run(model)
    return [verdict(results), *dam_moves(model, results)]


def dam_variants() -> str:
    """Return what Example 5 does with other joints, and with the dam standing before the water comes."""
    usual = load(f"{DAM}/slip")
    lines = [("as given", *_told_dam(usual))]
    lines += [
        (f"joints beyond the toe dip {words}", *_told_dam(_dam(MESH, f"{MESH}[mesh.parameters]\ntoe_dip = {dip}\n")))
        for dip, words in ((60.0, "60° upstream"), (90.0, "90°"), (135.0, "45° downstream, as the others"))
    ]
    for shear in (0.5e9, 1e9, 2e9):
        joints = [replace(joint, shear_stiffness=shear) for joint in usual.joints]
        lines.append((f"shear stiffness {shear / 1e9:g} GPa/m", *_told_dam(usual.replace(joints=joints))))
    on_rock = [replace(joint, shear_stiffness=5e9) if joint.name == "contact" else joint for joint in usual.joints]
    lines.append(("shear stiffness under the dam 5 GPa/m", *_told_dam(usual.replace(joints=on_rock))))
    soft = [replace(joint, normal_stiffness=5e9, shear_stiffness=1e9) for joint in usual.joints]
    lines.append(("normal, shear stiffness 5, 1 GPa/m", *_told_dam(usual.replace(joints=soft))))
    lines.append(("dam first, then the reservoir; since then", *_told_dam(_dam(WATER, FIRST))))
    return markdown(("variant", "verdict", *DAM_COLUMNS), lines)


TABLES: tuple[Table, ...] = (
    Table(name="pushed-block", page=f"examples/{PUSHED}/README.md", make=pushed_block, tolerance=0.1),
    Table(name="stratified-slope", page=f"examples/{SLOPE}/README.md", make=stratified_slope),
    Table(name="layered-sizes", page=f"examples/{SLOPE}/README.md", make=layered_sizes, tolerance=0.1, is_slow=True),
    Table(name="stratified-slope-way", page=f"examples/{SLOPE}/README.md", make=on_its_way, tolerance=0.1),
    Table(name="bolted-opening", page=f"examples/{OPENING}/README.md", make=bolted_opening),
    Table(name="filling-thickness", page=f"examples/{OPENING}/README.md", make=filling_thickness, tolerance=0.02),
    Table(name="dam-foundation", page=f"examples/{DAM}/README.md", make=dam_foundation),
    Table(name="dam-variants", page=f"examples/{DAM}/README.md", make=dam_variants, tolerance=0.02),
)
