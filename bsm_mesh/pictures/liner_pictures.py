"""The diagram of a liner: moments over thrusts of its sections, with the envelope of capacity."""

from __future__ import annotations

from pathlib import Path

from bsm_mesh.pictures.beside_marks import COLOURS
from bsm_mesh.pictures.canvas import WIDTH
from bsm_mesh.pictures.figures import paper, save
from bsm_mesh.results.liner import Capacity, LinerForces

HEIGHT = 7.0  # inches


def draw_capacity(found: LinerForces, capacity: Capacity, title: str, path: Path) -> None:
    """Draw every section as a point, and an envelope for each thickness that occurs, rounded to millimetres."""
    figure = paper((WIDTH / 100, HEIGHT))
    axes = figure.add_subplot()
    used = found.utilisation(capacity.compressive_strength, capacity.tensile_strength)
    for name, chosen, marker in (("within", used <= 1, "o"), ("beyond", ~(used <= 1), "X")):
        if chosen.any():
            axes.plot(
                1e-3 * found.moment[chosen], 1e-3 * found.thrust[chosen], marker, ms=5, color=COLOURS[marker == "X"],
                label=f"{chosen.sum()} sections {name} capacity",
            )  # fmt: skip
    for thickness in {round(float(t), 3) for t in (found.thickness.min(), found.thickness.max())}:
        moments, thrusts = capacity.envelope(max(thickness, 1e-3))
        axes.plot(1e-3 * moments, 1e-3 * thrusts, color="black", lw=1.2, label=f"capacity, {1e3 * thickness:.0f} mm")
    axes.axhline(0, color="grey", lw=0.6)
    axes.axvline(0, color="grey", lw=0.6)
    axes.set_xlabel("moment, kN m/m (positive: inside compressed)")
    axes.set_ylabel("thrust, kN/m (compression positive)")
    axes.legend(fontsize=9)
    axes.set_title(title, parse_math=False)
    save(figure, path)
