"""The work of the commands, step by step."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Literal

from bsm_mesh.errors import ModelError, counted
from bsm_mesh.files import whole_file
from bsm_mesh.folder.histories import history_file
from bsm_mesh.folder.result_tables import BOLTS, FLOW, ON_REQUEST, TableForm
from bsm_mesh.folder.results_folder import refuse_unwritable
from bsm_mesh.folder.run_file import run_file
from bsm_mesh.folder.shaking_files import SHAKEN_FILES
from bsm_mesh.folder.summary import summary
from bsm_mesh.modelfile.build_marks import geometry_faults
from bsm_mesh.modelfile.build_mesh import build_geometry, stdout_to_stderr
from bsm_mesh.reading import as_typed
from bsm_mesh.results.joint_sets import joint_sets
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.result_text import tables_of
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json

EXIT_CODES = {
    Status.STABLE: 0,
    Status.STABLE_AFTER_FALLS: 0,
    Status.UNSTABLE: 0,
    Status.NO_VERDICT: 0,
    Status.NOT_CONVERGED: 3,
}


def run_model(
    path: Path,
    output: Path | None,
    told: Progress,
    *,
    pictures: bool,
    as_json: bool,
    scripts: bool = True,
    resume: bool = False,
    spread: bool = False,
    tables: TableForm | Literal[False] = False,
    verbose: bool = False,
) -> int:
    """Solve a model file, write its results, and return the exit code."""
    with told as progress:
        done = run_file(
            path,
            None,
            progress.step,
            progress.report,
            output=output,
            scripts=scripts,
            resume=resume,
            spread=spread,
            tables=tables,
        )
        results, notes, folder = done.results, done.notes, done.folder
        assert folder is not None
        drawn = []
        if pictures:
            from bsm_mesh.pictures.plot import draw_in_subprocess

            progress.report("pictures")
            drawn = draw_in_subprocess(folder, report=progress.often)
    if as_json:
        sets = [asdict(one) for one in joint_sets(results, results.stages[-1])]
        say_json({**summary(results), "joints": sets, "notes": notes, "folder": str(folder)})
    else:
        _print_results(results, notes, verbose=verbose)
        _print_files(results, folder, drawn)
    return EXIT_CODES[results.status]


def _print_results(results: Results, notes: tuple[str, ...], *, verbose: bool) -> None:
    for note in notes:
        say(f"mesh: {note}", err=True)
    for table in tables_of(results, verbose=verbose):
        if table.rows:
            print_table(table.title, table.header, table.rows, texts=table.texts)
        elif table.title:
            say(table.title)
        for line in table.lines:
            say(f"  {line}" if table.title and not table.rows else line)


def _print_files(results: Results, folder: Path, drawn: list[Path]) -> None:
    names = ("blocks", "contacts", "joints", "supports", "water", FLOW, BOLTS, "zones")
    series = ", ".join(f"{name}.pvd" for name in names if (folder / f"{name}.pvd").exists())
    series += f", {', '.join(SHAKEN_FILES)}" if any(stage.shaking for stage in results.stages) else ""
    tables = [f"{name}.{ending}" for name in (BOLTS, FLOW, *ON_REQUEST) for ending in ("csv", "parquet")]
    series += "".join(f", {name}" for name in tables if (folder / name).exists())
    series += "".join(f", {history_file(name)}" for name in results.histories)
    say(f"written to {folder}: {series}, history.csv, certificate.json, summary.json, model.toml")
    say("open blocks.pvd in ParaView" if drawn else f"next: {as_typed('plot', folder)}, or open blocks.pvd in ParaView")
    if drawn:
        say(f"pictures: {counted(len(drawn), 'file')} in {drawn[0].parent}")


def build_mesh(case: str, output: Path | None, settings: tuple[str, ...]) -> None:
    """Build a geometry into a mesh file and report its contents."""
    from bsm_mesh.converters import read_mesh
    from bsm_mesh.geometries.cases import find_case, parse_settings

    path = output or Path(f"{Path(case).stem}.msh")
    if path.suffix != ".msh":
        raise ModelError(f"{path}: a mesh is written as .msh; give a name that ends in .msh")
    if path.is_dir():
        raise ModelError(f"{path} is a folder; give the name of a file in it")
    refuse_unwritable(path.parent, "a mesh")
    texts = dict(_key_and_value(setting) for setting in settings)
    with geometry_faults(), stdout_to_stderr():
        parameters = parse_settings(find_case(case), texts)
    try:
        with Progress() as progress, whole_file(path, parents=True) as draft:
            progress.report(f"building {case}")
            build_geometry(case, draft, parameters)
            progress.report("reading it")
            _, report = read_mesh(draft, groups={"*": "rock:rock"})
    except ModelError as error:
        raise ModelError([fault.replace(str(draft), str(path)) for fault in error.faults]) from error
    say(f"written: {path}")
    print_table("physical groups", ("group", "elements"), [(name, str(n)) for name, n in report.groups.items()])


def _key_and_value(setting: str) -> tuple[str, str]:
    key, equals, value = setting.partition("=")
    if not equals or not key.strip():
        raise ModelError(f"--set {setting}: write KEY=VALUE, for example --set radius=2.5")
    return key.strip(), value.strip()


def print_cases(case: str | None) -> None:
    """Print the built-in geometries, or the parameters of one."""
    from bsm_mesh.geometries.cases import case_names, case_parameters, find_case

    with geometry_faults():
        if case is None:
            rows = [(name, find_case(name).summary) for name in case_names()]
            print_table("cases (bsm-mesh mesh CASE --list: its parameters)", ("case", ""), rows, texts=2)
            return
        parameters = case_parameters(find_case(case))
    print_table(
        f"parameters of {case}",
        ("parameter", "default", "meaning"),
        [(name, "required" if p.required else str(p.default), p.summary) for name, p in parameters.items()],
        texts=3,
    )
