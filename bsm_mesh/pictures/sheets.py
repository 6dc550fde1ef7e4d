"""Scenes and sheets by the kind of blocks: in the plane, in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bsm_mesh.errors import ModelError
from bsm_mesh.model.kinds import in_space
from bsm_mesh.pictures.canvas import Sheet, empty_axes
from bsm_mesh.pictures.look import Look
from bsm_mesh.pictures.scene import Scene, Window
from bsm_mesh.pictures.space_scene import SpaceScene
from bsm_mesh.pictures.space_sheet import SpaceSheet
from bsm_mesh.results.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def scene_of(
    results: Results, number: int, title: str, *, window: Window | None = None, look: tuple[float, float] | None = None
) -> Scene:
    """Return the scene of a stage.

    Parameters
    ----------
    results, number, title, window
        As of `Scene`.
    look : (azimuth, plunge), optional [degrees]
        From where blocks in space are seen.

    Raises
    ------
    ModelError
        If it is no direction, or there is a window for blocks in space, a direction for blocks in the plane.
    """
    if not in_space(results.blocks):
        if look is not None:
            raise ModelError(
                "plot: look (--look) is for three dimensions, and these blocks are in the plane; leave it out"
            )
        return Scene(results=results, number=number, title=title, window=window)
    if window is not None:
        raise ModelError("plot: window (--window) is for blocks in the plane; leave it out, or give look (--look)")
    return SpaceScene(results=results, number=number, title=title, look=look and Look.checked(*look))


def new_sheet(scene: Scene, figure: Figure | None = None, place: tuple[int, int, int] = (1, 1, 1)) -> Sheet:
    """Return an empty sheet for a scene, on a figure of its own where none is given, at a place as of a subplot."""
    figure, axes = empty_axes(scene, figure, place)
    if isinstance(scene, SpaceScene):
        return SpaceSheet(figure=figure, axes=axes, scene=scene)
    return Sheet(figure=figure, axes=axes, scene=scene)
