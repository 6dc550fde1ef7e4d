"""The pictures of a results folder, drawn off screen with PyVista: ``python -m bsm_mesh.app.pictures OUT``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.app.added_files import AddedFiles
from bsm_mesh.app.canvas import Scene, add_blocks, add_paper, outline_of, save_picture, scalar_bar, scaled
from bsm_mesh.app.headings import PICTURES_FOLDER, heading
from bsm_mesh.app.plot import BAD_INPUT
from bsm_mesh.app.storage import SavedResults, load_results
from bsm_mesh.app.tables import engineering
from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, counted

if TYPE_CHECKING:
    from bsm_mesh.converters.vtk_files import Grid

MOST_GLYPHS = 1200  # arrows or crosses; more cannot be told apart
EXAGGERATED = 0.05  # of the model's size: greatest displacement drawn in the picture of the deformation


def draw_pictures(folder: Path) -> list[Path]:
    """Draw every picture of the last stage and return their paths."""
    import pyvista

    pyvista.OFF_SCREEN = True
    from bsm_mesh.converters.result_files import stage_file

    added = AddedFiles(folder)  # before anything is read: what is drawn belongs to what is there now
    saved = SavedResults(folder)
    saved.check()
    last = len(saved.told["stages"]) - 1
    grid = read_grid(saved, stage_file("blocks", last), needs=("displacement", "sigma_1", "stress"))
    joints = saved.grid(stage_file("joints", last), needs=("joint",))
    size, title = float(grid.length), heading(saved.told)
    bolts = _bolts(saved, last) if "bolts" in saved.told["stages"][-1] else None
    scene = Scene(
        grid=grid,
        title=title,
        size=size,
        joints=joint_traces(joints),
        water=saved.water_table(last),
        bolts=bolts,
    )
    drawers: dict[str, Callable[[Path], object]] = {
        name: partial(save_picture, scene, draw) for name, draw in PICTURES.items()
    }
    if bolts is not None:
        from bsm_mesh.app.bolt_pictures import draw_bolt_forces, draw_bolts

        drawers["bolts"] = partial(save_picture, scene, draw_bolts)
        drawers["bolt_forces"] = partial(draw_bolt_forces, load_results(folder).stages[-1].bolts, title)
    if saved.told.get("histories"):
        from bsm_mesh.app.history_pictures import draw_histories

        drawers["histories"] = partial(draw_histories, load_results(folder), title)
    return [add_picture(added, f"{name}.png", draw) for name, draw in drawers.items()]


def add_picture(added: AddedFiles, name: str, draw: Callable[[Path], object]) -> Path:
    """Add what `draw` draws to the pictures of a results folder, and return its path."""
    with added.file(f"{PICTURES_FOLDER}/{name}") as draft:
        draw(draft)
    return added.folder.path / PICTURES_FOLDER / name


def read_grid(saved: SavedResults, name: str, needs: Sequence[str]) -> Any:
    """Return a grid for PyVista."""
    import pyvista

    return pyvista.wrap(saved.vtk_grid(name, needs=needs))


def _bolts(saved: SavedResults, stage: int) -> Any:
    """Return the bolts that are there at the end of a stage."""
    from bsm_mesh.converters.result_files import stage_file

    bolts = read_grid(saved, stage_file("bolts", stage), needs=("axial_force", "alive"))
    return bolts.extract_cells(np.flatnonzero(bolts.cell_data["alive"]))


def joint_traces(joints: Grid) -> FloatArray:
    """Return both ends of every face that has a joint, (k, 2, 2) [m], where the blocks were given."""
    traces: FloatArray = joints.points.reshape(-1, 2, 2)[joints.cell_data["joint"] >= 0]
    return traces


def draw_displacement(plotter: Any, scene: Scene) -> str:
    """Blocks by the magnitude of their displacement."""
    size = np.linalg.norm(scene.grid.cell_data["displacement"], axis=1)
    values, unit = scaled(size, "m")
    remark = add_blocks(plotter, scene, values, f"displacement, {unit}", "viridis")
    return f"displacement of the blocks, greatest {engineering(float(size.max()), 'm')}{remark}"


def draw_sigma_1(plotter: Any, scene: Scene) -> str:
    """Blocks by their most compressive principal stress."""
    sigma = np.asarray(scene.grid.cell_data["sigma_1"])
    values, unit = scaled(sigma, "Pa")
    remark = add_blocks(plotter, scene, values, f"sigma_1, {unit} (compression negative)", "viridis_r")
    return f"most compressive principal stress, {engineering(float(sigma.min()), 'Pa')} at most{remark}"


def draw_arrows(plotter: Any, scene: Scene) -> str:
    """Displacement arrows on the blocks' outlines."""
    grid = scene.grid
    add_paper(plotter, scene)
    chosen, spacing = _spread(grid)
    vectors = np.asarray(grid.cell_data["displacement"])[chosen]
    length = np.linalg.norm(vectors, axis=1)
    greatest = float(np.linalg.norm(grid.cell_data["displacement"], axis=1).max())
    if greatest > 0:
        import pyvista

        points = pyvista.PolyData(grid.cell_centers().points[chosen] + (0, 0, 0.01 * scene.size))
        points["displacement"], unit = scaled(length, "m")
        points["arrow"] = vectors
        longest = 1.6 * spacing / float(points["displacement"].max())
        arrows = points.glyph(orient="arrow", scale="displacement", factor=longest, geom=_flat_arrow())
        plotter.add_mesh(
            arrows,
            scalars="displacement",
            cmap="plasma",
            lighting=False,
            scalar_bar_args=scalar_bar(f"displacement, {unit}"),
        )
    return f"displacement, greatest {engineering(greatest, 'm')}, {len(chosen)} of {counted(grid.n_cells, 'block')}"


def draw_principal_stresses(plotter: Any, scene: Scene) -> str:
    """Crosses of the principal stresses (as Wang Fig. 3.18): compression dark, tension red."""
    import pyvista

    grid = scene.grid
    add_paper(plotter, scene)
    chosen, spacing = _spread(grid)
    xx, yy, _, xy, _, _ = np.asarray(grid.cell_data["stress"])[chosen].T
    angle = np.arctan2(2 * xy, xx - yy) / 2  # direction of the greatest (least compressive) stress
    mean, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    greatest = float(max(np.abs(mean + radius).max(), np.abs(mean - radius).max(), 1e-300))
    centre = grid.cell_centers().points[chosen]
    for colour, sign in (("#1f3b73", -1.0), ("#d62728", 1.0)):
        lines = []
        for value, turn in ((mean + radius, 0.0), (mean - radius, np.pi / 2)):
            shown = value * sign > 0.002 * greatest
            along = np.column_stack([np.cos(angle + turn), np.sin(angle + turn), np.zeros(len(angle))])
            half = along * (np.abs(value) / greatest * 0.9 * spacing)[:, None]
            lines.append(np.stack([centre - half, centre + half], axis=1)[shown].reshape(-1, 3))
        points = np.concatenate(lines)
        points[:, 2] += 0.01 * scene.size
        if len(points):
            plotter.add_mesh(pyvista.line_segments_from_points(points), color=colour, line_width=2)
    return f"principal stresses, longest bar {engineering(greatest, 'Pa')}; blue compression, red tension"


def draw_deformation(plotter: Any, scene: Scene) -> str:
    """Deformed blocks, exaggerated, over their outline (as Wang Fig. 6.10)."""
    grid = scene.grid
    greatest = float(np.linalg.norm(grid.point_data["displacement"], axis=1).max())
    factor = max(_round_factor(EXAGGERATED * scene.size / greatest), 1.0) if greatest > 0 else 1.0
    warped = grid.copy()
    warped.points = grid.points + factor * grid.point_data["displacement"] + (0, 0, 0.005 * scene.size)
    plotter.add_mesh(warped, color="#c9d8ea", show_edges=scene.outlines, edge_color="#4a6a8a", lighting=False)
    outline = outline_of(grid)
    outline.points += (0, 0, 0.01 * scene.size)
    plotter.add_mesh(outline, color="black", line_width=2)
    return f"deformation, exaggerated {factor:g} times, over the original outline (black)"


def draw_final_position(plotter: Any, scene: Scene) -> str:
    """Blocks where they are at the end, true to scale, those that come down shaded (as Wang Fig. 4.19)."""
    count = add_position(plotter, scene)
    told = f", {count} {'block that comes' if count == 1 else 'blocks that come'} down in red" if count else ""
    return f"final position, true to scale, over the original outlines (grey){told}"


def add_position(plotter: Any, scene: Scene) -> int:
    """Draw blocks where they are over where they were, and return how many come down; those are red."""
    grid = scene.grid
    moved = grid.copy()
    moved.points = grid.points + grid.point_data["displacement"]
    unstable = np.asarray(grid.cell_data["unstable"]) > 0
    start = grid.copy()
    plotter.add_mesh(start, style="wireframe", color="#b9b2a3", line_width=1, lighting=False)
    moved.points[:, 2] = 0.005 * scene.size
    for chosen, colour in ((~unstable, "#c9d8ea"), (unstable, "#d9776b")):
        if chosen.any():
            part = moved.extract_cells(np.flatnonzero(chosen))
            plotter.add_mesh(part, color=colour, show_edges=scene.outlines, edge_color="#33475b", lighting=False)
    if scene.bolts is not None and scene.bolts.n_cells:
        bolts = scene.bolts.copy()
        bolts.points = bolts.points + bolts.point_data["displacement"] + (0, 0, 0.01 * scene.size)
        plotter.add_mesh(bolts, color="#1b5e20", line_width=5, lighting=False)
    return int(unstable.sum())


PICTURES: dict[str, Callable[[Any, Scene], str]] = {
    "displacement": draw_displacement,
    "sigma_1": draw_sigma_1,
    "displacement_arrows": draw_arrows,
    "principal_stresses": draw_principal_stresses,
    "deformation": draw_deformation,
    "final_position": draw_final_position,
}


def _spread(grid: Any) -> tuple[IntArray, float]:
    """Return at most `MOST_GLYPHS` cells spread evenly over the model, and their mean spacing [m]."""
    centre = grid.cell_centers().points[:, :2]
    area = float(np.sum(grid.compute_cell_sizes(length=False, volume=False)["Area"]))
    spacing = np.sqrt(area / min(grid.n_cells, MOST_GLYPHS))
    if grid.n_cells <= MOST_GLYPHS:
        return np.arange(grid.n_cells), float(spacing)
    square = np.floor((centre - centre.min(axis=0)) / spacing).astype(np.int64)
    _, chosen = np.unique(square, axis=0, return_index=True)
    return chosen, float(spacing)


def _flat_arrow() -> Any:
    """Return an arrow of length 1 along x, flat in the plane."""
    import pyvista

    points = [(0, -0.03), (0.68, -0.03), (0.68, -0.13), (1, 0), (0.68, 0.13), (0.68, 0.03), (0, 0.03)]
    return pyvista.PolyData(np.array([(*p, 0.0) for p in points]), faces=[7, *range(7)]).triangulate()


def _round_factor(factor: float) -> float:
    """Return 1, 2 or 5 times a power of ten, not above `factor`."""
    power = 10.0 ** np.floor(np.log10(factor))
    return float(max(step for step in (1, 2, 5) if step * power <= factor * (1 + 1e-9)) * power)


if __name__ == "__main__":
    try:
        for picture in draw_pictures(Path(sys.argv[1])):
            print(picture)
    except ModelError as error:
        print(error, file=sys.stderr)
        sys.exit(BAD_INPUT)
