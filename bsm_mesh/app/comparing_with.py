"""The command ``compare --with``: a model as blocks beside the result of another program."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.app.added_files import AddedFiles
from bsm_mesh.app.build import load_model_file
from bsm_mesh.app.comparing import ERROR_HEADER, NOT_COMPARED, drawn, error_row
from bsm_mesh.app.progress import Progress
from bsm_mesh.app.tables import print_table
from bsm_mesh.app.terminal import say, say_json
from bsm_mesh.app.units import in_unit
from bsm_mesh.errors import ModelError, placed
from bsm_mesh.model.quantities import COORDINATE, STRESS, Quantity
from bsm_mesh.run import run

if TYPE_CHECKING:
    from bsm_mesh.converters.continuum.foreign_fields import FieldNames
    from bsm_mesh.converters.continuum.outside import OutsideComparison

FILE = "compare_with.vtu"


def compare_with_file(
    path: Path,
    output: Path | None,
    other: Path,
    names: FieldNames,
    stage: str | None,
    *,
    pictures: bool,
    as_json: bool,
    quiet: bool,
    scripts: bool = True,
) -> int:
    """Solve a model as blocks and set another program's result beside a stage; print and write as `compare_model`.

    Returns the exit code: 0 where they were compared.
    """
    from bsm_mesh.converters.continuum.files import write_sides
    from bsm_mesh.converters.continuum.outside import compare_with
    from bsm_mesh.converters.meshes.foreign_files import read_foreign

    with Progress(quiet=quiet or as_json) as progress:
        progress.report(f"reading {other}")
        result = read_foreign(other)
        loaded = load_model_file(path, progress.report, scripts=scripts)
        added = AddedFiles(output or loaded.output_folder)
        with placed(path.name):
            results = run(loaded.model, loaded.options, progress.step, progress.report)
        found = compare_with(loaded.model, results, result, names, stage)
        files = []
        if not found.reason:
            with added.file(FILE) as draft:
                write_sides(
                    draft, loaded.model.blocks, found.compared, stress=found.stress, displacement=found.displacement
                )
            files.append(str(added.folder.path / FILE))
            if pictures:
                progress.report("pictures")
                title = f"{loaded.model.title or path.stem}, stage {found.stage}, beside {other.name}"
                files += drawn(added, {files[0]: title})
    if as_json:
        say_json({**_told(found), "files": files})
    else:
        _print(f"{loaded.model.title or path}: stage {found.stage} beside {other.name}", found, files)
    return NOT_COMPARED if found.reason else 0


def _print(title: str, found: OutsideComparison, files: Sequence[str]) -> None:
    if found.errors:
        header = (*ERROR_HEADER[:2], "other", *ERROR_HEADER[3:])
        print_table(title, header, [error_row(error, f"block {error.worst_block}") for error in found.errors])
    say(found.sentence)
    for note in found.notes:
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
            is_stress = key.startswith("s")
            kind = STRESS if is_stress else COORDINATE
            factors["stress" if is_stress else "displacement"] = _factor(unit, kind, f"--field {field}")
    if length is not None:
        factors["length"] = _factor(length, COORDINATE, f"--length {length}")
    return FieldNames(arrays=arrays, factors=factors, compression_positive=compression_positive)


def _factor(unit: str, quantity: Quantity, given: str) -> float:
    try:
        return in_unit(f"1 {unit}", quantity)
    except ValueError as problem:
        raise ModelError(f"{given}: unit '{unit}' {problem}") from None
