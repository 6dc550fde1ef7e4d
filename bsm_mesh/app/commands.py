"""What the commands do, step by step."""

from __future__ import annotations

import json
import os
from pathlib import Path

import click

from bsm_mesh.app.build import LoadedModel, build_geometry, load_model_file
from bsm_mesh.app.progress import Progress
from bsm_mesh.app.storage import save_results, summary, write_text
from bsm_mesh.app.tables import print_table, result_rows
from bsm_mesh.errors import ModelError
from bsm_mesh.results.records import Results, Status
from bsm_mesh.run import run

EXIT_CODES = {Status.STABLE: 0, Status.UNSTABLE: 0, Status.NOT_CONVERGED: 3}


def run_model(path: Path, output: Path | None, *, pictures: bool, as_json: bool, quiet: bool) -> int:
    """Solve a model file, write its results, and return the exit code."""
    with Progress(quiet=quiet or as_json) as progress:
        loaded = load_model_file(path, progress.report)
        folder = output or loaded.output_folder
        results = run(loaded.model, loaded.options, progress.step, progress.report)
        progress.report(f"writing {folder}")
        save_results(results, folder)
        write_text(folder / "model.toml", model_as_run(loaded, folder))
        drawn = []
        if pictures:
            from bsm_mesh.app.plot import draw_in_subprocess

            progress.report("pictures")
            drawn = draw_in_subprocess(folder)
    if as_json:
        click.echo(json.dumps({**summary(results), "notes": loaded.notes, "folder": str(folder)}, indent=2))
    else:
        _print_results(results, loaded.notes, folder, drawn)
    return EXIT_CODES[results.status]


def _print_results(results: Results, notes: tuple[str, ...], folder: Path, drawn: list[Path]) -> None:
    for note in notes:
        click.echo(f"mesh: {note}", err=True)
    print_table(results.title or "Results", ("", ""), result_rows(results))
    click.echo(f"written to {folder}: blocks.pvd, contacts.pvd, supports.pvd, history.csv, summary.json, model.toml")
    click.echo(
        "open blocks.pvd in ParaView" if drawn else f"next: bsm-mesh plot {folder}, or open blocks.pvd in ParaView"
    )
    for picture in drawn:
        click.echo(picture)


def model_as_run(loaded: LoadedModel, folder: Path) -> str:
    """Return the model file with every default and all numbers in SI, its mesh relative to `folder`."""
    import tomli_w

    content = loaded.file.model_dump(mode="json", exclude_none=True)
    for key in ("file", "geometry"):
        name = content["mesh"].get(key)
        if name is not None and (key == "file" or name.endswith(".py")):
            content["mesh"][key] = Path(os.path.relpath(loaded.path.parent / name, folder)).as_posix()
    content["output"]["folder"] = "."
    return tomli_w.dumps({key: value for key, value in content.items() if value not in ({}, [])})


def run_demo(folder: Path) -> None:
    """Write the starter ``tunnel`` into a folder, run it and draw it."""
    from bsm_mesh.app.starters import write_starter

    model = folder / "model.toml"
    if not model.exists():
        write_starter("tunnel", folder)
    run_model(model, folder / "out", pictures=True, as_json=False, quiet=False)


def build_mesh(case: str, output: Path | None, settings: tuple[str, ...]) -> None:
    """Build a geometry into a mesh file and say what is in it."""
    from geometries.cases import find_case, parse_settings
    from geometries.errors import GeometryError

    path = output or Path(f"{Path(case).stem}.msh")
    try:
        parameters = parse_settings(find_case(case), settings)
    except GeometryError as error:
        raise ModelError(str(error)) from error
    build_geometry(case, path, parameters, Path())
    click.echo(f"written: {path}")


def print_cases(case: str | None) -> None:
    """Print the built-in geometries, or the parameters of one."""
    from geometries.cases import case_names, case_parameters, find_case
    from geometries.errors import GeometryError

    if case is None:
        for name in case_names():
            click.echo(name)
        return
    try:
        for name, default in case_parameters(find_case(case)).items():
            click.echo(f"{name} = {default!r}")
    except GeometryError as error:
        raise ModelError(str(error)) from error


def check_model(path: Path, *, as_json: bool) -> None:
    """Validate a model file and print the quality of its blocks."""
    from bsm_mesh.app.quality import quality_rows, quality_summary
    from bsm_mesh.contact.table import initial_contacts
    from bsm_mesh.solve.system import LinearSystem

    loaded = load_model_file(path)
    system = LinearSystem(loaded.model, initial_contacts(loaded.model))
    system.check_supports()
    report = quality_summary(loaded.model, system)
    if as_json:
        click.echo(json.dumps({**report, "notes": loaded.notes}, indent=2))
        return
    for note in loaded.notes:
        click.echo(f"mesh: {note}")
    print_table(f"{path}: the model is valid", ("", ""), quality_rows(report))


def compare_model(path: Path, output: Path | None, *, order: int, as_json: bool, quiet: bool) -> None:
    """Solve a model as blocks and as a continuum and print both."""
    raise NotImplementedError
