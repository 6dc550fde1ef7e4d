"""From the model file to the model; every fault of the file is reported at once."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from bsm_mesh.errors import MeshWarning, ModelError, one_line, placed, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import beyond_usual
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantities import MERGE_TOLERANCE
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.modelfile.build_bolts import make_bolts
from bsm_mesh.modelfile.build_mesh import read_blocks
from bsm_mesh.modelfile.build_parts import (
    collected,
    make_history,
    make_in_situ,
    make_joint,
    make_load,
    make_options,
    make_rock,
    make_stage,
    make_supports,
    make_water,
)
from bsm_mesh.modelfile.flow_tables import make_flow
from bsm_mesh.modelfile.mesh_tables import LineFile
from bsm_mesh.modelfile.model_file import read_model_file, read_toml, validated
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_file import Cutter, blocks_of, cut_space_file, validated_space
from bsm_mesh.modelfile.space_mesh import default_of_blocks
from bsm_mesh.modelfile.space_model import space_model
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.modelfile.unused import excavations_left, unused_notes

if TYPE_CHECKING:
    from bsm_mesh.converters import MeshReport, Note

Reporter = Callable[[str], None]
Mesher: TypeAlias = "Callable[[ModelFile, Path, Reach], tuple[Blocks, MeshReport]]"
"""Returns the blocks of a mesh, and the report on it: `read_blocks`, or what keeps what that returned."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedModel:
    """A model as its file describes it.

    Attributes
    ----------
    path : Path
        The model file.
    reach : Reach
        Its rights.
    file : ModelFile or SpaceFile
        Its content.
    model : Model
        The model built from it.
    options : Options
        How it is to be solved.
    notes : tuple of str
        Repairs and omissions of the mesh, and possible slips in the file, a line each.
    mesh_lines : tuple of str
        Findings in the mesh, a line each, the notes included.
    dangling : mapping of str to int
        Pieces of the mesh's joints that bound no block.
    """

    path: Path
    reach: Reach
    file: ModelFile | SpaceFile
    model: Model
    options: Options
    notes: tuple[str, ...]
    mesh_lines: tuple[str, ...]
    dangling: Mapping[str, int]

    @property
    def output_folder(self) -> Path:
        """Where the file says that results go."""
        return output_folder(self.file, self.path, self.reach)


def read_file(path: Path) -> ModelFile | SpaceFile:
    """Return the content of a model file, of the plane or of three dimensions.

    Raises
    ------
    ModelError
        As `read_model_file`.
    """
    return checked(read_toml(path, "model file"), path.name)


def checked(content: dict[str, Any], name: str) -> ModelFile | SpaceFile:
    """Return the content of a model file of the plane or of three dimensions, checked; `name` is the file's."""
    dimensions = content.get("dimensions")
    if dimensions not in (None, 3):
        raise ModelError(f"{name}: dimensions = {dimensions!r}: must be 3; in a model of the plane leave it out")
    return (validated_space if dimensions == 3 else validated)(content, name)


def output_folder(file: ModelFile | SpaceFile, path: Path, reach: Reach) -> Path:
    """Return where a model file says that results go: by default to a folder of the file's name."""
    return reach.output(file.output.folder or f"out/{path.stem}")


def inputs_of(file: ModelFile | SpaceFile, path: Path) -> list[Path]:
    """Return the files that a model is made of: the model file, its mesh or script, its tables."""
    script = file.mesh.geometry if (file.mesh.geometry or "").endswith(".py") else None
    if isinstance(file, SpaceFile):
        given = [file.mesh.file, script, *(body.profile for body in file.excavation)]
        return [path, *(path.parent / name for name in given if name is not None)]
    lines = (table.along.file for table in file.joint.values() if isinstance(table.along, LineFile))
    beside = (name for table in file.history for name in table.measured)
    names = [file.mesh.file, script, *(table.table for table in file.bolt), *lines, *beside]
    return [path, *(path.parent / name for name in names if name is not None)]


def load(path: str | os.PathLike[str], *, scripts: bool = True) -> Model:
    """Return the model of a model file, with its ``[solver]`` as ``model.options``.

    Repairs of its mesh are warnings (`MeshWarning`). The output of its geometry script is dropped; ``bsm-mesh mesh``
    shows it.

    Parameters
    ----------
    path : path
        The file.
    scripts : bool
        Whether it may run a geometry script and name any path. If not, no code of its own is run, and nothing outside
        its folder is read.

    Raises
    ------
    ModelError
        With every fault found in the file, its mesh or the model as a whole.
    """
    path = Path(path)
    loaded = build_file(read_file(path), path, Reach(folder=path.parent, scripts=scripts))
    for note in loaded.notes:
        warnings.warn(one_line(note), MeshWarning, stacklevel=3)  # where `bsm.load` was called
    return loaded.model


def load_model_file(
    path: Path, report: Reporter = lambda text: None, *, scripts: bool = True, space: bool = False
) -> LoadedModel:
    """Return the model of a model file with its options and the notes on its mesh, of three dimensions with `space`."""
    file = read_file(path) if space else read_model_file(path)
    return build_file(file, path, Reach(folder=path.parent, scripts=scripts), report)


def build_file(
    file: ModelFile | SpaceFile,
    path: Path,
    reach: Reach,
    report: Reporter = lambda text: None,
    mesher: Mesher = read_blocks,
    cutter: Cutter = blocks_of,
) -> LoadedModel:
    """Return the model of a file of the plane, its blocks by a `Mesher`, or of three dimensions, by a `Cutter`."""
    if isinstance(file, ModelFile):
        return _build_plane(file, path, reach, report, mesher)
    report("reading the mesh" if file.mesh.box is None else "cutting the rock")
    model = space_model(cut_space_file(file, path, reach, cutter), reach)
    assert model.options is not None
    assert in_space(model.blocks)
    left = (text for _, text in excavations_left(model.blocks, model.stages))
    return LoadedModel(
        path=path,
        reach=reach,
        file=file,
        model=model,
        options=model.options,
        notes=(*default_of_blocks(file, model.blocks), *left),
        mesh_lines=(),
        dangling={},
    )


def _build_plane(file: ModelFile, path: Path, reach: Reach, report: Reporter, mesher: Mesher) -> LoadedModel:
    """Return the model of a model file that was read, with its options and the notes on its mesh, by a `Mesher`."""
    faults: list[str] = []
    rocks = collected(faults, [partial(make_rock, name, table) for name, table in file.rock.items()])
    joints = collected(faults, [partial(make_joint, name, table) for name, table in file.joint.items()])
    supports = collected(
        faults, [partial(make_supports, table, f"[[support]] number {k + 1}") for k, table in enumerate(file.support)]
    )
    loads = collected(
        faults, [partial(make_load, table, f"[[load]] number {k + 1}") for k, table in enumerate(file.load)]
    )
    ground = collected(faults, [] if file.in_situ is None else [partial(make_in_situ, file.in_situ)])
    water = collected(faults, [] if file.water is None else [partial(make_water, file.water, "[water]")])
    flow = collected(faults, [] if file.flow is None else [partial(make_flow, file.flow)])
    stages = collected(faults, [partial(make_stage, table, reach) for table in file.stage])
    stage_names = [INITIAL, *(table.name for table in file.stage)]
    histories = collected(faults, [partial(make_history, table, reach, stage_names) for table in file.history])
    options = collected(faults, [partial(make_options, file.solver, file.falls)])
    collected(faults, [partial(output_folder, file, path, reach)])
    raise_faults([f"{path.name}: {fault}" for fault in faults])
    report("mesh")
    blocks, mesh_report = mesher(file, path, reach)
    bolts = collected(
        faults,
        [
            partial(make_bolts, table, f"[[bolt]] number {k + 1}", blocks, mesh_report.bolts, reach, stages)
            for k, table in enumerate(file.bolt)
        ],
    )
    raise_faults([f"{path.name}: {fault}" for fault in faults])
    with placed(path.name), _told_of_unused_curves(mesh_report):
        model = Model(
            blocks=blocks,
            rocks=tuple(rocks),
            joints=tuple(joints),
            default_joint=file.mesh.default_joint,
            supports=tuple(support for group in supports for support in group),
            loads=tuple(loads),
            bolts=tuple(bolt for group in bolts for bolt in group),
            gravity_direction=file.gravity.direction,
            gravity_horizontal=file.gravity.horizontal,
            gravity_vertical=file.gravity.vertical,
            contact_points=file.mesh.contact_points,
            in_situ=ground[0] if ground else None,
            water=water[0] if water else None,
            flow=flow[0] if flow else None,
            stages=tuple(stages),
            histories=tuple(histories),
            options=options[0],
            title=file.title,
        )
        unused = unused_notes(file, model, mesh_report, bolts)
    beside = (*beyond_usual("", "merge_tolerance", file.mesh.merge_tolerance, MERGE_TOLERANCE), *unused)
    return _loaded(file, path, reach, model, mesh_report, beside)


def _loaded(
    file: ModelFile, path: Path, reach: Reach, model: Model, report: MeshReport, beside: tuple[str, ...]
) -> LoadedModel:
    """Return a model with the findings in its mesh, and additional notes."""
    assert model.options is not None
    report = replace(report, notes=_of_what_is_used(report, model))
    return LoadedModel(
        path=path,
        reach=reach,
        file=file,
        model=model,
        options=model.options,
        notes=(*(note.text for note in report.notes), *beside),
        mesh_lines=(report.sizes, *report.lines()[1:], *(f"note: {text}" for text in beside)),
        dangling=_dangling(report),
    )


def _of_what_is_used(report: MeshReport, model: Model) -> tuple[Note, ...]:
    """Return the notes on a mesh; rock on both sides of a boundary matters to loads and supports only."""
    from bsm_mesh.converters import NoteKind

    acting = (*model.supports, *model.loads, *(load for stage in model.stages for load in stage.loads))
    used = {f"boundary:{getattr(each, 'boundary', None)}" for each in acting}
    return tuple(note for note in report.notes if note.kind is not NoteKind.INTERIOR or note.name in used)


@contextmanager
def _told_of_unused_curves(report: MeshReport) -> Iterator[None]:
    """Add to a fault that misses a boundary or a joint the curve groups of the mesh whose names say nothing."""
    from bsm_mesh.converters import NoteKind

    try:
        yield
    except ModelError as error:
        texts = [note.text for note in report.notes if note.kind is NoteKind.UNKNOWN_GROUP]
        missed = any(words in str(error) for words in ("no boundary", "used by no face"))
        curves = [text for text in texts if text.startswith("curve") and missed]
        raise ModelError([*error.faults, *curves]) from error


def _dangling(report: MeshReport) -> dict[str, int]:
    from bsm_mesh.converters import NoteKind

    found: dict[str, int] = {}
    for kind in (NoteKind.LOOSE, NoteKind.LOST, NoteKind.DEAD_END):
        for name, count in report.about(kind).items():
            if name.startswith("joint:"):
                found[name] = found.get(name, 0) + count
    return found
