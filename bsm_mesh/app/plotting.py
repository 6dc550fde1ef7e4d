"""Pictures for scripts and notebooks: figures of Matplotlib of results, and of a model before it is run."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.app.block_pictures import draw_model
from bsm_mesh.app.canvas import finish, new_sheet
from bsm_mesh.app.pictures import figure_of
from bsm_mesh.app.scene import Scene, Window
from bsm_mesh.errors import ModelError
from bsm_mesh.results.records import ContactForces, StageResult, Status, SupportForces
from bsm_mesh.results.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bsm_mesh.model.model import Model

NO_ROWS: dict[str, Any] = {
    **dict.fromkeys(("block_a", "block_b", "joint"), np.zeros(0, np.int32)),
    **dict.fromkeys(("point", "normal"), np.zeros((0, 2))),
    **dict.fromkeys(("length", "normal_force", "shear_force", "opening", "slip"), np.zeros(0)),
    **dict.fromkeys(("utilisation", "water_pressure"), np.zeros(0)),
    "status": np.zeros(0, np.int8),
}
NO_CONTACTS = ContactForces(**NO_ROWS)
NO_SUPPORTS = SupportForces(
    block=np.zeros(0, np.int32), point=np.zeros((0, 2)), reaction=np.zeros((0, 2)), moment=np.zeros(0)
)


def plot_results(
    results: Results, picture: str, stage: int | str, window: Window | None, figure: Figure | None
) -> Figure:
    """Return a picture of a stage; parameters and errors as for `Results.plot`."""
    drawn = figure_of(results, picture, stage, window, figure)
    if drawn is None:
        raise ModelError(f"plot: there is nothing to show in '{picture}' of that stage")
    return _shown(drawn)


def plot_model(model: Model, window: Window | None, figure: Figure | None) -> Figure:
    """Return a picture of a model before it is run; parameters as for `Model.plot`."""
    scene = Scene(results=as_given(model), number=0, title=f"{model.title or 'Model'}: as given", window=window)
    sheet = new_sheet(scene, figure)
    return _shown(finish(sheet, draw_model(sheet) or ""))


def _shown(figure: Figure) -> Figure:
    """Return a figure that a notebook shows as it is: it shows those of pyplot only."""

    def png() -> bytes:
        content = BytesIO()
        figure.canvas.print_figure(content, format="png")
        return content.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined]
    return figure


def as_given(model: Model) -> Results:
    """Return what is known of a model before it is run: the start, where nothing has moved and no contact bears.

    All bolts are there, those that a stage installs too; blocks that a stage fills in are not.
    """
    from bsm_mesh.model.stages import presence
    from bsm_mesh.model.supports import bars_of
    from bsm_mesh.model.water_pressure import WaterLoad
    from bsm_mesh.results.evidence import Evidence, bar_rows
    from bsm_mesh.solve.algebra.loads import external_loads
    from bsm_mesh.solve.bolts.installed import InstalledBolts
    from bsm_mesh.solve.bolts.record import bolt_forces

    blocks, water = model.blocks, WaterLoad(model)
    still, tensors = np.zeros((blocks.count, 3)), np.zeros((blocks.count, 2, 2))
    bolts = InstalledBolts.of(model.replace(bolts=[replace(bolt, stage=None) for bolt in model.bolts]), still)
    bars = bars_of(model.supports, blocks)
    none = np.zeros(0)
    evidence = Evidence(
        laws=(),
        law=none.astype(np.int32),
        failed=none.astype(bool),
        tension=none,
        normal_stiffness=none,
        shear_stiffness=none,
        near=none.astype(bool),
        slip_path=none,
        weight=model.gravity_forces,
        bolt_pair=np.zeros((0, 2), np.int32),
        bolt_tangent=np.zeros((0, 3, 3)),
        **bar_rows(bars, bars.point),
    )
    stage = StageResult(
        name="as given",
        status=Status.UNFINISHED,
        reason="it was not run",
        present=presence(model.stages, blocks)[0],
        displacement=still,
        stage_displacement=still,
        origin=still,
        stress=tensors,
        stress_effective=tensors,
        loads=external_loads(model),
        reactions=still,
        water=water.on_blocks(blocks.vertices, blocks.moments.centroid),
        water_table=water.surface.between(*blocks.extent),
        contacts=NO_CONTACTS,
        supports=NO_SUPPORTS,
        bolts=bolt_forces(model.bolts, bolts, bolts.evaluate(still)),
        unstable_blocks=np.zeros(0, np.int32),
        start_residual=0.0,
        residual=0.0,
        reference_weight=0.0,
        steps=(),
        evidence=evidence,
    )
    return Results(
        blocks=blocks,
        joint_names=tuple(joint.name for joint in model.joints),
        stages=(stage,),
        scheme="linear",
        linear_solver="",
        tolerance=0.0,
        model_digest=model.digest,
        title=model.title,
        default_joint=model.default_joint,
        finished=True,
        model=model,
    )
