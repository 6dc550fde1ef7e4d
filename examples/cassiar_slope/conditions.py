"""The five groundwater conditions: Table 8.4 beside the blocks, Fig. 8.19 in kind, and the number of steps.

Run ``python examples/cassiar_slope/conditions.py``: prints the tables of the README, draws groundwater.png and
section.png.
"""

import dataclasses
import math
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import bsm_mesh as bsm
from bsm_mesh.geometries.cassiar_slope import monitoring_points
from bsm_mesh.model.locate import blocks_at

HERE = Path(__file__).parent
LAWS = {"Patton": "model.toml", "Mohr-Coulomb": "mohr_coulomb.toml"}
CONDITIONS = ("none", "low", "intermediate-low", "intermediate", "high")
# Wang Table 8.4, under the high water table [m]
UDEC = (0.47, 0.15, 0.14, 0.12, 0.09, 0.09, 0.06)
BLOSMER = (0.73, 0.55, 0.40, 0.37, 0.43, 0.05, 0.04)
OBSERVED = (0.74, 0.38, None, None, 0.18, 0.05, None)
CYCLES = {"UDEC": 12_500, "BLOSMER": 51}  # Wang 8.3.2, high water
OPTIONS = bsm.Options(scheme="continuation", displacement_limit=10.0)


def at_points(results, stage, points):
    """Return the displacements of points on the blocks, from the start and from the dry state, (k, 2) each [m]."""
    centroid = results.blocks.moments.centroid
    found = []
    for motion in (stage.origin + stage.displacement, stage.origin):
        moved = []
        for point in points:
            block = blocks_at(results.blocks, point, tolerance=1e-6)[0]
            (x, y), (u, v, turn) = np.array(point) - centroid[block], motion[block]
            versed, sine = math.cos(turn) - 1, math.sin(turn)
            moved.append((u + versed * x - sine * y, v + sine * x + versed * y))
        found.append(np.array(moved))
    return found[0], found[0] - found[1]


def as_the_water_rises(model, points=None):
    """Run all stages; return the results and the displacements from zero stress and from the dry state.

    The displacements are lengths [m], (conditions, points) each.
    """
    results = bsm.run(model, OPTIONS)
    points = monitoring_points() if points is None else points
    both = [at_points(results, stage, points) for stage in results.stages]
    whole, since_dry = (np.array([np.hypot(*moved.T) for moved in kind]) for kind in zip(*both, strict=True))
    since_dry[0] = 0.0  # the first stage is the dry state
    return results, whole, since_dry


def all_at_once(model):
    """Run every condition from zero stress, weight and water together; return the displacements and the results."""
    runs = []
    for water in (None, *(stage.water for stage in model.stages)):
        runs.append(bsm.run(dataclasses.replace(model, in_situ=None, stages=(), water=water), OPTIONS))
    moved = [np.hypot(*at_points(run, run.stages[-1], monitoring_points())[0].T) for run in runs]
    return np.array(moved), runs


def print_conditions(title, rows, verdicts):
    """Print the displacements of the seven points, one line a condition."""
    print(
        f"\n{title} [m]\n\n| groundwater | verdict | 1 | 2 | 3 | 4 | 5 | 6 | 7 |\n|---|---|---|---|---|---|---|---|---|"
    )
    for condition, verdict, row in zip(CONDITIONS, verdicts, rows, strict=False):
        print(f"| {condition} | {verdict} | " + " | ".join(f"{value:.3f}" for value in row) + " |")


def print_table_8_4(columns):
    """Print Table 8.4 with our columns beside it."""
    names = ["UDEC", "BLOSMER", "observed", *columns]
    print("\nHigh water table [m]\n\n| point | " + " | ".join(names) + " |\n" + "|---" * (len(names) + 1) + "|")
    for k in range(7):
        published = ["-" if value is None else f"{value:.2f}" for value in (UDEC[k], BLOSMER[k], OBSERVED[k])]
        print(f"| {k + 1} | " + " | ".join([*published, *(f"{values[k]:.2f}" for values in columns.values())]) + " |")


def moving_blocks(results):
    """Return the blocks that the highest water so far moves by more than half of the greatest movement."""
    moved = np.hypot(*results.stages[-1].displacement[:, :2].T)
    return np.flatnonzero(moved > moved.max() / 2)


def by_the_thesis(model, cycles):
    """Run the high water from zero stress by the thesis's own iteration; return the end and the displacements."""
    at_once = dataclasses.replace(model, in_situ=None, stages=(), water=model.stages[-1].water)
    results = bsm.run(at_once, dataclasses.replace(OPTIONS, scheme="wang", max_steps=cycles))
    stage = results.stages[-1]
    return stage, np.hypot(*at_points(results, stage, monitoring_points())[0].T)


def print_steps(model, runs):
    """Print the number of steps to the end under high water; return the displacements by the thesis's iteration."""
    high = runs[-1].stages[-1]
    factorizations = sum(step.factorizations for step in high.steps)
    print("\n| program | to the end under high water |\n|---|---|")
    print(f"| UDEC | {CYCLES['UDEC']} cycles |\n| BLOSMER | {CYCLES['BLOSMER']} cycles |")
    print(f"| here, continuation | {high.status.value}, {len(high.steps)} steps, {factorizations} factorizations |")
    for cycles in (CYCLES["BLOSMER"], 5000):
        stage, moved = by_the_thesis(model, cycles)
        print(
            f"| here, the thesis's own iteration | {stage.status.value} after {len(stage.steps)} cycles, point 1 at "
            f"{moved[0]:.2f} m, {stage.residual:.0e} of a mean block's weight out of balance |"
        )
    return moved


def draw(displacements):
    """Draw the displacements of the seven points against the groundwater, as Wang Fig. 8.19."""
    figure, axes = plt.subplots(1, 2, figsize=(10.5, 4.8), sharey=True)
    level = np.arange(len(CONDITIONS))
    for axis, (law, whole) in zip(axes, displacements.items(), strict=True):
        for k in range(7):
            axis.plot(level[: len(whole)], whole[:, k], "o-", ms=4, color=f"C{k}", label=f"point {k + 1}")
            axis.plot(4.15, BLOSMER[k], "s", color=f"C{k}", mfc="none")
            axis.plot(4.3, UDEC[k], "^", color=f"C{k}", mfc="none")
            if OBSERVED[k] is not None:
                axis.plot(4.45, OBSERVED[k], "*", ms=9, color=f"C{k}")
        axis.set_title(f"{law} joints")
        axis.set_xticks(level, CONDITIONS, rotation=20)
        axis.set_xlabel("groundwater")
        axis.grid(alpha=0.3)
    axes[0].set_ylim(bottom=0)
    axes[0].set_ylabel("displacement from zero stress [m]")
    for marker, name in (("s", "BLOSMER"), ("^", "UDEC"), ("*", "observed")):
        axes[0].plot([], [], marker, color="grey", mfc="grey" if marker == "*" else "none", label=f"{name}, high water")
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(HERE / "groundwater.png", dpi=130)


def draw_section(results):
    """Draw the section with its joints, monitoring points, water tables and the movement under high water."""
    figure, axis = plt.subplots(figsize=(10, 6.2))
    blocks, last, points = results.blocks, results.stages[-1], np.array(monitoring_points())
    for b in range(blocks.count):
        corners = blocks.vertices[blocks.offsets[b] : blocks.offsets[b + 1]]
        serpentinite = blocks.rock_names[blocks.rock[b]] == "serpentinite"
        axis.fill(*corners.T, fc="#b9d3b0" if serpentinite else "#eee6d8", ec="#444444", lw=1)
    middle = blocks.vertices + blocks.edge_vectors / 2
    for number, name in enumerate(blocks.joint_names):
        spot = middle[blocks.edge_joint == number].mean(axis=0)
        axis.annotate(name.replace("_", " "), spot, fontsize=8, ha="center", color="#7a1f1f")
    for condition, stage in zip(CONDITIONS[1:], results.stages[1:], strict=True):
        table = stage.water_table.reshape(-1, 2)
        axis.plot(*table.T, "--", color="#1f6fd0", lw=1)
        axis.annotate(condition, table[0], fontsize=7, color="#1f6fd0", va="bottom")
    moved = at_points(results, last, points)[1]
    axis.quiver(*points.T, *moved.T, angles="xy", scale_units="xy", scale=0.005, width=0.003, color="C3")
    axis.plot(*points.T, "ko", ms=4)
    for k, point in enumerate(points, start=1):
        axis.annotate(f"{k}", point, xytext=(4, 5), textcoords="offset points", weight="bold")
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("height over the toe [m]")
    axis.set_title("Reconstruction; arrows: movement from the dry state under high water, 200 times", fontsize=10)
    figure.tight_layout()
    figure.savefig(HERE / "section.png", dpi=130)


def main():
    """Print the tables and draw the pictures."""
    began = time.perf_counter()
    drawn, columns = {}, {}
    for law, file in LAWS.items():
        model = bsm.load(HERE / file)
        results, whole, since_dry = as_the_water_rises(model)
        verdicts = [stage.status.value for stage in results.stages]
        print_conditions(f"{law} joints, the water rises: displacement from zero stress", whole, verdicts)
        print_conditions(f"{law} joints, the water rises: displacement from the dry in-situ state", since_dry, verdicts)
        print(f"\nMoving wedge: blocks {moving_blocks(results).tolist()} of {results.blocks.count}")
        moved, runs = all_at_once(model)
        print_conditions(
            f"{law} joints, weight and water at once: displacement from zero stress",
            moved,
            [run.status.value for run in runs],
        )
        drawn[law] = whole
        columns |= {f"{law}, rising": whole[-1], f"{law}, at once": moved[-1]}
        if law == "Patton":
            columns["Patton, at once, thesis's iteration"] = print_steps(model, runs)
            draw_section(results)
        columns[f"{law}, from the dry state"] = since_dry[-1]
    print_table_8_4(columns)
    draw(drawn)
    print(f"\n{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
