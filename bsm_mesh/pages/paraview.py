"""The command ``paraview``: a script that opens a results folder in ParaView as one would set it up by hand."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from bsm_mesh.files import write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.frames import frames_in
from bsm_mesh.folder.saved_results import SavedResults, damage_told, find_results
from bsm_mesh.movements import lengths
from bsm_mesh.pages.view_space import view_of_space
from bsm_mesh.text.exaggeration import exaggeration, size_of

SCRIPT, TEMPLATE = "in_paraview.py", "in_paraview.py.j2"  # a paraview.py would hide ParaView's own module
PLANE_VIEW = {"in_space": False, "axes": "((1, 0, 0), (0, 1, 0), (0, 0, -1))", "opacity": 1.0}
OPACITY = 0.12  # of blocks in space where something within is to be seen
KINDS = ("blocks", "joints", "contacts", "supports", "bolts", "water", "flow")


def write_paraview(out: Path) -> Path:
    """Write the script of a results folder into it and return its path.

    Raises
    ------
    ModelError
        If the folder holds no results, or they are damaged.
    """
    from jinja2 import Environment

    find_results(out)
    added, saved = AddedFiles(out), SavedResults(out)
    with damage_told(out):
        greatest, factor, size = _movements(saved)
        states = [frame.label for frame in frames_in(saved)]
    text = f"{saved.told['title'] or 'bsm-mesh'}; {'true to scale' if factor == 1 else f'movements {factor:g} times'}"
    template = resources.files("bsm_mesh.pages").joinpath(TEMPLATE).read_text(encoding="utf-8")
    script = (
        Environment(keep_trailing_newline=True)
        .from_string(template)
        .render(
            name=SCRIPT,
            heading=repr(text),
            folder=repr(str(out.absolute())),
            kinds=repr([kind for kind in KINDS if f"{kind}.pvd" in saved]),
            states=repr(states),
            exaggeration=factor,
            greatest=greatest,
            size=size,
            **(_view_of_space(out) if saved.in_space else PLANE_VIEW),
        )
    )
    with added.file(SCRIPT) as draft:
        write_text(draft, script)
    return out / SCRIPT


def _movements(saved: SavedResults) -> tuple[float, float, float]:
    """Return the greatest displacement of a block that does not fall [m], the factor on movements, the size [m].

    Where blocks fall all is drawn true to scale.
    """
    grids = [saved.grid(frame.file("blocks"), needs=("displacement",)) for frame in frames_in(saved) if frame.is_end]
    blocks = saved.blocks()
    moved = [
        float(lengths(grid.cell_data["displacement"][grid.cell_data["unstable"] == 0]).max(initial=0.0))
        for grid in grids
    ]
    falls = any(stage["unstable_blocks"] for stage in saved.told["stages"])
    factors = [exaggeration(most, blocks, grid.cell_data["block_id"]) for most, grid in zip(moved, grids, strict=True)]
    return max(moved), 1.0 if falls else min(factors), size_of(blocks)


def _view_of_space(out: Path) -> dict[str, Any]:
    """Return the view of polyhedra: as of the pictures, through the blocks where an excavation or bolts lie within."""
    view = view_of_space(out)
    axes = tuple(tuple(round(part, 6) for part in axis) for axis in view.axes.tolist())
    return {"in_space": True, "axes": repr(axes), "opacity": OPACITY if view.within else 1.0}
