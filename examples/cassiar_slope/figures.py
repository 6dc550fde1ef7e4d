"""The figures of this example: the section with its movement, and the points against the groundwater (Fig. 8.19).

Run ``python -m examples.cassiar_slope.figures``.
"""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import bsm_mesh as bsm
from bsm_mesh.geometries.cassiar_slope import monitoring_points
from examples.cassiar_slope import slope


def at_once(model):
    """Return the displacements of the points (conditions, 7) [m] with weight and water together, and the last run."""
    found = []
    for water in (None, *(stage.water for stage in model.stages)):
        results = bsm.run(model.replace(in_situ=None, stages=(), water=water), slope.OPTIONS)
        found.append(slope.at_the_end(results))
    return np.array(found), results


def draw(displacements):
    """Draw the displacements of the seven points against the groundwater, as Wang Fig. 8.19."""
    figure, axes = plt.subplots(1, 2, figsize=(10.5, 4.8), sharey=True)
    level = np.arange(len(slope.CONDITIONS))
    for axis, (way, whole) in zip(axes, displacements.items(), strict=True):
        for k in range(7):
            axis.plot(level[: len(whole)], whole[:, k], "o-", ms=4, color=f"C{k}", label=f"point {k + 1}")
            axis.plot(4.15, slope.BLOSMER[k], "s", color=f"C{k}", mfc="none")
            axis.plot(4.3, slope.UDEC[k], "^", color=f"C{k}", mfc="none")
            if slope.OBSERVED[k] is not None:
                axis.plot(4.45, slope.OBSERVED[k], "*", ms=9, color=f"C{k}")
        axis.set_title(way)
        axis.set_xticks(level, slope.CONDITIONS, rotation=20)
        axis.set_xlabel("groundwater")
        axis.grid(alpha=0.3)
    axes[0].set_ylim(bottom=0)
    axes[0].set_ylabel("displacement from zero stress [m]")
    for marker, name in (("s", "BLOSMER"), ("^", "UDEC"), ("*", "observed")):
        axes[0].plot([], [], marker, color="grey", mfc="grey" if marker == "*" else "none", label=f"{name}, high water")
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(slope.HERE / "groundwater.png", dpi=130)


def draw_section(model, results):
    """Draw the section with its joints, monitoring points, water tables and the movement under high water."""
    figure, axis = plt.subplots(figsize=(10, 6.2))
    blocks, last, points = results.blocks, results.stages[-1], np.array(monitoring_points())
    for b in range(blocks.count):
        corners = blocks.vertices[blocks.offsets[b] : blocks.offsets[b + 1]]
        serpentinite = blocks.rock_names[blocks.rock[b]] == "serpentinite"
        axis.fill(*corners.T, fc="#b9d3b0" if serpentinite else "#eee6d8", ec="#cfc8bb", lw=0.4)
    ends = np.stack([blocks.vertices, blocks.vertices[blocks.following]], axis=1)
    for number, name in enumerate(blocks.joint_names):
        lines = ends[blocks.edge_joint == number]
        axis.plot(*lines.transpose(2, 1, 0), color="#7a1f1f", lw=1)
        axis.annotate(name.replace("_", " "), lines.mean(axis=(0, 1)), fontsize=8, ha="center", color="#7a1f1f")
    for condition, stage in zip(slope.CONDITIONS[1:], model.stages, strict=True):
        table = np.array(stage.water.table).reshape(-1, 2)
        axis.plot(*table.T, "--", color="#1f6fd0", lw=1)
        axis.annotate(condition, table[0], fontsize=7, color="#1f6fd0", va="bottom")
    vectors = slope.moved(results, last, points)[0]
    axis.quiver(*points.T, *vectors.T, angles="xy", scale_units="xy", scale=0.01, width=0.003, color="C3")
    axis.plot(*points.T, "ko", ms=4)
    for k, point in enumerate(points, start=1):
        axis.annotate(f"{k}", point, xytext=(4, 5), textcoords="offset points", weight="bold")
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("height over the toe [m]")
    axis.set_title("Reconstruction; arrows: movement under weight and high water at once, 100 times", fontsize=10)
    figure.tight_layout()
    figure.savefig(slope.HERE / "section.png", dpi=130)


def main():
    """Draw the figures."""
    model = slope.load()
    together, last = at_once(model)
    rising = slope.rising(bsm.run(model, slope.OPTIONS))[0]
    draw({"weight and water at once": together, "the water rises": rising})
    draw_section(model, last)


if __name__ == "__main__":
    main()
