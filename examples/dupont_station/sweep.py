"""The assumed numbers varied one at a time, Case 1: which conclusions survive.

Run ``python examples/dupont_station/sweep.py``: prints the table of docs/dupont_station.md, a line a run. To be quick,
the model is smaller than that of the example and its joints are 3 m apart.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import station

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.geometries import dupont_station

SMALL = {"width": 50.0, "below": 15.0, "joint_spacing": 3.0, "cross_spacing": 3.0}
OPTIONS = bsm.Options(scheme="continuation", max_steps=60, displacement_limit=0.3)
KS = 0.136e9
VARIATIONS = [
    ("none", {}),
    ("normal stiffness 5 Ks", {"normal_stiffness": 5 * KS}),
    ("normal stiffness 20 Ks", {"normal_stiffness": 20 * KS}),
    ("normal stiffness 100 Ks", {"normal_stiffness": 100 * KS}),
    ("K0 = 0.7", {"k0": 0.7}),
    ("K0 = 0.85", {"k0": 0.85}),
    ("K0 = 1.3", {"k0": 1.3}),
    ("K0 = 1.6", {"k0": 1.6}),
    ("joints 2 m apart", {"joint_spacing": 2.0, "cross_spacing": 2.0}),
    ("cross joints 2 m apart", {"cross_spacing": 2.0}),
    ("92 m wide, 25 m below the crown", {"width": 92.0, "below": 25.0}),
    ("zones and J1 dip 50", {"dip": 50.0, "cross_dip": -40.0}),
    ("zones and J1 dip 55", {"dip": 55.0, "cross_dip": -35.0}),
    ("zones and J1 dip 65", {"dip": 65.0, "cross_dip": -25.0}),
    ("zones and J1 dip 70", {"dip": 70.0, "cross_dip": -20.0}),
    ("cross joints level", {"cross_dip": 0.0}),
    ("the same, joints 2 m apart", {"cross_dip": 0.0, "joint_spacing": 2.0, "cross_spacing": 2.0}),
    ("K0 = 0.7, joints 2 m apart", {"k0": 0.7, "joint_spacing": 2.0, "cross_spacing": 2.0}),
    ("zone 2 m nearer the crown", {"zone_offset": -2.0}),
    ("zone through the upper right corner", {"zone_offset": -4.0}),
    ("zone 2 m farther", {"zone_offset": 2.0}),
    ("zones 2 m wide", {"zone_width": 2.0}),
    ("P_i = 48 kPa", {"pressure": 48e3}),
    ("P_i = 83 kPa", {"pressure": 83e3}),
]


def varied(base, change):
    """Return the model of Case 1 with some of its numbers changed."""
    change = dict(change)
    stiffness = change.pop("normal_stiffness", base.joints[0].normal_stiffness)
    k0, pressure = change.pop("k0", base.in_situ.k0), change.pop("pressure", base.stages[0].pressure)
    with tempfile.TemporaryDirectory() as folder:
        path = dupont_station.build(Path(folder) / "station.msh", **{**SMALL, **change})
        blocks = converters.read_blocks(path)
    return base.replace(
        blocks=blocks,
        joints=[replace(joint, normal_stiffness=stiffness) for joint in base.joints],
        in_situ=replace(base.in_situ, k0=k0),
        stages=[replace(base.stages[0], pressure=pressure)],
    )


def main():
    """Print the table."""
    base = bsm.load(station.HERE / "model.toml")
    print("| changed | verdict | settlement, mm | at x, m | crown | left wall | right wall | settles right of the "
          "centre line | right wall more than left | in the bands |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, change in VARIATIONS:
        model = varied(base, change)
        results = bsm.run(model, OPTIONS)
        told = station.movement_of(model, results).summary()
        crown, left, right = (told[key].mean() for key in ("crown", "left wall", "right wall"))
        bands = (
            4 <= told["settlement"] <= 20 and 2.5 <= crown <= 20 and 0.5 <= min(left, right) <= max(left, right) <= 6
        )
        found = (told["at"] > 0, right > left, bands)
        answers = " | ".join("yes" if yes else "no" for yes in found)
        numbers = f"{told['settlement']:.1f} | {told['at']:.1f} | {crown:.1f} | {left:.1f} | {right:.1f}"
        print(f"| {name} | {results.status} | {numbers} | {answers} |", flush=True)


if __name__ == "__main__":
    main()
