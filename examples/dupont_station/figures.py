"""The figures of this example: blocks beside finite elements, beside what was measured.

Run ``python -m examples.dupont_station.figures``.
"""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from PIL import Image

import bsm_mesh as bsm
from bsm_mesh.model.submodel import some_blocks
from bsm_mesh.results.movement import verdict_in_words
from examples.dupont_station import station, sweep

P_I = 69e3  # Pa
SHARE = 1.5  # m of wall a bolt
OPTIONS = bsm.Options(displacement_limit=0.3)  # m
COLOURS = {
    "blocks, Case 1": "tab:red",
    "blocks, Case 2": "tab:orange",
    "finite elements, joints that slip": "tab:purple",
    "finite elements, elastic joints": "tab:blue",
    "finite elements, no joints": "tab:cyan",
    "blocks, elastic joints": "black",
}
SLIP = "finite elements, joints that slip"
VIEW = (-15.0, 15.0, -13.0, 9.5)  # m: left, right, bottom, top of the pictures
MEASURED = {"crown, upwards": (5.0, 10.0), "right wall, level": (1.3, 2.5), "left wall, level": (1.3, 2.5)}  # mm


def draw_rock(axes, blocks):
    """Draw the blocks with their joints; shear zones brown."""
    polygons = np.split(blocks.vertices, blocks.offsets[1:-1])
    face = np.where(blocks.rock == list(blocks.rock_names).index("shear_zone"), "#d9c09c", "#f3f0ea")
    axes.add_collection(PolyCollection(polygons, facecolors=face, edgecolors="#d5cfc2", linewidths=0.3))
    for number, name in enumerate(blocks.joint_names):
        edges = np.flatnonzero(blocks.edge_joint == number)
        lines = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
        axes.add_collection(LineCollection(lines, colors="#8a4b2a" if name == "SZ" else "#777777", linewidths=0.7))
    axes.add_patch(plt.Rectangle((station.LEFT, station.FLOOR), 6, 8, fill=False, color="black", linewidth=1.2))
    axes.set_xlim(*VIEW[:2])
    axes.set_ylim(*VIEW[2:])
    axes.set_aspect("equal")


def draw_mesh(whole, bolts):
    """Draw the mesh before excavation, and that with bolts (Figs. 8.3, 8.4)."""
    figure, (left, right) = plt.subplots(2, 1, figsize=(8, 8.6), height_ratios=(34, 56))
    draw_rock(left, whole.blocks)
    left.set_xlim(-46, 46)
    left.set_ylim(-25, 9)
    left.set_title("before excavation: shear zones brown, joints grey, elements light grey", fontsize=9)
    keep = np.ones(whole.blocks.count, dtype=bool)
    keep[whole.blocks.excavations["1"]] = False
    draw_rock(right, some_blocks(whole.blocks, keep))
    for bolt in bolts.bolts:
        right.plot(*np.array([bolt.start, bolt.end]).T, color="tab:green", linewidth=2)
        right.annotate(bolt.name, bolt.end, fontsize=7, color="darkgreen")
    for (x0, y0), (x1, y1) in station.EXTENSOMETERS.values():
        right.plot([x0, x1], [y0, y1], ":", color="tab:blue", linewidth=1.5)
    right.set_title("stage 1 with the bolts of Case 2 (green) and the lines of the extensometers (dotted)", fontsize=9)
    save(figure, "mesh.png")


def draw_vectors(movements):
    """Draw displacement vectors of blocks and finite elements side by side (Figs. 8.5-8.7, 8.11)."""
    names = [name for name in ("blocks, Case 1", SLIP, "blocks, Case 2") if name in movements]
    figure, axes = plt.subplots(1, len(names), figsize=(4.7 * len(names), 4.1))
    for place, name in zip(axes, names, strict=True):
        movement = movements[name]
        draw_rock(place, movement.blocks)
        centre, u = movement.blocks.moments.centroid, movement.displacement[:, :2]
        shown = np.flatnonzero((np.abs(centre[:, 0]) < VIEW[1]) & (centre[:, 1] > VIEW[2]))[::2]
        place.quiver(
            *centre[shown].T, *u[shown].T, angles="xy", scale_units="xy", scale=2.2e-3, width=3e-3, color="darkred"
        )
        place.set_title(f"{name}: greatest {1e3 * np.hypot(*u.T).max():.1f} mm", fontsize=9)
    save(figure, "vectors.png")


def draw_trough(movements, drawn):
    """Draw the settlement of the top of rock (Figs. 8.8, 8.9); layouts drawn by seed thin and grey."""
    figure, axes = plt.subplots(figsize=(8, 4))
    for number, movement in enumerate(drawn):
        points, u = movement.on_line(y=station.TOP, side=-1)
        label = None if number else f"blocks, Case 1, {len(drawn)} layouts by seed"
        axes.plot(points[:, 0], -1e3 * u[:, 1], color="silver", linewidth=0.7, label=label)
    for name, movement in movements.items():
        points, u = movement.on_line(y=station.TOP, side=-1)
        style = "--" if name == "blocks, elastic joints" else "-"
        axes.plot(points[:, 0], -1e3 * u[:, 1], style, color=COLOURS[name], linewidth=1.3, label=name)
    for settled, name, mark in ((4.0, "Rodriguez Perez, finite elements", "s"), (10.0, "BLOSMER", "^")):
        axes.plot(8.0, settled, mark, color="tab:purple", label=f"greatest, {name} (published)")
    axes.axvline(0.0, color="grey", linewidth=0.6)
    axes.invert_yaxis()
    axes.set_xlim(-46, 46)
    axes.set_xlabel("distance from the centre line, m (right positive)")
    axes.set_ylabel("settlement of the top of rock, mm")
    axes.legend(fontsize=7)
    save(figure, "settlement.png")


def draw_extensometers(movements):
    """Draw movements into the opening along four lines (Figs. 8.10, 8.12)."""
    figure, axes = plt.subplots(2, 2, figsize=(9, 6))
    for place, (title, line) in zip(axes.ravel(), station.EXTENSOMETERS.items(), strict=True):
        for name, movement in movements.items():
            distance, moved = movement.along(*line)
            style = "--" if name == "blocks, elastic joints" else "-"
            place.plot(distance, 1e3 * moved, style, color=COLOURS[name], linewidth=1.3, label=name)
        if title in MEASURED:
            place.axhspan(
                *MEASURED[title], xmin=0, xmax=0.06, color="tab:green", alpha=0.5, label="measured at the wall"
            )
        place.set_title(title, fontsize=9)
        place.set_xlabel("distance from the wall, m", fontsize=8)
        place.set_ylabel("into the opening, mm", fontsize=8)
        place.tick_params(labelsize=8)
    axes[0, 0].legend(fontsize=7)
    save(figure, "extensometers.png")


def draw_bolts(forces):
    """Draw the forces along the bolts and their pressures on the walls (Figs. 8.13, 8.14)."""
    figure, axes = plt.subplots(3, 5, figsize=(13, 7))
    equivalent = P_I * SHARE * forces.spacing / 1e3
    for place, bolt in zip(axes.ravel(), range(forces.count), strict=False):
        nodes = slice(forces.node_start[bolt], forces.node_start[bolt + 1])
        axial = forces.axial_force[nodes.start - bolt : nodes.stop - bolt - 1] / 1e3
        place.stairs(axial, forces.station[nodes], fill=True, color="tab:green", alpha=0.5)
        place.axhline(equivalent[bolt], color="black", linestyle="--", linewidth=0.8)
        place.set_title(forces.names[bolt], fontsize=9)
        place.set_ylim(0, 1.1 * max(forces.greatest_force.max() / 1e3, equivalent.max()))
        place.tick_params(labelsize=7)
    last = axes.ravel()[-1]
    places = np.arange(forces.count)
    last.bar(places - 0.2, forces.support_pressure / 1e3, 0.4, color="tab:green", label="at the head")
    last.bar(places + 0.2, forces.mean_pressure / 1e3, 0.4, color="tab:olive", label="mean along it")
    last.legend(fontsize=6)
    last.axhline(P_I / 1e3, color="black", linestyle="--", linewidth=0.8)
    last.set_xticks(places, forces.names, fontsize=6, rotation=60)
    last.tick_params(axis="y", labelsize=7)
    last.set_title("pressure on the wall, kPa", fontsize=9)
    figure.supxlabel("distance from the head, m", fontsize=9)
    figure.supylabel("tension, kN; dashed: P_i over a bolt's share of the wall", fontsize=9)
    save(figure, "bolts.png")


def save(figure, name):
    """Write a figure beside this script, in few colours: it is kept with the example."""
    figure.tight_layout()
    figure.savefig(station.HERE / name, dpi=90)
    plt.close(figure)
    Image.open(station.HERE / name).convert("RGB").quantize(48).save(station.HERE / name, optimize=True)


def main():
    """Draw the figures."""
    pressure, bolts = station.load(), station.load("bolts")
    runs = [bsm.run(model, OPTIONS) for model in (pressure, bolts)]
    movements = {
        "blocks, Case 1": station.movement_of(runs[0]),
        "blocks, Case 2": station.movement_of(runs[1]),
        SLIP: station.continuum(pressure, joints=True, slips=True, order=1),
        "finite elements, elastic joints": station.continuum(pressure, joints=True),
        "finite elements, no joints": station.continuum(pressure, joints=False),
        "blocks, elastic joints": station.linear_blocks(pressure),
    }
    movements = {name: movement for name, movement in movements.items() if movement is not None}
    layouts = [bsm.run(model, OPTIONS) for _, model in sweep.layouts(pressure)]
    draw_mesh(pressure, bolts)
    draw_vectors(movements)
    draw_trough(
        movements,
        [station.movement_of(run) for run in layouts if verdict_in_words(run.blocks, run.stages[-1]) == "stable"],
    )
    draw_extensometers(movements)
    draw_bolts(runs[1].stages[-1].bolts)


if __name__ == "__main__":
    main()
