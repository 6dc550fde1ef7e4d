"""The command ``compare``: a model as blocks and as a continuum."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.errors import named_stage, one_line, placed
from bsm_mesh.files import write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.modelfile.build_marks import geometry_faults
from bsm_mesh.modelfile.build_mesh import stdout_to_stderr
from bsm_mesh.results.results import Results
from bsm_mesh.run import run
from bsm_mesh.text.beside_tables import table_of
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import engineering, print_table
from bsm_mesh.text.terminal import say, say_json

if TYPE_CHECKING:
    from bsm_mesh.converters.continuum import ComparedStage, Comparison, Difference, Refinement

HISTORIES, CONTINUUM = "compare_histories.csv", "finite elements"
NOT_COMPARED = 3  # exit code where a stage could not be compared
HISTORY_HEADER = ("history", "quantity", "blocks", "continuum")
LEVEL_TITLE = "Halved: greatest displacement, and what changes"
LEVEL_HEADER = ("halved", "elements", "points", "greatest", "change", "joint forces")
ERROR_HEADER = ("r.m.s. of", "blocks", "continuum", "L2", "greatest", "where")


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """Options of `compare_stages`; `size` [m] of Gmsh's mesh; pictures or none."""

    order: int | None
    joints: bool | None
    refinements: int
    size: float | None
    pictures: bool


def compare_model(
    path: Path,
    output: Path | None,
    asked: Asked,
    *,
    as_json: bool,
    quiet: bool,
    scripts: bool = True,
) -> int:
    """Solve a model as blocks and as a continuum; print both, write both and their difference as VTU.

    Returns the exit code: 0 where every stage was compared.
    """
    from bsm_mesh.converters.continuum import compare_stages
    from bsm_mesh.converters.continuum.compared_stages import refuse_zones
    from bsm_mesh.geometries import OutlineMesher

    with Progress(quiet=quiet or as_json) as progress:
        loaded = load_model_file(path, progress.report, scripts=scripts)
        refuse_zones(loaded.model)
        added = AddedFiles(output or loaded.output_folder)
        with placed(path.name):
            results = run(loaded.model, loaded.options, progress.step, progress.report)
        progress.report("continuum (scikit-fem)")
        with geometry_faults(), stdout_to_stderr():
            mesher = None if asked.size is None else OutlineMesher(size=asked.size)
            stages = compare_stages(
                loaded.model,
                results,
                order=asked.order,
                joints=asked.joints,
                refinements=asked.refinements,
                mesher=mesher,
            )
        files = _written(stages, loaded.model.blocks, added)
        files += _histories_file(results, stages, added)
        if asked.pictures:
            progress.report("pictures")
            titles = [
                f"{loaded.model.title or path.stem}, {named_stage(stage.name)}" for stage in stages if stage.comparison
            ]
            of_blocks = re.compile(r"compare(_\d+)?\.vtu")
            vtus = [file for file in files if of_blocks.fullmatch(Path(file).name)]
            files += drawn(added, dict(zip(vtus, titles, strict=True)), progress.often)
    compared = [stage.comparison for stage in stages if stage.comparison is not None]
    notes = (*loaded.notes, *results.stages[0].notes, *(compared[-1].notes if compared else ()))
    if as_json:
        say_json({"stages": [_told(stage) for stage in stages], "notes": notes, "files": files})
    else:
        _print(loaded.model.title or str(path), stages)
        for note in notes:
            say(f"note: {note}")
        for file in files:
            say(f"written: {file}")
    return 0 if len(compared) == len(stages) else NOT_COMPARED


def _written(stages: Sequence[ComparedStage], blocks: Blocks, added: AddedFiles) -> list[str]:
    """Write VTU files of the compared stages (blocks; joints; bolts), and the series of several; return their paths."""
    from bsm_mesh.converters.continuum.files import write_bolts, write_comparison, write_joints
    from bsm_mesh.converters.vtk_files import write_pvd

    several = len(stages) > 1
    written: dict[str, list[tuple[float, str]]] = {"compare": [], "compare_joints": [], "compare_bolts": []}

    def write(kind: str, number: int, draw: Callable[[Path], None]) -> None:
        name = f"{kind}_{number:04d}.vtu" if several else f"{kind}.vtu"
        with added.file(name) as draft:
            draw(draft)
        written[kind].append((float(number), name))

    for number, stage in enumerate(stages):
        comparison = stage.comparison
        if comparison is None:
            continue
        write("compare", number, partial(write_comparison, comparison, blocks))
        if comparison.joint_movement is not None:
            write("compare_joints", number, partial(write_joints, comparison))
        if comparison.bolts.count:
            write("compare_bolts", number, partial(write_bolts, comparison))
    names = []
    for kind, listed in written.items():
        names += [name for _, name in listed]
        if several and listed:
            with added.file(f"{kind}.pvd") as draft:
                write_pvd(draft, listed)
            names.append(f"{kind}.pvd")
    return [str(added.folder.path / name) for name in names]


def _histories_file(results: Results, stages: Sequence[ComparedStage], added: AddedFiles) -> list[str]:
    """Write the elements' values of the histories, as `plot --with` takes it; return the path of the file."""
    from bsm_mesh.converters.continuum.history_values import beside_of_elements

    values = beside_of_elements(results, results.recorded, stages, CONTINUUM)
    if not values:
        return []
    with added.file(HISTORIES) as draft:
        write_text(draft, table_of(values))
    return [str(added.folder.path / HISTORIES)]


def drawn(added: AddedFiles, titles: Mapping[str, str], report: Callable[[str], None]) -> list[str]:
    """Draw both sides and the difference of VTU files with their titles; return the pictures' paths.

    `report` gets the name of each picture when it is drawn.
    """
    from bsm_mesh.pictures.plot import render

    folder = added.folder.path
    if not titles:
        return []
    given = [f"{Path(file).name}={one_line(title)}" for file, title in titles.items()]
    module, place = "bsm_mesh.pictures.compare_pictures", str(folder.absolute())
    return [str(path) for path in render(folder, report, module, place, *given)]


def _told(stage: ComparedStage) -> dict[str, object]:
    """Return a stage for ``--json``."""
    rows = [] if stage.comparison is None else [row._asdict() for row in stage.comparison.table()]
    told: dict[str, object] = {"name": stage.name, "class": stage.kind.value, "sentence": stage.sentence, "rows": rows}
    if stage.comparison is not None and stage.comparison.histories:
        told["histories"] = [value._asdict() for value in stage.comparison.histories]
    study = None if stage.comparison is None else stage.comparison.refinement
    if study is not None:
        told["refinement"] = {
            "levels": [level._asdict() for level in study.levels],
            "limit": study.greatest_limit,
            "too_coarse": study.too_coarse.tolist(),
        }
    return told


def _print(title: str, stages: Sequence[ComparedStage]) -> None:
    for stage in stages:
        named = f"{title}: {named_stage(stage.name)}" if len(stages) > 1 else title
        if stage.comparison is None:
            say(f"{named}: {stage.sentence}")
            continue
        print_table(f"{named} ({stage.kind.value})", ERROR_HEADER, _rows(stage.comparison), last_wraps=True)
        if stage.comparison.histories:
            print_table("Histories", HISTORY_HEADER, _histories(stage.comparison), texts=2)
        if stage.comparison.refinement is not None:
            print_table(
                LEVEL_TITLE,
                LEVEL_HEADER,
                _levels(stage.comparison.refinement),
            )
        say(stage.sentence)
        blocks, fem = stage.comparison.bsm_seconds, stage.comparison.fem_seconds
        say(f"wall time: blocks {engineering(blocks, 's')}, continuum {engineering(fem, 's')}")


def _rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Return the printed text of a stage."""
    whole = max((error.rms_fem for error in comparison.errors if error.unit == "Pa"), default=0.0)
    rows = [error_row(error, comparison.where(error), whole) for error in comparison.errors]
    if comparison.force_error is not None:
        blocks, fem = comparison.slipping
        rows.append(("slip or open", f"{100 * blocks:.1f} %", f"{100 * fem:.1f} %", "", "", "by length"))
    return rows


def _histories(comparison: Comparison) -> list[tuple[str, ...]]:
    """Return the printed text of the model's histories."""

    def told(value: float, unit: str) -> str:
        return engineering(value, unit) if unit in ("m", "N") else f"{value:.4g} {unit}".rstrip()

    return [
        (value.history, value.quantity, told(value.bsm, value.unit), told(value.fem, value.unit))
        for value in comparison.histories
    ]


def error_row(error: Difference, where: str, whole_stress: float = 0.0) -> tuple[str, ...]:
    """Return the printed text of a difference, as `ERROR_HEADER` heads it; rounding of the whole stress as 0."""
    from bsm_mesh.converters.continuum.differences import NEGLIGIBLE

    least = NEGLIGIBLE * whole_stress if error.unit == "Pa" else 0.0
    return (
        error.name,
        *(engineering(rms if rms > least else 0.0, error.unit) for rms in (error.rms_bsm, error.rms_fem)),
        f"{100 * error.l2:.2f} %",
        f"{100 * error.largest:.2f} %",
        where,
    )


def _levels(refinement: Refinement) -> list[tuple[str, ...]]:
    """Return the printed text of halved elements and interfaces."""
    rows: list[tuple[str, ...]] = [
        (
            str(number),
            str(level.cells),
            str(level.points),
            engineering(level.greatest, "m"),
            f"{100 * level.change:.2f} %",
            "" if level.force_change is None else f"{100 * level.force_change:.2f} %",
        )
        for number, level in enumerate(refinement.levels)
    ]
    if refinement.greatest_limit is not None:
        rows.append(("limit", "", "", engineering(refinement.greatest_limit, "m"), "", ""))
    return rows
