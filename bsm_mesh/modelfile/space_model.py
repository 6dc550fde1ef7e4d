"""From a model file of three dimensions to the model that is run: its blocks with supports, loads and stages."""

from __future__ import annotations

from functools import partial

from bsm_mesh.errors import placed, raise_faults
from bsm_mesh.model.histories import History
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.water import HeadPlane, Water
from bsm_mesh.modelfile.build_bolts import make_space_bolts
from bsm_mesh.modelfile.build_parts import collected, make_in_situ, make_load, make_options, make_supports
from bsm_mesh.modelfile.class_keys import given_in
from bsm_mesh.modelfile.model_tables import SupportTable
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_file import LoadedSpace
from bsm_mesh.modelfile.space_tables import SpaceStageTable, SpaceWaterTable
from bsm_mesh.modelfile.unused import bolts_on_nothing


def space_model(loaded: LoadedSpace, reach: Reach) -> Model:
    """Return the model of a file of three dimensions whose blocks are cut.

    Raises
    ------
    ModelError
        With every fault of the file, of the rock that it describes, or of the model as a whole.
    """
    file, path, faults = loaded.file, loaded.path, list[str]()
    supports = collected(
        faults,
        (
            partial(make_supports, SupportTable(**table.model_dump()), f"[[support]] number {k + 1}")
            for k, table in enumerate(file.support)
        ),
    )
    loads = collected(
        faults, (partial(make_load, table, f"[[load]] number {k + 1}") for k, table in enumerate(file.load))
    )
    bolts = collected(
        faults,
        (partial(make_space_bolts, table, f"[[bolt]] number {k + 1}", reach) for k, table in enumerate(file.bolt)),
    )
    stages = collected(faults, [partial(_stage, table) for table in file.stage])
    water = collected(faults, [] if file.water is None else [partial(_water, file.water, "[water]")])
    ground = collected(faults, [] if file.in_situ is None else [partial(make_in_situ, file.in_situ)])
    histories = collected(faults, [partial(History, **table.model_dump()) for table in file.history])
    options = collected(faults, [partial(make_options, file.solver, file.falls)])
    raise_faults([f"{path.name}: {fault}" for fault in faults])
    with placed(path.name):
        model = Model(
            blocks=loaded.blocks,
            rocks=loaded.rocks,
            joints=loaded.joints,
            default_joint=file.mesh.default_joint,
            supports=tuple(support for group in supports for support in group),
            loads=tuple(loads),
            bolts=tuple(bolt for group in bolts for bolt in group),
            gravity_horizontal=file.gravity.horizontal,
            gravity_vertical=file.gravity.vertical,
            gravity_trend=file.gravity.trend,
            contact_points=file.mesh.contact_points,
            in_situ=ground[0] if ground else None,
            water=water[0] if water else None,
            stages=tuple(stages),
            histories=tuple(histories),
            options=options[0],
            title=file.title,
        )
        if not file.mesh.allow_unused:
            raise_faults([f"{text}; let one cross a joint, or leave it out" for text in bolts_on_nothing(model, bolts)])
    return model


def _stage(table: SpaceStageTable) -> Stage:
    """Return a stage."""
    where = f"stage '{table.name}'"
    loads = tuple(make_load(load, f"{where}: load {k + 1}") for k, load in enumerate(table.load))
    water = None if table.water is None else _water(table.water, f"{where}: water")
    gravity = None if table.gravity is None else (table.gravity.horizontal, table.gravity.vertical)
    return Stage(
        **given_in(table, Stage, without=("loads", "water", "gravity", "gravity_trend")),
        loads=loads,
        water=water,
        gravity=gravity,
        gravity_trend=None if table.gravity is None else table.gravity.trend,
    )


def _water(table: SpaceWaterTable, where: str) -> Water:
    """Return the groundwater."""
    with placed(where):
        plane = None if table.plane is None else HeadPlane(**table.plane.model_dump())
        return Water(**given_in(table, Water, without=("plane",)), plane=plane)
