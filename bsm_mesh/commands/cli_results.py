"""The commands on a results folder: ``plot``, ``report``, ``view``, ``paraview``, ``verify``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from bsm_mesh.commands.cli_options import PATH, json_option, quiet_option
from bsm_mesh.text.progress import reading
from bsm_mesh.text.terminal import say


@click.command()
@click.argument("out", type=PATH)
@click.option("--stage", metavar="NAME", help="Of this stage only, by name or number, -1 the last.")
@click.option("--window", nargs=4, type=float, metavar="X0 Y0 X1 Y1", help="Of this part of the model only [m].")
@click.option(
    "--look",
    nargs=2,
    type=float,
    metavar="AZIMUTH PLUNGE",
    help="Of three dimensions: seen in this direction, degrees from north and downwards.",
)
@click.option(
    "--only",
    multiple=True,
    metavar="NAME",
    help="This picture only, or all that begin with the word: joints, bolts, ...; repeatable.",
)
@click.option(
    "--with",
    "beside",
    multiple=True,
    metavar="[NAME=]PATH",
    help="Compared with the histories: a table (CSV) of measured or others' values, or the folder of another run.",
)
@click.option("--animate", is_flag=True, help="The movement as a GIF instead.")
@click.option("--step", type=click.IntRange(0), metavar="N", help="The position after N steps of the run instead.")
@quiet_option
def plot(
    out: Path,
    stage: str | None,
    window: tuple[float, float, float, float] | None,
    look: tuple[float, float] | None,
    only: tuple[str, ...],
    beside: tuple[str, ...],
    animate: bool,
    step: int | None,
    quiet: bool,
) -> None:
    """Draw PNG pictures of the results in OUT, of every stage.

    Values compared with histories are points, or curves, in histories, extensometers, profiles, points and
    displacement_arrows. Values of [[history]] measured are always drawn.

    --animate and --step need the snapshots of a run with snapshots = "steps" in [output].
    """
    with reading(out, quiet=quiet) as progress:
        from bsm_mesh.pictures.beside import named_source
        from bsm_mesh.pictures.plot import PictureChoice, draw_in_subprocess

        sources = ((name, str(Path(path).absolute())) for name, path in map(named_source, beside))
        choice = PictureChoice(stage=stage, window=window, look=look, only=only, beside=tuple(sources))
        drawn = draw_in_subprocess(out, choice, progress.often, animate=animate, step=step)
    for path in drawn:
        say(path)


@click.command()
@click.argument("out", type=PATH)
@click.option("--no-pictures", is_flag=True, help="Draw none; existing pictures are shown.")
@click.option("--project", default="", help="Name of the project; by default that of [report] in the run's model file.")
@click.option("--author", default="", help="Author; by default that of [report] in the model file.")
@click.option("--date", default="", help="Date; by default that of [report] in the model file.")
@click.option("--picture", type=PATH, metavar="PNG", help="Overview on the first page; by default the model's picture.")
@click.option(
    "--safety", type=PATH, metavar="FOLDER", help="Factor of safety on the first page; by default OUT-safety."
)
@quiet_option
def report(out: Path, no_pictures: bool, safety: Path | None, quiet: bool, **fields: Any) -> None:
    """Write OUT as one page, OUT/report.html, to be filed or printed: a run, a factor of safety, key blocks or a study.

    The page of a run shows verdicts with their grounds, displacement and slip, pictures, input, quality of the blocks,
    versions and checksums. Of earlier stages it shows displacement, joints and bolts. Factors of safety
    of the same model are on the first page (OUT-safety, OUT-safety-STAGE). So are limits of its keys (OUT-limit-KEY)
    and its key blocks (OUT-key-blocks). The page needs no other file.
    """
    with reading(out, quiet=quiet) as progress:
        from bsm_mesh.pages.report import ReportFields, write_report

        notes: list[str] = []
        head = ReportFields(**fields)
        path = write_report(
            out, progress.often, pictures=not no_pictures, fields=head, safety=safety, note=notes.append
        )
    for text in notes:
        say(f"note: {text}", err=True)
    say(path)


@click.command()
@click.argument("out", type=PATH)
@quiet_option
def view(out: Path, quiet: bool) -> None:
    """Write the results in OUT as a page to explore, OUT/view.html.

    Blocks, joints, bolts and water of every stage and step, coloured by any array, movements as large as one likes; a
    click shows numbers. The page needs no other file and no network. It takes Bokeh, for polyhedra Plotly too: pip
    install bokeh plotly.
    """
    with reading(out, quiet=quiet):
        from bsm_mesh.pages.view import write_view

        path = write_view(out)
    say(path)


@click.command()
@click.argument("out", type=PATH)
@quiet_option
def paraview(out: Path, quiet: bool) -> None:
    """Write a script that opens the results in OUT in ParaView, OUT/in_paraview.py.

    Coloured, moved, with the stages named: paraview --script=OUT/in_paraview.py, or File > Load State.
    """
    with reading(out, quiet=quiet):
        from bsm_mesh.pages.paraview import write_paraview

        path = write_paraview(out)
    say(path)


@click.command()
@click.argument("out", type=PATH)
@click.option("--rock", required=True, metavar="NAME", help="The rock of which the liner consists.")
@click.option("--stage", metavar="NAME", help="Name or number of the stage; the last by default.")
@click.option("--compressive-strength", required=True, metavar="STRENGTH", help='Of the liner, such as "25 MPa".')
@click.option("--tensile-strength", required=True, metavar="STRENGTH", help='Of the liner, such as "2.5 MPa".')
@json_option
def liner(out: Path, as_json: bool, **asked: Any) -> None:
    """Check thrust and moment of a liner in the results in OUT against its capacity.

    The liner is a ring or arch of blocks of one rock. OUT/liner.csv has thrust, shear, moment and utilisation of each
    section. OUT/liner.png shows moments over thrusts, with the elastic envelope of capacity.
    """
    from bsm_mesh.commands.liner import check_liner

    check_liner(out, as_json=as_json, **asked)


@click.command()
@click.argument("out", type=PATH)
@json_option
@quiet_option
def verify(out: Path, as_json: bool, quiet: bool) -> None:
    """Check from the files in OUT alone the ground of every verdict.

    At rest: forces that balance, within strength, without overlap, with no direction in which blocks fall. Unstable:
    a mechanism that proves that blocks must move, or which were followed how far. Exit code 3 where a verdict does
    not hold.
    """
    with reading(out, quiet=quiet or as_json):
        from bsm_mesh.folder.verify import grounds_in, print_grounds

        grounds = grounds_in(out)
    sys.exit(print_grounds(grounds, as_json=as_json))
