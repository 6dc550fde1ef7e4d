"""The command ``compare --with``: a model as blocks compared with the result of another program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.commands.comparing import ERROR_HEADER, NOT_COMPARED, drawn, error_row
from bsm_mesh.errors import ModelError, named_stage, placed
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.model.model import Model
from bsm_mesh.model.quantities import COORDINATE, STRESS
from bsm_mesh.model.quantity import Quantity, in_unit
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.run import run
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json

if TYPE_CHECKING:
    from bsm_mesh.converters.continuum.foreign_fields import FieldNames
    from bsm_mesh.converters.continuum.outside import OutsideComparison

STEM = "compare_with"


@dataclass(frozen=True, slots=True, kw_only=True)
class Others:
    """Results of another program: files (a PVD means those that it lists), their fields, and their stages."""

    files: tuple[Path, ...]
    names: FieldNames
    stages: tuple[str, ...]


def compare_with_files(
    path: Path,
    output: Path | None,
    others: Others,
    *,
    pictures: bool,
    as_json: bool,
    quiet: bool,
    scripts: bool = True,
) -> int:
    """Compare the stages of a model with another program's results; print and write as `compare_model`.

    Returns the exit code: 0 where all were compared.
    """
    from bsm_mesh.converters.continuum.outside import compare_with, stages_of
    from bsm_mesh.converters.meshes.foreign_files import read_foreign

    with Progress(quiet=quiet or as_json) as progress:
        series = _series(others.files)
        read = []
        for _, file in series:
            progress.report(f"reading {file}")
            read.append(read_foreign(file))
        loaded = load_model_file(path, progress.report, scripts=scripts)
        stages = stages_of(loaded.model, [time for time, _ in series], others.stages)
        added = AddedFiles(output or loaded.output_folder)
        with placed(path.name):
            results = run(loaded.model, loaded.options, progress.step, progress.report)
        found = [
            compare_with(loaded.model, results, other, others.names, stage)
            for other, stage in zip(read, stages, strict=True)
        ]
        files = _written(found, loaded.model, added)
        if pictures:
            progress.report("pictures")
            title = loaded.model.title or path.stem
            compared = [one for one in found if not one.reason]
            titles = [f"{title}, {named_stage(one.stage)}, beside {Path(one.source).name}" for one in compared]
            vtus = [file for file in files if file.endswith(".vtu")]
            files += drawn(added, dict(zip(vtus, titles, strict=True)), progress.often)
    if as_json:
        told = [_told(one) for one in found]
        say_json({**(told[0] if len(told) == 1 else {"stages": told}), "files": files})
    else:
        _print(str(loaded.model.title or path), found, files)
    return NOT_COMPARED if any(one.reason for one in found) else 0


def _series(files: Sequence[Path]) -> list[tuple[float, Path]]:
    """Return all results in the order of their times, a PVD's as it gives them, else numbered from 0."""
    from bsm_mesh.converters.meshes.files import refuse_unreadable
    from bsm_mesh.converters.vtk_files import read_pvd

    found: list[tuple[float, Path]] = []
    for file in files:
        refuse_unreadable(file)
        if file.suffix.lower() == ".pvd":
            found += sorted(read_pvd(file), key=lambda entry: entry[0])
        else:
            found.append((float(len(found)), file))
    return found


def _written(found: Sequence[OutsideComparison], model: Model, added: AddedFiles) -> list[str]:
    """Write a VTU file for each comparison, and of several the series; return their paths."""
    from bsm_mesh.converters.continuum.files import write_sides
    from bsm_mesh.converters.continuum.outside import stage_names
    from bsm_mesh.converters.vtk_files import write_pvd

    listed: list[tuple[float, str]] = []
    for one in found:
        if one.reason:
            continue
        number = stage_names(model).index(one.stage)
        name = f"{STEM}_{number:04d}.vtu" if len(found) > 1 else f"{STEM}.vtu"
        with added.file(name) as draft:
            write_sides(draft, model.blocks, one.compared, stress=one.stress, displacement=one.displacement)
        listed.append((float(number), name))
    names = [name for _, name in listed]
    if len(found) > 1 and listed:
        with added.file(f"{STEM}.pvd") as draft:
            write_pvd(draft, listed)
        names.append(f"{STEM}.pvd")
    return [str(added.folder.path / name) for name in names]


def _print(title: str, found: Sequence[OutsideComparison], files: Sequence[str]) -> None:
    header = (*ERROR_HEADER[:2], "other", *ERROR_HEADER[3:])
    for one in found:
        named = f"{title}: {named_stage(one.stage)} beside {Path(one.source).name}"
        if one.errors:
            print_table(named, header, [error_row(error, f"block {error.worst_block}") for error in one.errors])
        say(one.sentence if one.errors else f"{named}: {one.sentence}")
        for note in one.notes:
            say(f"note: {note}")
    for file in files:
        say(f"written: {file}")


def _told(found: OutsideComparison) -> dict[str, object]:
    rows = [
        {
            "name": error.name,
            "unit": error.unit,
            "rms": [error.rms_bsm, error.rms_fem],
            "l2": error.l2,
            "greatest": error.largest,
            "where": error.worst_block,
        }
        for error in found.errors
    ]
    return {
        "stage": found.stage,
        "with": found.source,
        "sentence": found.sentence,
        "differences": rows,
        "notes": found.notes,
    }


def field_names(fields: Sequence[str], length: str | None, compression_positive: bool) -> FieldNames:
    """Return the names and units of ``--field displacement=U:mm``, ``--field stress=SIG:MPa``, ``--length mm``.

    Raises
    ------
    ModelError
        If one cannot be read.
    """
    from bsm_mesh.converters.continuum.foreign_fields import FieldNames

    arrays, factors = {}, {}
    for field in fields:
        key, equals, array = (part.strip() for part in field.partition("="))
        name, colon, unit = array.rpartition(":")
        if not equals or not array:
            raise ModelError(f"--field {field}: write --field stress=NAME, or --field stress=NAME:kPa")
        arrays[key] = name if colon else array
        if colon:
            factors[key] = _factor(unit, STRESS if key.startswith("s") else COORDINATE, f"--field {field}")
    if length is not None:
        factors["length"] = _factor(length, COORDINATE, f"--length {length}")
    return FieldNames(arrays=arrays, factors=factors, compression_positive=compression_positive)


def _factor(unit: str, quantity: Quantity, given: str) -> float:
    try:
        return in_unit(f"1 {unit}", quantity)
    except ValueError as problem:
        raise ModelError(f"{given}: unit '{unit}' {problem}") from None
