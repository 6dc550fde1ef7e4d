"""Pictures for scripts and notebooks: figures of Matplotlib of results, and of a model before it is run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from io import BytesIO
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.model.kinds import in_space
from bsm_mesh.pictures.beside import with_sources
from bsm_mesh.pictures.block_pictures import draw_model
from bsm_mesh.pictures.canvas import finish
from bsm_mesh.pictures.figures import plain_texts
from bsm_mesh.pictures.pictures import figure_of, refuse_window
from bsm_mesh.pictures.scene import Window
from bsm_mesh.pictures.sheets import new_sheet, scene_of
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results, Source, StageResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bsm_mesh.model.model import Model


def plot_results(
    results: Results,
    picture: str,
    stage: int | str,
    window: Window | None,
    figure: Figure | None,
    beside: Mapping[str, Source] | Sequence[Source] | Source = (),
    look: tuple[float, float] | None = None,
) -> Figure:
    """Return a picture of a stage; parameters and errors as for `Results.plot`."""
    if isinstance(beside, str | PathLike | Results) or beside:
        results = with_sources(results, beside)
    refuse_axes(figure)
    drawn = figure_of(results, picture, stage, window, figure, look)
    if drawn is None:
        raise ModelError(f"plot: there is nothing to show in '{picture}' of that stage")
    return _shown(drawn)


def plot_model(
    model: Model, window: Window | None, figure: Figure | None, look: tuple[float, float] | None = None
) -> Figure:
    """Return a picture of a model before it is run; parameters as for `Model.plot`."""
    refuse_axes(figure)
    refuse_window(window, ["model"])
    scene = scene_of(as_given(model), 0, f"{model.title or 'Model'}: as given", window=window, look=look)
    sheet = new_sheet(scene, figure)
    return _shown(finish(sheet, draw_model(sheet) or ""))


def refuse_axes(figure: object) -> None:
    """Raise a `ModelError` for anything but a figure of Matplotlib: axes of one, for example."""
    if figure is not None and not hasattr(figure, "add_subplot"):
        raise ModelError(
            f"plot: figure is of the kind {type(figure).__name__}; it must be a matplotlib Figure, such as axes.figure"
        )


def _shown(figure: Figure) -> Figure:
    """Return a figure that a notebook shows as it is: it shows those of pyplot only."""

    def png() -> bytes:
        content = BytesIO()
        figure.canvas.print_figure(content, format="png")
        return content.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined]
    return plain_texts(figure)


def as_given(model: Model) -> Results:
    """Return the state of a model before it is run: the start, where nothing moved and no contact carries.

    All bolts are there, those that a stage installs too; blocks that a stage fills in are not.
    """
    from bsm_mesh.model.stages import presence
    from bsm_mesh.model.supports import bars_of
    from bsm_mesh.results.evidence import Evidence
    from bsm_mesh.results.histories import recorded_of
    from bsm_mesh.solve.bolts.installed import InstalledBolts
    from bsm_mesh.solve.bolts.record import bolt_forces

    blocks = model.blocks
    acting = _acting_in_space(model) if in_space(blocks) else _acting(model)
    still = np.zeros_like(acting["loads"])
    bolts = InstalledBolts.of(model.replace(bolts=[replace(bolt, stage=None) for bolt in model.bolts]), still)
    stage = StageResult.as_given(
        present=presence(model.stages, blocks)[0],
        **acting,
        bolts=bolt_forces(model.bolts, bolts, bolts.evaluate(still)),
        evidence=Evidence.as_given(model.gravity_forces, bars_of(model.supports, blocks)),
    )
    return Results(
        blocks=blocks,
        joint_names=tuple(joint.name for joint in model.joints),
        stages=StageResults((stage,)),
        scheme="linear",
        linear_solver="",
        tolerance=0.0,
        model_digest=model.digest,
        title=model.title,
        default_joint=model.default_joint,
        recorded=tuple(recorded_of(history, spatial=in_space(blocks)) for history in model.histories),
        finished=True,
        model=model,
    )


def _acting(model: Model) -> dict[str, Any]:
    """Return loads and water on polygons as given: fields of `StageResult`."""
    from bsm_mesh.model.water_pressure import WaterLoad
    from bsm_mesh.solve.algebra.loads import external_loads

    blocks, water = model.blocks, WaterLoad(model)
    on_blocks = water.on_blocks(blocks.vertices, blocks.moments.centroid)
    return {"loads": external_loads(model), "water": on_blocks, **water.recorded()}


def _acting_in_space(model: Model) -> dict[str, Any]:
    """Return loads and water on polyhedra as given: fields of `StageResult`."""
    from bsm_mesh.three_d.loads.external import ExternalLoads
    from bsm_mesh.three_d.loads.water import joint_water

    external, given = ExternalLoads(model), np.zeros((model.blocks.count, 6))
    water, _ = external.water.on_blocks(given)
    dry = {"water_table": np.zeros((0, 2, 2)), "water_gradient": np.zeros(0)}  # a plane of head is no table
    return {"loads": external.at(given), "water": water, **dry, "joint_water": joint_water(model)}
