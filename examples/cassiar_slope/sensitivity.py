"""The assumed numbers, one changed at a time: what becomes of the movement under high water, and which findings stay.

Run ``python examples/cassiar_slope/sensitivity.py``: prints the table of docs/cassiar_slope.md.
"""

import dataclasses
import math
import tempfile
import time
from pathlib import Path

import numpy as np
from conditions import BLOSMER, HERE, as_the_water_rises

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.geometries import cassiar_slope

FILE = HERE / "model.toml"
FINDINGS = (
    "the wedge moves, 6 and 7 less than a fifth of point 1",
    "most at its top",
    "point 5 feels the water most",
    "more water, more movement (from the dry state, within 2 mm)",
    "point 1 within a factor of two of 0.73 m",
)
CREST = -330 / math.tan(math.radians(40))


def with_geometry(model, **parameters):
    """Return the model on blocks of another geometry, and its monitoring points."""
    with tempfile.TemporaryDirectory() as folder:
        blocks = converters.read_blocks(cassiar_slope.build(Path(folder) / "slope.msh", **parameters), blocks="regions")
    known = ("height", "slope_angle", "fault_level", "joint_f_level")
    points = cassiar_slope.monitoring_points(**{k: v for k, v in parameters.items() if k in known})
    return dataclasses.replace(model, blocks=blocks), points


def with_joints(model, change, which=None):
    """Return the model with `change(joint)` for the joints of these names, or all."""
    chosen = [change(joint) if which is None or joint.name in which else joint for joint in model.joints]
    return dataclasses.replace(model, joints=chosen)


def with_levels(model, highest=0.8, shape=0.5, crest=CREST):
    """Return the model with four tables, from 0.5 to `highest` of the height at the crest."""
    share = np.linspace(1, 0, 41)
    stages = []
    for stage, part in zip(model.stages, np.linspace(0.5, highest, 4), strict=True):
        level = np.minimum(part * 330 * share**shape, 330 * share)
        table = tuple(zip((crest * share).tolist(), level.tolist(), strict=True))
        stages.append(dataclasses.replace(stage, water=dataclasses.replace(stage.water, table=table)))
    return dataclasses.replace(model, stages=tuple(stages))


def with_k0(model, k0):
    """Return the model with the stress set before, under a ground that follows the slope."""
    ground = ((CREST - 250, 330.0), (CREST, 330.0), (0.0, 0.0), (200.0, 0.0))
    return dataclasses.replace(model, in_situ=bsm.InSitu(method="direct", surface=ground, k0=k0))


def stiffer(factor):
    """Return a change of the normal stiffness by a factor."""
    return lambda joint: dataclasses.replace(joint, normal_stiffness=factor * joint.normal_stiffness)


def steeper_friction(degrees):
    """Return a change of the friction angle."""
    return lambda joint: dataclasses.replace(
        joint, law=dataclasses.replace(joint.law, friction=joint.law.friction + degrees)
    )


def serpentine(joint):
    """Return the joint with the strength and stiffness of the serpentinite's discontinuities."""
    return dataclasses.replace(joint, normal_stiffness=43e6, law=dataclasses.replace(joint.law, friction=24.0))


def table_8_3(joint):
    """Return the joint with the shear stiffness of Table 8.3 without the star."""
    return dataclasses.replace(joint, shear_stiffness=2.7e6 if joint.name in ("dyke", "contact") else 6.8e6)


def variants(model):
    """Yield name, model and points of every variant."""
    yield "as it is", model, None
    yield "Mohr-Coulomb joints", bsm.load(HERE / "mohr_coulomb.toml"), None
    for name, value in (
        ("north_fault_dip", (30, 33, 36, 38)),
        ("fault_a1_dip", (5, 12)),
        ("fault_a1_length", (80, 120)),
        ("fault_level", (100, 140)),
        ("joint_dip", (15, 25)),
        ("joint_f_dip", (5, 15)),
        ("dyke_dip", (65, 85)),
        ("dyke_setback", (5, 40)),
    ):
        for number in value:
            yield f"{name} = {number}", *with_geometry(model, **{name: number})
    for angle in (38, 42):
        changed, points = with_geometry(model, slope_angle=angle)
        yield f"slope_angle = {angle}", with_levels(changed, crest=points[0][0]), points
    for part in (0.75, 0.85):
        yield f"high water at {part:g} of the height", with_levels(model, part), None
    yield "water tables straight from crest to toe", with_levels(model, 0.8, shape=1.0), None
    for factor in (0.5, 2.0, 10.0):
        yield f"normal stiffness x {factor:g}", with_joints(model, stiffer(factor)), None
    yield "Ks of Table 8.3 without the star", with_joints(model, table_8_3), None
    for degrees in (-2.0, 2.0):
        yield f"friction {degrees:+g} degrees", with_joints(model, steeper_friction(degrees)), None
    yield "faults with serpentinite's strength", with_joints(model, serpentine, ("north_fault", "fault_a1")), None
    for k0 in (0.5, 1.0, 1.5):
        yield f"stress set first, K0 = {k0:g}", with_k0(model, k0), None


def findings(results, whole, since_dry):
    """Return which of `FINDINGS` hold; the first alone where the wedge does not come to rest."""
    high, moved = whole[-1], since_dry[-1]
    wedge = bool((high[5:] < high[0] / 5).all() and moved[:5].min() > 2 * moved[5:].max())
    if results.status.value != "stable":
        return (wedge,)
    return (
        wedge,
        high.argmax() == 0,
        moved.argmax() == 4 and (high / whole[0]).argmax() == 4,
        bool((np.diff(since_dry[:, :5], axis=0) > -2e-3).all()),
        BLOSMER[0] / 2 < high[0] < 2 * BLOSMER[0],
    )


def statics(model):
    """Return whether forces within strength balance weight and high water where the blocks are given."""
    at_once = dataclasses.replace(model, in_situ=None, stages=(), water=model.stages[-1].water)
    return bsm.limit_analysis(at_once).admissible


def main():
    """Print the table."""
    began = time.perf_counter()
    print("Findings: " + "; ".join(f"({k}) {text}" for k, text in zip("abcde", FINDINGS, strict=True)) + "\n")
    columns = "last stage | statics | 1, zero stress | 5, zero stress | 1, dry state | 5, dry state | 6 | a b c d e |"
    print(f"| changed | {columns}")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, model, points in variants(bsm.load(FILE)):
        results, whole, since_dry = as_the_water_rises(model, points)
        last, held = results.stages[-1], findings(results, whole, since_dry)
        marks = " ".join("+" if one else "no" for one in held)
        may_stand = "admits" if statics(model) else "refuses"
        numbers = (whole[-1, 0], whole[-1, 4], since_dry[-1, 0], since_dry[-1, 4], whole[-1, 5])
        print(
            f"| {name} | {last.name}: {last.status.value} | {may_stand} | "
            + " | ".join(f"{number:.2f}" for number in numbers)
            + f" | {marks} |",
            flush=True,
        )
    print(f"\n{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
