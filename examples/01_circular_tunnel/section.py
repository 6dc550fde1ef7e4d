"""Stresses on section I-I for three meshes: blocks, continuum of the same blocks, and Eq. 3.46.

Run ``python examples/01_circular_tunnel/section.py``: draws section.png.
"""

import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.converters.continuum import blocks_on_line
from bsm_mesh.geometries import circular_tunnel

HERE = Path(__file__).parent
A, DEPTH, GAMMA, MU, FAR = 2.0, 11.0, 26e3, 0.25, 22.0
K0 = MU / (1 - MU)


def eq_3_46(x, depth):
    """Return (sigma_h, sigma_v) [Pa] on the section by Wang Eq. 3.46, tension positive."""
    p, q, k = GAMMA * depth, K0 * GAMMA * depth, (A / x) ** 2
    sigma_h = -(p + q) / 2 * (1 - k) + (p - q) / 2 * (1 + 3 * k**2 - 4 * k)
    sigma_v = -(p + q) / 2 * (1 + k) - (p - q) / 2 * (1 + 3 * k**2)
    return sigma_h, sigma_v


def solve(size, kind="triangles", stiffness="wang", far=FAR):
    """Return model and comparison for an element size and a distance to the right and the bottom [m]."""
    with tempfile.TemporaryDirectory() as folder:
        path = circular_tunnel.build(
            Path(folder) / "tunnel.msh",
            radius=A,
            depth=DEPTH,
            below=far,
            width=far,
            mesh=kind,
            size=size,
            **({} if kind == "radial" else {"size_at_wall": 0.22 * size, "grading_distance": 10.0}),
        )
        blocks = converters.read_blocks(path)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", GAMMA, 50e9, MU, stiffness=stiffness)],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.Pressure(boundary="right", pressure=(K0 * GAMMA * DEPTH, 0.0, -K0 * GAMMA))],
    )
    return model, converters.compare(model, bsm.run(model, bsm.Options(scheme="linear")))


def errors(model, comparison):
    """Return L2 and greatest error [%] of sigma_v on the section, and L2 of all stresses within three radii."""
    section = comparison.along(blocks_on_line(model.blocks, (A, 0), (5 * A, 0)))
    difference, fem = section.bsm[:, 1, 1] - section.fem[:, 1, 1], section.fem[:, 1, 1]
    l2 = np.sqrt((section.area * difference**2).sum() / (section.area * fem**2).sum())
    near = np.hypot(*comparison.centroid.T) < 3 * A
    square = [
        (comparison.area[near] * (s[near] ** 2).sum(axis=(1, 2))).sum()
        for s in (comparison.stress_difference, comparison.nominal.stress)
    ]
    return 100 * l2, 100 * np.abs(difference).max() / np.abs(fem).max(), 100 * np.sqrt(square[0] / square[1])


def binned(section, component, edges):
    """Return area-weighted means of blocks, continuum and Eq. 3.46 [kPa, compression positive] by distance."""
    x, y = section.centroid.T
    exact = eq_3_46(x, DEPTH - y)[component]
    bin_of = np.digitize(x, edges) - 1
    rows = []
    for k in range(len(edges) - 1):
        here = bin_of == k
        weight = section.area[here] / section.area[here].sum()
        fields = (section.bsm[here, component, component], section.fem[here, component, component], exact[here])
        rows.append([-(weight * field).sum() / 1e3 for field in fields])
    return np.array(rows)


def draw(model, comparison):
    """Draw sigma_h and sigma_v on the section, as Wang Fig. 3.19."""
    section = comparison.along(blocks_on_line(model.blocks, (A, 0), (5 * A, 0)))
    x = section.centroid[:, 0]
    line = np.linspace(A, 5 * A, 200)
    figure, axes = plt.subplots(figsize=(7, 4.5))
    for component, name, colour in ((1, "sigma_v", "tab:red"), (0, "sigma_h", "tab:blue")):
        axes.plot(line, -eq_3_46(line, DEPTH)[component] / 1e3, color=colour, label=f"{name}, Eq. 3.46")
        axes.plot(x, -section.bsm[:, component, component] / 1e3, "o", ms=4, mfc="none", color=colour, label="blocks")
        axes.plot(x, -section.fem[:, component, component] / 1e3, "x", ms=4, color=colour, label="continuum")
    axes.set_xlabel("distance from the centre of the tunnel [m]")
    axes.set_ylabel("stress [kPa], compression positive")
    axes.set_title(f"Section I-I, {model.blocks.count} triangles")
    axes.grid(alpha=0.3)
    axes.legend(ncols=2, fontsize=8)
    figure.tight_layout()
    figure.savefig(HERE / "section.png", dpi=130)


def main():
    """Draw the picture."""
    draw(*solve(0.9))


if __name__ == "__main__":
    main()
