"""Numbers of Examples 2 to 5 of the thesis."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
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
    ):
        name = f"{SLOPE}/{file}"
        model, results = load(name), run(name)
        lower, upper = (moved(results, rows).mean() for rows in layers(model))
        far = f"{lower:.3f}, {upper:.3f} m" if upper > 0.1 else f"{1e3 * upper:.3f} mm"
        place = ", at the toe" if upper > 0.1 else ""
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


DIPS = {"dip_24_5": "24.5", "dip_25_5": "25.5", "model": "40", "mohr_coulomb": "40"}


def layers(model: bsm.Model) -> tuple[list[int], list[int]]:
    """Return the blocks of the lower and of the upper layer of Example 3."""
    return list(range(3, 9)), list(range(9, 15))


def on_its_way() -> str:
    """Return the step of Example 3 at which the lower layer has reached the toe and the upper slides over it."""
    model = load(f"{SLOPE}/model")
    lower, upper = layers(model)
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
    return f"""After step {arrived + 1} of {last} the lower layer has moved {spans[0]} and the upper {spans[1]} (as
Fig. 4.21); at the end {ends[0]} and {ends[1]} (Fig. 4.22). What moves has inertia: blocks of the lower
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
whatever that is: the thickness sets how far blocks move, not which of them stand."""


def filling_thickness() -> str:
    """Return what Example 4 does with thicker fillings."""
    lines = []
    for thickness in (0.2e-3, 0.5e-3, 1e-3, 2e-3, 3e-3):
        stages = {}
        for file in ("unbolted", "roof_bolt", "two_bolts", "model"):
            model = load(f"{OPENING}/{file}")
            joints = [replace(joint, filling=replace(joint.filling, thickness=thickness)) for joint in model.joints]
            stages[file] = bsm.run(model.replace(joints=joints)).stages[-1]
        down = [f"blocks {', '.join(map(str, stages[file].unstable_blocks))}" for file in ("unbolted", "roof_bolt")]
        far = [f"{1e3 * stages[file].displacement[6, 0]:.1f} mm" for file in ("two_bolts", "model")]
        held = [stages[file].status.value for file in ("two_bolts", "model")]
        lines.append((f"{1e3 * thickness:g} mm", *down, *(f"{one}, {two}" for one, two in zip(held, far, strict=True))))
    header = ("filling", "come down unbolted", "with the roof bolt", "two bolts; corner block moves", "three bolts")
    return markdown(header, lines)


def dam_foundation() -> str:
    """Return the table and the water's force of Example 5."""
    lines = []
    for file, scheme in (("model", "linear"), ("slip", "continuation: joints slip and open")):
        stage = run(f"{DAM}/{file}").stages[-1]
        u = 1e3 * stage.displacement
        dam, heel, upstream, toe = u[0], u[34], u[33], u[37]
        moves = f"{dam[0]:.2f} mm downstream, {dam[1]:.2f} mm up"
        lines.append((f"{file}.toml", scheme, moves, f"{heel[0] - upstream[0]:.2f} mm", f"{toe[1]:.2f} mm up"))
    uplift = run(f"{DAM}/slip").stages[-1].water[:, 1].sum() / 1e6
    table = markdown(("file", "scheme", "dam", "opening of the joint at the heel", "block at the toe"), lines)
    return f"""{table}

The water takes {uplift:.1f} MN/m off the weight of dam and rock; the forces in the contacts are the effective ones."""


TABLES: tuple[Table, ...] = (
    Table(name="pushed-block", page=f"examples/{PUSHED}/README.md", make=pushed_block, tolerance=0.1),
    Table(name="stratified-slope", page=f"examples/{SLOPE}/README.md", make=stratified_slope),
    Table(name="stratified-slope-way", page=f"examples/{SLOPE}/README.md", make=on_its_way, tolerance=0.1),
    Table(name="bolted-opening", page=f"examples/{OPENING}/README.md", make=bolted_opening),
    Table(name="filling-thickness", page=f"examples/{OPENING}/README.md", make=filling_thickness, tolerance=0.02),
    Table(name="dam-foundation", page=f"examples/{DAM}/README.md", make=dam_foundation),
)
